//! Blocks of flats: long slabs, staggered and bent ones, crosses and three-winged ones, of 10 to 20 storeys.

use crate::city::toronto::massing::{Building, Frame, GROUNDED, Kind, Relief, balconies, flat, grounded, penthouse};
use crate::kit::buildings::{Facade, Furnishing, Mass, furnish};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// Outline of a block in its own frame: x along it, the entrance towards -y.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    /// Counter-clockwise corners.
    pub(super) outline: Vec<DVec2>,
    /// Where the entrance is.
    pub(super) door: DVec2,
    /// Where its lifts come out on the roof.
    lifts: Vec<DVec2>,
    /// Width of a wing, m.
    wing_m: f64,
}

impl Shape {
    /// Half the sizes of what it covers, from its frame's origin.
    pub(super) fn half(&self) -> DVec2 {
        self.outline.iter().fold(DVec2::ZERO, |h, p| h.max(p.abs()))
    }

    /// A bar of a length and depth: straight, its halves staggered, or bent in the middle.
    pub(super) fn bar(length_m: f64, depth_m: f64, rng: &mut Rng) -> Self {
        let (l, t) = (length_m / 2.0, depth_m / 2.0);
        let p = DVec2::new;
        let half = |sign: f64, y: f64| p(sign * l * 0.5, y);
        match rng.weighted(&[0.55, 0.27, 0.18]) {
            0 => Self {
                outline: polygon::rectangle(p(-l, -t), p(l, t)),
                door: p(0.0, -t),
                lifts: vec![p(rng.signed() * l * 0.2, 0.0)],
                wing_m: depth_m,
            },
            1 => {
                let o = rng.range(2.0, 3.5) * if rng.chance(0.5) { 1.0 } else { -1.0 };
                let c = rng.range(-0.15, 0.15) * l;
                let outline = [
                    (-l, -t - o),
                    (c, -t - o),
                    (c, -t + o),
                    (l, -t + o),
                    (l, t + o),
                    (c, t + o),
                    (c, t - o),
                    (-l, t - o),
                ];
                Self {
                    outline: outline.map(|(x, y)| p(x, y)).to_vec(),
                    door: p(-l * 0.5, -t - o),
                    lifts: vec![half(-1.0, -o), half(1.0, o)],
                    wing_m: depth_m,
                }
            }
            _ => {
                // The ends lie further back than the middle, by an angle of up to 15 degrees each.
                let back = l * rng.range(0.12, 0.26);
                let outline = [(-l, -t + back), (0.0, -t), (l, -t + back), (l, t + back), (0.0, t), (-l, t + back)];
                let outline = outline.map(|(x, y)| p(x, y - back / 2.0)).to_vec();
                Self {
                    outline,
                    door: p(0.0, -t - back / 2.0),
                    lifts: vec![half(-1.0, 0.0), half(1.0, 0.0)],
                    wing_m: depth_m,
                }
            }
        }
    }

    /// A tower with three or four wings around its lifts.
    pub(super) fn winged(reach_m: f64, wing_m: f64, rng: &mut Rng) -> Self {
        let wings = if rng.chance(0.5) { 3_u32 } else { 4 };
        let w = wing_m / 2.0;
        let step = core::f64::consts::TAU / f64::from(wings);
        let start =
            -core::f64::consts::FRAC_PI_2 + if wings == 4 { step / 2.0 * rng.below(2) as f64 } else { step / 2.0 };
        let turned = |angle: f64| {
            let (s, c) = libm::sincos(angle);
            DVec2::new(c, s)
        };
        let mut outline = Vec::new();
        for k in 0..wings {
            let angle = start + step * f64::from(k);
            let d = turned(angle);
            let reach = reach_m * rng.range(0.85, 1.0);
            outline.push(d * reach - d.perp() * w);
            outline.push(d * reach + d.perp() * w);
            outline.push(turned(angle + step / 2.0) * (w / libm::sin(step / 2.0)));
        }
        let low = outline.iter().map(|p| p.y).fold(f64::MAX, f64::min);
        Self { outline, door: DVec2::new(0.0, low), lifts: vec![DVec2::ZERO], wing_m }
    }
}

