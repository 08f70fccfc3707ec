//! One recipe again and again, with one thing changed: a grid of datasets, and the curves of what predictions make of them.
//!
//! Scenes, seeds and pairs are the same in every cell; the index proves it with a hash of each cell's recipe in which the
//! varied keys are put back to the first cell's values.

mod curves;
mod report;
mod vary;

pub use curves::{CellScores, Curves, SceneScores, curves};
pub use report::html_report;
pub use vary::Vary;

use crate::plan::{Plan, PlanError};
use crate::recipe::{Changes, Recipe, RecipeError};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// The index's name in a sweep's folder.
pub const INDEX: &str = "sweep.json";
/// Most cells of a sweep.
const MOST_CELLS: usize = 1000;

/// Why there is no sweep.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A cell's recipe is not legal.
    #[error("cell {cell}: {reason}")]
    Recipe {
        /// Which cell.
        cell: String,
        /// Why.
        reason: RecipeError,
    },
    /// A cell's plan is not possible.
    #[error("cell {cell}: {reason}")]
    Plan {
        /// Which cell.
        cell: String,
        /// Why.
        reason: PlanError,
    },
    /// What is asked for is no sweep.
    #[error("{0}")]
    Asked(String),
}

/// A grid of recipes.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// What the folder's index says.
    pub index: SweepIndex,
    /// Each cell's recipe and plan, in the index's order.
    pub cells: Vec<(Recipe, Plan)>,
}

/// `sweep.json`: what a sweep consists of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SweepIndex {
    /// What is varied, the slowest first.
    pub vary: Vec<Vary>,
    /// BLAKE3 of every cell's resolved recipe with the varied keys at the first cell's values: one and the same.
    pub recipe_but_for_varied_blake3: String,
    /// The cells; each is a dataset in a folder of its name.
    pub cells: Vec<IndexedCell>,
}

/// A cell, as the index has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IndexedCell {
    /// Its folder.
    pub name: String,
    /// The varied keys' values, as TOML.
    pub values: BTreeMap<String, String>,
    /// Hash of its plan.
    pub plan: String,
}

impl Sweep {
    /// The grid of a recipe with changes, over all combinations of what is varied. Nothing is made; every cell is checked.
    ///
    /// # Errors
    /// Where a cell is not legal, or they would differ by more than what is varied.
    pub fn new(recipe: &str, changes: &Changes, vary: &[Vary]) -> Result<Self, SweepError> {
        check(vary)?;
        let count: usize = vary.iter().map(|v| v.values.len()).product();
        if count > MOST_CELLS {
            return Err(SweepError::Asked(format!("{count} cells are more than the {MOST_CELLS} of a sweep")));
        }
        let mut cells = Vec::new();
        let mut indexed: Vec<IndexedCell> = Vec::new();
        let mut same: Option<String> = None;
        for number in 0..count {
            let values = combination(vary, number);
            let name = values.iter().map(|(key, value)| folder_name(key, value)).collect::<Vec<_>>().join("__");
            let set: Vec<String> = values.iter().map(|(key, value)| format!("{key}={value}")).collect();
            let refused = |reason| SweepError::Recipe { cell: name.clone(), reason };
            let changed = Changes { set: [changes.set.clone(), set].concat(), ..changes.clone() };
            let made = Recipe::load(recipe, &changed).map_err(refused)?;
            let plan = Plan::new(&made).map_err(|reason| SweepError::Plan { cell: name.clone(), reason })?;
            let first: Vec<String> = combination(vary, 0).iter().map(|(k, v)| format!("{k}={v}")).collect();
            let back = Recipe::parse_with(&name, &made.to_toml(), &first).map_err(refused)?.to_toml();
            let hash = blake3::hash(back.as_bytes()).to_hex().to_string();
            if *same.get_or_insert_with(|| hash.clone()) != hash {
                let keys = vary.iter().map(|v| v.key.as_str()).collect::<Vec<_>>().join(" and ");
                let message =
                    format!("cell {name} would differ from the first by more than {keys}; vary each key by itself");
                return Err(SweepError::Asked(message));
            }
            if let Some(other) = indexed.iter().find(|cell| cell.name == name || cell.plan == plan.hash) {
                let message =
                    format!("cells {} and {name} would be the same dataset: their values are alike", other.name);
                return Err(SweepError::Asked(message));
            }
            let values = values.into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
            indexed.push(IndexedCell { name, values, plan: plan.hash.clone() });
            cells.push((made, plan));
        }
        let recipe_but_for_varied_blake3 = same.unwrap_or_default();
        Ok(Self { index: SweepIndex { vary: vary.to_vec(), recipe_but_for_varied_blake3, cells: indexed }, cells })
    }
}

impl SweepIndex {
    /// The text of `sweep.json`.
    pub fn to_text(&self) -> String {
        serde_json::to_string_pretty(self).expect("an index is plain data with text keys") + "\n"
    }

    /// Reads the text of `sweep.json`, which anyone may have written.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let index: Self = serde_json::from_str(text).map_err(|e| format!("it is no index of a sweep: {e}"))?;
        let plain = |name: &str| {
            !name.is_empty()
                && !name.starts_with('.')
                && name.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.'))
        };
        match index.cells.iter().find(|cell| !plain(&cell.name)) {
            Some(cell) => Err(format!("`{}` cannot be a cell's folder", cell.name.escape_default())),
            None if index.vary.is_empty() || index.cells.is_empty() => Err("it has no cells".to_owned()),
            None => Ok(index),
        }
    }
}

