//! Truth of other datasets, in the layouts in which they are given out, so that the same scores can be had for them.

use super::EvaluateError;
use super::boundary::{jumps, squared_distances};
use super::breakdown::{By, DisparityBins, boundary_bin};
use super::picture::read_rgb;
use super::prediction::{self, Size};
use super::truth::Truth;
use crate::dataset::texture::contrast_steps;
use crate::dataset::validity;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// How a foreign dataset lies in its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TruthLayout {
    /// `*_LEFT_RGB.tif`, `*_LEFT_DSP.tif` anywhere: f32, -999 without truth.
    Us3d,
    /// `{train,val,test}/{left,disp}/*_{left,disparity}_*.tiff`: f32, -999 without truth.
    Whu,
    /// `training{F,H,Q}/<scene>/{im0.png,disp0GT.pfm,mask0nocc.png}`: infinite without truth, mask 255 where both see.
    Middlebury,
    /// `two_view_training/<scene>/im0.png`, `two_view_training_gt/<scene>/{disp0GT.pfm,mask0nocc.png}`: likewise.
    Eth3d,
    /// `training/{image_2,disp_occ_0,disp_noc_0}/*_10.png`: 256ths, 0 without truth; 2012's names too.
    Kitti,
}

impl TruthLayout {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Us3d => "us3d",
            Self::Whu => "whu",
            Self::Middlebury => "middlebury",
            Self::Eth3d => "eth3d",
            Self::Kitti => "kitti",
        }
    }

    fn expects(self) -> &'static str {
        match self {
            Self::Us3d => "*_LEFT_DSP.tif with *_LEFT_RGB.tif beside or in a folder near",
            Self::Whu => "{train,val,test}/disp/*_disparity_*.tiff with left/*_left_*.tiff",
            Self::Middlebury => "training{F,H,Q}/<scene>/disp0GT.pfm with im0.png",
            Self::Eth3d => "two_view_training_gt/<scene>/disp0GT.pfm with two_view_training/<scene>/im0.png",
            Self::Kitti => "training/disp_occ_0/*_10.png with image_2/*_10.png",
        }
    }
}

/// A foreign dataset.
pub struct Foreign {
    layout: TruthLayout,
    samples: Vec<ForeignSample>,
}

/// One of its pairs.
pub(super) struct ForeignSample {
    pub(super) id: String,
    /// Its part of the dataset: `test`, `trainingH`; `all` where there are no parts.
    pub(super) part: String,
    truth: PathBuf,
    image: PathBuf,
    seen: Seen,
}

/// What tells occluded pixels.
enum Seen {
    /// Nothing: all pixels with truth count as seen by both.
    Unknown,
    /// A mask with 255 where both cameras see.
    Mask(PathBuf),
    /// A second truth that only pixels have which both cameras see.
    Truth(PathBuf),
}

impl Foreign {
    /// Looks for the samples in a folder.
    ///
    /// # Errors
    /// Where there are none.
    pub fn open(root: &Path, layout: TruthLayout) -> Result<Self, EvaluateError> {
        let mut samples = match layout {
            TruthLayout::Us3d => us3d(root),
            TruthLayout::Whu => whu(root),
            TruthLayout::Middlebury => middlebury(root),
            TruthLayout::Eth3d => eth3d(root),
            TruthLayout::Kitti => kitti(root),
        };
        samples.sort_by(|a, b| a.id.cmp(&b.id));
        if samples.is_empty() {
            let (layout, expected) = (layout.name(), layout.expects());
            return Err(EvaluateError::NoForeignTruth { root: root.to_owned(), layout, expected });
        }
        Ok(Self { layout, samples })
    }

    pub(super) fn layout(&self) -> TruthLayout {
        self.layout
    }

    /// Whether any sample tells occluded pixels.
    pub(super) fn knows_occlusion(&self) -> bool {
        self.samples.iter().any(|s| !matches!(s.seen, Seen::Unknown))
    }

    pub(super) fn samples(&self) -> &[ForeignSample] {
        &self.samples
    }
}

/// Names of a folder's entries, sorted; none where it cannot be read.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort();
    names
}

