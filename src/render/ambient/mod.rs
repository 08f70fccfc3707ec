//! Light from the dome and by one bounce, worked out once per scene.
//!
//! It does not depend on the camera, and a scene serves hundreds of views: so it is known on a lattice in the world and
//! interpolated. A surface point asks the lattice of the axis that its normal leans to most. On that axis's lattice lines,
//! 1 m apart, a node is the first surface that faces the asker's way inside a slab of 2 m; it holds the vector irradiance
//! (Lambert's light vector, Gershun 1939) of 64 fixed directions, so that a bumpy normal is answered too: `E = n . V`.
//! Leaves have a wider lattice of fewer directions.
//!
//! A block of 4 x 4 nodes is a pure function of the scene, its light and the block's own place: who asks first, on which
//! thread, in which shard or crop, changes nothing. Where no node of a slab is near enough to the asker's own plane, the
//! lattice does not answer, and the point samples its dome by itself.

mod block;
mod lattice;
mod store;
#[cfg(test)]
mod tests;

use super::light::Light;
use block::{Block, Dome};
use glam::DVec3;
use lattice::{BlockKey, Corner, Face, Scale};
use satseed_scene::Bands;
use satseed_tracer::Tracer;
use store::Store;

/// Distance of a neighbouring node from the asker's plane at which it counts half, m: less than the depth of a window's
/// recess, so that what lies in it does not darken the wall beside it.
const HALF_WEIGHT_M: f64 = 0.1;
/// Below this share of nodes that fit, the lattice does not answer.
const LEAST_WEIGHT: f64 = 0.3;

/// What a point of a surface asks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ask {
    /// Where, m.
    pub point_m: DVec3,
    /// Normal of the surface on the side that is lit.
    pub geometric: DVec3,
    /// Normal for shading on the same side.
    pub normal: DVec3,
    /// Whether it is a leaf: one of many about it that lie in every direction, so that what their neighbourhood receives
    /// is what they receive.
    pub leaf: bool,
}

impl Ask {
    fn corners(&self) -> [Corner; 4] {
        let scale = if self.leaf { Scale::Foliage } else { Scale::Surface };
        Face::towards(self.geometric).corners(scale, self.point_m)
    }
}

/// Irradiance from everything but the sun itself, for all views of a scene under one light.
#[derive(Debug)]
pub(super) struct Ambient {
    dome: Dome,
    store: Store,
}

impl Ambient {
    /// Empty; it fills as points ask. At most `most_bytes` are kept, what goes beyond is worked out each time.
    pub(super) fn new(light: &Light, most_bytes: usize) -> Self {
        Self { dome: Dome::new(light), store: Store::new(most_bytes) }
    }

    /// Bytes that may come to be kept for a scene of this size: eight nodes for each square metre.
    pub(super) fn most_bytes(radius_m: f64) -> u64 {
        let side = libm::ceil(2.0 * radius_m) as u64 + 1;
        8 * side * side * Store::BYTES_OF_A_NODE as u64
    }

    /// Irradiance at points, W / (m^2 um); none where the lattice has no answer. Neighbouring points cost least.
    pub(super) fn irradiance(&self, tracer: &Tracer, light: &Light, asks: &[Ask]) -> Vec<Option<Bands>> {
        let corners: Vec<[Corner; 4]> = asks.iter().map(Ask::corners).collect();
        let mut keys: Vec<BlockKey> = Vec::with_capacity(asks.len());
        for corner in corners.iter().flatten() {
            // Most corners lie in a block that was asked for just before: sorting all of them costs more than finding out.
            if !keys.iter().rev().take(4).any(|key| *key == corner.block) {
                keys.push(corner.block);
            }
        }
        keys.sort_unstable();
        keys.dedup();
        let blocks: Vec<Block> =
            keys.iter().map(|key| self.store.get(*key, || Block::new(tracer, light, &self.dome, *key))).collect();
        let mut last = 0;
        let mut found = |c: &Corner| {
            if keys[last] != c.block {
                last = keys.binary_search(&c.block).expect("the block of every corner was fetched");
            }
            blocks[last].node(c.node)
        };
        asks.iter()
            .zip(&corners)
            .map(|(ask, corners)| {
                let (mut sum, mut total) = (Bands::ZERO, 0.0);
                for corner in corners {
                    let Some(node) = found(corner) else { continue };
                    let fit = if ask.leaf { 1.0 } else { node.fit(ask) };
                    let weight = corner.weight * fit;
                    sum += node.irradiance(ask.normal) * weight as f32;
                    total += weight;
                }
                (total >= LEAST_WEIGHT).then(|| sum * (1.0 / total) as f32)
            })
            .collect()
    }
}