fn check(vary: &[Vary]) -> Result<(), SweepError> {
    let asked = |message: String| Err(SweepError::Asked(message));
    if vary.is_empty() {
        return asked("a sweep varies at least one key: --vary camera.gsd_m=0.3,0.5".to_owned());
    }
    let mut keys = BTreeSet::new();
    for v in vary {
        if v.key == "seed" || v.key == "pivots" || v.key == "seeds" {
            return asked(format!("`{}` cannot be varied: scenes and their seeds are what stays the same", v.key));
        }
        if !keys.insert(&v.key) {
            return asked(format!("`{}` is varied twice", v.key));
        }
    }
    Ok(())
}

/// The varied keys and their values in a cell; the last key changes fastest.
fn combination(vary: &[Vary], mut number: usize) -> Vec<(&str, &str)> {
    let mut values: Vec<_> = vary
        .iter()
        .rev()
        .map(|v| {
            let value = &v.values[number % v.values.len()];
            number /= v.values.len();
            (v.key.as_str(), value.as_str())
        })
        .collect();
    values.reverse();
    values
}

/// `texture_contrast-0.5`: the key's last part and the value.
fn folder_name(key: &str, value: &str) -> String {
    let key = key.rsplit('.').next().unwrap_or(key);
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_') { c } else { '_' };
    let value: String = value.trim_matches(['"', '\'']).chars().map(plain).collect();
    format!("{key}-{value}").to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(set: &[&str], vary: &[&str]) -> Result<Sweep, SweepError> {
        let vary: Vec<Vary> = vary.iter().map(|v| v.parse().unwrap()).collect();
        let changes = Changes { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Changes::default() };
        Sweep::new("quickstart", &changes, &vary)
    }

    #[test]
    fn cells_differ_by_the_factor_alone() {
        let sweep = sweep(&[], &["scene.canyon.texture_contrast=0:1:3", "sensor.samples_per_pixel=1,4"]).unwrap();
        let names: Vec<_> = sweep.index.cells.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(
            names[..3],
            [
                "texture_contrast-0.0__samples_per_pixel-1",
                "texture_contrast-0.0__samples_per_pixel-4",
                "texture_contrast-0.5__samples_per_pixel-1"
            ]
        );
        assert_eq!(names.len(), 6);
        let (first, plan) = &sweep.cells[0];
        let lines = |recipe: &Recipe| recipe.to_toml().lines().map(str::to_owned).collect::<Vec<_>>();
        for ((recipe, other), cell) in sweep.cells.iter().zip(&sweep.index.cells).skip(1) {
            let (a, b) = (lines(first), lines(recipe));
            assert_eq!(a.len(), b.len());
            let different: Vec<_> = a.iter().zip(&b).filter(|(x, y)| x != y).map(|(_, y)| y.clone()).collect();
            let varied = |line: &String| line.contains("texture_contrast") || line.contains("samples_per_pixel");
            assert!(!different.is_empty() && different.iter().all(varied), "{}: {different:?}", cell.name);
            let seeds = |p: &Plan| p.scenes.iter().map(|s| s.seed).collect::<Vec<_>>();
            let pairs = |p: &Plan| {
                p.scenes.iter().flat_map(|s| &s.pairs).map(|p| (p.folder().to_owned(), p.split)).collect::<Vec<_>>()
            };
            assert_eq!((seeds(plan), pairs(plan)), (seeds(other), pairs(other)));
        }
        let text = sweep.index.to_text();
        assert_eq!(SweepIndex::from_text(&text).unwrap(), sweep.index);
    }

    /// A split that went by all parameters would train one cell's net on what another's is tested with.
    #[test]
    fn pivots_keep_their_splits() {
        for rule in ["by-pivot", "published"] {
            let scenes = "scene=[{canyon={radius_m=170.0},pivots=9},{toronto={radius_m=170.0},pivots=7}]";
            let rule = format!("split.rule={rule}");
            let sweep = sweep(&[scenes, &rule], &["scene.canyon.relief_m=120:200:5"]).unwrap();
            let splits = |plan: &Plan| {
                let pairs = plan
                    .scenes
                    .iter()
                    .flat_map(|s| s.pairs.iter().map(move |p| (s.seed, p.folder().to_owned(), p.split)));
                pairs.collect::<Vec<_>>()
            };
            let first = splits(&sweep.cells[0].1);
            assert!(first.iter().any(|s| s.2 != first[0].2), "one split proves nothing");
            for (_, plan) in &sweep.cells[1..] {
                assert_eq!(splits(plan), first, "{rule}");
            }
        }
    }

    #[test]
    fn what_is_no_sweep_is_refused() {
        for (vary, told) in [
            (&["seed=1,2"][..], "cannot be varied"),
            (&["camera.gsd_m=0.3,0.5", "camera.gsd_m=0.6"], "varied twice"),
            (&["camera.gsd_m=0.3,0.30"], "the same dataset"),
            (&["camera.gsd_m=0.3,-1"], "cell gsd_m--1: "),
            (&["camera.gsdm=0.3"], "gsdm"),
            (&["camera.gsd_m=0.2:0.9:1001"], "more than the 1000"),
        ] {
            let error = sweep(&[], vary).unwrap_err().to_string();
            assert!(error.contains(told), "{vary:?}: {error}");
        }
        let bad = |text: &str| SweepIndex::from_text(text).unwrap_err();
        assert!(bad("{}").contains("no index of a sweep"));
        let cell = r#"{"vary":[{"key":"a","values":["1"]}],"recipe_but_for_varied_blake3":"","cells":[{"name":"../x","values":{},"plan":""}]}"#;
        assert!(bad(cell).contains("cannot be a cell's folder"), "{}", bad(cell));
    }
}
