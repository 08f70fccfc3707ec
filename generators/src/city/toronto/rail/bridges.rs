//! Bridges over the corridor: streets on rows of columns, footbridges where streets end.

use super::works::{Part, slot};
use super::{Corridor, DEPTH_M, WALL_M};
use crate::city::toronto::relief::Swells;
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use crate::kit::streets::Street;
use crate::kit::sweep::{self, Station};
use glam::{DVec2, DVec3};
use satseed_scene::{Class, Mesh, SeedPath};

/// Thickness of a road's deck, m.
const DECK_M: f64 = 1.5;

/// A place along a street as a station of its bridge, in the bridge's frame, and how the ground leans to the right there.
struct Over<'a> {
    relief: &'a Swells,
    street: &'a Street,
    middle_m: f64,
    base_m: f64,
    half_m: f64,
}

impl<'a> Over<'a> {
    fn new(corridor: &Corridor, relief: &'a Swells, street: &'a Street, beyond_m: f64) -> Self {
        let middle = street.crossing(0.0, &corridor.line, 0.0);
        let middle_m = street.along(middle);
        let lean = street.direction.perp_dot(corridor.line.direction).abs();
        Self { relief, street, middle_m, base_m: relief.height_m(middle), half_m: corridor.half_m / lean + beyond_m }
    }

    fn height_m(&self, along: f64, left: f64) -> f64 {
        self.relief.height_m(self.street.at(self.middle_m + along, left)) - self.base_m
    }

    fn station(&self, k: usize, steps: usize) -> Station {
        let along = self.half_m * (2.0 * k as f64 / steps as f64 - 1.0);
        Station { at: DVec2::new(along, 0.0), direction: DVec2::X, height_m: self.height_m(along, 0.0) }
    }

    /// A section that leans as the ground does.
    fn sweep(&self, b: &mut MeshBuilder, width_m: f64, section: &[DVec2], slots: &[u16]) {
        let steps = libm::ceil(self.half_m / 4.0) as usize;
        let leaning = |k: usize| -> Vec<DVec2> {
            let along = self.station(k, steps).at.x;
            let tilt = (self.height_m(along, -width_m) - self.height_m(along, width_m)) / (2.0 * width_m);
            section.iter().map(|c| DVec2::new(c.x, c.y + tilt * c.x)).collect()
        };
        sweep::solid(b, &|k| self.station(k, steps), 0..=steps, &leaning, slots);
    }

    fn part(&self, name: String, mesh: Mesh, street_kind: u16) -> Part {
        let origin = self.street.at(self.middle_m, 0.0).extend(self.base_m);
        Part { name, mesh, class: Class::Bridge, origin, axis: self.street.direction, track: false, street_kind }
    }
}

/// Piers under a bridge: rows of columns in the gaps between groups of tracks and at the feet of banks, `offsets` across.
fn piers(b: &mut MeshBuilder, corridor: &Corridor, over: &Over<'_>, offsets: &[f64], half_m: f64, under_m: f64) {
    let lean = corridor.line.direction;
    let mut rows = corridor.gaps_m.clone();
    let [right, left] = corridor.floor_m();
    if corridor.run_m[0] > WALL_M {
        rows.push(right + 0.9);
    }
    if corridor.run_m[1] > WALL_M {
        rows.push(left - 0.9);
    }
    let d = over.street.direction;
    // The corridor's direction in the bridge's frame.
    let row_axis = DVec2::new(lean.dot(d), d.perp_dot(lean));
    for row in rows {
        let world = over.street.crossing(0.0, &corridor.line, row);
        let along = over.street.along(world) - over.middle_m;
        let top = over.height_m(along, 0.0) - under_m;
        for offset in offsets {
            let at = DVec2::new(along, 0.0) + row_axis * (*offset / row_axis.y.abs().max(0.5));
            let low = over.height_m(at.x, at.y) - DEPTH_M - 1.0;
            let column = polygon::oriented_rectangle(at, row_axis, DVec2::new(0.55, 0.45));
            b.prism(slot::CONCRETE, slot::CONCRETE, &polygon::rounded(&column, 0.3, 1), low, top - 0.5, Wall::PLAIN);
        }
        let cap = polygon::oriented_rectangle(DVec2::new(along, 0.0), row_axis, DVec2::new(half_m, 0.7));
        b.prism(slot::CONCRETE, slot::CONCRETE, &cap, top - 0.9, top + 0.12, Wall::PLAIN);
    }
}

