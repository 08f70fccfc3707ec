//! Where walls overhang: soft beds worn back below hard ones, and alcoves at the foot of cliffs.

use super::relief::{Relief, WORN_M};
use super::strata::Habit;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::overhang::{Inward, Undercut};
use crate::kit::terrain::sampling::{blurred, smoothstep};
use glam::{DVec2, DVec3};
use satseed_scene::{SeedPath, hash_cell, unit_from_hash};

/// Ground steeper than this is wall.
const WALL: f64 = 1.7;
/// The deepest that a soft bed is worn back, and an alcove, m.
const NOTCH_M: f64 = 2.4;
const ALCOVE_M: f64 = 3.2;

/// A bed's foot from which rock is worn back.
struct Foot {
    /// Its stratigraphic height, m.
    height_m: f64,
    /// How far up the hollow reaches, m.
    rise_m: f64,
    /// Its greatest depth, m.
    depth_m: f64,
    /// How high alcoves arch over it, m; 0 where it bears none.
    arch_m: f64,
    seed: u32,
}

/// The hollows of a canyon.
pub(super) struct Undercuts<'a> {
    relief: &'a Relief<'a>,
    /// Into the walls: 1 long on them, 0 away from them and where they turn their backs to each other.
    inward: Inward,
    /// From the lowest up.
    feet: Vec<Foot>,
}

/// How far below its foot a hollow's floor begins, m.
const FLOOR_M: f64 = 0.9;

impl<'a> Undercuts<'a> {
    pub(super) fn new(relief: &'a Relief<'a>, path: &SeedPath) -> Self {
        let seed = path.hash_u32();
        let strata = relief.strata;
        let draw = |bed: usize, k: i32| f64::from(unit_from_hash(hash_cell(bed as i32, k, 0, seed)));
        let mut feet = Vec::new();
        for bed in 1..strata.beds.len() {
            let thick = strata.beds[bed].top_m - strata.base_m(bed);
            if strata.beds[bed].habit != Habit::Cliff || thick < 1.5 {
                continue;
            }
            // Over a soft bed cliffs recede; between two hard ones a seam does, here and there.
            let over_soft = strata.beds[bed - 1].habit != Habit::Cliff;
            let (rise, depth) =
                if over_soft { (1.3 + 2.2 * draw(bed, 0), NOTCH_M) } else { (0.7 + 0.8 * draw(bed, 0), 0.9) };
            feet.push(Foot {
                height_m: strata.base_m(bed),
                rise_m: rise.min(0.8 * thick),
                depth_m: depth * (0.6 + 0.4 * draw(bed, 1)) * relief.roughness.min(1.0),
                arch_m: if over_soft && thick > 4.0 { (5.0 + 5.0 * draw(bed, 2)).min(0.8 * thick) } else { 0.0 },
                seed: hash_cell(bed as i32, 3, 0, seed),
            });
        }
        Self { relief, inward: inward(relief), feet }
    }

    /// How deep a foot's hollows are at a place of its wall, `above_m` over it, m.
    fn depth_m(&self, foot: &Foot, p: DVec2, above_m: f64) -> f64 {
        if above_m < -FLOOR_M {
            return 0.0;
        }
        let floor = smoothstep(-FLOOR_M, -0.1, above_m);
        let mut depth_m = 0.0;
        if above_m < foot.rise_m {
            let along = smoothstep(-0.25, 0.55, fractal(p, foot.seed, 26.0, 2, 0.5));
            depth_m = foot.depth_m * along * smoothstep(foot.rise_m, 0.75 * foot.rise_m, above_m);
        }
        if above_m < foot.arch_m {
            let along = smoothstep(0.15, 0.75, fractal(p, foot.seed ^ 0x51, 38.0, 1, 0.5));
            let t = above_m.max(0.0) / (foot.arch_m * along.max(1e-3));
            let arch = (1.0 - t * t).max(0.0);
            depth_m = depth_m.max(ALCOVE_M * along * arch * arch * self.relief.roughness.min(1.0));
        }
        depth_m * floor
    }
}

impl Undercut for Undercuts<'_> {
    fn shift_m(&self, p: DVec3) -> DVec2 {
        let plan = p.truncate();
        let inward = self.inward.at(plan);
        if inward == DVec2::ZERO {
            return inward;
        }
        let height_m = p.z - self.relief.fold.at(plan);
        let first = self.feet.partition_point(|f| f.height_m <= height_m + FLOOR_M);
        // The highest hollow reaches less than 11 m up.
        let below = self.feet[..first].iter().rev().take_while(|f| f.height_m > height_m - 11.0);
        inward * below.map(|f| self.depth_m(f, plan, height_m - f.height_m)).fold(0.0, f64::max)
    }
}

/// Directions into the walls, which fade away from them.
fn inward(relief: &Relief<'_>) -> Inward {
    let plan = blurred(relief.worn.distance_m.clone(), 4);
    let (width, height) = (plan.width, plan.height);
    let mut wall = plan.clone();
    for (post, value) in wall.data.iter_mut().enumerate() {
        let p = plan.position(post % width, post / width);
        let steep = |x: f64, y: f64| relief.slope(p + DVec2::new(x, y)).length() > WALL;
        let e = 0.5 * WORN_M;
        let count = [(0.0, 0.0), (-e, -e), (e, -e), (-e, e), (e, e)].iter().filter(|(x, y)| steep(*x, *y)).count();
        // None near the border: the ring beyond it has no hollows.
        let inside = (post % width).min(post / width).min(width - 1 - post % width).min(height - 1 - post / width);
        *value = if inside < 12 { 0.0 } else { (count.min(2) as f32) / 2.0 };
    }
    let wall = blurred(wall, 2);
    Inward::new(&plan, |i, j| smoothstep(0.06, 0.30, wall.get(i, j).into()))
}
