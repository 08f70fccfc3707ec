//! A finished sample: two views of one pair, their cameras, and what may be said of them.

use super::camera_file::CameraFile;
use super::formats::{MISS, Pixels, Plane};
use super::layer::{LAST_CLASS, LAST_COUNT, Layer, View, validity};
use serde::{Deserialize, Serialize};

/// Who a sample is: what its record says before any pixel is counted, under the same names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// `<scene>/<sample>`: its folder, such as `canyon-gorge-7/b03-a17`.
    pub id: String,
    /// Region.
    pub region: String,
    /// The region's variant.
    pub variant: String,
    /// The scene's seed.
    pub scene_seed: u64,
    /// `train`, `val` or `test`.
    pub split: String,
    /// Hash of the scene's parameters.
    pub scene_params_hash: String,
    /// Distance of the optical centres, m.
    pub baseline_m: f64,
    /// Direction of the baseline, clockwise from north, degrees.
    pub azimuth_deg: f64,
    /// Angle under which the baseline is seen from z = 0, degrees.
    pub convergence_deg: f64,
}

impl Identity {
    /// The scene's name, its folder.
    pub fn scene(&self) -> &str {
        self.id.split_once('/').map_or("", |(scene, _)| scene)
    }
}

/// A finished pair.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Who it is.
    pub identity: Identity,
    /// Its cameras.
    pub camera: CameraFile,
    /// Its arrays. The left image, disparity and validity are always there.
    pub planes: Vec<(Layer, View, Plane)>,
}

/// Shares of the left view's pixels and the range of its disparities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Share of pixels seen by both views, 0 to 1.
    pub valid_fraction: f64,
    /// Share of pixels in the other frame but behind something, 0 to 1.
    pub occluded_fraction: f64,
    /// Share of pixels beyond the other frame, 0 to 1.
    pub out_of_frame_fraction: f64,
    /// Lowest and highest disparity of all hit pixels, px; none where nothing was hit.
    pub disparity_range_px: Option<[f32; 2]>,
}

impl Statistics {
    /// Counts a validity map and its disparities.
    pub fn of(disparity_px: &[f32], validity: &[u8]) -> Self {
        let mut counts = [0_u64; 256];
        for value in validity {
            counts[usize::from(*value)] += 1;
        }
        let share = |value: u8| counts[usize::from(value)] as f64 / validity.len().max(1) as f64;
        let range = disparity_px.iter().filter(|d| !d.is_nan()).fold(None, |range: Option<[f32; 2]>, d| {
            Some(range.map_or([*d, *d], |[low, high]| [low.min(*d), high.max(*d)]))
        });
        Self {
            valid_fraction: share(validity::VALID),
            occluded_fraction: share(validity::OCCLUDED),
            out_of_frame_fraction: share(validity::OUT_OF_FRAME),
            disparity_range_px: range,
        }
    }
}

/// What is wrong with a sample's content. The writer asserts it before writing, `verify` on reading.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{file}`: {what}")]
pub struct ContentError {
    /// The file it concerns.
    pub file: String,
    /// What is wrong.
    pub what: String,
}

impl Sample {
    /// One of its arrays.
    pub fn plane(&self, layer: Layer, view: View) -> Option<&Plane> {
        self.planes.iter().find(|(l, v, _)| (*l, *v) == (layer, view)).map(|(_, _, plane)| plane)
    }

    /// Counts its left view and puts the range of disparities into its camera file.
    ///
    /// # Errors
    /// Where the left disparity or validity is missing.
    pub fn count(&mut self) -> Result<Statistics, ContentError> {
        let (disparity, validity) = self.left_labels()?;
        let statistics = Statistics::of(disparity, validity);
        self.camera.disparity_range_px = statistics.disparity_range_px;
        Ok(statistics)
    }

    fn left_labels(&self) -> Result<(&[f32], &[u8]), ContentError> {
        let missing = |layer: Layer| ContentError { file: usual_name(layer), what: "it is missing".into() };
        match (self.plane(Layer::Disparity, View::Left), self.plane(Layer::Validity, View::Left)) {
            (Some(Plane { pixels: Pixels::Float(d), .. }), Some(Plane { pixels: Pixels::Gray(v), .. })) => Ok((d, v)),
            (None, _) => Err(missing(Layer::Disparity)),
            _ => Err(missing(Layer::Validity)),
        }
    }

