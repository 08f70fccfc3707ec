//! Floating docks as meshes: a walk with fingers between the berths, its gangway and the piles that hold it; and fixed
//! timber piers.
//!
//! x runs from the shore out, z = 0 is the water.

use super::harbour::WATER_M;
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, Rng};

/// Slots of a dock's material set.
pub(in super::super) mod slot {
    /// Boards.
    pub(in super::super::super) const DECK: u16 = 0;
    /// Floats and frames.
    pub(in super::super::super) const FLOAT: u16 = 1;
    /// Piles.
    pub(in super::super::super) const PILE: u16 = 2;
    /// Boxes at the berths.
    pub(in super::super::super) const BOX: u16 = 3;
    /// Metal of gangways.
    pub(in super::super::super) const METAL: u16 = 4;
    /// How many.
    pub(in super::super::super) const COUNT: usize = 5;
}

/// Height of a floating deck above the water, m.
pub(in super::super) const FREEBOARD_M: f64 = 0.5;
/// Half width of a walk, m.
pub(super) const WALK_M: f64 = 1.15;
/// Half width of a finger, m.
const FINGER_M: f64 = 0.55;
/// Where a walk begins, from the water's line, m.
const BEGIN_M: f64 = 4.0;
/// Where a gangway comes down on it, m.
const LANDING_M: f64 = 13.0;

/// A floating dock in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct Dock {
    /// Length of the walk from the water's line, m.
    pub(super) length_m: f64,
    /// Where fingers leave it, m, the same on both sides.
    pub(super) fingers: Vec<f64>,
    /// Length of a finger, m.
    pub(super) reach_m: f64,
    /// Half length of the head across its end, m.
    pub(super) head_m: f64,
}

fn boards(b: &mut MeshBuilder, low: DVec2, high: DVec2, top_m: f64) {
    let outline = polygon::rectangle(low, high);
    b.prism(slot::FLOAT, slot::FLOAT, &polygon::mitred(&outline, 0.08), -0.3, top_m - 0.1, Wall::PLAIN);
    b.prism(slot::FLOAT, slot::DECK, &outline, top_m - 0.16, top_m, Wall::PLAIN);
}

fn pile(b: &mut MeshBuilder, at: DVec2, top_m: f64) {
    b.limb(slot::PILE, at.extend(-2.0), at.extend(top_m), [0.19, 0.19], 7);
}

impl Dock {
    pub(super) fn mesh(&self, rng: &mut Rng) -> Mesh {
        let mut b = MeshBuilder::default();
        let p = DVec2::new;
        boards(&mut b, p(BEGIN_M, -WALK_M), p(self.length_m, WALK_M), FREEBOARD_M);
        let top_m = rng.range(2.6, 3.4);
        for (k, x) in self.fingers.iter().enumerate() {
            for side in [-1.0, 1.0] {
                let (near, far) = (side * (WALK_M - 0.3), side * (WALK_M + self.reach_m));
                boards(&mut b, p(x - FINGER_M, near.min(far)), p(x + FINGER_M, near.max(far)), FREEBOARD_M - 0.03);
                pile(&mut b, p(*x, far + side * 0.26), top_m);
                if k % 3 == 1 {
                    pile(&mut b, p(x + FINGER_M + 0.3, side * (WALK_M + 0.25)), top_m);
                }
                if rng.chance(0.75) {
                    let at = p(x + 0.1, side * (WALK_M - 0.35));
                    b.block(slot::BOX, slot::BOX, at, DVec2::X, p(0.5, 0.26), FREEBOARD_M - 0.05, FREEBOARD_M + 0.6);
                }
            }
        }
        let end = self.length_m;
        boards(&mut b, p(end - 0.3, -self.head_m), p(end + 2.2, self.head_m), FREEBOARD_M - 0.05);
        for y in [-self.head_m + 1.0, 0.0, self.head_m - 1.0] {
            pile(&mut b, p(end - 0.6, y), top_m);
        }
        self.gangway(&mut b);
        b.finish()
    }

