//! The layouts, each with what its loader makes of its files.

mod counts;
mod geo;
mod published;
mod scenes;
mod tar;

use super::pair::Pair;
use super::{ExportError, File, Place};
use crate::dataset::formats::FormatError;

/// A layout that some loader reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// `SatUnreal` as published: colour, raw and normalised disparity, cameras; 0 where a pixel has no match.
    Satunreal,
    /// Scene Flow's `FlyingThings3D`: PFM, both views.
    Sceneflow,
    /// ETH3D, two views: PFM and a mask of what both cameras see.
    Eth3d,
    /// `MiddEval3`: the same with calibration.
    Middlebury,
    /// Middlebury 2014 as torchvision reads it.
    Middlebury2014,
    /// MPI Sintel: 24-bit disparity, occlusion and out-of-frame apart.
    Sintel,
    /// KITTI 2015: 256ths in 16 bits.
    Kitti,
    /// The Carla data of `CREStereo`: PFM.
    Carla,
    /// `CREStereo`: 32nds in 16 bits, JPEG images.
    Crestereo,
    /// Urban Semantic 3D: signed 32-bit floats, classes, heights.
    Us3d,
    /// WHU-Stereo: one 16-bit band, signed floats.
    Whu,
    /// Pandora: its own sign, mask and configuration.
    Pandora,
    /// Tar shards of the native files.
    Webdataset,
}

/// A pair's files, and the names that the layout lists at the end.
pub(super) struct Coded {
    pub(super) files: Vec<File>,
    pub(super) listed: Vec<String>,
}

/// Why a pair cannot be coded.
pub(super) enum Unfit {
    /// What the layout cannot hold.
    Coding(String),
    Format(FormatError),
}

impl From<FormatError> for Unfit {
    fn from(reason: FormatError) -> Self {
        Self::Format(reason)
    }
}

type Files = Result<Vec<File>, Unfit>;

impl Layout {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Satunreal,
        Self::Sceneflow,
        Self::Eth3d,
        Self::Middlebury,
        Self::Middlebury2014,
        Self::Sintel,
        Self::Kitti,
        Self::Carla,
        Self::Crestereo,
        Self::Us3d,
        Self::Whu,
        Self::Pandora,
        Self::Webdataset,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Satunreal => "satunreal",
            Self::Sceneflow => "sceneflow",
            Self::Eth3d => "eth3d",
            Self::Middlebury => "middlebury",
            Self::Middlebury2014 => "middlebury2014",
            Self::Sintel => "sintel",
            Self::Kitti => "kitti",
            Self::Carla => "carla",
            Self::Crestereo => "crestereo",
            Self::Us3d => "us3d",
            Self::Whu => "whu",
            Self::Pandora => "pandora",
            Self::Webdataset => "webdataset",
        }
    }

    /// Whether loaders make the right image's path by putting `right` for `left` in all of the left one's.
    pub(super) fn swaps_left(self) -> bool {
        matches!(self, Self::Sceneflow | Self::Sintel | Self::Crestereo)
    }

    /// How many pairs a loader wants.
    pub(super) fn least_pairs(self) -> usize {
        if self == Self::Crestereo { counts::CRESTEREO_FOLDERS.len() } else { 1 }
    }

    /// How many of a dataset's samples share files, one written after the other, and what ends such a file.
    pub(super) fn shared(self) -> (usize, &'static [u8]) {
        if self == Self::Webdataset { (tar::SAMPLES, &tar::END) } else { (1, &[]) }
    }

    /// A pair's files. What belongs to a file of the same name that another pair of its samples began goes to its end.
    pub(super) fn code(self, pair: &Pair, place: Place) -> Result<Coded, ExportError> {
        let id = pair.identity.id.clone();
        let files = match self {
            Self::Satunreal => published::satunreal(pair, place),
            Self::Sceneflow => scenes::sceneflow(pair),
            Self::Eth3d => scenes::eth3d(pair),
            Self::Middlebury => scenes::middlebury(pair),
            Self::Middlebury2014 => scenes::middlebury_2014(pair),
            Self::Sintel => counts::sintel(pair),
            Self::Kitti => counts::kitti(pair),
            Self::Carla => scenes::carla(pair),
            Self::Crestereo => counts::crestereo(pair, place),
            Self::Us3d => geo::us3d(pair, place),
            Self::Whu => geo::whu(pair, place),
            Self::Pandora => geo::pandora(pair),
            Self::Webdataset => tar::entries(pair, place),
        };
        match files {
            Ok(files) => Ok(Coded { files, listed: vec![pair.name.clone()] }),
            Err(Unfit::Coding(what)) => Err(ExportError::Coding { layout: self.name(), id, what }),
            Err(Unfit::Format(reason)) => Err(ExportError::Encode { id, reason }),
        }
    }

    /// Files that name all pairs.
    pub(super) fn closing(self, names: &[String]) -> Vec<File> {
        match self {
            Self::Middlebury => {
                vec![("MiddEval3/official_train.txt".to_owned(), (names.join("\n") + "\n").into_bytes())]
            }
            _ => Vec::new(),
        }
    }
}

/// Refuses what a loader reads without its sign.
fn expect_no_negative(disparity_px: &[f32], why: &str) -> Result<(), Unfit> {
    let lowest = disparity_px.iter().copied().filter(|d| d.is_finite()).fold(f32::INFINITY, f32::min);
    if lowest >= 0.0 || lowest == f32::INFINITY {
        return Ok(());
    }
    Err(Unfit::Coding(format!(
        "disparities go down to {lowest} px, but {why}; generate with camera.datum = \"none\" or \"lowest\", under which none is \
         negative, or export with --crop overlap:lowest"
    )))
}

/// Refuses what is too large for a coding.
fn expect_below(disparity_px: &[f32], limit: f32, why: &str) -> Result<(), Unfit> {
    let highest = disparity_px.iter().copied().filter(|d| d.is_finite()).fold(f32::NEG_INFINITY, f32::max);
    if highest < limit {
        return Ok(());
    }
    Err(Unfit::Coding(format!(
        "disparities go up to {highest} px, but {why}; generate with camera.datum = \"lowest\" or \"pivot\", or a shorter \
         baseline, or export with --crop overlap:lowest or --downsample"
    )))
}

/// The labels of the right view, which some loaders want.
fn right_labels(pair: &Pair) -> Result<(), Unfit> {
    if pair.has_right_labels {
        return Ok(());
    }
    Err(Unfit::Coding(
        "its loader wants the right view's disparity too, but the dataset has none; generate with labels.write = \
         [\"disparity_right\"]"
            .to_owned(),
    ))
}
