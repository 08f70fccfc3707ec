//! What stands on squares and in the water: well heads, parasols, benches, people, piles.

use super::fabric::Open;
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, Rng, SeedPath};

/// Slot of stone or wood, and of cloth.
const BODY: u16 = 0;
const CLOTH: u16 = 1;

/// Kinds of things.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Thing {
    /// Carved well head on its steps.
    Well,
    /// Parasol with a table.
    Parasol,
    /// Market stall or kiosk.
    Stall,
    /// Bench.
    Bench,
    /// Someone who stands or walks.
    Person,
    /// Three piles that mark a channel.
    Briccola,
    /// A mooring pile.
    Pile,
}

impl Thing {
    /// All kinds.
    pub(super) const ALL: [Self; 7] =
        [Self::Well, Self::Parasol, Self::Stall, Self::Bench, Self::Person, Self::Briccola, Self::Pile];

    /// Its mesh; z = 0 is the ground, of piles the water.
    pub(super) fn mesh(self) -> Mesh {
        let mut b = MeshBuilder::default();
        let square = |r: f64| polygon::rectangle(DVec2::splat(-r), DVec2::splat(r));
        let disc = |r: f64| -> Vec<DVec2> {
            (0..8)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 8.0);
                    DVec2::new(c, s) * r
                })
                .collect()
        };
        match self {
            Self::Well => {
                b.prism(BODY, BODY, &disc(1.7), -0.4, 0.16, Wall::PLAIN);
                b.prism(BODY, BODY, &disc(1.25), -0.3, 0.32, Wall::PLAIN);
                b.frustum(BODY, CLOTH, &disc(0.62), &disc(0.8), 0.2, 1.25);
            }
            Self::Parasol => {
                b.limb(BODY, DVec3::new(0.0, 0.0, -0.4), DVec3::new(0.0, 0.0, 2.4), [0.04, 0.04], 5);
                b.frustum(CLOTH, CLOTH, &square(1.45), &square(0.1), 2.2, 2.85);
                b.prism(BODY, BODY, &disc(0.45), 0.68, 0.75, Wall::PLAIN);
            }
            Self::Stall => {
                b.block(BODY, BODY, DVec2::ZERO, DVec2::X, DVec2::new(1.2, 0.7), -0.4, 1.0);
                for (x, y) in [(-1.3, -0.9), (1.3, -0.9), (1.3, 0.9), (-1.3, 0.9)] {
                    b.block(BODY, BODY, DVec2::new(x, y), DVec2::X, DVec2::splat(0.05), -0.4, 2.3);
                }
                let roof = polygon::rectangle(DVec2::new(-1.6, -1.2), DVec2::new(1.6, 1.2));
                b.frustum(CLOTH, CLOTH, &roof, &polygon::mitred(&roof, 0.8), 2.2, 2.7);
            }
            Self::Bench => b.block(BODY, BODY, DVec2::ZERO, DVec2::X, DVec2::new(0.9, 0.25), -0.4, 0.45),
            Self::Person => {
                b.block(BODY, BODY, DVec2::ZERO, DVec2::X, DVec2::new(0.13, 0.18), -0.4, 0.85);
                b.block(CLOTH, CLOTH, DVec2::ZERO, DVec2::X, DVec2::new(0.15, 0.25), 0.8, 1.45);
                b.block(BODY, BODY, DVec2::ZERO, DVec2::X, DVec2::new(0.1, 0.09), 1.42, 1.72);
            }
            Self::Briccola => {
                for k in 0..3 {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 3.0);
                    let d = DVec3::new(c, s, 0.0);
                    b.limb(
                        BODY,
                        d * 0.65 - DVec3::Z * 1.5,
                        d * 0.16 + DVec3::Z * (2.4 + 0.5 * f64::from(k == 0)),
                        [0.16, 0.14],
                        6,
                    );
                }
            }
            Self::Pile => b.limb(BODY, DVec3::new(0.0, 0.0, -1.5), DVec3::new(0.03, 0.05, 2.1), [0.12, 0.1], 6),
        }
        b.finish()
    }
}