fn plain(outline: Vec<DVec2>, low_m: f64, roof_m: f64, parapet_m: f64) -> Mass {
    Mass {
        outline,
        low_m,
        roof_m,
        first_floor_m: 0.0,
        floor_m: 3.0,
        bay_m: 0.0,
        shop: false,
        facade: Facade::Plain,
        roof: flat(parapet_m),
        balconies: Vec::new(),
    }
}

/// A block of a shape and number of storeys in a frame of the world.
pub(super) fn flats(frame: &Frame, shape: &Shape, storeys: u32, relief: &Relief<'_>, path: &SeedPath) -> Building {
    let mut rng = path.child("flats").rng();
    let first_floor_m = rng.range(3.2, 4.2);
    let floor_m = rng.range(2.7, 2.85);
    // Above the first floor's slab lie all storeys but the entrance hall's.
    let roof_m = first_floor_m + floor_m * f64::from(storeys - 1);
    let bay_m = rng.range(3.2, 4.4);
    let facade = match rng.weighted(&[0.62, 0.38]) {
        0 => Facade::Punched {
            recess_m: rng.range(0.14, 0.22),
            band_m: rng.range(1.15, 1.55),
            pier_m: rng.range(0.5, 1.9),
            proud_m: rng.range(-0.03, 0.06),
        },
        _ => Facade::Slabs {
            recess_m: rng.range(0.15, 0.25),
            slab_m: rng.range(0.22, 0.35),
            pier_every: 1 + rng.below(2) as u32,
        },
    };
    let parapet_m = rng.range(0.5, 0.9);
    let outline = shape.outline.clone();
    let length = |k: usize| outline[k].distance(outline[(k + 1) % outline.len()]);
    let mut masses = vec![Mass {
        // Ends of wings have none.
        balconies: balconies(&outline, bay_m, &mut rng)
            .into_iter()
            .filter(|b| length(b.edge) > shape.wing_m + 0.5)
            .collect(),
        outline: outline.clone(),
        low_m: GROUNDED,
        roof_m,
        first_floor_m,
        floor_m,
        bay_m,
        shop: false,
        facade,
        roof: flat(parapet_m),
    }];
    // The ends are walls without windows, a little wider than the block.
    if rng.chance(0.75) {
        for k in (0..outline.len()).filter(|k| (length(*k) - shape.wing_m).abs() < 0.6) {
            let (p, q) = (outline[k], outline[(k + 1) % outline.len()]);
            let along = (q - p).normalize();
            let centre = (p + q) * 0.5 + along.perp() * 0.3;
            let wall = polygon::oriented_rectangle(centre, along, DVec2::new(length(k) / 2.0 + 0.14, 0.45));
            masses.push(plain(wall, GROUNDED, roof_m + parapet_m + 0.06, 0.12));
        }
    }
    // Hall and canopy before the door.
    let door = shape.door + DVec2::new(0.0, 1.0);
    let hall = DVec2::new(rng.range(4.0, 7.0), rng.range(2.2, 3.2));
    masses.push(plain(polygon::rectangle(door - hall, door + DVec2::new(hall.x, 0.5)), GROUNDED, 3.0, 0.2));
    let reach = hall.y + rng.range(1.4, 2.2);
    let canopy = polygon::rectangle(door - DVec2::new(2.4, reach), door + DVec2::new(2.4, 0.0));
    masses.push(plain(canopy, 3.05, 3.5, 0.15));
    for x in [-2.0, 2.0] {
        let post = polygon::oriented_rectangle(door + DVec2::new(x, 0.4 - reach), DVec2::X, DVec2::splat(0.32));
        masses.push(plain(post, GROUNDED, 3.2, 0.05));
    }
    let mut above = Vec::new();
    for at in &shape.lifts {
        let room = rng.range(3.6, 5.6);
        let mass = penthouse(*at, DVec2::new(rng.range(9.0, 13.0), shape.wing_m / 2.0 - 1.0), roof_m, &mut rng);
        above.push(mass.outline.clone());
        masses.push(Mass { roof_m: roof_m + room, floor_m: room, ..mass });
    }
    let what = Furnishing { base_m: roof_m, machines: 0.15, panels: 0.04, beds: 0.0, bulkhead: 0.8 };
    let items = furnish(&outline, &above, what, &path.child("roof"));
    let mut plan = grounded(frame, relief, masses);
    plan.items = items;
    Building { kind: Kind::Flats, plan }
}
