//! Scenes that are built once and traced as often as one likes.

use crate::{GenerateError, RecipeError, arrays, background, recipe};
use pyo3::prelude::*;
use satseed::pipeline::{BuiltScene, PipelineError, build_scene, make_sample, thread_pool};
use satseed::plan::{Plan, SceneSpec};
use satseed::recipe::Recipe;
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
    pool: Arc<rayon::ThreadPool>,
    name: String,
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
    ) -> PyResult<Self> {
        let recipe = recipe(recipe_text, set, seed)?;
        let plan = Plan::new(&recipe).map_err(|e| RecipeError::new_err(e.to_string()))?;
        let count = plan.scenes.len();
        let Some(spec) = plan.scenes.into_iter().nth(index) else {
            return Err(RecipeError::new_err(format!(
                "the recipe has {count} scenes, so there is none of index {index}"
            )));
        };
        let pool = Arc::new(thread_pool(threads).map_err(|e| failed(&e))?);
        let (name, pairs) = (spec.name.clone(), spec.pairs.iter().map(|p| p.id.clone()).collect());
        let builder = Arc::clone(&pool);
        let kept = background::run(py, move || builder.install(|| build(recipe, spec)))?.map_err(|e| failed(&e))?;
        Ok(Self { kept: Arc::new(kept), pool, name, pairs })
    }

    /// The scene's name, its folder in a dataset.
    #[getter]
    fn name(&self) -> &str {
        &self.name
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
        let (kept, pool) = (Arc::clone(&self.kept), Arc::clone(&self.pool));
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
