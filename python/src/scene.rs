//! Scenes that are built once and traced as often as one likes.

use crate::pool::Lease;
use crate::{GenerateError, RecipeError, arrays, background, recipe};
use pyo3::prelude::*;
use satseed::pipeline::{BuiltScene, PipelineError, build_scene, make_sample};
use satseed::plan::{Plan, PlanError, SceneSpec, scenes};
use satseed::recipe::{Datum, Recipe};
use self_cell::self_cell;
use std::sync::Arc;

/// What a built scene borrows.
struct Parts {
    recipe: Recipe,
    spec: SceneSpec,
    scene: satseed_scene::Scene,
}

self_cell!(
    struct Kept {
        owner: Parts,
        #[covariant]
        dependent: BuiltScene,
    }
);

/// A scene of a recipe, built. Traced from many threads at once, if need be.
#[pyclass(frozen, module = "satseed._native")]
pub(crate) struct Scene {
    kept: Arc<Kept>,
    threads: Lease,
    name: String,
    radius_m: f64,
    pairs: Vec<String>,
}

#[pymethods]
impl Scene {
    #[new]
    fn new(
        py: Python<'_>,
        recipe_text: &str,
        set: Vec<String>,
        seed: Option<u64>,
        index: usize,
        threads: usize,
        crop: bool,
    ) -> PyResult<Self> {
        let recipe = recipe(recipe_text, set, seed)?;
        let refused = |e: PlanError| RecipeError::new_err(e.to_string());
        let scenes =
            if crop { scenes(&recipe) } else { Plan::new(&recipe).map(|plan| plan.scenes) }.map_err(refused)?;
        let count = scenes.len();
        let Some(mut spec) = scenes.into_iter().nth(index) else {
            return Err(RecipeError::new_err(format!(
                "the recipe has {count} scenes, so there is none of index {index}"
            )));
        };
        if crop {
            spec = cropped(&recipe, spec)?;
            spec.check_frames(&recipe).map_err(refused)?;
        }
        let threads = Lease::new(threads).map_err(|e| failed(&e))?;
        let (name, pairs) = (spec.name.clone(), spec.pairs.iter().map(|p| p.id.clone()).collect());
        let radius_m = spec.region.full_detail_radius_m();
        let builder = Arc::clone(&threads.pool);
        let kept = background::run(py, move || builder.install(|| build(recipe, spec)))?.map_err(|e| failed(&e))?;
        Ok(Self { kept: Arc::new(kept), threads, name, radius_m, pairs })
    }

    /// The scene's name, its folder in a dataset.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// How far from the pivot it stands in full detail, m.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Ids of its pairs, in plan order.
    #[getter]
    fn pairs(&self) -> Vec<String> {
        self.pairs.clone()
    }

    /// Traces, renders and labels a pair.
    fn sample<'py>(&self, py: Python<'py>, pair: usize) -> PyResult<arrays::Made<'py>> {
        if pair >= self.pairs.len() {
            let (name, count) = (&self.name, self.pairs.len());
            return Err(RecipeError::new_err(format!(
                "scene {name} has {count} pairs, so there is none of index {pair}"
            )));
        }
        let (kept, pool) = (Arc::clone(&self.kept), Arc::clone(&self.threads.pool));
        let made = background::run(py, move || {
            let mut made =
                pool.install(|| make_sample(kept.borrow_dependent(), &kept.borrow_owner().spec.pairs[pair]))?;
            // The camera file tells the range of disparities, which writing a sample counts.
            Ok::<_, PipelineError>(made.count().map(|_| made))
        })?;
        let counted = made.map_err(|e| failed(&e))?;
        arrays::sample(py, counted.map_err(|e| GenerateError::new_err(e.to_string()))?)
    }
}

/// The scene with no more of it than its pairs' frames see. It keeps its name: what they see is the same in the whole.
fn cropped(recipe: &Recipe, spec: SceneSpec) -> PyResult<SceneSpec> {
    if recipe.camera().datum == Datum::Lowest {
        return Err(RecipeError::new_err(
            "camera.datum = \"lowest\" is the lowest point of a whole scene, which a crop does not know: take \"pivot\", a \
             height or \"none\"",
        ));
    }
    let needed_m = spec.reach_m(recipe.camera()).ceil();
    let region = spec.region.clone().with_radius_m(needed_m);
    let region = match region.check() {
        Err(e) if e.key == "radius_m" && needed_m < e.low => region.with_radius_m(e.low),
        Err(e) if e.key == "radius_m" => {
            return Err(RecipeError::new_err(format!(
                "the frames of scene {} see as far as {needed_m} m from the pivot, but a scene reaches at most {} m: smaller \
                 frames or shorter baselines",
                spec.name, e.high
            )));
        }
        _ => region,
    };
    Ok(SceneSpec { region, ..spec })
}

fn build(recipe: Recipe, spec: SceneSpec) -> Result<Kept, PipelineError> {
    let scene = build_scene(&spec)?;
    let parts = Parts { recipe, spec, scene };
    Ok(Kept::new(parts, |parts| BuiltScene::new(&parts.recipe, &parts.spec, &parts.scene)))
}

fn failed(error: &PipelineError) -> PyErr {
    GenerateError::new_err(error.to_string())
}

/// The scenes of a recipe with their pairs, as JSON.
#[pyfunction]
pub(crate) fn plan(recipe_text: &str, set: Vec<String>, seed: Option<u64>) -> PyResult<String> {
    let recipe = recipe(recipe_text, set, seed)?;
    let plan = Plan::new(&recipe).map_err(|e| RecipeError::new_err(e.to_string()))?;
    let scenes = plan.scenes.iter().map(|s| {
        let pairs = s.pairs.iter().map(|p| {
            serde_json::json!({
                "id": p.id, "baseline_m": p.baseline_m, "azimuth_deg": p.azimuth_deg, "split": p.split.word(),
            })
        });
        serde_json::json!({
            "name": s.name, "region": s.region.name(), "variant": s.region.variant(), "seed": s.seed,
            "pairs": pairs.collect::<Vec<_>>(),
        })
    });
    Ok(serde_json::json!({ "hash": plan.hash, "scenes": scenes.collect::<Vec<_>>() }).to_string())
}
