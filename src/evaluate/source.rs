//! Where truth comes from: a dataset of ours, or a foreign one.

use super::EvaluateError;
use super::breakdown::DisparityBins;
use super::foreign::{Foreign, ForeignSample};
use super::prediction::Size;
use super::truth::Truth;
use crate::dataset::formats::HeightMap;
use crate::dataset::{Dataset, Layer, SampleRecord, View};
use rayon::prelude::*;

/// What predictions are held against.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// A dataset of ours.
    Dataset(&'a Dataset<'a>),
    /// A foreign one.
    Foreign(&'a Foreign),
}

/// A sample with truth.
#[derive(Clone, Copy)]
pub(super) enum Item<'a> {
    Native(&'a Dataset<'a>, &'a SampleRecord),
    Foreign(&'a Foreign, &'a ForeignSample),
}

/// What a picture of a sample needs.
pub(super) struct Maps {
    pub(super) size: Size,
    pub(super) rgb: Vec<u8>,
    pub(super) disparity_px: Vec<f32>,
    pub(super) validity: Vec<u8>,
}

impl<'a> Source<'a> {
    /// All samples, in their order.
    pub(super) fn items(self) -> Vec<Item<'a>> {
        match self {
            Self::Dataset(dataset) => dataset.records().iter().map(|r| Item::Native(dataset, r)).collect(),
            Self::Foreign(foreign) => foreign.samples().iter().map(|s| Item::Foreign(foreign, s)).collect(),
        }
    }

    /// The root hash of a dataset of ours.
    pub(super) fn root_hash(self) -> Option<String> {
        match self {
            Self::Dataset(dataset) => Some(dataset.root_hash().hex()),
            Self::Foreign(_) => None,
        }
    }
}

impl<'a> Item<'a> {
    /// Its name.
    pub(super) fn id(self) -> &'a str {
        match self {
            Self::Native(_, record) => record.id(),
            Self::Foreign(_, sample) => &sample.id,
        }
    }

    /// What `--split` chooses by.
    pub(super) fn split(self) -> &'a str {
        match self {
            Self::Native(_, record) => &record.identity.split,
            Self::Foreign(_, sample) => &sample.part,
        }
    }

    /// Region and variant; of a foreign sample, its dataset's layout and its part.
    pub(super) fn region(self) -> (String, String) {
        match self {
            Self::Native(_, r) => (r.identity.region.clone(), r.identity.variant.clone()),
            Self::Foreign(foreign, s) => (foreign.layout().name().to_owned(), s.part.clone()),
        }
    }

    /// Distance of the optical centres, m, where it is known.
    pub(super) fn baseline_m(self) -> Option<f64> {
        match self {
            Self::Native(_, record) => Some(record.identity.baseline_m),
            Self::Foreign(..) => None,
        }
    }

    /// What samples share that lie in one scene.
    pub(super) fn scene(self) -> &'a str {
        match self {
            Self::Native(_, record) => record.scene(),
            Self::Foreign(..) => "",
        }
    }

    /// The bare ground of its scene.
    pub(super) fn ground(self) -> Result<Option<HeightMap>, EvaluateError> {
        match self {
            Self::Native(dataset, record) => Ok(Some(dataset.height_map(record, "dtm")?)),
            Self::Foreign(..) => Ok(None),
        }
    }

    /// Lowest and highest disparity, px.
    fn range_px(self) -> Result<Option<[f32; 2]>, EvaluateError> {
        match self {
            Self::Native(_, r) => Ok(r.disparity_min_px.zip(r.disparity_max_px).map(|(low, high)| [low, high])),
            Self::Foreign(_, sample) => sample.range_px(),
        }
    }

    /// Its truth.
    pub(super) fn truth(self, ground: Option<&HeightMap>, bins: DisparityBins) -> Result<Truth, EvaluateError> {
        match self {
            Self::Native(dataset, record) => Ok(Truth::read(dataset, record, ground, bins)?),
            Self::Foreign(_, sample) => sample.read(bins),
        }
    }

    /// Its maps.
    pub(super) fn maps(self) -> Result<Maps, EvaluateError> {
        match self {
            Self::Native(dataset, record) => {
                let camera = dataset.camera(record)?;
                let plane = |layer| dataset.plane(record, &camera, layer, View::Left);
                Ok(Maps {
                    size: Size { width: camera.left.width_px, height: camera.left.height_px },
                    rgb: plane(Layer::Image)?.to_rgb8(),
                    disparity_px: plane(Layer::Disparity)?.into_floats(),
                    validity: plane(Layer::Validity)?.into_bytes(),
                })
            }
            Self::Foreign(_, sample) => {
                let (rgb, size) = sample.image()?;
                let disparity_px = sample.disparity_px(size)?;
                let validity = sample.validity(&disparity_px, size)?;
                Ok(Maps { size, rgb, disparity_px, validity })
            }
        }
    }
}

/// Bins from the lowest disparity of some samples to the highest. Foreign truth is read once more for it, since nothing
/// tells its range.
pub(super) fn disparity_bins<'a>(items: impl Iterator<Item = Item<'a>>) -> Result<DisparityBins, EvaluateError> {
    let items: Vec<Item<'a>> = items.collect();
    let ranges: Vec<Option<[f32; 2]>> = items.par_iter().map(|item| item.range_px()).collect::<Result<_, _>>()?;
    let low = ranges.iter().flatten().fold(f32::INFINITY, |low, r| low.min(r[0]));
    let high = ranges.iter().flatten().fold(f32::NEG_INFINITY, |high, r| high.max(r[1]));
    Ok(if low <= high { DisparityBins::new(low.into(), high.into()) } else { DisparityBins::new(0.0, 0.0) })
}
