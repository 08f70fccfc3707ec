//! Predictions held against a dataset's truth: scores, break-downs, and what is wrong with the predictions.
//!
//! Samples are read one after the other, as many at a time as there are threads; what stays of each is sums. They are added
//! in plan order, so scores do not depend on threads.

mod boundary;
mod breakdown;
mod foreign;
mod html;
mod mistakes;
mod picture;
mod prediction;
mod report;
mod score;
mod source;
mod tally;
mod truth;

pub use breakdown::{Breakdown, Row};
pub use foreign::{Foreign, TruthLayout};
pub use html::html_report;
pub(crate) use html::page;
pub use mistakes::{Mistake, MistakeKind};
pub use report::{BoundaryScores, Evaluation, Group, Limit, RegionGroup, SampleScores, Unusable};
pub use score::{ByVisibility, Scores};
pub use source::Source;

use crate::dataset::ReadError;
use crate::dataset::formats::HeightMap;
use crate::dataset::texture;
use breakdown::{By, DisparityBins, Frames};
use mistakes::{Suspicion, suspicions, together};
use prediction::{Found, find, strangers};
use rayon::prelude::*;
use source::{Item, disparity_bins};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use tally::Tally;

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
    /// Foreign truth cannot be read.
    #[error("`{path}`: {reason}")]
    ForeignTruth {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// There is no foreign truth.
    #[error("`{root}` holds nothing in the layout {layout}, which has {expected}")]
    NoForeignTruth {
        /// Where it was looked for.
        root: PathBuf,
        /// The layout's name.
        layout: &'static str,
        /// What it would look like.
        expected: &'static str,
    },
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

/// Holds the predictions in a folder against truth, on the current rayon pool. `done` is told of each sample.
///
/// # Errors
/// Where the truth cannot be read, or no prediction can be used at all. A single missing or unusable prediction is no error:
/// it is counted and named.
pub fn evaluate(
    source: Source<'_>,
    folder: &Path,
    options: &Options,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Evaluation, EvaluateError> {
    let items = asked(source, options)?;
    if !folder.is_dir() {
        return Err(EvaluateError::NoFolder(folder.to_owned()));
    }
    let Files { there, missing, mut unusable, strangers } = look(folder, &items)?;
    let disparity = disparity_bins(there.iter().map(|(item, _)| *item))?;
    let mut outcome = Outcome::default();
    for scene in there.chunk_by(|a, b| a.0.scene() == b.0.scene()) {
        let ground = scene[0].0.ground()?;
        // As many samples at a time as can be worked on: memory does not grow with the dataset.
        for some in scene.chunks(rayon::current_num_threads().max(1)) {
            let read = some.par_iter().map(|(item, file)| {
                let one = Job { folder, options, ground: ground.as_ref(), disparity };
                let result = one.sample(*item, file);
                done(item.id());
                result
            });
            for ((item, file), one) in some.iter().zip(read.collect::<Result<Vec<_>, _>>()?) {
                match one {
                    Ok((tally, suspicions)) => outcome.add(*item, file, &tally, &suspicions),
                    Err(reason) => unusable.push(Unusable { id: item.id().to_owned(), file: shown(file), reason }),
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
        dataset_root_hash: source.root_hash(),
        split: options.split.clone(),
        samples: items.len(),
        evaluated: outcome.each.len(),
        missing,
        unusable,
        strangers,
        likely_mistakes: together(&outcome.suspicions),
        notes: notes(&total, source),
        regions: outcome.regions.iter().map(region).collect(),
        total,
        each: outcome.each,
    })
}

/// The samples that are asked for, in their order.
fn asked<'a>(source: Source<'a>, options: &Options) -> Result<Vec<Item<'a>>, EvaluateError> {
    let all = source.items();
    let Some(split) = &options.split else {
        return if all.is_empty() { Err(EvaluateError::Empty) } else { Ok(all) };
    };
    let items: Vec<_> = all.iter().copied().filter(|item| item.split() == split).collect();
    if items.is_empty() {
        let splits: BTreeSet<&str> = all.iter().map(|item| item.split()).collect();
        let there = splits.into_iter().collect::<Vec<_>>().join(", ");
        return Err(EvaluateError::NoSplit { split: split.clone(), there });
    }
    Ok(items)
}

/// What lies in the folder of predictions.
struct Files<'a> {
    there: Vec<(Item<'a>, PathBuf)>,
    missing: Vec<String>,
    unusable: Vec<Unusable>,
    strangers: Vec<String>,
}

fn look<'a>(folder: &Path, items: &[Item<'a>]) -> Result<Files<'a>, EvaluateError> {
    let mut files = Files { there: Vec::new(), missing: Vec::new(), unusable: Vec::new(), strangers: Vec::new() };
    let mut known = BTreeSet::new();
    for item in items {
        let id = item.id().to_owned();
        match find(folder, &id) {
            Found::Missing => files.missing.push(id),
            Found::At(path) => {
                known.insert(path.clone());
                files.there.push((*item, path));
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
            samples: items.len(),
            example: items[0].id().to_owned(),
            found,
        });
    }
    Ok(files)
}

/// A file's name without control characters: strangers give any.
fn shown(path: &Path) -> String {
    path.to_string_lossy().escape_debug().to_string()
}

/// What a sample's evaluation needs.
struct Job<'a> {
    folder: &'a Path,
    options: &'a Options,
    ground: Option<&'a HeightMap>,
    disparity: DisparityBins,
}

impl Job<'_> {
    /// The sums of a sample; the inner error is what is wrong with its prediction.
    fn sample(&self, item: Item<'_>, file: &Path) -> Result<Result<(Tally, Vec<Suspicion>), String>, EvaluateError> {
        let truth = item.truth(self.ground, self.disparity)?;
        Ok(match prediction::read(&self.folder.join(file), truth.size, self.options.png_scale) {
            Err(e) => Err(e.to_string()),
            Ok(predicted) if !predicted.iter().any(|p| p.is_finite()) => {
                Err("it holds no finite number: nothing is predicted".to_owned())
            }
            Ok(predicted) => {
                let tally = Tally::of(&truth, &predicted, item.baseline_m());
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
    fn add(&mut self, item: Item<'_>, file: &Path, tally: &Tally, suspicions: &[Suspicion]) {
        self.total.merge(tally);
        self.regions.entry(item.region()).or_insert_with(Tally::new).merge(tally);
        self.suspicions.extend(suspicions);
        self.each.push(SampleScores {
            id: item.id().to_owned(),
            file: shown(file),
            scores: tally.total.scores(),
            likely_mistakes: suspicions.iter().map(|s| s.kind).collect(),
        });
    }
}

/// Break-downs that there cannot be, and why.
fn notes(total: &Group, source: Source<'_>) -> Vec<String> {
    if let Source::Foreign(foreign) = source {
        let layout = foreign.layout().name();
        let mut notes =
            vec![format!("not broken down by slope, height, class, shadow and baseline: {layout} does not tell them")];
        if !foreign.knows_occlusion() {
            notes.push(format!("{layout} does not tell occluded pixels: all pixels with truth count as noc"));
        }
        return notes;
    }
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
