//! Predictions held against a dataset's truth: scores, break-downs, and what is wrong with the predictions.
//!
//! Samples are read one after the other, as many at a time as there are threads; what stays of each is sums. They are added
//! in plan order, so scores do not depend on threads.

mod boundary;
mod breakdown;
mod html;
mod mistakes;
mod prediction;
mod report;
mod score;
mod tally;
mod texture;
mod truth;

pub use breakdown::{Breakdown, Row};
pub use html::html_report;
pub use mistakes::{Mistake, MistakeKind};
pub use report::{BoundaryScores, Evaluation, Group, Limit, RegionGroup, SampleScores, Unusable};
pub use score::{ByVisibility, Scores};

use crate::dataset::formats::HeightMap;
use crate::dataset::{Dataset, ReadError, SampleRecord};
use breakdown::{By, DisparityBins, Frames};
use mistakes::{Suspicion, suspicions, together};
use prediction::{Found, find, strangers};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use tally::Tally;
use truth::Truth;

/// How predictions are to be read and which are asked for.
#[derive(Clone, Debug)]
pub struct Options {
    /// Only samples of this split.
    pub split: Option<String>,
    /// What the numbers of a 16-bit PNG are divided by: 256 in KITTI's coding.
    pub png_scale: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { split: None, png_scale: 256.0 }
    }
}

/// Why there is no evaluation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// The truth cannot be read.
    #[error(transparent)]
    Truth(#[from] ReadError),
    /// The dataset has no such samples.
    #[error("the dataset has no sample of the split `{split}`; it has {there}")]
    NoSplit {
        /// As asked.
        split: String,
        /// The splits that there are.
        there: String,
    },
    /// The dataset is empty.
    #[error("the dataset has no samples")]
    Empty,
    /// There is no such folder.
    #[error("`{0}` is no folder with predictions")]
    NoFolder(PathBuf),
    /// None of the samples has a prediction.
    #[error(
        "`{folder}` holds no prediction for any of the {samples} samples: a prediction is called like its sample, such as \
         {example}.pfm, .tif, .npy or .png, or with `__` for the slash{found}"
    )]
    NoPrediction {
        /// Where they were looked for.
        folder: PathBuf,
        /// How many samples were asked for.
        samples: usize,
        /// A sample's id.
        example: String,
        /// What there is instead, as the end of the sentence.
        found: String,
    },
    /// None of the predictions can be used.
    #[error("none of the {count} predictions can be used; the first, `{file}`: {reason}")]
    AllUnusable {
        /// How many there are.
        count: usize,
        /// The first one.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// Holds the predictions in a folder against a dataset, on the current rayon pool. `done` is told of each sample.
///
/// # Errors
/// Where the truth cannot be read, or no prediction can be used at all. A single missing or unusable prediction is no error:
/// it is counted and named.
pub fn evaluate(
    dataset: &Dataset<'_>,
    folder: &Path,
    options: &Options,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Evaluation, EvaluateError> {
    let records = asked(dataset, options)?;
    if !folder.is_dir() {
        return Err(EvaluateError::NoFolder(folder.to_owned()));
    }
    let Files { there, missing, mut unusable, strangers } = look(folder, &records)?;
    let disparity = disparity_bins(&there);
    let mut outcome = Outcome::default();
    for scene in there.chunk_by(|a, b| a.0.scene() == b.0.scene()) {
        let ground = dataset.height_map(scene[0].0, "dtm")?;
        // As many samples at a time as can be worked on: memory does not grow with the dataset.
        for some in scene.chunks(rayon::current_num_threads().max(1)) {
            let read = some.par_iter().map(|(record, file)| {
                let one = Job { dataset, folder, options, ground: &ground, disparity };
                let result = one.sample(record, file);
                done(record.id());
                result
            });
            for ((record, file), one) in some.iter().zip(read.collect::<Result<Vec<_>, _>>()?) {
                match one {
                    Ok((tally, suspicions)) => outcome.add(record, file, &tally, &suspicions),
                    Err(reason) => unusable.push(Unusable { id: record.id().to_owned(), file: shown(file), reason }),
                }
            }
        }
    }
    if outcome.each.is_empty() {
        let Unusable { file, reason, .. } = unusable.swap_remove(0);
        return Err(EvaluateError::AllUnusable { count: unusable.len() + 1, file, reason });
    }
    let frames = Frames { disparity, deciles: texture::deciles(&outcome.total.texture_counts()) };
    let total = outcome.total.group(&frames);
    let region = |((region, variant), tally): (&(String, String), &Tally)| RegionGroup {
        region: region.clone(),
        variant: variant.clone(),
        group: tally.group(&frames),
    };
    Ok(Evaluation {
        dataset_root_hash: dataset.root_hash().hex(),
        split: options.split.clone(),
        samples: records.len(),
        evaluated: outcome.each.len(),
        missing,
        unusable,
        strangers,
        likely_mistakes: together(&outcome.suspicions),
        notes: notes(&total),
        regions: outcome.regions.iter().map(region).collect(),
        total,
        each: outcome.each,
    })
}

/// The samples that are asked for, in plan order.
fn asked<'d>(dataset: &'d Dataset<'_>, options: &Options) -> Result<Vec<&'d SampleRecord>, EvaluateError> {
    let all = dataset.records();
    let Some(split) = &options.split else {
        return if all.is_empty() { Err(EvaluateError::Empty) } else { Ok(all.iter().collect()) };
    };
    let records: Vec<_> = all.iter().filter(|r| r.identity.split == *split).collect();
    if records.is_empty() {
        let splits: BTreeSet<&str> = all.iter().map(|r| r.identity.split.as_str()).collect();
        let there = splits.into_iter().collect::<Vec<_>>().join(", ");
        return Err(EvaluateError::NoSplit { split: split.clone(), there });
    }
    Ok(records)
}

/// What lies in the folder of predictions.
struct Files<'r> {
    there: Vec<(&'r SampleRecord, PathBuf)>,
    missing: Vec<String>,
    unusable: Vec<Unusable>,
    strangers: Vec<String>,
}

fn look<'r>(folder: &Path, records: &[&'r SampleRecord]) -> Result<Files<'r>, EvaluateError> {
    let mut files = Files { there: Vec::new(), missing: Vec::new(), unusable: Vec::new(), strangers: Vec::new() };
    let mut known = BTreeSet::new();
    for record in records {
        let id = record.id().to_owned();
        match find(folder, &id) {
            Found::Missing => files.missing.push(id),
            Found::At(path) => {
                known.insert(path.clone());
                files.there.push((record, path));
            }
            Found::Several(paths) => {
                let names: Vec<_> = paths.iter().map(|p| shown(p)).collect();
                let reason = format!("several files claim to be its prediction: {}", names.join(", "));
                files.unusable.push(Unusable { id, file: names[0].clone(), reason });
                known.extend(paths);
            }
        }
    }
    files.strangers = strangers(folder, &known).iter().map(|p| shown(p)).collect();
    if files.there.is_empty() {
        if !files.unusable.is_empty() {
            let Unusable { file, reason, .. } = files.unusable.swap_remove(0);
            return Err(EvaluateError::AllUnusable { count: files.unusable.len() + 1, file, reason });
        }
        let found = files.strangers.first().map(|f| format!("; it holds `{f}` instead")).unwrap_or_default();
        return Err(EvaluateError::NoPrediction {
            folder: folder.to_owned(),
            samples: records.len(),
            example: records[0].id().to_owned(),
            found,
        });
    }
    Ok(files)
}

