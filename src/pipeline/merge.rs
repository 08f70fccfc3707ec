//! What shards wrote becomes a dataset.

use super::PipelineError;
use super::contents::{recipe_text, scene_contents};
use crate::card::ensure_card;
use crate::dataset::{ManifestHash, RECIPE, Store, bring, join, put_same, same_recipe};
use crate::gallery::ensure_gallery;
use crate::plan::Plan;
use crate::recipe::Recipe;

/// How to merge.
#[derive(Clone, Copy)]
pub struct Merge<'a> {
    /// Where shards wrote that did not write into the dataset's own store; may be empty.
    pub from: &'a [&'a dyn Store],
    /// Whether to make the card and the gallery too, for which every sample is read.
    pub pages: bool,
}

/// Joins what the shards of a plan wrote, on the current rayon pool: the same bytes as one run makes. The caller holds
/// the folder's lock alone.
///
/// # Errors
/// Where samples are missing, or differ between those who made them.
pub fn merge(recipe: &Recipe, plan: &Plan, store: &dyn Store, how: Merge<'_>) -> Result<ManifestHash, PipelineError> {
    let recipe_toml = recipe_text(recipe, plan);
    if !store.is_shared() {
        store.clear_unfinished().map_err(crate::dataset::WriteError::from)?;
    }
    put_same(store, RECIPE, recipe_toml.as_bytes())?;
    let scenes = || plan.scenes.iter().map(|spec| scene_contents(spec, 0..spec.pairs.len()));
    for from in how.from {
        same_recipe(*from, &recipe_toml)?;
        for scene in scenes() {
            bring(*from, store, &scene)?;
        }
    }
    let joined = join(store, &recipe_toml, scenes)?;
    if how.pages {
        ensure_card(store)?;
        ensure_gallery(store)?;
    }
    // All shards are done, so whatever is unfinished is a dead one's.
    store.clear_unfinished().map_err(crate::dataset::WriteError::from)?;
    Ok(joined.root_hash)
}