/// A thing in its place.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// What.
    pub thing: Thing,
    /// Where in the world, m.
    pub at: DVec2,
    /// Direction of its x.
    pub axis: DVec2,
    /// Which of the cloths.
    pub cloth: usize,
    /// Its path below the city's.
    pub name: String,
}

fn direction(rng: &mut Rng) -> DVec2 {
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    DVec2::new(c, s)
}

/// Things and trees of a piece of open ground. `trees` is a factor on the number of trees.
pub(super) fn furnish(
    outline: &[DVec2],
    open: Open,
    trees: f64,
    name: &str,
    city: &SeedPath,
) -> (Vec<Placed>, Vec<(DVec2, f64, String)>) {
    let path = city.child(name);
    let area = polygon::area(outline);
    let (low, high) = polygon::bounds(outline);
    let somewhere = |rng: &mut Rng, clear_m: f64| {
        (0..12)
            .map(|_| DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y)))
            .find(|p| polygon::contains(outline, *p) && polygon::border_distance(outline, *p) > clear_m)
    };
    let mut things = Vec::new();
    let mut put = |thing: Thing, at: DVec2, axis: DVec2, cloth: usize| {
        let name = format!("{name}/thing/{}", things.len());
        things.push(Placed { thing, at, axis, cloth, name });
    };
    let mut rng = path.child("things").rng();
    if matches!(open, Open::Campo | Open::Campiello) {
        let middle = polygon::centroid(outline) + DVec2::new(rng.signed(), rng.signed()) * 2.0;
        if polygon::border_distance(outline, middle) > 2.5 && polygon::contains(outline, middle) {
            put(Thing::Well, middle, DVec2::X, 4);
        }
        let axis = direction(&mut rng);
        if open == Open::Campo {
            // Tables of one or two cafés, stalls in a row.
            for _ in 0..=rng.below(2) {
                let cloth = rng.below(4) as usize;
                if let Some(at) = somewhere(&mut rng, 5.0) {
                    for (x, y) in (0..4).flat_map(|x| (0..2).map(move |y| (f64::from(x), f64::from(y)))) {
                        let p = at + axis * (x * 3.3 - 5.0) + axis.perp() * (y * 3.2);
                        if polygon::contains(outline, p)
                            && polygon::border_distance(outline, p) > 2.2
                            && rng.chance(0.8)
                        {
                            put(Thing::Parasol, p, axis, cloth);
                        }
                    }
                }
            }
            if rng.chance(0.5)
                && let Some(at) = somewhere(&mut rng, 5.0)
            {
                for x in 0..=rng.below(5) {
                    let p = at + axis.perp() * (x as f64 * 3.8);
                    if polygon::contains(outline, p) && polygon::border_distance(outline, p) > 2.5 {
                        put(Thing::Stall, p, axis.perp(), rng.below(4) as usize);
                    }
                }
            }
            for _ in 0..6 {
                if let Some(at) = somewhere(&mut rng, 1.5) {
                    put(Thing::Bench, at, axis, 0);
                }
            }
        }
        for _ in 0..(area / 75.0) as u32 {
            if let Some(at) = somewhere(&mut rng, 0.8) {
                let cloth = rng.below(6) as usize;
                put(Thing::Person, at, direction(&mut rng), cloth);
            }
        }
    }
    let mut planted = Vec::new();
    let (wanted, size) = match open {
        Open::Campo => (path.child("how many trees").rng().below(5) as f64, 0.85),
        Open::Campiello => (0.6, 0.7),
        Open::Court => (area / 190.0, 0.5),
        Open::Garden => (area / 26.0 + 0.8, 0.75),
    };
    let mut rng = path.child("trees").rng();
    let count = libm::floor(wanted * trees + rng.unit()) as u64;
    for k in 0..count {
        let key = format!("{name}/tree/{k}");
        let mut rng = city.child(&key).rng();
        if let Some(at) = somewhere(&mut rng, 1.3) {
            let room = (polygon::border_distance(outline, at) / 3.0).clamp(0.5, 1.1);
            planted.push((at, size * room, key));
        }
    }
    (things, planted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn things_are_closed_and_rooted() {
        for thing in Thing::ALL {
            let m = thing.mesh();
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{thing:?}");
            assert!(m.bounds_m().unwrap().0.z <= -0.39, "{thing:?}");
        }
    }
}