/// A street's bridge: a deck with sidewalks and parapets on rows of columns.
pub(super) fn road_bridge(corridor: &Corridor, relief: &Swells, index: i64, street: &Street, key: &SeedPath) -> Part {
    let mut rng = key.rng();
    let over = Over::new(corridor, relief, street, 1.4);
    let mut b = MeshBuilder::default();
    let w = street.section.right_of_way_m() / 2.0;
    let r = street.section.roadway_m / 2.0;
    let guard = rng.range(1.05, 1.9);
    // A little above the street's own surfaces, which it meets behind the walls.
    let (road, walk) = (-0.13, 0.02);
    let section = [
        (-w + 0.7, -DECK_M),
        (w - 0.7, -DECK_M),
        (w, -0.7),
        (w, guard),
        (w - 0.28, guard),
        (w - 0.28, walk),
        (r, walk),
        (r, road),
        (-r, road),
        (-r, walk),
        (-w + 0.28, walk),
        (-w + 0.28, guard),
        (-w, guard),
        (-w, -0.7),
    ]
    .map(|(x, y)| DVec2::new(x, y));
    let c = slot::CONCRETE;
    let slots = [c, c, c, c, c, slot::SIDEWALK, c, slot::ROAD, c, slot::SIDEWALK, c, c, c, c];
    over.sweep(&mut b, w, &section, &slots);
    let count = libm::ceil(2.0 * w / 6.0);
    let offsets: Vec<f64> = (0..count as u32).map(|k| (w - 1.4) * (2.0 * f64::from(k) / (count - 1.0) - 1.0)).collect();
    piers(&mut b, corridor, &over, &offsets, w - 0.6, DECK_M);
    // Railing posts on the parapets, lamps at the kerbs.
    let mut x = -over.half_m + 2.0;
    while x < over.half_m - 1.0 {
        for side in [-1.0, 1.0] {
            let y = side * (w - 0.14);
            let z = over.height_m(x, y);
            b.block(
                slot::STEEL,
                slot::STEEL,
                DVec2::new(x, y),
                DVec2::X,
                DVec2::splat(0.06),
                z + guard - 0.3,
                z + guard + 0.45,
            );
        }
        x += 4.0;
    }
    over.part(format!("rail/bridge/{index}"), b.finish(), street.section.kind)
}

/// A covered footbridge where a street ends: glazed, or open between trusses.
pub(super) fn foot_bridge(corridor: &Corridor, relief: &Swells, index: i64, street: &Street, key: &SeedPath) -> Part {
    let mut rng = key.rng();
    let over = Over::new(corridor, relief, street, 3.2);
    let mut b = MeshBuilder::default();
    let w = rng.range(1.7, 2.3);
    let deck = |low: f64, high: f64, half: f64| {
        [(-half, low), (half, low), (half, high), (-half, high)].map(|(x, y)| DVec2::new(x, y))
    };
    over.sweep(&mut b, w, &deck(-0.55, 0.06, w), &[slot::STEEL, slot::STEEL, slot::PLATFORM, slot::STEEL]);
    let covered = rng.chance(0.5);
    let top = if covered { 2.9 } else { 1.35 };
    for side in [-1.0, 1.0] {
        let shift = |s: [DVec2; 4]| s.map(|c| DVec2::new(c.x + side * (w - 0.06), c.y));
        let (slot_of, high) = if covered { (slot::GLASS, top) } else { (slot::STEEL, 0.3) };
        over.sweep(&mut b, w, &shift(deck(-0.4, high, 0.05)), &[slot_of; 4]);
        over.sweep(&mut b, w, &shift(deck(top - 0.1, top + 0.05, 0.09)), &[slot::STEEL; 4]);
        let mut x = -over.half_m + 0.3;
        while x + 2.6 < over.half_m {
            let y = -side * (w - 0.06);
            let at = |x: f64, z: f64| DVec3::new(x, y, over.height_m(x, y) + z);
            b.limb(slot::STEEL, at(x, -0.3), at(x, top), [0.07; 2], 4);
            if !covered {
                b.limb(slot::STEEL, at(x, top), at(x + 2.6, -0.2), [0.05; 2], 4);
            }
            x += 2.6;
        }
    }
    if covered {
        let roof = [(-w - 0.3, top), (w + 0.3, top), (0.0, top + 0.55)].map(|(x, y)| DVec2::new(x, y));
        over.sweep(&mut b, w, &roof, &[slot::STEEL, slot::ROOF, slot::ROOF]);
    }
    piers(&mut b, corridor, &over, &[0.0], w - 0.3, 0.55);
    over.part(format!("rail/footbridge/{index}"), b.finish(), 0)
}