    /// Whether arrays, cameras and each other agree.
    ///
    /// # Errors
    /// The first disagreement.
    pub fn check(&self) -> Result<(), ContentError> {
        let (disparity, validity) = self.left_labels()?;
        let fault = |file: String, what: String| Err(ContentError { file, what });
        if self.plane(Layer::Image, View::Left).is_none() {
            return fault(usual_name(Layer::Image), "it is missing".into());
        }
        for (layer, view, plane) in &self.planes {
            let camera = if *view == View::Left { &self.camera.left } else { &self.camera.right };
            let file = layer.file_name(*view, plane.kind());
            if (plane.width, plane.height) != (camera.width_px, camera.height_px) {
                let (w, h) = (camera.width_px, camera.height_px);
                return fault(file, format!("{} x {} px, but the camera has {w} x {h}", plane.width, plane.height));
            }
            if !layer.kinds().contains(&plane.kind()) {
                let usual = layer.kinds()[0];
                return fault(file, format!("it holds {:?}, but must hold {usual:?}", plane.kind()));
            }
            if let Some(what) = value_fault(*layer, plane, self.plane(Layer::Validity, *view)) {
                return fault(file, what);
            }
        }
        let range = Statistics::of(disparity, validity).disparity_range_px;
        if self.camera.disparity_range_px != range {
            let what = format!(
                "disparities run over {range:?}, but the camera file says {:?}",
                self.camera.disparity_range_px
            );
            return fault(usual_name(Layer::Disparity), what);
        }
        Ok(())
    }
}

/// The name of a left view's file, as most datasets have it.
fn usual_name(layer: Layer) -> String {
    layer.file_name(View::Left, layer.kinds()[0])
}