    /// A sloping bridge from the land: a box whose ends are upright.
    #[allow(clippy::unused_self)]
    fn gangway(&self, b: &mut MeshBuilder) {
        let (from, to) = (DVec2::new(-1.6, -WATER_M + 0.12), DVec2::new(LANDING_M, FREEBOARD_M + 0.1));
        let p = |x: DVec2, y: f64, lift: f64| DVec3::new(x.x, y, x.y + lift);
        let mut beam = |y0: f64, y1: f64, low: f64, high: f64, top: u16| {
            let ring = |lift: f64| [p(from, y0, lift), p(to, y0, lift), p(to, y1, lift), p(from, y1, lift)];
            let (bottom, over) = (ring(low), ring(high));
            let uv = |v: DVec3| (v, DVec2::new(v.x, v.y));
            b.fan(top, &over.map(uv));
            b.fan(slot::METAL, &[bottom[3], bottom[2], bottom[1], bottom[0]].map(uv));
            for k in 0..4 {
                let n = (k + 1) % 4;
                b.fan(slot::METAL, &[bottom[k], bottom[n], over[n], over[k]].map(uv));
            }
        };
        beam(-0.75, 0.75, -0.15, 0.0, slot::METAL);
        for y in [-0.75, 0.75] {
            beam(y - 0.05, y + 0.05, -0.2, 0.95, slot::METAL);
        }
    }
}

/// A fixed pier of timber on piles: a deck of a length and half width with a wider end, and a hut there; its deck stands as high as the land.
pub(super) fn pier(length_m: f64, half_m: f64) -> Mesh {
    let mut b = MeshBuilder::default();
    let p = DVec2::new;
    let deck = -WATER_M + 0.14;
    let mut slab = |low: DVec2, high: DVec2| {
        b.prism(slot::FLOAT, slot::DECK, &polygon::rectangle(low, high), deck - 0.45, deck, Wall::PLAIN);
        let (nx, ny) = (libm::ceil((high.x - low.x) / 4.5) as u32, libm::ceil((high.y - low.y) / 3.6) as u32);
        for i in 0..=nx {
            for j in 0..=ny {
                let share = p(f64::from(i) / f64::from(nx), f64::from(j) / f64::from(ny));
                let at = low + p(0.35, 0.35) + (high - low - p(0.7, 0.7)) * share;
                b.limb(slot::PILE, at.extend(-2.2), at.extend(deck - 0.3), [0.2, 0.2], 6);
            }
        }
        for y in [low.y + 0.08, high.y - 0.08] {
            b.block(
                slot::FLOAT,
                slot::FLOAT,
                p(f64::midpoint(low.x, high.x), y),
                DVec2::X,
                p((high.x - low.x) / 2.0, 0.06),
                deck - 0.1,
                deck + 1.0,
            );
        }
    };
    slab(p(-5.0, -half_m), p(length_m - 11.0, half_m));
    slab(p(length_m - 11.4, -half_m - 4.2), p(length_m, half_m + 4.2));
    let hut = polygon::rectangle(p(length_m - 9.0, -half_m - 2.4), p(length_m - 2.6, half_m + 0.6));
    b.prism(slot::BOX, slot::BOX, &polygon::mitred(&hut, 0.3), deck - 0.1, deck + 2.9, Wall::PLAIN);
    let ridge = polygon::mitred(&hut, 2.6);
    b.frustum(slot::METAL, slot::METAL, &polygon::mitred(&hut, -0.4), &ridge, deck + 2.8, deck + 4.3);
    b.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;
    use satseed_scene::SeedPath;

    #[test]
    fn docks_are_closed_and_float() {
        let dock = Dock { length_m: 58.0, fingers: vec![20.0, 30.0, 40.0, 50.0], reach_m: 11.0, head_m: 14.0 };
        let m = dock.mesh(&mut SeedPath::root("dock", 1).rng());
        assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
        let decks = m.triangles.iter().zip(&m.slots).filter(|(_, s)| **s == slot::DECK);
        for z in decks.flat_map(|(t, _)| t.map(|v| m.positions_m[v as usize][2])) {
            // The undersides of the boards are of the same slot.
            assert!((0.25..=0.8).contains(&z), "{z}");
        }
        let m = pier(40.0, 3.0);
        assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
    }
}
