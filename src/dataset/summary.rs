//! What a dataset holds, in numbers: composition, disparity and occlusion by region, and figures of its scenes.

use super::formats::{HeightMap, Pixels};
use super::layer::{Layer, View};
use super::reader::{Dataset, ReadError};
use super::record::SampleRecord;
use super::terrain::SceneFigures;
use super::texture::{contrast_steps, levels};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Bins of a disparity histogram.
const DISPARITY_BINS: usize = 16;
/// Borders of the occlusion histogram, share of a sample's left pixels.
const OCCLUSION_BORDERS: [f64; 9] = [0.0, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32];
/// Borders of the texture histogram, grey levels of 255.
const TEXTURE_BORDERS: [f64; 9] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// Names of the semantic classes, by number.
pub const CLASS_NAMES: [&str; 15] = [
    "none",
    "ground",
    "road",
    "roof",
    "facade",
    "bridge",
    "low-vegetation",
    "tree",
    "water",
    "vehicle",
    "boat",
    "crop",
    "rock",
    "sand",
    "other-structure",
];

/// What a dataset holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Hash of the manifest.
    pub root_hash: String,
    /// Samples.
    pub samples: usize,
    /// Scenes.
    pub scenes: usize,
    /// Samples of each split.
    pub splits: BTreeMap<String, usize>,
    /// Bytes of all files that records name.
    pub bytes: u64,
    /// Each region and variant.
    pub regions: Vec<RegionSummary>,
}

/// One region's variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionSummary {
    /// Region.
    pub region: String,
    /// Its variant.
    pub variant: String,
    /// Samples.
    pub samples: usize,
    /// Samples of each split.
    pub splits: BTreeMap<String, usize>,
    /// Means by baseline, ascending.
    pub baselines: Vec<BaselineSummary>,
    /// Disparities of the left views' hit pixels.
    pub disparity: Histogram,
    /// How many samples have an occluded share in each bin; the last bin ends at 1.
    pub occlusion: Histogram,
    /// Pixels of the left views by local contrast: standard deviation of (R + G + B) / 3 in 9 x 9 pixels, grey levels.
    pub texture: Histogram,
    /// Share of the left views' pixels by semantic class; none where the recipe does not write classes.
    pub classes: Option<BTreeMap<&'static str, f64>>,
    /// Roof pixels among those that are no facade: what a map would call built; none without classes.
    pub built_fraction: Option<f64>,
    /// Figures of its scenes.
    pub scenes: Vec<SceneSummary>,
}

/// Means over the samples of one baseline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BaselineSummary {
    /// Distance of the optical centres, m.
    pub baseline_m: f64,
    /// Samples.
    pub samples: usize,
    /// Share of pixels seen by both views.
    pub valid_fraction: f64,
    /// Share of pixels in the other frame but behind something.
    pub occluded_fraction: f64,
    /// Share of pixels beyond the other frame.
    pub out_of_frame_fraction: f64,
}

/// Counts between borders.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Where each bin begins.
    pub from: Vec<f64>,
    /// Where the last bin ends.
    pub to: f64,
    /// How many in each bin.
    pub counts: Vec<u64>,
}

/// Figures of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneSummary {
    /// Its name.
    pub name: String,
    /// Share of its map with two or more upward surfaces above each other.
    pub multi_layer_fraction: f64,
    /// From its surface models.
    #[serde(flatten)]
    pub figures: SceneFigures,
}

/// What `info` needs of `scene.json`.
#[derive(Deserialize)]
struct SceneFacts {
    multi_layer_fraction: f64,
    full_detail_radius_m: f64,
}

/// Counts a whole dataset; it reads every left view's image and labels, on the current rayon pool.
///
/// # Errors
/// Where a file is missing or damaged.
pub fn summarise(dataset: &Dataset<'_>) -> Result<Summary, ReadError> {
    let mut groups: BTreeMap<(&str, &str), Vec<&SampleRecord>> = BTreeMap::new();
    for record in dataset.records() {
        groups.entry((&record.identity.region, &record.identity.variant)).or_default().push(record);
    }
    let regions: Vec<RegionSummary> =
        groups.values().map(|records| region(dataset, records)).collect::<Result<_, _>>()?;
    let files: BTreeMap<&str, u64> =
        dataset.records().iter().flat_map(|r| r.files.values()).map(|f| (f.path.as_str(), f.bytes)).collect();
    Ok(Summary {
        root_hash: dataset.root_hash().hex(),
        samples: dataset.records().len(),
        scenes: regions.iter().map(|r| r.scenes.len()).sum(),
        splits: splits(dataset.records().iter()),
        bytes: files.values().sum(),
        regions,
    })
}

fn splits<'a>(records: impl Iterator<Item = &'a SampleRecord>) -> BTreeMap<String, usize> {
    let mut splits = BTreeMap::new();
    for record in records {
        *splits.entry(record.identity.split.clone()).or_insert(0) += 1;
    }
    splits
}

/// What is counted of one sample's left labels.
struct Counts {
    disparity: Vec<u64>,
    texture: Vec<u64>,
    classes: Option<[u64; CLASS_NAMES.len()]>,
}

