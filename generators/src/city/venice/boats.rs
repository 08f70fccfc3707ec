//! Boats: hulls of several sizes, closed, on the water.
//!
//! x is forward, z = 0 the water.

use crate::kit::mesh_builder::{BlockSlots, MeshBuilder, Parapet, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::Mesh;

/// Slots of a boat's material set.
pub(super) mod slot {
    /// Hull.
    pub(in super::super) const HULL: u16 = 0;
    /// Gunwale and foredeck.
    pub(in super::super) const TRIM: u16 = 1;
    /// Floor and benches.
    pub(in super::super) const FLOOR: u16 = 2;
    /// Tarpaulin or cargo.
    pub(in super::super) const COVER: u16 = 3;
    /// Cabin.
    pub(in super::super) const CABIN: u16 = 4;
    /// Windows.
    pub(in super::super) const GLASS: u16 = 5;
    /// Motors, ropes.
    pub(in super::super) const DARK: u16 = 6;
    /// How many.
    pub(in super::super) const COUNT: usize = 7;
}

/// Kinds of boats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Boat {
    /// Small wooden boat.
    Sandolo,
    /// Open motorboat.
    Cofano,
    /// The same under its tarpaulin.
    Covered,
    /// Barge with goods.
    Barge,
    /// Water taxi.
    Taxi,
    /// Gondola.
    Gondola,
    /// Water bus.
    Vaporetto,
}

impl Boat {
    /// All kinds.
    pub(super) const ALL: [Self; 7] =
        [Self::Sandolo, Self::Cofano, Self::Covered, Self::Barge, Self::Taxi, Self::Gondola, Self::Vaporetto];

    /// Length and width, m.
    pub(super) fn size_m(self) -> [f64; 2] {
        match self {
            Self::Sandolo => [5.4, 1.45],
            Self::Cofano => [6.0, 2.05],
            Self::Covered => [5.8, 1.95],
            Self::Barge => [10.5, 2.5],
            Self::Taxi => [8.6, 2.3],
            Self::Gondola => [10.9, 1.42],
            Self::Vaporetto => [24.0, 4.3],
        }
    }

    /// Its mesh.
    pub(super) fn mesh(self) -> Mesh {
        let mut b = MeshBuilder::default();
        let [l, w] = self.size_m();
        let at = |x: f64, y: f64| DVec2::new(x * l, y * w);
        let block = |b: &mut MeshBuilder, s: u16, x: f64, y: f64, half: [f64; 2], low: f64, high: f64| {
            b.block(s, s, at(x, y), DVec2::X, DVec2::new(half[0], half[1]), low, high);
        };
        match self {
            Self::Sandolo => {
                hull(&mut b, l, w, 0.34, 0.55, 0.5);
                for x in [-0.25, 0.0, 0.2] {
                    block(&mut b, slot::FLOOR, x, 0.0, [0.14, w * 0.42], 0.2, 0.42);
                }
                motor(&mut b, l);
            }
            Self::Cofano => {
                hull(&mut b, l, w, 0.3, 0.72, 0.8);
                foredeck(&mut b, l, w, 0.14, 0.74);
                block(&mut b, slot::CABIN, 0.02, 0.0, [0.4, 0.5], 0.1, 1.05);
                block(&mut b, slot::GLASS, 0.09, 0.0, [0.05, w * 0.4], 0.6, 1.25);
                block(&mut b, slot::FLOOR, -0.22, 0.0, [0.3, w * 0.4], 0.1, 0.5);
                motor(&mut b, l);
            }
            Self::Covered => {
                hull(&mut b, l, w, 0.3, 0.62, 0.8);
                let foot = outline(l * 0.93, w * 1.02, 0.25, 0.85);
                let top = outline(l * 0.7, w * 0.22, 0.2, 0.9);
                b.frustum(slot::COVER, slot::COVER, &foot, &top, 0.58, 1.0);
                motor(&mut b, l);
            }
            Self::Barge => {
                hull(&mut b, l, w, 0.22, 0.75, 0.9);
                foredeck(&mut b, l, w, 0.26, 0.76);
                block(&mut b, slot::COVER, -0.12, 0.12, [1.3, 0.6], 0.1, 1.25);
                block(&mut b, slot::CABIN, 0.1, -0.1, [0.8, 0.75], 0.1, 1.0);
                block(&mut b, slot::FLOOR, -0.3, -0.05, [0.6, 0.8], 0.1, 0.85);
                block(&mut b, slot::CABIN, -0.41, 0.0, [0.5, 0.6], 0.1, 2.0);
            }
            Self::Taxi => {
                hull(&mut b, l, w, 0.36, 0.85, 0.85);
                foredeck(&mut b, l, w, 0.12, 0.87);
                let body = polygon::rectangle(at(-0.27, -0.4), at(0.08, 0.4));
                b.prism(slot::GLASS, slot::GLASS, &polygon::mitred(&body, 0.05), 0.1, 1.5, Wall::PLAIN);
                b.frustum(slot::CABIN, slot::CABIN, &body, &polygon::mitred(&body, 0.2), 1.42, 1.62);
                block(&mut b, slot::FLOOR, -0.38, 0.0, [0.5, 0.7], 0.1, 0.6);
                block(&mut b, slot::GLASS, 0.15, 0.0, [0.05, 0.8], 0.7, 1.35);
            }
            Self::Gondola => {
                hull(&mut b, l, w, 0.42, 0.5, 0.25);
                foredeck(&mut b, l, w, 0.22, 0.53);
                block(&mut b, slot::COVER, -0.06, 0.0, [0.5, 0.42], 0.1, 0.75);
                block(&mut b, slot::COVER, 0.07, 0.0, [0.28, 0.4], 0.1, 0.45);
                b.limb(slot::DARK, DVec3::new(l * 0.46, 0.0, 0.3), DVec3::new(l * 0.5, 0.0, 1.45), [0.09, 0.05], 4);
                b.limb(slot::DARK, DVec3::new(-l * 0.44, 0.0, 0.3), DVec3::new(-l * 0.49, 0.0, 1.1), [0.08, 0.04], 4);
            }
            Self::Vaporetto => {
                hull(&mut b, l, w, 0.2, 1.0, 0.8);
                let body = polygon::rectangle(at(-0.36, -0.44), at(0.3, 0.44));
                b.prism(slot::GLASS, slot::GLASS, &polygon::mitred(&body, 0.1), 0.3, 2.3, Wall::PLAIN);
                b.prism(slot::CABIN, slot::CABIN, &polygon::mitred(&body, -0.12), 2.25, 2.55, Wall::PLAIN);
                b.prism(slot::CABIN, slot::CABIN, &body, 0.3, 1.3, Wall::PLAIN);
                block(&mut b, slot::CABIN, 0.2, 0.0, [1.1, 1.2], 2.5, 3.3);
                block(&mut b, slot::COVER, -0.12, 0.0, [3.2, 0.5], 2.5, 2.75);
            }
        }
        b.finish()
    }
}

