//! What one interchange has of its own: how its freeways cross, and how each of its ramps turns.

use super::LEVELS_M;
use glam::DVec2;
use satseed_scene::SeedPath;

/// How a quarter's traffic turns left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Left {
    /// Over both freeways: radius of the bend, length of the approach to the crossing, m, and height of the deck above the
    /// ground, m.
    Over { radius_m: f64, run_m: f64, level_m: f64 },
    /// By three quarters of a circle to the right, after the crossing: its radius, m.
    Loop { radius_m: f64 },
}

/// The form of an interchange. Its own frame has the lower freeway along y, the upper one along -x.
#[derive(Clone, Debug)]
pub(super) struct Form {
    /// The crossing, sheet.
    pub(super) centre: DVec2,
    /// The frame's x on the sheet.
    turn: DVec2,
    /// How far the lower and the upper freeway lean aside near the crossing, as slopes.
    lean: [f64; 2],
    pub(super) left: [Left; 4],
    /// Radius of the quarters' right turns, m.
    pub(super) right_m: [f64; 4],
}

/// Beyond this distance from the crossing the freeways lie straight on the sheet, m: where the city begins.
const LEAN_REACH_M: f64 = 330.0;

impl Form {
    pub(super) fn new(centre: DVec2, key: &SeedPath) -> Self {
        let mut rng = key.child("form").rng();
        let turn = if rng.chance(0.5) { DVec2::X } else { DVec2::Y };
        let lean = [rng.signed() * 0.14, rng.signed() * 0.14];
        // One pair of opposite quarters bends below the other pair.
        let high = rng.below(2) as usize;
        // Bends of opposite quarters pass each other on one level: they stay apart from 110 m on.
        let radii_m = [rng.range(118.0, 168.0), rng.range(118.0, 168.0)];
        let mut left = [0, 1, 2, 3].map(|q: usize| {
            let up = usize::from(q % 2 == high);
            Left::Over {
                radius_m: radii_m[q % 2] + rng.signed() * 5.0,
                run_m: rng.range(375.0, 425.0) + 80.0 * up as f64,
                level_m: LEVELS_M[2 + up],
            }
        });
        // Two in five have loops in place of one or both of the higher bends.
        let loops = *rng.pick(&[0, 0, 0, 1, 2]);
        let first = rng.below(2) as usize;
        for k in 0..loops {
            let q = (2 * (first + k) + high) % 4;
            left[q] = Left::Loop { radius_m: rng.range(47.0, 54.0) };
        }
        let right_m = [0, 1, 2, 3].map(|q: usize| {
            let radius_m = rng.range(112.0, 225.0);
            // Around a loop, which lies in the quarter before it.
            if matches!(left[(q + 3) % 4], Left::Loop { .. }) { 350.0 } else { radius_m }
        });
        Self { centre, turn, lean, left, right_m }
    }

    /// How far from the crossing a quarter's left turn has a lane of its own beside the freeway that it leaves or joins, m.
    pub(super) fn beside_m(&self, quarter: usize) -> f64 {
        match self.left[quarter] {
            Left::Over { run_m, .. } => run_m,
            Left::Loop { .. } => 0.0,
        }
    }

    /// A place of the form's frame on the sheet.
    pub(super) fn flat(&self, p: DVec2) -> DVec2 {
        let q = p.length_squared() / (LEAN_REACH_M * LEAN_REACH_M);
        let near = (1.0 - q).max(0.0) * (1.0 - q).max(0.0);
        let leant = p + DVec2::new(self.lean[0] * p.y, self.lean[1] * p.x) * near;
        self.centre + self.turn.rotate(leant)
    }

    /// Direction of a freeway where it is straight, sheet.
    pub(super) fn along(&self, upper: bool) -> DVec2 {
        self.turn.rotate(if upper { -DVec2::X } else { DVec2::Y })
    }

    /// A place by its distance along and to the left of a freeway, sheet.
    pub(super) fn beside(&self, upper: bool, s: f64, left: f64) -> DVec2 {
        self.flat(if upper { DVec2::new(-s, -left) } else { DVec2::new(-left, s) })
    }
}
