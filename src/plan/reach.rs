//! How far from the pivot frames see, before any scene stands.

use super::{CLEARANCE_M, PairSpec, PlanError, SceneSpec};
use crate::recipe::{Camera, Datum, Recipe};

/// Lowest and highest height that the datum can turn out to have, m; `None` without a datum.
pub type DatumBounds = Option<[f64; 2]>;

/// "Just under the lowest point" is at most so far below the scene's lower bound, m.
const LOWEST_MARGIN_M: f64 = 1.0;

fn datum_bounds(camera: &Camera, heights_m: [f64; 2]) -> DatumBounds {
    match camera.datum {
        Datum::None => None,
        Datum::HeightM(z) => Some([z, z]),
        Datum::Pivot => Some(heights_m),
        Datum::Lowest => Some([heights_m[0] - LOWEST_MARGIN_M, heights_m[1]]),
    }
}

/// Greatest horizontal distance from the pivot that a corner of either frame sees, m, over all heights of a scene and all
/// heights that its datum may have. The azimuth turns both frames about the pivot and changes nothing.
///
/// A frame's centre stands at -t B (left) or (1 - t) B (right) along the baseline. A datum z0 shifts the principal points
/// by f B / (H - z0), half on each side, so that at height z the left frame's centre lies at
/// -t B + (B / 2) (H - z) / (H - z0), the right one's at (1 - t) B minus the same. A frame's corner lies
/// (W, N) / 2 * gsd * (H - z) / H from its centre. Both are linear in z and monotone in z0, and a distance is convex: the
/// greatest lies at an end of each range.
pub fn frame_reach_m(
    camera: &Camera,
    baseline_m: f64,
    pivot_along_baseline: f64,
    heights_m: [f64; 2],
    datum_m: DatumBounds,
) -> f64 {
    let h = camera.altitude_m;
    let [width_m, depth_m] = camera.footprint_m();
    let datums = datum_m.map_or([None, None], |[low, high]| [Some(low), Some(high)]);
    let mut reach = 0.0_f64;
    for z in heights_m {
        let scale = (h - z) / h;
        let (half_u, half_v) = (0.5 * width_m * scale, 0.5 * depth_m * scale);
        for datum in datums {
            let shift = datum.map_or(0.0, |z0| 0.5 * baseline_m * (h - z) / (h - z0));
            let left = -pivot_along_baseline * baseline_m + shift;
            let right = (1.0 - pivot_along_baseline) * baseline_m - shift;
            for centre in [left, right] {
                let u = centre.abs() + half_u;
                reach = reach.max((u * u + half_v * half_v).sqrt());
            }
        }
    }
    reach
}

impl SceneSpec {
    /// The smallest radius of full detail that holds every frame of its pairs, m: a scene of that radius serves them as well
    /// as a larger one.
    pub fn reach_m(&self, camera: &Camera) -> f64 {
        let heights_m = self.region.height_bounds_m();
        let datum_m = datum_bounds(camera, heights_m);
        let reach = |p: &PairSpec| frame_reach_m(camera, p.baseline_m, p.pivot_along_baseline, heights_m, datum_m);
        self.pairs.iter().map(reach).fold(0.0, f64::max)
    }
}

/// Refuses a plan whose cameras would stand in the scene or see beyond its full detail.
pub(super) fn check(recipe: &Recipe, scenes: &[SceneSpec]) -> Result<(), PlanError> {
    let camera = recipe.camera();
    let mut worst: Option<(f64, &SceneSpec, &str)> = None;
    for scene in scenes {
        let heights_m = scene.region.height_bounds_m();
        let [lowest_m, highest_m] = heights_m;
        let name = || scene.name.clone();
        if camera.altitude_m < highest_m + CLEARANCE_M {
            let needed_m = highest_m + CLEARANCE_M;
            return Err(PlanError::TooLow { name: name(), highest_m, altitude_m: camera.altitude_m, needed_m });
        }
        if let Datum::HeightM(datum_m) = camera.datum
            && !(lowest_m - CLEARANCE_M..=highest_m + CLEARANCE_M).contains(&datum_m)
        {
            return Err(PlanError::DatumOutside { name: name(), datum_m, lowest_m, highest_m });
        }
        let datum_m = datum_bounds(camera, heights_m);
        let radius_m = scene.region.full_detail_radius_m();
        for pair in &scene.pairs {
            let reach_m = frame_reach_m(camera, pair.baseline_m, pair.pivot_along_baseline, heights_m, datum_m);
            if reach_m > radius_m && worst.is_none_or(|(r, ..)| reach_m > r) {
                worst = Some((reach_m, scene, &pair.id));
            }
        }
    }
    let Some((reach_m, scene, id)) = worst else { return Ok(()) };
    Err(PlanError::BeyondDetail {
        id: id.to_owned(),
        region: scene.region.name(),
        reach_m,
        radius_m: scene.region.full_detail_radius_m(),
        needed_m: libm::ceil(reach_m),
    })
}