/// The plan of a hull: a pointed bow that begins at a share of the length, and a stern of a share of the width.
fn outline(l: f64, w: f64, bow: f64, stern: f64) -> Vec<DVec2> {
    let (h, x) = (w / 2.0, l / 2.0);
    [
        (-x, -h * stern),
        (-x + l * 0.16, -h),
        (x - l * bow, -h),
        (x - l * bow * 0.42, -h * 0.66),
        (x - l * bow * 0.1, -h * 0.2),
        (x, 0.0),
        (x - l * bow * 0.1, h * 0.2),
        (x - l * bow * 0.42, h * 0.66),
        (x - l * bow, h),
        (-x + l * 0.16, h),
        (-x, h * stern),
    ]
    .map(|(x, y)| DVec2::new(x, y))
    .to_vec()
}

/// An open hull.
fn hull(b: &mut MeshBuilder, l: f64, w: f64, bow: f64, free_m: f64, stern: f64) {
    let rim = outline(l, w, bow, stern);
    let keel = outline(l * 0.93, w * 0.72, bow * 1.1, stern);
    b.frustum(slot::HULL, slot::HULL, &keel, &rim, -0.35, 0.1);
    let slots = BlockSlots { side: slot::HULL, coping: slot::TRIM, strip: slot::FLOOR, roof: slot::FLOOR };
    let shape = Parapet { height_m: free_m - 0.16, width_m: 0.12, strip_m: 0.0 };
    b.parapet_block(slots, &rim, 0.05, 0.16, shape, Wall::PLAIN);
}

fn foredeck(b: &mut MeshBuilder, l: f64, w: f64, from: f64, high_m: f64) {
    let x = l / 2.0;
    let deck = [
        (l * from, -w * 0.4),
        (x - l * 0.15, -w * 0.28),
        (x - l * 0.05, 0.0),
        (x - l * 0.15, w * 0.28),
        (l * from, w * 0.4),
    ]
    .map(|(x, y)| DVec2::new(x, y));
    b.prism(slot::TRIM, slot::TRIM, &deck, 0.2, high_m, Wall::PLAIN);
}

fn motor(b: &mut MeshBuilder, l: f64) {
    b.block(slot::DARK, slot::DARK, DVec2::new(-l / 2.0 - 0.05, 0.0), DVec2::X, DVec2::new(0.22, 0.17), -0.2, 0.95);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn boats_are_closed_afloat_and_of_their_size() {
        for boat in Boat::ALL {
            let m = boat.mesh();
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{boat:?}");
            let (low, high) = m.bounds_m().unwrap();
            let [l, w] = boat.size_m();
            assert!(low.z < -0.2 && high.z > 0.4, "{boat:?}");
            assert!((high.x - low.x - l).abs() < 0.4 && (high.y - low.y - w).abs() < 0.3, "{boat:?} {low} {high}");
        }
    }
}