fn us3d(root: &Path) -> Vec<ForeignSample> {
    let mut files: BTreeMap<String, PathBuf> = BTreeMap::new();
    let mut folders = vec![(root.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        for name in names(&folder) {
            let path = folder.join(&name);
            if path.is_dir() && depth < 3 {
                folders.push((path, depth + 1));
            } else if name.ends_with("_LEFT_DSP.tif") || name.ends_with("_LEFT_RGB.tif") {
                files.insert(name, path);
            }
        }
    }
    let sample = |(name, truth): (&String, &PathBuf)| {
        let id = name.strip_suffix("_LEFT_DSP.tif")?.to_owned();
        let image = files.get(&format!("{id}_LEFT_RGB.tif"))?.clone();
        Some(ForeignSample { id, part: "all".to_owned(), truth: truth.clone(), image, seen: Seen::Unknown })
    };
    files.iter().filter_map(sample).collect()
}

fn whu(root: &Path) -> Vec<ForeignSample> {
    let mut out = Vec::new();
    for part in names(root) {
        let (truths, images) = (root.join(&part).join("disp"), root.join(&part).join("left"));
        for name in names(&truths) {
            let image = name.replacen("_disparity_", "_left_", 1);
            let path = images.join(&image);
            if let Some((stem, _)) = image.rsplit_once('.').filter(|_| image != name && path.is_file()) {
                let (id, truth) = (format!("{part}/{stem}"), truths.join(&name));
                out.push(ForeignSample { id, part: part.clone(), truth, image: path, seen: Seen::Unknown });
            }
        }
    }
    out
}

fn middlebury(root: &Path) -> Vec<ForeignSample> {
    let inner = root.join("MiddEval3");
    let root = if inner.is_dir() { &inner } else { root };
    let mut out = Vec::new();
    for part in names(root).into_iter().filter(|n| n.starts_with("training")) {
        for scene in names(&root.join(&part)) {
            let folder = root.join(&part).join(&scene);
            out.extend(scene_of(format!("{part}/{scene}"), part.clone(), &folder, &folder));
        }
    }
    out
}

fn eth3d(root: &Path) -> Vec<ForeignSample> {
    let truths = root.join("two_view_training_gt");
    let of = |scene: String| {
        scene_of(scene.clone(), "all".to_owned(), &truths.join(&scene), &root.join("two_view_training").join(&scene))
    };
    names(&truths).into_iter().filter_map(of).collect()
}

/// A scene in Middlebury's manner.
fn scene_of(id: String, part: String, truth: &Path, image: &Path) -> Option<ForeignSample> {
    let (mask, truth, image) = (truth.join("mask0nocc.png"), truth.join("disp0GT.pfm"), image.join("im0.png"));
    let seen = if mask.is_file() { Seen::Mask(mask) } else { Seen::Unknown };
    (truth.is_file() && image.is_file()).then_some(ForeignSample { id, part, truth, image, seen })
}

fn kitti(root: &Path) -> Vec<ForeignSample> {
    let inner = root.join("training");
    let root = if inner.is_dir() { &inner } else { root };
    let mut out = Vec::new();
    for (truths, both_see, images) in [("disp_occ_0", "disp_noc_0", "image_2"), ("disp_occ", "disp_noc", "colored_0")] {
        for name in names(&root.join(truths)).into_iter().filter(|n| n.ends_with("_10.png")) {
            let (truth, image) = (root.join(truths).join(&name), root.join(images).join(&name));
            let both = root.join(both_see).join(&name);
            if image.is_file() {
                let seen = if both.is_file() { Seen::Truth(both) } else { Seen::Unknown };
                let id = name.trim_end_matches(".png").to_owned();
                out.push(ForeignSample { id, part: "all".to_owned(), truth, image, seen });
            }
        }
    }
    out
}

impl ForeignSample {
    fn fault(path: &Path, reason: &impl std::fmt::Display) -> EvaluateError {
        EvaluateError::ForeignTruth { path: path.to_owned(), reason: reason.to_string() }
    }

    /// The left image, RGB, and its size.
    pub(super) fn image(&self) -> Result<(Vec<u8>, Size), EvaluateError> {
        read_rgb(&self.image).map_err(|e| Self::fault(&self.image, &e))
    }

    /// Disparities, NaN where there is no truth.
    pub(super) fn disparity_px(&self, size: Size) -> Result<Vec<f32>, EvaluateError> {
        let values = prediction::read(&self.truth, size, 256.0).map_err(|e| Self::fault(&self.truth, &e))?;
        let known = |d: f64| d.is_finite() && d > -900.0;
        Ok(values.into_iter().map(|d| if known(d) { d as f32 } else { f32::NAN }).collect())
    }

    /// Validity as our datasets have it: 0 where there is no truth.
    pub(super) fn validity(&self, disparity_px: &[f32], size: Size) -> Result<Vec<u8>, EvaluateError> {
        let both: Vec<bool> = match &self.seen {
            Seen::Unknown => vec![true; disparity_px.len()],
            Seen::Mask(path) => {
                let (mask, found) = read_rgb(path).map_err(|e| Self::fault(path, &e))?;
                if found != size {
                    return Err(Self::fault(path, &"it has not the size of the image"));
                }
                mask.chunks_exact(3).map(|m| m[0] == 255).collect()
            }
            Seen::Truth(path) => {
                let values = prediction::read(path, size, 256.0).map_err(|e| Self::fault(path, &e))?;
                values.iter().map(|d| d.is_finite()).collect()
            }
        };
        let value = |(d, both): (&f32, bool)| match (d.is_finite(), both) {
            (false, _) => validity::MISS,
            (true, true) => validity::VALID,
            (true, false) => validity::OCCLUDED,
        };
        Ok(disparity_px.iter().zip(both).map(value).collect())
    }

    /// Its truth.
    pub(super) fn read(&self, disparity_bins: DisparityBins) -> Result<Truth, EvaluateError> {
        let (rgb, size) = self.image()?;
        let width = size.width as usize;
        let disparity_px = self.disparity_px(size)?;
        let jumps = jumps(&disparity_px, width);
        let jump_distances = squared_distances(&jumps, width);
        let bins = By::ALL.map(|by| match by {
            By::Texture => Some(contrast_steps(&rgb, width)),
            By::Disparity => Some(disparity_px.iter().map(|d| disparity_bins.bin(*d)).collect()),
            By::Boundary => Some(jump_distances.iter().map(|d| boundary_bin(*d)).collect()),
            By::Slope | By::Height | By::Class | By::Shadow => None,
        });
        let validity = self.validity(&disparity_px, size)?;
        Ok(Truth { size, disparity_px, validity, jumps, jump_distances, bins, doffs_px: 0.0 })
    }

    /// Lowest and highest disparity.
    pub(super) fn range_px(&self) -> Result<Option<[f32; 2]>, EvaluateError> {
        let (_, size) = self.image()?;
        let known = self.disparity_px(size)?;
        let finite = known.iter().filter(|d| d.is_finite());
        Ok(finite.fold(None, |range: Option<[f32; 2]>, d| {
            Some(range.map_or([*d, *d], |[low, high]| [low.min(*d), high.max(*d)]))
        }))
    }
}
