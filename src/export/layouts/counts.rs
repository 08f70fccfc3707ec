//! Layouts that code disparity in the whole numbers of a PNG.

use super::super::Place;
use super::super::encode::{gray, jpeg, png16, rgb};
use super::super::pair::{Pair, Side};
use super::{Files, Unfit, expect_below, expect_no_negative, right_labels};
use crate::dataset::formats::{Pixels, Plane};
use crate::dataset::validity;

const UNSIGNED: &str = "its coding has no sign";

/// 16-bit numbers of `1 / scale` px; 0 where there is no value, and a value that rounds to it becomes 1.
fn numbers(values: &[f32], scale: f32) -> Vec<u16> {
    let number = |d: &f32| if d.is_finite() { (d * scale).round().max(1.0) as u16 } else { 0 };
    values.iter().map(number).collect()
}

fn checked(values: Vec<f32>, limit: f32, why: &str) -> Result<Vec<f32>, Unfit> {
    expect_no_negative(&values, UNSIGNED)?;
    expect_below(&values, limit, why)?;
    Ok(values)
}

/// KITTI 2015: 256ths. `disp_occ` holds what was hit, `disp_noc` what both cameras see.
pub(super) fn kitti(pair: &Pair) -> Files {
    right_labels(pair)?;
    let mut files = Vec::new();
    for (side, image, camera) in [(&pair.left, "image_2", 0), (&pair.right, "image_3", 1)] {
        let place = |folder: &str| format!("Kitti2015/training/{folder}/{}_10.png", pair.name);
        let (width, height) = (side.image.width, side.image.height);
        let why = "its 16 bits of 256ths end below 256 px";
        let all = checked(side.disparity_px.clone(), 255.99, why)?;
        files.push((place(image), rgb(&side.image)?));
        files.push((place(&format!("disp_occ_{camera}")), png16(width, height, &numbers(&all, 256.0))?));
        files
            .push((place(&format!("disp_noc_{camera}")), png16(width, height, &numbers(&side.seen_by_both(), 256.0))?));
    }
    Ok(files)
}

/// The folders of `CREStereo`. Its loader wants pairs in each, so they are dealt out in turn.
pub(super) const CRESTEREO_FOLDERS: [&str; 4] = ["shapenet", "reflective", "tree", "hole"];

/// `CREStereo`: 32nds. Its images are JPEG: they lose a little.
pub(super) fn crestereo(pair: &Pair, place: Place) -> Files {
    right_labels(pair)?;
    let mut files = Vec::new();
    for (side, view) in [(&pair.left, "left"), (&pair.right, "right")] {
        let values = checked(side.seen_by_both(), 2047.9, "its 16 bits of 32nds end below 2048 px")?;
        let place = format!("CREStereo/{}/{}_{view}", CRESTEREO_FOLDERS[place.number % 4], pair.name);
        files.push((format!("{place}.jpg"), jpeg(&side.image)?));
        let (width, height) = (side.image.width, side.image.height);
        files.push((format!("{place}.disp.png"), png16(width, height, &numbers(&values, 32.0))?));
    }
    Ok(files)
}

/// MPI Sintel: `4 R + G / 64 + B / 16384` px; occluded and out-of-frame pixels in maps of their own. What nothing was hit
/// at counts as out of frame.
pub(super) fn sintel(pair: &Pair) -> Files {
    let Side { image, disparity_px, validity: map } = &pair.left;
    let values = checked(disparity_px.clone(), 1023.9, "its 24 bits end below 1024 px")?;
    let scene = pair.identity.scene();
    let frame = pair.name.split_once("__").map_or(pair.name.as_str(), |(_, frame)| frame);
    let place = |folder: &str| format!("Sintel/training/{folder}/{scene}/frame_{frame}.png");
    let coded = |d: &f32| {
        let n = if d.is_finite() { (f64::from(*d) * 16384.0).round() as u32 } else { 0 };
        [(n >> 16) as u8, (n >> 8) as u8, n as u8]
    };
    let disparities = Pixels::Rgb(values.iter().flat_map(coded).collect());
    let marked = |mark: &dyn Fn(u8) -> bool| {
        gray(image.width, image.height, map.iter().map(|v| if mark(*v) { 255 } else { 0 }).collect())
    };
    let (left, right) = (rgb(&pair.left.image)?, rgb(&pair.right.image)?);
    Ok(vec![
        (place("clean_left"), left.clone()),
        (place("final_left"), left),
        (place("clean_right"), right.clone()),
        (place("final_right"), right),
        (place("disparities"), Plane { width: image.width, height: image.height, pixels: disparities }.encode()?),
        (place("occlusions"), marked(&|v| v == validity::OCCLUDED)?),
        (place("outofframe"), marked(&|v| matches!(v, validity::OUT_OF_FRAME | validity::MISS))?),
    ])
}
