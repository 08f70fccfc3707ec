//! Where walls overhang: what lies below a hard bed is worn back, and alcoves arch into the bed itself.

use super::relief::FACE_M;
use super::strata::{Habit, Strata};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::overhang::{Hollow, UNTOLD_M};
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use satseed_scene::{SeedPath, hash_cell, unit_from_hash};

/// How far before a bed's mean line its foot is looked at, m.
const BEFORE_M: f64 = 3.5;
/// The deepest hollow, m.
const DEEPEST_M: f64 = 9.0;
/// Hollows end this far within the radius of full detail, m.
const FADE_M: [f64; 2] = [4.0, 10.0];

/// A bed below which rock is worn back.
struct Foot {
    bed: usize,
    /// Where in the strata's profile the bed begins, m, and its stratigraphic height, m.
    start_m: f64,
    height_m: f64,
    /// How far down the soft rock below it is hollowed, m.
    seam_m: f64,
    /// How deep, m.
    depth_m: f64,
    /// Which share of its length is hollow, in deviations of the noise.
    extent: f64,
    /// How high and how deep alcoves arch into the bed, m; 0 where it bears none.
    arch_m: f64,
    alcove_m: f64,
    seed: u32,
}

/// A place of a wall.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_field_names, reason = "the unit stands in the name")]
pub(super) struct Wall {
    /// Distance in the strata's profile, m.
    pub(super) distance_m: f64,
    /// How far above its channel, in the same measure.
    pub(super) climb_m: f64,
    /// Stratigraphic height of what is seen there from above, m.
    pub(super) height_m: f64,
}

/// The hollows of a canyon.
pub(super) struct Undercuts {
    /// By rising height.
    feet: Vec<Foot>,
    /// 1 in nature; 0 leaves every wall as it is.
    strength: f64,
    radius_m: f64,
}

impl Undercuts {
    pub(super) fn new(strata: &Strata, roughness: f64, radius_m: f64, path: &SeedPath) -> Self {
        let seed = path.hash_u32();
        let draw = |bed: usize, k: i32| f64::from(unit_from_hash(hash_cell(bed as i32, k, 0, seed)));
        let mut feet = Vec::new();
        for bed in 1..strata.beds.len() {
            let thick = strata.beds[bed].top_m - strata.base_m(bed);
            if strata.beds[bed].habit != Habit::Cliff || thick < 1.2 {
                continue;
            }
            // Over a soft bed cliffs recede; between two hard ones a seam does, here and there.
            let soft = strata.beds[bed - 1].habit != Habit::Cliff;
            let below = strata.base_m(bed) - strata.base_m(bed - 1);
            let massive = thick > 4.5 && (soft || draw(bed, 0) < 0.6);
            feet.push(Foot {
                bed,
                start_m: strata.start_m(bed),
                height_m: strata.base_m(bed),
                seam_m: (if soft { 1.3 + 1.4 * draw(bed, 1) } else { 0.9 + 0.9 * draw(bed, 1) }).min(0.7 * below),
                depth_m: if soft { 1.8 + 2.0 * draw(bed, 2) } else { 0.9 + 1.3 * draw(bed, 2) },
                extent: if soft { -0.7 } else { 0.9 * draw(bed, 3) - 1.78 },
                arch_m: if massive { (3.5 + 6.0 * draw(bed, 4)).min(0.7 * thick) } else { 0.0 },
                alcove_m: 3.0 + 3.5 * draw(bed, 5),
                seed: hash_cell(bed as i32, 3, 0, seed),
            });
        }
        Self { feet, strength: roughness.min(1.2), radius_m }
    }

    /// The hollows at a place of the wall, by rising height; `line` tells how far the face of a bed stands before its mean line.
    pub(super) fn at(&self, p: DVec2, wall: Wall, line: impl Fn(usize) -> f64) -> Vec<Hollow> {
        let Wall { distance_m, climb_m, height_m } = wall;
        let inward = self.radius_m - p.length();
        if inward < FADE_M[0] || climb_m < 1.0 || self.strength == 0.0 {
            return Vec::new();
        }
        let keep = smoothstep(FADE_M[0], FADE_M[1], inward) * smoothstep(1.0, 8.0, climb_m);
        let from = self.feet.partition_point(|f| f.start_m < distance_m - DEEPEST_M - Hollow::BEARING_M - FACE_M);
        let to = self.feet.partition_point(|f| f.start_m < distance_m + BEFORE_M + FACE_M);
        let mut hollows = Vec::new();
        for foot in &self.feet[from..to] {
            let n = |salt: u32, wavelength_m: f64| fractal(p, foot.seed ^ salt, wavelength_m, 2, 0.4) / 0.29;
            let mut depth = foot.depth_m * (foot.extent + n(0, 31.0)).clamp(-1.0, 1.5);
            let mut alcove = 0.0;
            if foot.arch_m > 0.0 {
                alcove = smoothstep(1.5, 2.2, n(1, 44.0));
                depth += (depth.max(0.0) + foot.alcove_m - depth) * alcove;
            }
            let depth = Hollow::faded(depth * self.strength, keep);
            if depth < -Hollow::BEARING_M {
                continue;
            }
            let behind = distance_m + line(foot.bed) - foot.start_m;
            let cover_m = depth + Hollow::BEARING_M - behind;
            if behind < -BEFORE_M || cover_m < -UNTOLD_M {
                continue;
            }
            let vault = Hollow::vault(depth, behind);
            // Before the lip the floor rises to what the slope was.
            let apron = vault * (1.0 + behind.min(0.0) / 2.5).max(0.0);
            let rubble = 0.12 * n(2, 3.0);
            let roof_m = foot.height_m + foot.arch_m * alcove * vault + 0.7 * rubble + 0.25 * vault.min(0.0);
            let mut floor_m = foot.height_m + rubble - foot.seam_m * apron + 0.10 * behind;
            if height_m < roof_m + 0.4 {
                // Rock that ends below the roof is the face's foot, or no cliff at all and left as it is.
                floor_m = floor_m.max(height_m - (1.5 - behind).max(0.0));
            }
            hollows.push(Hollow { level: foot.bed as u32, floor_m, roof_m, cover_m });
        }
        hollows
    }
}
