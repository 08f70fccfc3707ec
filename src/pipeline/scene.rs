//! A scene as the pipeline needs it: built, traceable, and with the files that its samples share.

use super::PipelineError;
use crate::camera::Datum as RigDatum;
use crate::dataset::{SceneFiles, to_json};
use crate::labels;
use crate::plan::SceneSpec;
use crate::recipe::{Datum, Recipe};
use crate::render::Light;
use satseed_generators::Region;
use satseed_scene::{Environment, Scene};
use satseed_tracer::Tracer;
use serde::Serialize;

/// A built scene with all that its pairs share.
pub struct BuiltScene<'s> {
    /// What was asked for.
    pub recipe: &'s Recipe,
    /// Which scene of the plan.
    pub spec: &'s SceneSpec,
    /// Rays against it.
    pub tracer: Tracer<'s>,
    /// Sun and air.
    pub environment: Environment,
    /// What they make of the scene: the same for all its pairs.
    pub light: Light,
    /// Where disparity is 0, resolved for this scene.
    pub datum: RigDatum,
}

/// `scene.json`.
#[derive(Clone, Debug, Serialize)]
pub struct SceneRecord {
    /// Name and folder.
    pub name: String,
    /// Region.
    pub region: String,
    /// The region's variant.
    pub variant: String,
    /// The scene's seed.
    pub seed: u64,
    /// The generator's version.
    pub generator_version: u32,
    /// BLAKE3 of the parameters.
    pub params_hash: String,
    /// The parameters, every one of them.
    pub parameters: serde_json::Value,
    /// Lowest and highest height that the scene may have, from its parameters alone, m.
    pub height_bounds_m: [f64; 2],
    /// Height of the ground at the pivot, m. The pivot stands at x = y = 0.
    pub pivot_height_m: f64,
    /// Within this distance from the pivot geometry stands in full detail, m.
    pub full_detail_radius_m: f64,
    /// Height at which disparity is 0, m; none where the recipe has no datum.
    pub datum_m: Option<f64>,
    /// Share of the surface model's cells whose vertical line meets two or more upward surfaces over 1 m apart with open
    /// space above them: crowns, decks, balconies, overhangs; not a solid building on its plot.
    pub multi_layer_fraction: f64,
    /// Triangles, counted once for each placement.
    pub triangles: usize,
    /// What the numbers of the instance label mean: entry 0 is the bare terrain.
    pub objects: Vec<ObjectRecord>,
}

/// An entry of a scene's object table.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectRecord {
    /// Its number in the instance label.
    pub id: u32,
    /// Its path in the scene's seed tree.
    pub path: String,
    /// Its semantic class.
    pub class: u8,
}

/// Builds a scene and checks what its generator made.
///
/// # Errors
/// Where that is not legal, which is a bug in the generator.
pub fn build_scene(spec: &SceneSpec) -> Result<Scene, PipelineError> {
    let scene = spec.region.build(spec.seed);
    scene.validate().map_err(|reason| PipelineError::Scene { name: spec.name.clone(), reason })?;
    Ok(scene)
}

impl<'s> BuiltScene<'s> {
    /// Prepares a scene for its pairs.
    pub fn new(recipe: &'s Recipe, spec: &'s SceneSpec, scene: &'s Scene) -> Self {
        let datum = match recipe.camera().datum {
            Datum::None => RigDatum::None,
            Datum::HeightM(z) => RigDatum::Height(z),
            Datum::Pivot => RigDatum::Height(scene.pivot_height_m),
            Datum::Lowest => RigDatum::Height(under_the_lowest_m(scene)),
        };
        let (tracer, environment) = (Tracer::new(scene), Environment::from(recipe.light()));
        let light = Light::of(&tracer, &environment).with_ambient(recipe.light().ambient, scene.full_detail_radius_m);
        Self { recipe, spec, tracer, environment, light, datum }
    }

    /// The files that its samples share.
    pub fn files(&self) -> SceneFiles {
        let scene = self.tracer.scene();
        let (half_side_m, cell_m) = (self.spec.region.full_detail_radius_m(), self.recipe.camera().gsd_m);
        let models = labels::surface_models(scene, half_side_m, cell_m);
        let several = models.layers.data.iter().filter(|n| **n >= 2).count();
        let record = SceneRecord {
            name: self.spec.name.clone(),
            region: self.spec.region.name().to_owned(),
            variant: self.spec.region.variant().to_owned(),
            seed: self.spec.seed,
            generator_version: self.spec.region.version(),
            params_hash: self.spec.params_hash.clone(),
            parameters: parameters(&self.spec.region),
            height_bounds_m: self.spec.region.height_bounds_m(),
            pivot_height_m: scene.pivot_height_m,
            full_detail_radius_m: half_side_m,
            datum_m: match self.datum {
                RigDatum::None => None,
                RigDatum::Height(z) => Some(z),
            },
            multi_layer_fraction: several as f64 / models.layers.data.len().max(1) as f64,
            triangles: scene.triangle_counts().1,
            objects: (0..)
                .zip(&scene.objects)
                .map(|(id, o)| ObjectRecord { id, path: o.path.clone(), class: o.class as u8 })
                .collect(),
        };
        SceneFiles {
            scene_json: to_json(&record),
            dsm: models.dsm_m.into(),
            dtm: models.dtm_m.into(),
            ndsm: models.ndsm_m.into(),
        }
    }
}

/// Just under the lowest vertex of any triangle that reaches into the full-detail square: no frame sees lower.
fn under_the_lowest_m(scene: &Scene) -> f64 {
    const MARGIN_M: f64 = 0.5;
    let radius_m = scene.full_detail_radius_m;
    let mut lowest = f64::INFINITY;
    for (i, instance) in scene.instances.iter().enumerate() {
        for triangle in 0..scene.meshes[instance.mesh as usize].triangles.len() {
            let corners = scene.corners(i as u32, triangle as u32);
            let low = |axis: fn(&glam::DVec3) -> f64| corners.iter().map(axis).fold(f64::INFINITY, f64::min);
            let high = |axis: fn(&glam::DVec3) -> f64| corners.iter().map(axis).fold(f64::NEG_INFINITY, f64::max);
            let near = low(|p| p.x) <= radius_m
                && high(|p| p.x) >= -radius_m
                && low(|p| p.y) <= radius_m
                && high(|p| p.y) >= -radius_m;
            if near {
                lowest = lowest.min(low(|p| p.z));
            }
        }
    }
    lowest - MARGIN_M
}

fn parameters(region: &Region) -> serde_json::Value {
    let tagged = serde_json::to_value(region).expect("parameter structs hold numbers, words, lists and tables only");
    match tagged {
        serde_json::Value::Object(map) => map.into_iter().next().map_or(serde_json::Value::Null, |(_, v)| v),
        other => other,
    }
}

/// What the surface models of a scene take, bytes: three heights a cell that are kept, and on top of them what it takes to
/// make them or, after that, to encode all three at once: each turned, with its predictor, compressed.
pub(super) fn surface_model_bytes(region: &Region, cell_m: f64) -> u64 {
    let cells = map_cells(region, cell_m);
    cells * 12 + labels::surface_model_bytes(map_side(region, cell_m)).max(cells * 3 * (4 + 4 + 4))
}

/// Cells of a scene's surface model.
pub(super) fn map_cells(region: &Region, cell_m: f64) -> u64 {
    map_side(region, cell_m).pow(2)
}

fn map_side(region: &Region, cell_m: f64) -> u64 {
    (2.0 * region.full_detail_radius_m() / cell_m) as u64 + 1
}
