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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::pipeline::{BuiltScene, make_sample, rig};
    use crate::plan::Plan;
    use crate::recipe::Recipe;
    use glam::DVec3;

    const RECIPE: &str = r#"
[camera]
gsd_m = 0.6
size_px = [64, 48]
datum = "pivot"
[acquisition]
baseline_m = 120.0
azimuth_deg = 35.0
pairs_per_pivot = 1
[sensor]
preset = "worldview3_rgb"
samples_per_pixel = 1
[labels]
write = ["disparity_right", "class"]
[[scene]]
canyon = { radius_m = 60.0 }
pivots = 1
[[scene]]
toronto = { radius_m = 60.0 }
pivots = 1
"#;

    /// Each point lies where the tracer's ray of its pixel ends, with that pixel's colour and class.
    #[test]
    fn points_lie_on_the_scene() {
        let recipe = Recipe::parse("test", RECIPE).unwrap();
        for spec in &Plan::new(&recipe).unwrap().scenes {
            let scene = spec.region.build(spec.seed);
            let built = BuiltScene::new(&recipe, spec, &scene);
            let sample = make_sample(&built, &spec.pairs[0]).unwrap();
            let cloud = PointCloud::of(&sample).unwrap();
            assert!(cloud.classes && cloud.points.len() == 2 * 64 * 48);
            let rig = rig(&built, &spec.pairs[0]);
            let mut points = cloud.points.iter();
            let mut worst_m = 0.0_f64;
            for (view, camera) in [(View::Left, &rig.left), (View::Right, &rig.right)] {
                let image = sample.plane(Layer::Image, view).unwrap().to_rgb8();
                for (pixel, point) in (0..64 * 48).zip(points.by_ref()) {
                    let (u, v) = (f64::from(pixel % 64), f64::from(pixel / 64));
                    let hit = hit(&built, camera, u, v);
                    let found = DVec3::from_array(point.position_m.map(f64::from));
                    worst_m = worst_m.max((found - hit.point).length());
                    assert_eq!(point.rgb, image[3 * pixel as usize..][..3]);
                    assert_eq!(point.class, scene.material(hit.instance, hit.triangle).class as u8);
                }
            }
            assert!(worst_m < 1e-3, "{}: {worst_m} m", spec.name);
        }
    }

    fn hit(built: &BuiltScene<'_>, camera: &Camera, u: f64, v: f64) -> satseed_tracer::Hit {
        built.tracer.closest(&camera.ray(u, v), 1e5).unwrap()
    }

    #[test]
    fn a_ply_file_says_what_it_holds() {
        let point = Point { position_m: [1.0, -2.5, 300.25], rgb: [9, 8, 7], class: 4 };
        let mut cloud = PointCloud { sample: "town-1/b00-a00".to_owned(), points: vec![point; 3], classes: true };
        let about = About {
            scene: "town-1".to_owned(),
            region: "town".to_owned(),
            variant: "core".to_owned(),
            seed: 1,
            generator_version: 4,
            params_hash: String::new(),
        };
        let bytes = cloud.ply(&about);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        assert!(text.contains("comment satseed ") && text.contains("sample town-1/b00-a00\n"), "{text}");
        assert!(text.contains("element vertex 3\n") && text.contains("property uchar class\nend_header\n"), "{text}");
        let body = &bytes[bytes.len() - 3 * 16..];
        assert!(bytes[..bytes.len() - body.len()].ends_with(b"end_header\n"));
        let number = |k: usize| f32::from_le_bytes(body[16 + 4 * k..][..4].try_into().unwrap());
        assert_eq!(([number(0), number(1), number(2)], &body[28..32]), (point.position_m, &[9_u8, 8, 7, 4][..]));
        cloud.classes = false;
        assert_eq!(cloud.ply(&about).len() + "property uchar class\n".len() + 3, bytes.len());
    }
}
