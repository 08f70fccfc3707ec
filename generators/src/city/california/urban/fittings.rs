//! What city buildings have beside masses and roof furniture: slabs on posts, ramps, walls, landing pads, pools.
//!
//! Everything is in the building's frame and closed; nothing shares a plane with what it stands on.

use super::part;
use crate::kit::buildings::slot;
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};

/// A closed solid of a building.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::city::california) enum Fitting {
    /// An upright prism.
    Prism {
        /// Simple outline, counter-clockwise.
        outline: Vec<DVec2>,
        /// Underside and top, m.
        heights_m: [f64; 2],
        /// Slots of its sides, and of its top and underside.
        slots: [u16; 2],
    },
    /// A sloping slab.
    Slope {
        /// Corners of its top, counter-clockwise seen from above.
        top: [DVec3; 4],
        /// Underside, m: below all corners.
        low_m: f64,
        /// Slots of its sides and of its top.
        slots: [u16; 2],
    },
}

impl Fitting {
    /// Moves it in plan.
    pub(in crate::city::california) fn shift(&mut self, by: DVec2) {
        match self {
            Self::Prism { outline, .. } => outline.iter_mut().for_each(|p| *p += by),
            Self::Slope { top, .. } => top.iter_mut().for_each(|p| *p += by.extend(0.0)),
        }
    }

    /// Its triangles.
    pub(in crate::city::california) fn add(&self, b: &mut MeshBuilder) {
        match self {
            Self::Prism { outline, heights_m: [low, high], slots: [side, cap] } => {
                b.prism(*side, *cap, outline, *low, *high, Wall::PLAIN);
            }
            Self::Slope { top, low_m, slots: [side, cap] } => {
                let flat = |p: DVec3| (p, p.truncate());
                let below = |p: DVec3| p.truncate().extend(*low_m);
                b.fan(*cap, &top.map(flat));
                b.fan(*side, &[3, 2, 1, 0].map(|k: usize| flat(below(top[k]))));
                for k in 0..4 {
                    let (p, q) = (top[k], top[(k + 1) % 4]);
                    b.fan(*side, &[below(p), below(q), q, p].map(flat));
                }
            }
        }
    }
}

/// A block over a rectangle.
pub(super) fn block([x0, x1, y0, y1]: [f64; 4], heights_m: [f64; 2], slots: [u16; 2]) -> Fitting {
    Fitting::Prism { outline: polygon::rectangle(DVec2::new(x0, y0), DVec2::new(x1, y1)), heights_m, slots }
}

/// A regular outline of as many corners, the first edge square to the x axis.
pub(super) fn round(centre: DVec2, radius_m: f64, corners: usize) -> Vec<DVec2> {
    (0..corners)
        .map(|k| {
            let (s, c) = libm::sincos(core::f64::consts::TAU * (k as f64 + 0.5) / corners as f64);
            centre + DVec2::new(c, s) * radius_m
        })
        .collect()
}

/// A straight wall.
pub(super) fn wall(from: DVec2, to: DVec2, thick_m: f64, heights_m: [f64; 2], side: u16) -> Fitting {
    let half = DVec2::new(from.distance(to) / 2.0, thick_m / 2.0);
    let outline = polygon::oriented_rectangle((from + to) * 0.5, (to - from).normalize(), half);
    Fitting::Prism { outline, heights_m, slots: [side, slot::COPING] }
}

/// A flat roof on posts over a rectangle, `posts` of them along x and two rows deep.
pub(super) fn canopy(
    [x0, x1, y0, y1]: [f64; 4],
    [under_m, thick_m]: [f64; 2],
    posts: u32,
    slots: [u16; 2],
) -> Vec<Fitting> {
    let mut out = vec![block([x0, x1, y0, y1], [under_m, under_m + thick_m], slots)];
    for k in 0..posts {
        let x = x0 + (x1 - x0) * (f64::from(k) + 0.5) / f64::from(posts);
        for y in [y0 + 0.22 * (y1 - y0), y1 - 0.22 * (y1 - y0)] {
            out.push(block([x - 0.12, x + 0.12, y - 0.12, y + 0.12], [-0.9, under_m + 0.05], [slot::METAL; 2]));
        }
    }
    out
}

