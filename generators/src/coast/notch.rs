//! The notch that the sea wears into the foot of cliffs.

use super::shore::Shore;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::overhang::{Inward, Undercut};
use crate::kit::terrain::sampling::{blurred, smoothstep};
use glam::{DVec2, DVec3};
use satseed_scene::SeedPath;

/// Where the notch begins and ends, m above the sea: what storms reach.
const LOW_M: f64 = 1.5;
const HIGH_M: f64 = 4.2;
/// Its greatest depth, m.
const DEPTH_M: f64 = 2.8;

/// The notch of one coast.
pub(super) struct Notch<'a> {
    shore: &'a Shore,
    /// Away from the sea.
    inward: Inward,
    seed: u32,
    /// Half the side of the square of full detail, m.
    detail_half_m: f64,
}

/// How far beyond the full detail the notch begins to fade and ends, m: the world's own border stays straight, and what normals
/// at the detail's border ask of is the same whatever the radius.
const FADE_M: [f64; 2] = [1.0, 60.0];

impl<'a> Notch<'a> {
    pub(super) fn new(shore: &'a Shore, detail_half_m: f64, path: &SeedPath) -> Self {
        let inward = Inward::new(&blurred(shore.inland().clone(), 2), |_, _| 1.0);
        Self { shore, inward, seed: path.hash_u32(), detail_half_m }
    }
}

impl Undercut for Notch<'_> {
    fn shift_m(&self, p: DVec3) -> DVec2 {
        if p.z <= LOW_M || p.z >= HIGH_M {
            return DVec2::ZERO;
        }
        let plan = p.truncate();
        let place = self.shore.at(plan);
        // Rock alone, and no farther from the sea than its waves throw stones.
        let here = smoothstep(0.45, 0.15, place.sandy)
            * smoothstep(-5.0, 2.0, place.inland_m)
            * smoothstep(32.0, 20.0, place.inland_m)
            * smoothstep(FADE_M[1], FADE_M[0], plan.abs().max_element() - self.detail_half_m);
        if here == 0.0 {
            return DVec2::ZERO;
        }
        // Softer rock recedes farther.
        let along = smoothstep(-0.45, 0.5, fractal(plan, self.seed, 30.0, 2, 0.5));
        let profile = smoothstep(LOW_M, LOW_M + 0.5, p.z) * smoothstep(HIGH_M, HIGH_M - 0.8 - 0.8 * along, p.z);
        self.inward.at(plan) * (DEPTH_M * here * along * profile)
    }
}
