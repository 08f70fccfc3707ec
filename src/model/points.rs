//! What both views of a pair saw, as coloured points: PLY.

use super::{About, ModelError};
use crate::dataset::formats::{Pixels, Plane};
use crate::dataset::{Layer, Sample, View};
use std::fmt::Write as _;

/// One pixel's surface point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// East, north, up from the pivot's foot at the region's datum, m. What f32 rounds off is below 0.1 mm within 1 km.
    pub position_m: [f32; 3],
    /// Red, green, blue of the pixel.
    pub rgb: [u8; 3],
    /// Semantic class; 0 where the sample has no class label.
    pub class: u8,
}

/// The points of every pixel that hit something: those of the left view, row by row, then those of the right one. What both
/// views see is there twice, from two pixel grids.
#[derive(Clone, Debug)]
pub struct PointCloud {
    /// The sample's id.
    pub sample: String,
    /// The points.
    pub points: Vec<Point>,
    /// Whether the classes are known.
    pub classes: bool,
}

impl PointCloud {
    /// From a sample's disparities and cameras, in f64. The right view is left out where the sample has no disparity of it.
    ///
    /// # Errors
    /// Where the left view's image or disparity is missing.
    pub fn of(sample: &Sample) -> Result<Self, ModelError> {
        let missing = |what| ModelError::Missing { id: sample.identity.id.clone(), what };
        let mut points = Vec::new();
        let mut classes = true;
        for view in [View::Left, View::Right] {
            let image = sample.plane(Layer::Image, view);
            let Some(Plane { pixels: Pixels::Float(disparity_px), .. }) = sample.plane(Layer::Disparity, view) else {
                if view == View::Left {
                    return Err(missing("disparity"));
                }
                continue;
            };
            let rgb = image.ok_or_else(|| missing("image"))?.to_rgb8();
            let class = match sample.plane(Layer::Class, view) {
                Some(Plane { pixels: Pixels::Gray(values), .. }) => Some(values),
                _ => None,
            };
            classes &= class.is_some();
            for (pixel, disparity_px) in disparity_px.iter().enumerate().filter(|(_, d)| !d.is_nan()) {
                points.push(Point {
                    position_m: sample.camera.point_m(view, pixel, *disparity_px).map(|x| x as f32),
                    rgb: core::array::from_fn(|k| rgb[3 * pixel + k]),
                    class: class.map_or(0, |values| values[pixel]),
                });
            }
        }
        Ok(Self { sample: sample.identity.id.clone(), points, classes })
    }

    /// The bytes of a PLY file, binary, little-endian.
    pub fn ply(&self, about: &About) -> Vec<u8> {
        let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
        let version = env!("CARGO_PKG_VERSION");
        let (sample, About { region, variant, seed, generator_version, .. }) = (&self.sample, about);
        // Writing to a string cannot fail.
        let _ = writeln!(header, "comment satseed {version}, sample {sample}");
        let _ = writeln!(header, "comment {region} {variant}, seed {seed}, generator version {generator_version}");
        header.push_str("comment x east, y north, z up in metres from the pivot's foot at the region's datum\n");
        let _ = writeln!(header, "element vertex {}", self.points.len());
        header.push_str("property float x\nproperty float y\nproperty float z\n");
        header.push_str("property uchar red\nproperty uchar green\nproperty uchar blue\n");
        if self.classes {
            header.push_str("property uchar class\n");
        }
        header.push_str("end_header\n");
        let mut bytes = header.into_bytes();
        bytes.reserve(self.points.len() * 16);
        for point in &self.points {
            for x in point.position_m {
                bytes.extend_from_slice(&x.to_le_bytes());
            }
            bytes.extend_from_slice(&point.rgb);
            if self.classes {
                bytes.push(point.class);
            }
        }
        bytes
    }
}
