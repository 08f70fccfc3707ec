//! The native half of the Python package `satseed`: scenes, pairs and datasets as NumPy arrays. The other half, in
//! `satseed/`, gives them names and types.
//!
//! Long work runs on threads of its own while the interpreter's lock is free; Ctrl-C is looked for meanwhile.

mod arrays;
mod background;
mod dataset;
mod pool;
mod scene;

use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use satseed::recipe::{Changes, Recipe};

create_exception!(satseed, RecipeError, PyValueError, "A recipe, a seed or a name that is not legal.");
create_exception!(satseed, DatasetError, PyOSError, "A dataset that cannot be read.");
create_exception!(satseed, GenerateError, PyRuntimeError, "A scene or a pair that could not be made.");

/// A recipe by a preset's name, a file's path or its own text, with `key=value`s laid over it.
fn recipe(recipe: &str, set: Vec<String>, seed: Option<u64>) -> PyResult<Recipe> {
    let refused = |e: satseed::recipe::RecipeError| RecipeError::new_err(e.to_string());
    if recipe.contains('\n') {
        let seed = seed.map(|seed| format!("seed={seed}"));
        let set: Vec<String> = seed.into_iter().chain(set).collect();
        return Recipe::parse_with("recipe", recipe, &set).map_err(refused);
    }
    Recipe::load(recipe, &Changes { set, seed, seed_list: None }).map_err(refused)
}

#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("RecipeError", m.py().get_type::<RecipeError>())?;
    m.add("DatasetError", m.py().get_type::<DatasetError>())?;
    m.add("GenerateError", m.py().get_type::<GenerateError>())?;
    m.add_class::<scene::Scene>()?;
    m.add_class::<dataset::Dataset>()?;
    m.add_function(wrap_pyfunction!(scene::plan, m)?)?;
    m.add_function(wrap_pyfunction!(arrays::_hand_over, m)?)?;
    Ok(())
}
