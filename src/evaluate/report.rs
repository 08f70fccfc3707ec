//! What an evaluation says.

use super::breakdown::Breakdown;
use super::mistakes::{Mistake, MistakeKind};
use super::score::{ByVisibility, Scores};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Predictions held against a dataset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// Hash of the dataset's manifest; none where the truth is foreign.
    pub dataset_root_hash: Option<String>,
    /// The split that was asked for; all where none was.
    pub split: Option<String>,
    /// Samples that were asked for.
    pub samples: usize,
    /// Samples with a prediction that could be used; only they stand in scores.
    pub evaluated: usize,
    /// Samples without a prediction.
    pub missing: Vec<String>,
    /// Samples whose prediction could not be used.
    pub unusable: Vec<Unusable>,
    /// Files that could be predictions but belong to no sample that was asked for.
    pub strangers: Vec<String>,
    /// Mistakes that the predictions look like, the most frequent first.
    pub likely_mistakes: Vec<Mistake>,
    /// What else should be known.
    pub notes: Vec<String>,
    /// Over all evaluated samples.
    pub total: Group,
    /// Each region and variant.
    pub regions: Vec<RegionGroup>,
    /// Each evaluated sample, in plan order.
    pub each: Vec<SampleScores>,
}

impl Evaluation {
    /// Whether every sample that was asked for had a prediction that could be used.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty() && self.unusable.is_empty()
    }
}

/// A prediction that could not be used.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unusable {
    /// The sample.
    pub id: String,
    /// The file, below the folder of predictions.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
}

/// Scores of some samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// How many samples.
    pub samples: usize,
    /// Pixels that do not count because they lie beyond the right frame.
    pub out_of_frame_pixels: u64,
    /// Pixels that do not count because nothing was hit.
    pub nothing_hit_pixels: u64,
    /// Over all pixels.
    pub scores: ByVisibility<Scores>,
    /// Mean of the samples' own mean errors, px.
    pub epe_images_px: ByVisibility<Option<f64>>,
    /// At disparity jumps.
    pub boundary: BoundaryScores,
    /// Broken down: by `texture`, `disparity`, `slope`, `height`, `class`, `shadow`, `boundary_distance`, `baseline`.
    pub by: BTreeMap<&'static str, Breakdown>,
}

/// Scores at disparity jumps of more than 3 px.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundaryScores {
    /// Over the pixels at most 5 px from a pixel beside a jump.
    pub within_5_px: ByVisibility<Scores>,
    /// Counted pixels beside a jump.
    pub jump_pixels: u64,
    /// Soft edge error over them: least difference to any truth in 3 x 3 pixels, mean, px.
    pub see_3_px: Option<f64>,
    /// The same in 5 x 5 pixels.
    pub see_5_px: Option<f64>,
}

/// Scores of one region's variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionGroup {
    /// Region.
    pub region: String,
    /// Its variant.
    pub variant: String,
    /// Its scores.
    #[serde(flatten)]
    pub group: Group,
}

/// Scores of one sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SampleScores {
    /// The sample.
    pub id: String,
    /// Its prediction's file, below the folder of predictions.
    pub file: String,
    /// Its scores.
    #[serde(flatten)]
    pub scores: ByVisibility<Scores>,
    /// Mistakes that its prediction looks like.
    pub likely_mistakes: Vec<MistakeKind>,
}

/// Sets of pixels that a limit can be set for.
const SETS: [&str; 4] = ["noc", "occ", "all", "boundary"];
/// Metrics that a limit can be set for: all grow with the error.
const METRICS: [&str; 6] = ["epe_px", "bad_1", "bad_2", "bad_3", "d1", "unpredicted"];

/// The highest value that a metric may have: `noc.epe_px=1.5`, or `epe_px=1.5`, which means `noc`.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    set: &'static str,
    metric: &'static str,
    most: f64,
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("a limit is METRIC=VALUE, such as noc.epe_px=1.5")?;
        let (set, metric) = name.trim().split_once('.').unwrap_or(("noc", name.trim()));
        let metrics = || METRICS.iter().copied().chain(["epe_images_px", "see_3_px", "see_5_px"]);
        let set = SETS.into_iter().find(|s| *s == set);
        let metric = metrics().find(|m| *m == metric);
        let (Some(set), Some(metric)) = (set, metric) else {
            return Err(format!(
                "no metric is called `{}`: it is one of {}, after noc., occ., all. or boundary.",
                name.escape_default(),
                metrics().collect::<Vec<_>>().join(", ")
            ));
        };
        if set == "boundary" && metric == "epe_images_px" || set != "boundary" && metric.starts_with("see_") {
            return Err(format!("`{set}.{metric}` is not measured: soft edges are boundary., means of images are not"));
        }
        let most: f64 = value.trim().parse().map_err(|_| format!("`{}` is no number", value.escape_default()))?;
        if !(most.is_finite() && most >= 0.0) {
            return Err(format!("`{most}` cannot be a limit, which is 0 or more"));
        }
        if most > 1.0 && !metric.ends_with("_px") {
            return Err(format!("`{metric}` is a share of the pixels, 0 to 1: 5 % are 0.05"));
        }
        Ok(Self { set, metric, most })
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.set, self.metric)
    }
}

impl Limit {
    /// What is wrong where an evaluation exceeds the limit, in a sentence. A metric without a value exceeds every limit: it
    /// was asked for and could not be held.
    pub fn exceeded(&self, evaluation: &Evaluation) -> Option<String> {
        let group = &evaluation.total;
        match self.value(group) {
            Some(value) if value <= self.most => None,
            Some(value) => Some(format!("{self} is {value}, above the limit of {}", self.most)),
            None => Some(format!("{self} has no value, so that the limit of {} is not kept", self.most)),
        }
    }

    fn value(&self, group: &Group) -> Option<f64> {
        let zone = &group.boundary.within_5_px;
        let (scores, images) = match self.set {
            "occ" => (&group.scores.occ, group.epe_images_px.occ),
            "all" => (&group.scores.all, group.epe_images_px.all),
            "boundary" => (&zone.all, None),
            _ => (&group.scores.noc, group.epe_images_px.noc),
        };
        match self.metric {
            "epe_px" => scores.epe_px,
            "epe_images_px" => images,
            "bad_1" => scores.bad_1,
            "bad_2" => scores.bad_2,
            "bad_3" => scores.bad_3,
            "d1" => scores.d1,
            "see_3_px" => group.boundary.see_3_px,
            "see_5_px" => group.boundary.see_5_px,
            _ => scores.unpredicted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_parsed() {
        for (text, shown, most) in [
            ("epe_px=1.5", "noc.epe_px", 1.5),
            ("all.d1=0.05", "all.d1", 0.05),
            ("occ.epe_images_px=12", "occ.epe_images_px", 12.0),
            ("boundary.see_3_px=2", "boundary.see_3_px", 2.0),
            ("unpredicted=0", "noc.unpredicted", 0.0),
        ] {
            let limit: Limit = text.parse().unwrap();
            assert_eq!((limit.to_string().as_str(), limit.most), (shown, most));
        }
        for (text, told) in [
            ("epe_px", "METRIC=VALUE"),
            ("epe=1", "no metric is called `epe`"),
            ("foo.epe_px=1", "noc., occ., all. or boundary."),
            ("noc.see_3_px=1", "not measured"),
            ("boundary.epe_images_px=1", "not measured"),
            ("epe_px=x", "no number"),
            ("epe_px=NaN", "cannot be a limit"),
            ("epe_px=-1", "cannot be a limit"),
            ("bad_1=5", "5 % are 0.05"),
        ] {
            let error = text.parse::<Limit>().unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
