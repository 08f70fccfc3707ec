//! What scenes and pairs cost in processor time, from a table that was measured.
//!
//! It decides how a plan is dealt to machines and what `--dry-run` says, and no byte of a dataset.

use super::{Plan, SceneSpec};
use crate::recipe::Recipe;

/// What a region took when it was measured. Seconds are processor seconds of one core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The region.
    pub region: &'static str,
    /// Radius of full detail of the measured scene, m.
    pub radius_m: f64,
    /// A scene's own: generator, trees, surface models, its files; s.
    pub scene_s: f64,
    /// The light that all views of a scene share, worked out once for each square metre of a frame, s.
    pub light_s_per_m2: f64,
    /// Labels and files of a pair for each megapixel of one of its views, s.
    pub labels_s_per_mpx: f64,
    /// Images for each million samples (pixels times samples a pixel) of a view, s.
    pub render_s_per_msample: f64,
}

/// How [`TABLE`] was measured: said wherever its numbers are printed.
pub const HOW_MEASURED: &str =
    "AMD EPYC of 2 cores busy with other work (scenes: Intel Xeon), 23 November 2026, release build, processor time";

/// Measured as [`HOW_MEASURED`] says; docs/cluster.md tells the command.
pub const TABLE: &[Measured] = &[
    Measured {
        region: "california",
        radius_m: 700.0,
        scene_s: 27.4,
        light_s_per_m2: 0.000378,
        labels_s_per_mpx: 1.07,
        render_s_per_msample: 0.969,
    },
    Measured {
        region: "canyon",
        radius_m: 700.0,
        scene_s: 35.9,
        light_s_per_m2: 0.000411,
        labels_s_per_mpx: 0.91,
        render_s_per_msample: 0.94,
    },
    Measured {
        region: "coast",
        radius_m: 700.0,
        scene_s: 37.9,
        light_s_per_m2: 0.000112,
        labels_s_per_mpx: 0.78,
        render_s_per_msample: 0.608,
    },
    Measured {
        region: "desert",
        radius_m: 700.0,
        scene_s: 28.2,
        light_s_per_m2: 0.000004,
        labels_s_per_mpx: 0.57,
        render_s_per_msample: 0.481,
    },
    Measured {
        region: "field",
        radius_m: 700.0,
        scene_s: 29.5,
        light_s_per_m2: 0.000087,
        labels_s_per_mpx: 0.72,
        render_s_per_msample: 0.659,
    },
    Measured {
        region: "forest",
        radius_m: 700.0,
        scene_s: 83.6,
        light_s_per_m2: 0.001269,
        labels_s_per_mpx: 4.32,
        render_s_per_msample: 2.594,
    },
    Measured {
        region: "toronto",
        radius_m: 700.0,
        scene_s: 19.1,
        light_s_per_m2: 0.000465,
        labels_s_per_mpx: 0.68,
        render_s_per_msample: 0.817,
    },
    Measured {
        region: "venice",
        radius_m: 700.0,
        scene_s: 11.3,
        light_s_per_m2: 0.000300,
        labels_s_per_mpx: 0.86,
        render_s_per_msample: 0.908,
    },
];

/// The same units of work for everything: a processor millisecond.
const MS_PER_S: f64 = 1000.0;

/// What the scenes and pairs of one recipe cost, processor milliseconds of one core.
///
/// A scene is scaled by its area, its light by that of a frame, a pair by its pixels and samples. Regions that are not in
/// the table cost what the dearest of the table does.
#[derive(Clone, Copy, Debug)]
pub struct Costs {
    megapixels: f64,
    megasamples: f64,
    frame_m2: f64,
}

/// What one scene and each of its pairs cost, processor milliseconds of one core; never 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneCost {
    /// What has to be done before any pair: again by each shard that has pairs of the scene.
    pub scene_ms: u64,
    /// Each pair.
    pub pair_ms: u64,
}

/// What a region's share of a plan costs, processor milliseconds of one core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionTotal {
    /// The region.
    pub region: &'static str,
    /// Whether it stands in the table.
    pub is_measured: bool,
    /// How many scenes.
    pub scenes: u64,
    /// How many pairs.
    pub pairs: u64,
    /// The scenes by themselves.
    pub scenes_ms: u64,
    /// Scenes and pairs.
    pub all_ms: u64,
}

impl Costs {
    /// The costs of a recipe's scenes.
    pub fn of(recipe: &Recipe) -> Self {
        let megapixels = recipe.camera().pixels() as f64 / 1e6;
        Self {
            megapixels,
            megasamples: megapixels * f64::from(recipe.sensor().samples_per_pixel),
            frame_m2: recipe.camera().footprint_m().into_iter().product(),
        }
    }

    /// The cost of a scene.
    pub fn scene(&self, spec: &SceneSpec) -> SceneCost {
        let measured = measured(spec.region.name());
        let scale = spec.region.full_detail_radius_m() / measured.radius_m;
        let view_s = self.megapixels * measured.labels_s_per_mpx + self.megasamples * measured.render_s_per_msample;
        let ms = |seconds: f64| (seconds * MS_PER_S).ceil().max(1.0) as u64;
        let scene_s = measured.scene_s * scale * scale + measured.light_s_per_m2 * self.frame_m2;
        SceneCost { scene_ms: ms(scene_s), pair_ms: ms(2.0 * view_s) }
    }

    /// What a plan costs region by region, in the order of their first scenes.
    pub fn by_region(&self, plan: &Plan) -> Vec<RegionTotal> {
        let mut totals: Vec<RegionTotal> = Vec::new();
        for spec in &plan.scenes {
            let region = spec.region.name();
            let at = totals.iter().position(|total| total.region == region).unwrap_or_else(|| {
                let is_measured = TABLE.iter().any(|row| row.region == region);
                totals.push(RegionTotal { region, is_measured, scenes: 0, pairs: 0, scenes_ms: 0, all_ms: 0 });
                totals.len() - 1
            });
            let (cost, pairs) = (self.scene(spec), spec.pairs.len());
            let total = &mut totals[at];
            total.scenes += 1;
            total.pairs += pairs as u64;
            total.scenes_ms += cost.of_pairs(pairs) - cost.pair_ms * pairs as u64;
            total.all_ms += cost.of_pairs(pairs);
        }
        totals
    }

    /// The cost of a whole plan made by one machine, processor milliseconds.
    pub fn plan_ms(&self, plan: &Plan) -> u64 {
        plan.scenes.iter().map(|spec| self.scene(spec).of_pairs(spec.pairs.len())).sum()
    }
}

impl SceneCost {
    /// The scene and some of its pairs; nothing where there are none.
    pub fn of_pairs(&self, pairs: usize) -> u64 {
        if pairs == 0 { 0 } else { self.scene_ms + self.pair_ms * pairs as u64 }
    }
}

/// A region's row of the table.
fn measured(region: &str) -> &'static Measured {
    let dearest = || TABLE.iter().max_by(|a, b| a.render_s_per_msample.total_cmp(&b.render_s_per_msample));
    TABLE.iter().find(|row| row.region == region).or_else(dearest).expect("the table has rows")
}
