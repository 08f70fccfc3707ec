//! Layouts of satellite stereo: TIFF, with signed disparities.

use super::super::Place;
use super::super::encode::{float_tiff, gray};
use super::super::pair::{Pair, Side};
use super::{Files, Unfit};
use crate::dataset::formats::{Pixels, Plane};
use crate::dataset::validity;

/// Where there is no value, in US3D and WHU-Stereo.
const NO_DATA: f32 = -999.0;

fn coded(values: Vec<f32>, nothing: f32) -> Vec<f32> {
    values.into_iter().map(|d| if d.is_finite() { d } else { nothing }).collect()
}

/// Three bands as TIFF: the counts that the sensor wrote, or the picture's 8 bits.
fn rgb_tiff(image: &Plane) -> Result<Vec<u8>, Unfit> {
    if matches!(image.pixels, Pixels::Counts(3, _)) {
        return Ok(image.encode_tiff()?);
    }
    Ok(Plane { width: image.width, height: image.height, pixels: Pixels::Rgb(image.to_rgb8()) }.encode_tiff()?)
}

/// LAS classes as US3D has them: 2 ground, 5 tree, 6 building, 9 water, 17 bridge, 65 no label.
fn las(class: u8) -> u8 {
    match class {
        1 | 2 | 6 | 11..=13 => 2,
        3 | 4 => 6,
        5 => 17,
        7 => 5,
        8 => 9,
        _ => 65,
    }
}

/// Urban Semantic 3D: `<AOI>_<n>_<i>_<j>_*`; the scene's name stands for the area.
pub(super) fn us3d(pair: &Pair, place: Place) -> Files {
    let [row, column] = place.tile;
    let name = format!("{}_{:03}_{row:03}_{column:03}", pair.identity.scene(), place.in_region);
    let Side { image, .. } = &pair.left;
    let (width, height) = (image.width, image.height);
    let truth = coded(pair.left.seen_by_both(), NO_DATA);
    let above: Vec<f32> = pair.above_ground_m.iter().map(|h| *h as f32).collect();
    let mut files = vec![
        (format!("{name}_LEFT_RGB.tif"), rgb_tiff(image)?),
        (format!("{name}_RIGHT_RGB.tif"), rgb_tiff(&pair.right.image)?),
        (format!("{name}_LEFT_DSP.tif"), float_tiff(width, height, truth)?),
        (format!("{name}_LEFT_AGL.tif"), float_tiff(width, height, coded(above, NO_DATA))?),
    ];
    if let Some(class) = &pair.class {
        let pixels = Pixels::Gray(class.iter().map(|c| las(*c)).collect());
        files.push((format!("{name}_LEFT_CLS.tif"), Plane { width, height, pixels }.encode_tiff()?));
    }
    Ok(files)
}

/// WHU-Stereo: one band of 16 bits, disparities from -128 to 64 px.
pub(super) fn whu(pair: &Pair, place: Place) -> Files {
    let band = |image: &Plane| match &image.pixels {
        Pixels::Counts(1, _) => Ok(image.encode()?),
        _ => Err(Unfit::Coding(
            "it has one band of 16 bits, but the images are of another kind; generate with sensor.preset = \"gf7_pan\""
                .to_owned(),
        )),
    };
    let values = pair.left.seen_by_both();
    if let Some(d) = values.iter().find(|d| d.is_finite() && !(-128.0..64.0).contains(*d)) {
        return Err(Unfit::Coding(format!(
            "a disparity is {d} px, but WHU-Stereo's nets look from -128 to 64 px; generate with camera.datum = \"pivot\" and a \
             shorter baseline, or export with --crop overlap or --downsample"
        )));
    }
    let part = &pair.identity.split;
    let (city, number) = (pair.identity.scene(), place.in_region);
    let name = |what: &str| format!("{city}_{what}_{number}_{}-{}.tiff", place.tile[0], place.tile[1]);
    let (width, height) = (pair.left.image.width, pair.left.image.height);
    Ok(vec![
        (format!("{part}/left/{}", name("left")), band(&pair.left.image)?),
        (format!("{part}/right/{}", name("right")), band(&pair.right.image)?),
        (format!("{part}/disp/{}", name("disparity")), float_tiff(width, height, coded(values, NO_DATA))?),
    ])
}

/// Pandora: a folder a pair. Its disparity has the other sign: `I_L(x) = I_R(x + d)`.
pub(super) fn pandora(pair: &Pair) -> Files {
    const INVALID: f32 = -9999.0;
    let band = |image: &Plane| {
        let rgb = image.to_rgb8();
        let mean = |p: &[u8]| p.iter().map(|x| f32::from(*x)).sum::<f32>() / 3.0;
        float_tiff(image.width, image.height, rgb.chunks_exact(3).map(mean).collect())
    };
    let Side { image, validity: map, .. } = &pair.left;
    let (width, height) = (image.width, image.height);
    let truth: Vec<f32> = pair.left.seen_by_both().into_iter().map(|d| -d).collect();
    let range = pair.camera.disparity_range_px.unwrap_or([0.0, 0.0]);
    // Pandora walks through its pipeline in the order of the file, which a map of keys does not keep.
    let config = format!(
        r#"{{
  "input": {{
    "left": {{"img": "left.tif", "disp": [{}, {}], "mask": "left_mask.tif", "nodata": "NaN"}},
    "right": {{"img": "right.tif", "nodata": "NaN"}}
  }},
  "pipeline": {{
    "matching_cost": {{"matching_cost_method": "zncc", "window_size": 5, "subpix": 1}},
    "disparity": {{"disparity_method": "wta", "invalid_disparity": {INVALID:?}}}
  }}
}}
"#,
        -(range[1].ceil() as i64),
        -(range[0].floor() as i64),
    );
    let name = &pair.name;
    // 0 is valid; occluded pixels belong to the left image too and are no fault of it.
    let mask = Pixels::Gray(map.iter().map(|v| u8::from(*v == validity::MISS)).collect());
    let seen = map.iter().map(|v| if *v == validity::VALID { 0 } else { 255 }).collect();
    Ok(vec![
        (format!("{name}/left.tif"), band(image)?),
        (format!("{name}/right.tif"), band(&pair.right.image)?),
        (format!("{name}/left_mask.tif"), Plane { width, height, pixels: mask }.encode_tiff()?),
        (format!("{name}/left_disparity.tif"), float_tiff(width, height, coded(truth, INVALID))?),
        (format!("{name}/left_occlusion.png"), gray(width, height, seen)?),
        (format!("{name}/config.json"), config.into_bytes()),
    ])
}
