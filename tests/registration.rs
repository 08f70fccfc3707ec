//! Pictures and labels are registered: the right image, fetched by the left disparity, lies on the left image to
//! 0.02 px in both axes.
//!
//! The shift is estimated by least squares on the images' gradients (Lucas and Kanade 1981), with the right image
//! resampled by a cubic; both gradients are averaged, so that noise in one of them does not pull the estimate to 0.
//! Only Valid pixels of textured parts count, away from borders of objects, whose mixed pixels have no one disparity.

mod support;

use glam::{DAffine3, DVec2, DVec3};
use satseed::camera::{Datum, StereoRig};
use satseed::labels::{Extra, Validity, View, ViewLabels, extract};
use satseed::render::{AmbientMode, Image, Light, Sensor, Settings, develop, expose};
use satseed_generators::Region;
use satseed_scene::{
    Bands, Brdf, Class, Environment, Field, Fractal, Layer, Material, Scene, SeedPath, Space, gradient_noise_2d,
};
use satseed_tracer::Tracer;
use support::solids::{cuboid, grid};
use support::stage::{RigCase, Stage, noon};

/// An image of one channel.
struct Grey {
    width: usize,
    height: usize,
    data: Vec<f64>,
}

impl Grey {
    fn of(image: &Image) -> Self {
        let data = image.bytes().chunks(3).map(|p| p.iter().map(|x| f64::from(*x)).sum::<f64>() / 3.0).collect();
        Self { width: image.width as usize, height: image.height as usize, data }
    }

    fn at(&self, u: usize, v: usize) -> f64 {
        self.data[v * self.width + u]
    }

    /// Value between columns, by Catmull and Rom's cubic; `None` near the border.
    fn between(&self, u: f64, v: usize) -> Option<f64> {
        let first = libm::floor(u);
        if first < 1.0 || first + 2.0 >= self.width as f64 {
            return None;
        }
        let (i, s) = (first as usize, u - first);
        let [a, b, c, d] = [-1_isize, 0, 1, 2].map(|k| self.at(i.checked_add_signed(k).expect("inside"), v));
        Some(b + 0.5 * s * (c - a + s * (2.0 * a - 5.0 * b + 4.0 * c - d + s * (3.0 * (b - c) + d - a))))
    }
}

/// The shift of the warped right image against the left, px, and how many pixels it rests on.
fn misregistration(left: &Grey, right: &Grey, labels: &ViewLabels, shift: DVec2) -> (DVec2, usize) {
    let edge = labels.edge.as_ref().expect("asked");
    let (width, height) = (left.width, left.height);
    let whole = |u: usize, v: usize| {
        let near = (v - 2..=v + 2).flat_map(|v| (u - 2..=u + 2).map(move |u| v * width + u));
        near.into_iter().all(|at| labels.validity[at] == Validity::Valid as u8 && edge[at] == 0)
    };
    // The right image where the left pixels' points are.
    let mut warped = Grey { width, height, data: vec![f64::NAN; width * height] };
    for v in 1..height - 1 {
        for u in 0..width {
            let at = v * width + u;
            if labels.validity[at] == Validity::Valid as u8 {
                // A planted shift asks the neighbours, linearly between rows.
                let (du, dv) = (shift.x, shift.y);
                let column = u as f64 - f64::from(labels.disparity_px[at]) + du;
                let other_row = if dv >= 0.0 { v + 1 } else { v - 1 };
                let (here, there) = (right.between(column, v), right.between(column, other_row));
                if let (Some(here), Some(there)) = (here, there) {
                    warped.data[at] = here + (there - here) * dv.abs();
                }
            }
        }
    }
    let mut samples = Vec::new();
    for v in 3..height - 3 {
        for u in 3..width - 3 {
            if !whole(u, v) {
                continue;
            }
            let gradient =
                |g: &Grey| DVec2::new(g.at(u + 1, v) - g.at(u - 1, v), g.at(u, v + 1) - g.at(u, v - 1)) / 2.0;
            let g = (gradient(left) + gradient(&warped)) / 2.0;
            let t = warped.at(u, v) - left.at(u, v);
            if g.is_finite() && t.is_finite() && g.length() >= 2.0 {
                samples.push((g, t));
            }
        }
    }
    (robust_shift(&samples), samples.len())
}