fn region(dataset: &Dataset<'_>, records: &[&SampleRecord]) -> Result<RegionSummary, ReadError> {
    let low = records.iter().filter_map(|r| r.disparity_min_px).fold(f32::INFINITY, f32::min);
    let high = records.iter().filter_map(|r| r.disparity_max_px).fold(f32::NEG_INFINITY, f32::max);
    let (low, high) = if low <= high { (f64::from(low), f64::from(high)) } else { (0.0, 0.0) };
    let step = ((high - low) / DISPARITY_BINS as f64).max(f64::MIN_POSITIVE);
    let counts: Vec<Counts> = records.par_iter().map(|r| count(dataset, r, low, step)).collect::<Result<_, _>>()?;

    let mut disparity = vec![0; DISPARITY_BINS];
    let mut texture = vec![0; TEXTURE_BORDERS.len()];
    let mut classes = [0; CLASS_NAMES.len()];
    let mut with_classes = true;
    for c in &counts {
        disparity.iter_mut().zip(&c.disparity).for_each(|(sum, n)| *sum += n);
        texture.iter_mut().zip(&c.texture).for_each(|(sum, n)| *sum += n);
        match &c.classes {
            Some(own) => classes.iter_mut().zip(own).for_each(|(sum, n)| *sum += n),
            None => with_classes = false,
        }
    }
    let pixels = classes.iter().sum::<u64>().max(1) as f64;
    let share = |class: usize| classes[class] as f64 / pixels;
    let mut scenes: BTreeMap<&str, &SampleRecord> = BTreeMap::new();
    for record in records {
        scenes.entry(record.scene()).or_insert(record);
    }
    Ok(RegionSummary {
        region: records[0].identity.region.clone(),
        variant: records[0].identity.variant.clone(),
        samples: records.len(),
        splits: splits(records.iter().copied()),
        baselines: baselines(records),
        disparity: Histogram {
            from: (0..DISPARITY_BINS).map(|i| low + step * i as f64).collect(),
            to: high,
            counts: disparity,
        },
        occlusion: occlusion(records),
        texture: Histogram { from: TEXTURE_BORDERS.to_vec(), to: 127.5, counts: texture },
        classes: with_classes.then(|| CLASS_NAMES.iter().enumerate().map(|(i, name)| (*name, share(i))).collect()),
        built_fraction: with_classes.then(|| share(3) / (1.0 - share(4)).max(f64::MIN_POSITIVE)),
        scenes: scenes.values().map(|r| scene(dataset, r)).collect::<Result<_, _>>()?,
    })
}

fn count(dataset: &Dataset<'_>, record: &SampleRecord, low: f64, step: f64) -> Result<Counts, ReadError> {
    let camera = dataset.camera(record)?;
    let mut disparity = vec![0; DISPARITY_BINS];
    if let Pixels::Float(values) = dataset.plane(record, &camera, Layer::Disparity, View::Left)?.pixels {
        for d in values.into_iter().filter(|d| !d.is_nan()) {
            disparity[(((f64::from(d) - low) / step) as usize).min(DISPARITY_BINS - 1)] += 1;
        }
    }
    let image = dataset.plane(record, &camera, Layer::Image, View::Left)?.to_rgb8();
    let mut texture = vec![0; TEXTURE_BORDERS.len()];
    for step in contrast_steps(&image, camera.left.width_px as usize) {
        let bin = TEXTURE_BORDERS.iter().rposition(|from| levels(step.into()) >= *from).unwrap_or(0);
        texture[bin] += 1;
    }
    let has_classes = record.files.contains_key(&Layer::Class.key(View::Left));
    let classes = if has_classes {
        let mut classes = [0; CLASS_NAMES.len()];
        if let Pixels::Gray(values) = dataset.plane(record, &camera, Layer::Class, View::Left)?.pixels {
            for class in values {
                // Classes beyond the last are for `verify` to name.
                classes[usize::from(class).min(CLASS_NAMES.len() - 1)] += 1;
            }
        }
        Some(classes)
    } else {
        None
    };
    Ok(Counts { disparity, texture, classes })
}

fn baselines(records: &[&SampleRecord]) -> Vec<BaselineSummary> {
    // Lengths to the millimetre as keys: floats have no order that a map could use.
    let mut groups: BTreeMap<i64, Vec<&SampleRecord>> = BTreeMap::new();
    for record in records {
        groups.entry((record.identity.baseline_m * 1000.0).round() as i64).or_default().push(record);
    }
    groups
        .values()
        .map(|group| {
            let mean = |f: fn(&SampleRecord) -> f64| group.iter().map(|r| f(r)).sum::<f64>() / group.len() as f64;
            BaselineSummary {
                baseline_m: group[0].identity.baseline_m,
                samples: group.len(),
                valid_fraction: mean(|r| r.valid_fraction),
                occluded_fraction: mean(|r| r.occluded_fraction),
                out_of_frame_fraction: mean(|r| r.out_of_frame_fraction),
            }
        })
        .collect()
}

fn occlusion(records: &[&SampleRecord]) -> Histogram {
    let mut counts = vec![0; OCCLUSION_BORDERS.len()];
    for record in records {
        let bin = OCCLUSION_BORDERS.iter().rposition(|from| record.occluded_fraction >= *from).unwrap_or(0);
        counts[bin] += 1;
    }
    Histogram { from: OCCLUSION_BORDERS.to_vec(), to: 1.0, counts }
}

fn scene(dataset: &Dataset<'_>, record: &SampleRecord) -> Result<SceneSummary, ReadError> {
    let facts: SceneFacts = serde_json::from_str(&dataset.text(record, "scene")?).map_err(|e| ReadError::File {
        path: format!("{}/scene.json", record.scene()),
        reason: format!("it is no scene record: {e}"),
    })?;
    let (dsm, dtm): (HeightMap, HeightMap) = (dataset.height_map(record, "dsm")?, dataset.height_map(record, "dtm")?);
    Ok(SceneSummary {
        name: record.scene().to_owned(),
        multi_layer_fraction: facts.multi_layer_fraction,
        figures: SceneFigures::of(&dsm, &dtm, facts.full_detail_radius_m),
    })
}