/// Part of a ring around a centre, between two angles in turns.
fn arc(centre: DVec2, [inner, outer]: [f64; 2], [from, to]: [f64; 2]) -> Vec<DVec2> {
    let at = |r: f64, share: f64| {
        let (s, c) = libm::sincos(core::f64::consts::TAU * (from + (to - from) * share));
        centre + DVec2::new(c, s) * r
    };
    let steps = 12;
    let share = |k: u32| f64::from(k) / f64::from(steps);
    let mut out: Vec<DVec2> = (0..=steps).map(|k| at(outer, share(k))).collect();
    out.extend((0..=steps).rev().map(|k| at(inner, share(k))));
    out
}

/// A landing pad for helicopters on a roof: a slab on a stub, a painted ring, an H, a number's place.
pub(super) fn helipad(centre: DVec2, axis: DVec2, radius_m: f64, roof_m: f64, square: bool) -> Vec<Fitting> {
    let (low, top) = (roof_m + 1.5, roof_m + 1.9);
    let slab = if square {
        polygon::oriented_rectangle(centre, axis, DVec2::splat(radius_m))
    } else {
        round(centre, radius_m * 1.06, 24)
    };
    let prism = |outline: Vec<DVec2>, heights_m: [f64; 2], s: u16| Fitting::Prism { outline, heights_m, slots: [s; 2] };
    let mut out = vec![
        prism(round(centre, radius_m * 0.55, 8), [roof_m - 0.2, low + 0.05], slot::METAL),
        prism(slab, [low, top], part::PAD),
    ];
    // Paint has a thickness of its own so that it lies in no plane with the slab.
    let paint = [top - 0.1, top + 0.02];
    let ring = [radius_m * 0.8, radius_m * 0.8 + 0.55];
    for span in [[0.005, 0.495], [0.505, 0.995]] {
        out.push(prism(arc(centre, ring, span), paint, part::PAINT));
    }
    let across = axis.perp();
    let bar = |x: f64, y: f64, half: DVec2| polygon::oriented_rectangle(centre + axis * x + across * y, axis, half);
    let reach = radius_m * 0.32;
    for x in [-reach * 0.62, reach * 0.62] {
        out.push(prism(bar(x, 0.0, DVec2::new(0.35, reach)), paint, part::PAINT));
    }
    out.push(prism(bar(0.0, 0.0, DVec2::new(reach * 0.62 - 0.4, 0.35)), paint, part::PAINT));
    out
}

/// A pool in a deck: rim and water above the deck's level.
pub(super) fn pool([x0, x1, y0, y1]: [f64; 4], deck_m: f64) -> Vec<Fitting> {
    let e = 0.45;
    vec![
        block([x0 - e, x1 + e, y0 - e, y1 + e], [deck_m - 0.2, deck_m + 0.1], [slot::COPING; 2]),
        block([x0, x1, y0, y1], [deck_m - 0.1, deck_m + 0.12], [part::WATER; 2]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn fittings_are_closed_also_when_moved() {
        let top = [(0.0, 0.0, 0.2), (5.0, 0.0, 0.2), (5.0, 30.0, 3.4), (0.0, 30.0, 3.4)];
        let mut all = vec![
            Fitting::Slope { top: top.map(|(x, y, z)| DVec3::new(x, y, z)), low_m: -0.5, slots: [0, 1] },
            wall(DVec2::ZERO, DVec2::new(3.0, 4.0), 0.2, [0.0, 1.1], 0),
        ];
        all.extend(helipad(DVec2::new(3.0, 2.0), DVec2::new(0.6, 0.8), 9.0, 120.0, false));
        all.extend(canopy([0.0, 26.0, 0.0, 12.0], [5.2, 0.9], 3, [part::CANOPY, slot::COPING]));
        all.extend(pool([0.0, 12.0, 0.0, 6.0], 18.0));
        for mut fitting in all {
            let mesh = |f: &Fitting| {
                let mut b = MeshBuilder::default();
                f.add(&mut b);
                b.finish()
            };
            let still = mesh(&fitting);
            fitting.shift(DVec2::new(8.0, -4.0));
            let moved = mesh(&fitting);
            for m in [&still, &moved] {
                assert_eq!((m.validate(), open_edges(m)), (Ok(()), 0), "{fitting:?}");
            }
            let lowest = |m: &satseed_scene::Mesh| m.bounds_m().unwrap().0;
            assert!((lowest(&moved) - lowest(&still) - DVec3::new(8.0, -4.0, 0.0)).length() < 2e-3);
        }
    }
}
