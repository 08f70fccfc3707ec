//! What predictions make of each cell, and how much that depends on the scene.

use super::SweepIndex;
use crate::dataset::{Dataset, DiskStore, ReadError, StoreError};
use crate::evaluate::{EvaluateError, Evaluation, Options, SampleScores, Source, evaluate};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A sweep's scores.
#[derive(Clone, Debug, Serialize)]
pub struct Curves {
    /// The sweep.
    #[serde(flatten)]
    pub sweep: SweepIndex,
    /// Its cells' scores, in the sweep's order.
    pub scores: Vec<CellScores>,
}

/// Scores of a cell.
#[derive(Clone, Debug, Serialize)]
pub struct CellScores {
    /// The cell.
    pub cell: String,
    /// Over all its samples.
    pub evaluation: Evaluation,
    /// Of each scene by itself, in plan order: the same scenes in every cell.
    pub scenes: Vec<SceneScores>,
}

/// Scores of a scene: means of its samples' own scores, so that every pair counts alike. None where nothing counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneScores {
    /// Region and seed, such as `toronto 7`: the same in every cell, whatever the scene's folder is called.
    pub scene: String,
    /// Samples with a usable prediction.
    pub samples: usize,
    /// Mean error where both cameras see, px.
    pub noc_epe_px: Option<f64>,
    /// Share of these pixels that is off by more than 1 px.
    pub noc_bad_1: Option<f64>,
    /// Mean error where the right camera does not see, px.
    pub occ_epe_px: Option<f64>,
}

/// Evaluates the predictions in `predictions/<cell>/` for every cell of the sweep in `root`, on the current rayon pool.
///
/// # Errors
/// Where a cell's dataset or predictions cannot be read; the sentence begins with the cell.
pub fn curves(
    root: &Path,
    index: SweepIndex,
    predictions: &Path,
    options: &Options,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Curves, (String, EvaluateError)> {
    let scores = index.cells.iter().map(|cell| {
        let failed = |e: EvaluateError| (cell.name.clone(), e);
        let store =
            DiskStore::open(&root.join(&cell.name)).map_err(|e: StoreError| failed(ReadError::from(e).into()))?;
        let dataset = Dataset::open(&store).map_err(|e| failed(e.into()))?;
        let source = Source::Dataset(&dataset);
        let evaluation = evaluate(source, &predictions.join(&cell.name), options, done).map_err(failed)?;
        let scenes = scenes(&dataset, &evaluation.each);
        Ok(CellScores { cell: cell.name.clone(), evaluation, scenes })
    });
    let scores = scores.collect::<Result<Vec<_>, _>>()?;
    Ok(Curves { sweep: index, scores })
}

fn scenes(dataset: &Dataset<'_>, each: &[SampleScores]) -> Vec<SceneScores> {
    let by_id: BTreeMap<&str, &SampleScores> = each.iter().map(|s| (s.id.as_str(), s)).collect();
    let mut scenes: Vec<(String, Vec<&SampleScores>)> = Vec::new();
    for record in dataset.records() {
        let Some(scores) = by_id.get(record.id()) else { continue };
        let scene = format!("{} {}", record.identity.region, record.identity.scene_seed);
        match scenes.last_mut().filter(|(name, _)| *name == scene) {
            Some((_, samples)) => samples.push(scores),
            None => scenes.push((scene, vec![scores])),
        }
    }
    let mean = |samples: &[&SampleScores], of: fn(&SampleScores) -> Option<f64>| {
        let values: Vec<f64> = samples.iter().filter_map(|s| of(s)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    scenes
        .into_iter()
        .map(|(scene, samples)| SceneScores {
            scene,
            samples: samples.len(),
            noc_epe_px: mean(&samples, |s| s.scores.noc.epe_px),
            noc_bad_1: mean(&samples, |s| s.scores.noc.bad_1),
            occ_epe_px: mean(&samples, |s| s.scores.occ.epe_px),
        })
        .collect()
}