/// The s with t = g . s, by weighted least squares: Tukey's biweight takes what moves between views (glints, mixed
/// pixels, leaves) out of the sum.
fn robust_shift(samples: &[(DVec2, f64)]) -> DVec2 {
    let mut shift = DVec2::ZERO;
    for _ in 0..12 {
        let residual = |(g, t): &(DVec2, f64)| t - g.dot(shift);
        let mut sizes: Vec<f64> = samples.iter().map(|s| residual(s).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(median) = sizes.get(sizes.len() / 2) else { return DVec2::NAN };
        let limit = 4.685 * 1.4826 * median.max(0.1);
        let (mut a, mut b, mut c, mut p, mut q) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for sample in samples {
            let r = residual(sample) / limit;
            let w = if r.abs() < 1.0 { (1.0 - r * r) * (1.0 - r * r) } else { 0.0 };
            let (g, t) = *sample;
            a += w * g.x * g.x;
            b += w * g.x * g.y;
            c += w * g.y * g.y;
            p += w * g.x * t;
            q += w * g.y * t;
        }
        shift = DVec2::new(c * p - b * q, a * q - b * p) / (a * c - b * b);
    }
    shift
}

fn images(scene: &Scene, rig: &StereoRig, sensor: Sensor, samples: u32, sun: &Environment) -> (Grey, Grey, ViewLabels) {
    let tracer = Tracer::new(scene);
    let settings = Settings { samples_per_pixel: samples, sensor };
    let light = Light::of(&tracer, sun).with_ambient(AmbientMode::PerScene, scene.full_detail_radius_m);
    let shot = |camera, side| expose(&tracer, camera, &light, settings, &SeedPath::root(side, 5));
    let pair = develop(vec![shot(&rig.left, "left"), shot(&rig.right, "right")], sensor);
    let extra = Extra { edge: true, ..Extra::default() };
    (Grey::of(&pair[0]), Grey::of(&pair[1]), extract(&tracer, rig, View::Left, sun, extra))
}

/// Rough ground and boxes, all with a fine texture.
fn textured() -> Scene {
    let mut stage = Stage::new();
    let height = |x: f64, y: f64| 6.0 * f64::from(gradient_noise_2d(x / 41.0, y / 41.0, 3));
    stage.add(grid(-80.0, -80.0, 2.0, 80, &mut |x, y| height(x, y)), DAffine3::IDENTITY, Class::Ground);
    for (x, y, size, top) in [(-14.0, 3.0, 9.0, 22.0), (10.0, -12.0, 7.0, 35.0), (13.0, 13.0, 6.0, 15.0)] {
        let low = DVec3::new(x - size, y - size, -9.0);
        stage.add(cuboid(low, DVec3::new(x + size, y + size, top)), DAffine3::IDENTITY, Class::Roof);
    }
    let mut scene = stage.finish();
    for (k, m) in scene.materials.iter_mut().enumerate() {
        let noise =
            |wavelength_m, gain| Field::Noise(Fractal::new(Space::World, k as u32 + 7, wavelength_m, 3).gain(gain));
        *m = Material::diffuse(&m.name, m.class, Bands::grey(0.22)).with(Layer::Brightness { amount: noise(4.0, 0.7) });
    }
    scene
}

fn rig(azimuth_rad: f64, height_m: f64, size: u32) -> StereoRig {
    RigCase {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [size, size],
        feet_m: [-75.0, 75.0],
        azimuth_rad,
        datum: Datum::Height(height_m),
        shift_px: [0.0; 2],
    }
    .rig()
}

#[allow(clippy::print_stderr, reason = "the numbers are part of the proof")]
fn prove(what: &str, pair: &(Grey, Grey, ViewLabels), least: usize) -> DVec2 {
    let (left, right, labels) = pair;
    let (shift, count) = misregistration(left, right, labels, DVec2::ZERO);
    eprintln!("{what}: shift ({:+.4}, {:+.4}) px over {count} pixels", shift.x, shift.y);
    assert!(count >= least, "{what}: only {count} pixels have texture");
    shift
}

#[test]
fn pictures_and_labels_are_registered() {
    let scene = textured();
    for (azimuth_rad, sensor) in [(0.4, Sensor::IDEAL), (-1.1, Sensor::WORLDVIEW3_RGB)] {
        let pair = images(&scene, &rig(azimuth_rad, 0.0, 160), sensor, 16, &noon());
        let shift = prove(&format!("{sensor:?}"), &pair, 5000);
        assert!(shift.abs().max_element() <= 0.02, "{sensor:?}: off by {shift} px");
        // The measure itself: a planted shift of 0.1 px is seen as that.
        for planted in [DVec2::new(0.1, 0.0), DVec2::new(-0.1, 0.0), DVec2::new(0.0, 0.1), DVec2::new(0.0, -0.1)] {
            let (seen, _) = misregistration(&pair.0, &pair.1, &pair.2, planted);
            assert!((seen - shift - planted).abs().max_element() < 0.025, "{planted} is seen as {}", seen - shift);
        }
    }
}

#[test]
fn pictures_and_labels_of_regions_are_registered() {
    for name in Region::NAMES {
        let region = Region::by_name(name).expect("registered").with_radius_m(80.0);
        let mut scene = region.build(12);
        // A canal shows the houses beside it as mirror images, which have a parallax of their own.
        if *name == "venice" {
            for material in scene.materials.iter_mut().filter(|m| !matches!(m.brdf, Brdf::Leaf { .. })) {
                material.brdf = Brdf::Diffuse { roughness_rad: 0.0 };
            }
        }
        let pair = images(&scene, &rig(0.8, scene.pivot_height_m, 256), Sensor::WORLDVIEW3_RGB, 16, &noon());
        let shift = prove(name, &pair, 2000);
        assert!(shift.abs().max_element() <= 0.02, "{name}: off by {shift} px");
    }
}
