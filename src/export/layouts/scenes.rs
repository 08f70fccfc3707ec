//! Layouts of floats in PFM, infinite where there is no truth. Their loaders take the absolute value.

use super::super::encode::{gray, pfm, rgb};
use super::super::pair::{Pair, Side};
use super::{Files, expect_no_negative, right_labels};
use crate::dataset::formats::FormatError;
use crate::dataset::validity;

const ABSOLUTE: &str = "its loader takes the absolute value";

/// Infinite where there is no value.
fn infinite(values: Vec<f32>) -> Vec<f32> {
    values.into_iter().map(|d| if d.is_finite() { d } else { f32::INFINITY }).collect()
}

/// What both cameras see, infinite elsewhere: for loaders that know no mask.
fn masked(side: &Side) -> Vec<u8> {
    pfm(side.image.width, side.image.height, &infinite(side.seen_by_both()))
}

/// Amodal disparity, infinite where nothing was hit: for loaders that read a mask beside.
fn amodal(side: &Side) -> Vec<u8> {
    pfm(side.image.width, side.image.height, &infinite(side.disparity_px.clone()))
}

/// 255 where both cameras see, else 0. (The real masks have 128 where one sees; torchvision takes that for valid.)
fn mask(side: &Side) -> Result<Vec<u8>, FormatError> {
    let value = |v: &u8| if *v == validity::VALID { 255 } else { 0 };
    gray(side.image.width, side.image.height, side.validity.iter().map(value).collect())
}

/// Middlebury's calibration: `d = f B / depth - doffs`, lengths in mm.
fn calibration(pair: &Pair) -> Vec<u8> {
    let (l, r) = (&pair.camera.left, &pair.camera.right);
    let [low, high] = pair.camera.disparity_range_px.unwrap_or([0.0, 0.0]);
    format!(
        "cam0=[{} 0 {}; 0 {} {}; 0 0 1]\ncam1=[{} 0 {}; 0 {} {}; 0 0 1]\ndoffs={}\nbaseline={}\nwidth={}\nheight={}\nndisp={}\n\
         isint=0\nvmin={}\nvmax={}\ndyavg=0\ndymax=0\n",
        l.fx_px,
        l.cx_px,
        l.fy_px,
        l.cy_px,
        r.fx_px,
        r.cx_px,
        r.fy_px,
        r.cy_px,
        pair.camera.doffs_px,
        pair.camera.baseline_m * 1000.0,
        l.width_px,
        l.height_px,
        high.ceil().max(1.0) as u32,
        low.floor(),
        high.ceil(),
    )
    .into_bytes()
}

/// `FlyingThings3D`: `TRAIN` for the split train, `TEST` for the others. Both passes hold the same pictures.
pub(super) fn sceneflow(pair: &Pair) -> Files {
    right_labels(pair)?;
    let mut files = Vec::new();
    let part = if pair.identity.split == "train" { "TRAIN" } else { "TEST" };
    for (side, view) in [(&pair.left, "left"), (&pair.right, "right")] {
        expect_no_negative(&side.seen_by_both(), ABSOLUTE)?;
        let place = format!("{part}/A/0000/{view}/{}", pair.name);
        let picture = rgb(&side.image)?;
        for pass in ["frames_cleanpass", "frames_finalpass"] {
            files.push((format!("SceneFlow/FlyingThings3D/{pass}/{place}.png"), picture.clone()));
        }
        files.push((format!("SceneFlow/FlyingThings3D/disparity/{place}.pfm"), masked(side)));
    }
    Ok(files)
}

/// ETH3D's two-view training set.
pub(super) fn eth3d(pair: &Pair) -> Files {
    let folder = |what: &str| format!("ETH3D/two_view_training{what}/{}", pair.name);
    with_mask(pair, &folder(""), &folder("_gt"))
}

/// `MiddEval3`, full size.
pub(super) fn middlebury(pair: &Pair) -> Files {
    let folder = format!("MiddEval3/trainingF/{}", pair.name);
    with_mask(pair, &folder, &folder)
}

/// Torchvision's `Middlebury2014Stereo`. It only opens a folder in which a scene's name begins as one of the real ones do.
pub(super) fn middlebury_2014(pair: &Pair) -> Files {
    both_views(pair, &format!("Middlebury2014/train/Adirondack_{}-perfect", pair.name), "")
}

/// The Carla data of `CREStereo`; its loader knows no mask.
pub(super) fn carla(pair: &Pair) -> Files {
    both_views(pair, &format!("carla-highres/trainingF/{}", pair.name), "GT")
}

/// Both pictures and their calibration.
fn pictures(pair: &Pair, folder: &str) -> Files {
    Ok(vec![
        (format!("{folder}/im0.png"), rgb(&pair.left.image)?),
        (format!("{folder}/im1.png"), rgb(&pair.right.image)?),
        (format!("{folder}/calib.txt"), calibration(pair)),
    ])
}

/// The left view's amodal truth, and a mask beside it.
fn with_mask(pair: &Pair, folder: &str, truth: &str) -> Files {
    expect_no_negative(&pair.left.disparity_px, ABSOLUTE)?;
    let mut files = pictures(pair, folder)?;
    files.push((format!("{truth}/disp0GT.pfm"), amodal(&pair.left)));
    files.push((format!("{truth}/mask0nocc.png"), mask(&pair.left)?));
    Ok(files)
}

/// Truth of both views where both cameras see.
fn both_views(pair: &Pair, folder: &str, ending: &str) -> Files {
    right_labels(pair)?;
    let mut files = pictures(pair, folder)?;
    for (k, side) in [&pair.left, &pair.right].into_iter().enumerate() {
        expect_no_negative(&side.seen_by_both(), ABSOLUTE)?;
        files.push((format!("{folder}/disp{k}{ending}.pfm"), masked(side)));
    }
    Ok(files)
}