/// A file's name without control characters: strangers give any.
fn shown(path: &Path) -> String {
    path.to_string_lossy().escape_debug().to_string()
}

fn disparity_bins(there: &[(&SampleRecord, PathBuf)]) -> DisparityBins {
    let low = there.iter().filter_map(|(r, _)| r.disparity_min_px).fold(f32::INFINITY, f32::min);
    let high = there.iter().filter_map(|(r, _)| r.disparity_max_px).fold(f32::NEG_INFINITY, f32::max);
    if low <= high { DisparityBins::new(low.into(), high.into()) } else { DisparityBins::new(0.0, 0.0) }
}

/// What a sample's evaluation needs.
struct Job<'a> {
    dataset: &'a Dataset<'a>,
    folder: &'a Path,
    options: &'a Options,
    ground: &'a HeightMap,
    disparity: DisparityBins,
}

impl Job<'_> {
    /// The sums of a sample; the inner error is what is wrong with its prediction.
    fn sample(&self, record: &SampleRecord, file: &Path) -> Result<Result<(Tally, Vec<Suspicion>), String>, ReadError> {
        let truth = Truth::read(self.dataset, record, self.ground, self.disparity)?;
        Ok(match prediction::read(&self.folder.join(file), truth.size, self.options.png_scale) {
            Err(e) => Err(e.to_string()),
            Ok(predicted) if !predicted.iter().any(|p| p.is_finite()) => {
                Err("it holds no finite number: nothing is predicted".to_owned())
            }
            Ok(predicted) => {
                let tally = Tally::of(&truth, &predicted, record.identity.baseline_m);
                Ok((tally, suspicions(&truth, &predicted)))
            }
        })
    }
}

/// What stays of the samples.
struct Outcome {
    total: Tally,
    regions: BTreeMap<(String, String), Tally>,
    suspicions: Vec<Suspicion>,
    each: Vec<SampleScores>,
}

impl Default for Outcome {
    fn default() -> Self {
        Self { total: Tally::new(), regions: BTreeMap::new(), suspicions: Vec::new(), each: Vec::new() }
    }
}

impl Outcome {
    fn add(&mut self, record: &SampleRecord, file: &Path, tally: &Tally, suspicions: &[Suspicion]) {
        let key = (record.identity.region.clone(), record.identity.variant.clone());
        self.total.merge(tally);
        self.regions.entry(key).or_insert_with(Tally::new).merge(tally);
        self.suspicions.extend(suspicions);
        self.each.push(SampleScores {
            id: record.id().to_owned(),
            file: shown(file),
            scores: tally.total.scores(),
            likely_mistakes: suspicions.iter().map(|s| s.kind).collect(),
        });
    }
}

/// Break-downs that there cannot be, and why.
fn notes(total: &Group) -> Vec<String> {
    let labels: Vec<(&str, &str)> = By::ALL
        .iter()
        .filter(|by| !total.by.contains_key(by.name()))
        .filter_map(|by| Some((by.name(), by.label()?)))
        .collect();
    labels
        .into_iter()
        .map(|(by, label)| format!("not broken down by {by}: the recipe's labels.write does not ask for \"{label}\""))
        .collect()
}
