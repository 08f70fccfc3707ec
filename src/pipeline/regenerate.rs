//! Samples made again from their seeds, held against what stands.

use super::scene::{BuiltScene, build_scene};
use super::{PipelineError, make_sample, recipe_text};
use crate::dataset::{Dataset, Finding, ReadError, SampleRecord, compare_sample, compare_scene};
use crate::plan::Plan;
use crate::recipe::Recipe;

/// The samples that are made again: the `n` lowest by a hash keyed with the dataset's own root hash, so that whoever
/// checks a published dataset checks the same ones, and whoever forges one cannot choose them.
pub fn chosen<'a>(dataset: &'a Dataset<'_>, n: usize) -> Vec<&'a str> {
    let root = dataset.root_hash();
    let mut ids: Vec<&str> = dataset.records().iter().map(SampleRecord::id).collect();
    ids.sort_by_cached_key(|id| *blake3::keyed_hash(root.bytes(), id.as_bytes()).as_bytes());
    ids.truncate(n);
    ids
}

/// Makes samples again and compares them with what stands, scene by scene in plan order, on the current rayon pool.
/// Only findings about readable files are given; damage is `verify`'s own business.
///
/// # Errors
/// Where the plan has no such sample, or the store fails.
pub fn regenerate(
    recipe: &Recipe,
    plan: &Plan,
    dataset: &Dataset<'_>,
    ids: &[&str],
    report: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Finding>, PipelineError> {
    let mut findings = Vec::new();
    for id in ids {
        if !plan.pairs().any(|(_, pair)| pair.id == *id) {
            return Err(ReadError::NoSample((*id).to_owned()).into());
        }
    }
    for spec in &plan.scenes {
        let pairs: Vec<_> = spec.pairs.iter().filter(|p| ids.contains(&p.id.as_str())).collect();
        let Some(first) = pairs.first() else { continue };
        let scene = build_scene(spec)?;
        let built = BuiltScene::new(recipe, spec, &scene);
        findings.extend(compare_scene(dataset, dataset.record(&first.id)?, &built.files())?);
        for pair in pairs {
            findings.extend(compare_sample(dataset, dataset.record(&pair.id)?, make_sample(&built, pair)?)?);
            report(&pair.id);
        }
    }
    Ok(findings)
}

/// Whether this program makes the bytes of a dataset's `recipe.toml`; otherwise the first line that differs.
pub fn same_recipe_text(recipe: &Recipe, plan: &Plan, standing: &str) -> Result<(), String> {
    let own = recipe_text(recipe, plan);
    match own.lines().zip(standing.lines()).find(|(a, b)| a != b) {
        Some((own, standing)) => Err(format!("it says `{standing}` where this program says `{own}`")),
        None if own.len() != standing.len() => Err("it is longer or shorter than what this program writes".to_owned()),
        None => Ok(()),
    }
}