/// The first value that its layer cannot hold.
fn value_fault(layer: Layer, plane: &Plane, validity_map: Option<&Plane>) -> Option<String> {
    let at = |i: usize| format!("pixel ({}, {})", i % plane.width as usize, i / plane.width as usize);
    let above = |values: &[u8], limit: u8, what: &str| {
        let i = values.iter().position(|v| *v > limit)?;
        Some(format!("{} is {}, but a {what} is at most {limit}", at(i), values[i]))
    };
    match (layer, &plane.pixels) {
        (Layer::Validity, Pixels::Gray(v)) => above(v, validity::OUT_OF_FRAME, "validity"),
        (Layer::Class, Pixels::Gray(v)) => above(v, LAST_CLASS, "class"),
        (Layer::Edge, Pixels::Gray(v)) => above(v, 1, "edge mark"),
        (Layer::Image, Pixels::Counts(n, v)) => {
            let i = v.iter().position(|count| *count > LAST_COUNT)?;
            Some(format!("{} is {}, but a count is at most {LAST_COUNT}", at(i / usize::from(*n)), v[i]))
        }
        (Layer::Image, Pixels::Radiance(n, v)) => {
            let i = v.iter().position(|radiance| !radiance.is_finite())?;
            Some(format!("{} is {}, which is no radiance", at(i / usize::from(*n)), v[i]))
        }
        (Layer::Disparity | Layer::Elevation, Pixels::Float(values)) => {
            let map = match validity_map.map(|p| &p.pixels) {
                Some(Pixels::Gray(map)) if map.len() == values.len() => Some(map),
                _ => None,
            };
            for (i, value) in values.iter().enumerate() {
                if value.is_infinite() || (value.is_nan() && value.to_bits() != MISS.to_bits()) {
                    return Some(format!("{} is {value}, which no label holds", at(i)));
                }
                let missed = map.map(|m| m[i] == validity::MISS);
                if missed.is_some_and(|missed| missed != value.is_nan()) {
                    return Some(format!("{} is {value}, but its validity is {}", at(i), map.map_or(0, |m| m[i])));
                }
            }
            None
        }
        _ => None,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::camera_file::CameraRecord;
    use super::*;

    fn camera(width: u32, height: u32) -> CameraRecord {
        CameraRecord {
            width_px: width,
            height_px: height,
            fx_px: 10_000.0 / 3.0,
            fy_px: 10_000.0 / 3.0,
            cx_px: f64::from(width - 1) / 2.0,
            cy_px: f64::from(height - 1) / 2.0,
            position_m: [-50.0, 0.0, 1000.0],
            world_from_camera: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            projection: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.1]],
        }
    }

    /// A sample whose arrays are made of its names: synthetic, but every check applies to it.
    pub(crate) fn synthetic(scene: &str, name: &str, width: u32, height: u32) -> Sample {
        let salt = blake3::hash(format!("{scene}/{name}").as_bytes()).as_bytes()[0];
        let pixels = width as usize * height as usize;
        let validity: Vec<u8> = (0..pixels).map(|i| [1, 1, 1, 2, 3, 0][(i / 3 + salt as usize) % 6]).collect();
        let disparity = |offset: f32| -> Vec<f32> {
            let value = |(i, v): (usize, &u8)| if *v == 0 { MISS } else { offset + i as f32 * 0.1 };
            validity.iter().enumerate().map(value).collect()
        };
        let of = |pixels| Plane { width, height, pixels };
        let image = |salt: u8| of(Pixels::Rgb((0..pixels * 3).map(|i| (i as u8).wrapping_mul(salt | 1)).collect()));
        let mut sample = Sample {
            identity: Identity {
                id: format!("{scene}/{name}"),
                region: "canyon".into(),
                variant: "gorge".into(),
                scene_seed: 7,
                split: "train".into(),
                scene_params_hash: "9f03c1aa".into(),
                baseline_m: 100.0,
                azimuth_deg: 30.0,
                convergence_deg: 5.72,
            },
            camera: CameraFile {
                left: camera(width, height),
                right: camera(width, height),
                baseline_m: 100.0,
                altitude_m: 1000.0,
                gsd_m: 0.3,
                azimuth_deg: 30.0,
                convergence_deg: 5.72,
                convergence_at_pivot_deg: 5.8,
                doffs_px: 0.0,
                disparity_range_px: None,
            },
            planes: vec![
                (Layer::Image, View::Left, image(salt)),
                (Layer::Image, View::Right, image(salt.wrapping_add(4))),
                (Layer::Disparity, View::Left, of(Pixels::Float(disparity(300.0)))),
                (Layer::Validity, View::Left, of(Pixels::Gray(validity.clone()))),
                (Layer::Instance, View::Left, of(Pixels::Id((0..pixels as u32).collect()))),
            ],
        };
        sample.count().expect("left labels are there");
        sample
    }

    #[test]
    fn statistics_count_every_pixel() {
        let s = Statistics::of(&[MISS, 3.0, -2.0, 9.0], &[0, 1, 2, 3]);
        assert_eq!((s.valid_fraction, s.occluded_fraction, s.out_of_frame_fraction), (0.25, 0.25, 0.25));
        assert_eq!(s.disparity_range_px, Some([-2.0, 9.0]));
        assert_eq!(Statistics::of(&[MISS], &[0]).disparity_range_px, None);
    }

    #[test]
    fn disagreements_are_found() {
        let good = synthetic("canyon-gorge-7", "b00-a00", 12, 9);
        good.check().unwrap();
        let change = |f: &dyn Fn(&mut Sample)| {
            let mut sample = good.clone();
            f(&mut sample);
            sample.check().unwrap_err().to_string()
        };
        let disparity = |s: &mut Sample, i: usize, value: f32| {
            let Pixels::Float(v) = &mut s.planes[2].2.pixels else { panic!() };
            v[i] = value;
        };
        let hit = (0..108).find(|i| matches!(&good.planes[3].2.pixels, Pixels::Gray(v) if v[*i] == 1)).unwrap();
        assert!(change(&|s| disparity(s, hit, MISS)).contains("its validity is 1"));
        assert!(change(&|s| disparity(s, hit, f32::INFINITY)).contains("no label holds"));
        assert!(change(&|s| disparity(s, hit, -f32::NAN)).contains("no label holds"));
        assert!(change(&|s| disparity(s, hit, 9999.0)).contains("camera file says"));
        assert!(change(&|s| s.camera.left.width_px = 13).contains("the camera has 13 x 9"));
        let strange = |s: &mut Sample| {
            let Pixels::Gray(v) = &mut s.planes[3].2.pixels else { panic!() };
            v[hit] = 4;
        };
        assert!(change(&strange).contains("at most 3"));
        assert!(change(&|s| drop(s.planes.remove(3))).contains("missing"));
        assert!(change(&|s| drop(s.planes.remove(0))).contains("`left.png`: it is missing"));
    }
}
