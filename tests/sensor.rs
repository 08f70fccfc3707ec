//! What a sensor must show: radiance in closed form through the air, the blur and the noise that were set, and nothing
//! that changes between the views of a pair but the camera and the noise.

#![allow(clippy::print_stderr)]

#[path = "support/mod.rs"]
mod support;

use core::f64::consts::PI;
use glam::{DAffine3, DMat3, DVec3};
use satseed::camera::{Camera, Datum};
use satseed::dataset::formats::{Pixels, Plane};
use satseed::render::sensor::{BandSet, Coding, ImagePixels, Noise};
use satseed::render::{AmbientMode, Image, Light, Sensor, Settings, develop, expose, render};
use satseed_generators::Region;
use satseed_scene::{Bands, Class, Environment, Scene, SeedPath};
use satseed_tracer::Tracer;
use support::solids::{cuboid, mesh};
use support::stage::{RigCase, Stage, noon};

const GSD_M: f64 = 0.3;
/// The scene's band behind each of an image's.
const ORDER: [usize; 4] = [2, 1, 0, 3];

/// North up from 1 km, the world's origin in the middle.
fn nadir(size_px: u32) -> Camera {
    let middle = (f64::from(size_px) - 1.0) / 2.0;
    Camera {
        width_px: size_px,
        height_px: size_px,
        fx_px: 1000.0 / GSD_M,
        fy_px: 1000.0 / GSD_M,
        cx_px: middle,
        cy_px: middle,
        position_m: DVec3::new(0.0, 0.0, 1000.0),
        world_from_camera: DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
    }
}

fn quad(corners: [[f64; 2]; 4]) -> satseed_scene::Mesh {
    mesh(&corners.map(|[x, y]| DVec3::new(x, y, 0.0)), vec![[0, 1, 2], [0, 2, 3]])
}

/// Flat ground of Lambert reflectances, part by part.
fn ground(parts: &[([[f64; 2]; 4], f32)]) -> Scene {
    let mut stage = Stage::new();
    for (corners, _) in parts {
        stage.add(quad(*corners), DAffine3::IDENTITY, Class::Ground);
    }
    let mut scene = stage.finish();
    for (material, (_, reflectance)) in scene.materials.iter_mut().zip(parts) {
        material.base = Bands::grey(*reflectance);
    }
    scene
}

const SQUARE: [[f64; 2]; 4] = [[-1000.0, -1000.0], [1000.0, -1000.0], [1000.0, 1000.0], [-1000.0, 1000.0]];

fn radiance(image: &Image) -> &[f32] {
    let ImagePixels::Radiance(values) = &image.pixels else { panic!("asked for radiance") };
    values
}

fn channel(image: &Image, band: usize) -> Vec<f64> {
    radiance(image).iter().skip(band).step_by(image.channels).map(|x| f64::from(*x)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn of(sensor: Sensor, samples_per_pixel: u32) -> Settings {
    Settings { samples_per_pixel, sensor }
}

/// `path + E / pi (direct + diffuse) rho` over endless ground of one reflectance, in every band.
#[test]
fn a_lambert_plane_through_the_air_has_its_closed_form() {
    let reflectance = 0.25;
    let scene = ground(&[(SQUARE, reflectance)]);
    let tracer = Tracer::new(&scene);
    for aerosol_optical_depth in [0.05, 0.3] {
        let environment = Environment { aerosol_optical_depth, ..noon() };
        let light = Light::of(&tracer, &environment);
        let sensor = Sensor { bands: BandSet::RgbNir, ..Sensor::LINEAR };
        let image = render(&tracer, &nadir(32), &light, of(sensor, 64), &SeedPath::root("plane", 1));
        let stated = Light::over(&environment, Bands::grey(reflectance));
        let veil = stated.veil(DVec3::Z);
        for (i, b) in ORDER.into_iter().enumerate() {
            let leaving = reflectance * stated.flat_irradiance()[b] / core::f32::consts::PI;
            let expected = f64::from(leaving * veil.direct[b] + veil.added[b]);
            let found = mean(&channel(&image, i));
            assert!((found / expected - 1.0).abs() < 0.003, "band {b}: {found} against {expected}");
        }
    }
}

/// Ground in the shadow of a wall against ground in the sun, at the sensor.
#[test]
fn shadows_are_neither_black_nor_grey() {
    let mut stage = Stage::new();
    stage.add(quad(SQUARE), DAffine3::IDENTITY, Class::Ground);
    let wall = cuboid(DVec3::new(-60.0, -1.0, 0.0), DVec3::new(60.0, 0.0, 20.0));
    stage.add(wall, DAffine3::IDENTITY, Class::Facade);
    let scene = stage.finish();
    let tracer = Tracer::new(&scene);
    for aerosol_optical_depth in [0.05, 0.12, 0.2] {
        // The sun in the south: the wall's shadow lies north of it.
        let environment = Environment { sun_elevation_rad: 0.733, sun_azimuth_rad: PI, aerosol_optical_depth };
        let light = Light::of(&tracer, &environment);
        let around = |image: &Image, band: usize, y_m: f64| {
            let row = (79.5 - y_m / GSD_M) as usize;
            mean(&channel(image, band)[row * 160 + 40..row * 160 + 120])
        };
        let shot = |bands| {
            let sensor = Sensor { bands, ..Sensor::LINEAR };
            render(&tracer, &nadir(160), &light, of(sensor, 16), &SeedPath::root("shadow", 1))
        };
        let (pan, colour) = (shot(BandSet::Pan), shot(BandSet::Rgb));
        let at_sensor = around(&pan, 0, 12.0) / around(&pan, 0, -14.0);
        // Without the air's own light: what the ground sends up.
        let veil = light.veil(DVec3::Z);
        let at_ground = [0, 1, 2].map(|i| {
            let air = f64::from(veil.added[ORDER[i]]);
            (around(&colour, i, 12.0) - air) / (around(&colour, i, -14.0) - air)
        });
        eprintln!(
            "aerosol {aerosol_optical_depth}: shadow to sun {at_sensor:.3}; at the ground, red, green, blue {at_ground:.3?}"
        );
        assert!((0.15..=0.40).contains(&at_sensor), "{at_sensor}");
        assert!(at_ground[2] > at_ground[1] && at_ground[1] > at_ground[0], "shadows are bluish: {at_ground:?}");
        assert!(at_ground.iter().all(|r| (0.04..=0.40).contains(r)), "{at_ground:?}");
    }
}

/// Modulation transfer at half a cycle a pixel from an edge that leans by 6 degrees (as in ISO 12233), along rows or columns.
fn edge_transfer(sensor: Sensor, along_columns: bool) -> f64 {
    const SIZE: u32 = 96;
    /// Bins a pixel.
    const FINE: f64 = 4.0;
    /// No simple fraction, so that the rows' phases fill every bin evenly; and 200 m of it end on the lattice of vertices.
    const LEAN: f64 = 20.679_687_5 / 200.0;
    let turn = |p: [f64; 2]| if along_columns { [p[1], p[0]] } else { p };
    let foot = 200.0 * LEAN;
    let dark = [[-200.0, -200.0], [-foot, -200.0], [foot, 200.0], [-200.0, 200.0]].map(turn);
    let bright = [[-foot, -200.0], [200.0, -200.0], [200.0, 200.0], [foot, 200.0]].map(turn);
    let scene = ground(&[(dark, 0.05), (bright, 0.45)]);
    let tracer = Tracer::new(&scene);
    let light = Light::of(&tracer, &noon());
    let plain = Sensor { noise: Noise::NONE, coding: Coding::Radiance, ..sensor };
    let image = render(&tracer, &nadir(SIZE), &light, of(plain, 64), &SeedPath::root("edge", 1));
    let values = channel(&image, usize::from(image.channels > 1));
    let middle = (f64::from(SIZE) - 1.0) / 2.0;
    let reach = 14.0;
    let mut bins = vec![(0.0, 0.0); (2.0 * reach * FINE) as usize];
    for (i, value) in values.iter().enumerate() {
        let (x, y) = (f64::from(i as u32 % SIZE) - middle, middle - f64::from(i as u32 / SIZE));
        let (across, along) = if along_columns { (y, x) } else { (x, y) };
        // Distance from the edge, px, square on.
        let distance = (across - LEAN * along) / (1.0 + LEAN * LEAN).sqrt();
        let bin = ((distance + reach) * FINE).floor();
        if bin >= 0.0 && bin < bins.len() as f64 {
            let (sum, count) = &mut bins[bin as usize];
            (*sum, *count) = (*sum + value, *count + 1.0);
        }
    }
    let edge: Vec<f64> = bins.iter().map(|(sum, count)| sum / count).collect();
    assert!(edge.iter().all(|v| v.is_finite()), "a bin is empty");
    let line: Vec<f64> = edge.windows(2).map(|w| w[1] - w[0]).collect();
    let wave = |f: f64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, v) in line.iter().enumerate() {
            let (s, c) = libm::sincos(2.0 * PI * f * i as f64 / FINE);
            (re, im) = (re + v * c, im + v * s);
        }
        libm::hypot(re, im)
    };
    // The bins' own box, and that of the difference.
    let half = PI * 0.5 / FINE;
    let own = libm::sin(half) / half;
    wave(0.5) / wave(0.0) / (own * own)
}

#[test]
fn slanted_edges_have_the_transfer_that_is_set() {
    let presets = [
        ("ideal", Sensor::IDEAL),
        ("worldview3_rgb", Sensor::WORLDVIEW3_RGB),
        ("gf7_pan", Sensor::GF7_PAN),
        ("linear", Sensor::LINEAR),
    ];
    for (name, sensor) in presets {
        let across = sensor.optics.mtf_at_nyquist.unwrap_or(2.0 / PI);
        for (direction, expected, columns) in
            [("across", across, false), ("along", sensor.optics.mtf_along_track(), true)]
        {
            let found = edge_transfer(sensor, columns);
            eprintln!("{name}, {direction} track: {found:.3}, set {expected:.3}");
            assert!((found - expected).abs() < 0.03, "{name} {direction}: {found} against {expected}");
        }
    }
}

/// Half the difference of two images of even ground whose noise alone differs.
fn noise_of(sensor: Sensor, reflectance: f32, size: u32) -> (Light, Vec<Image>) {
    let scene = ground(&[(SQUARE, reflectance)]);
    let tracer = Tracer::new(&scene);
    let light = Light::of(&tracer, &noon());
    let noise = SeedPath::root("noise", 9);
    let shot = |side: &str| expose(&tracer, &nadir(size), &light, of(sensor, 1), &noise.child(side));
    let images = develop(vec![shot("left"), shot("right")], sensor);
    (light, images)
}

#[test]
fn noise_has_the_variance_that_is_set_and_is_independent() {
    let presets = [Sensor { sharpening: None, ..Sensor::WORLDVIEW3_RGB }, Sensor::GF7_PAN];
    for preset in presets {
        let noise = Noise { column_gain: 0.0, ..preset.noise };
        let sensor = Sensor { noise, coding: Coding::Radiance, ..preset };
        let [a, b] = noise.variance();
        for reflectance in [0.04, 0.15, 0.5] {
            let (light, images) = noise_of(sensor, reflectance, 200);
            let (quiet_light, quiet) = noise_of(Sensor { noise: Noise::NONE, ..sensor }, reflectance, 200);
            assert_eq!(light.white_radiance, quiet_light.white_radiance);
            assert_eq!(quiet[0], quiet[1], "without noise both images are one");
            for (band, order) in ORDER.into_iter().enumerate().take(sensor.bands.count()) {
                let unit = match sensor.bands {
                    // A panchromatic signal of 1 is a radiance that only the sensor knows: from the values themselves.
                    BandSet::Pan => {
                        let counts = Sensor { coding: Coding::Counts, noise: Noise::NONE, ..sensor };
                        let (_, counted) = noise_of(counts, reflectance, 64);
                        let ImagePixels::Counts(counts) = &counted[0].pixels else { panic!("counts") };
                        let signal = counts.iter().map(|c| f64::from(*c)).sum::<f64>() / counts.len() as f64 / 2047.0;
                        mean(&channel(&quiet[0], 0)) / signal
                    }
                    _ => f64::from(light.white_radiance[order]),
                };
                let of_view = |view: usize| -> Vec<f64> {
                    let values = channel(&images[view], band).into_iter().zip(channel(&quiet[view], band));
                    values.map(|(with, without)| (with - without) / unit).collect()
                };
                let (left, right) = (of_view(0), of_view(1));
                let signal = mean(&channel(&quiet[0], band)) / unit;
                let expected = a + b * signal;
                let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / x.len() as f64;
                let variance = f64::midpoint(product(&left, &left), product(&right, &right));
                assert!(
                    (variance / expected - 1.0).abs() < 0.03,
                    "{reflectance} {band}: {variance} against {expected}"
                );
                let shared = product(&left, &right) / expected;
                assert!(shared.abs() < 0.02, "{reflectance} {band}: the views share {shared} of their noise");
                assert!(mean(&left).abs() < 4.0 * (expected / left.len() as f64).sqrt());
            }
        }
    }
}

#[test]
fn columns_have_the_gains_that_are_set() {
    let noise = Noise { column_gain: 0.004, ..Noise::NONE };
    let sensor = Sensor { bands: BandSet::RgbNir, noise, sharpening: None, coding: Coding::Radiance, ..Sensor::IDEAL };
    let (_, images) = noise_of(sensor, 0.3, 400);
    let (_, quiet) = noise_of(Sensor { noise: Noise::NONE, ..sensor }, 0.3, 400);
    let mut gains = Vec::new();
    for image in &images {
        for band in 0..4 {
            let (with, without) = (channel(image, band), channel(&quiet[0], band));
            for u in 0..400 {
                let gain = |v: usize| with[v * 400 + u] / without[v * 400 + u];
                assert!((gain(0) - gain(399)).abs() < 1e-5, "a column has one gain");
                gains.push(gain(0) - 1.0);
            }
        }
    }
    let spread = (gains.iter().map(|g| g * g).sum::<f64>() / gains.len() as f64).sqrt();
    assert!((spread / 0.004 - 1.0).abs() < 0.06, "{spread}");
}

fn pair_of_cameras(size_px: u32) -> [Camera; 2] {
    let rig = RigCase {
        altitude_m: 1000.0,
        gsd_m: GSD_M,
        size_px: [size_px; 2],
        feet_m: [-100.0, 100.0],
        azimuth_rad: 0.7,
        datum: Datum::Height(0.0),
        shift_px: [0.0; 2],
    }
    .rig();
    [rig.left, rig.right]
}

/// One world point, one footprint, two cameras: before air and noise a Lambert surface has one radiance. And the air over
/// each camera is what its own zenith makes of it.
#[test]
fn the_same_surface_has_the_same_colour() {
    let scene = ground(&[(SQUARE, 0.3)]);
    let tracer = Tracer::new(&scene);
    let light = Light::of(&tracer, &noon());
    let sensor = Sensor { bands: BandSet::RgbNir, ..Sensor::LINEAR };
    let cameras = pair_of_cameras(48);
    let means = cameras.each_ref().map(|camera| {
        let image = render(&tracer, camera, &light, of(sensor, 64), &SeedPath::root("colour", 2));
        let veil = light.veil(camera.position_m.normalize());
        ORDER.map(|b| {
            let at_sensor = mean(&channel(&image, ORDER.iter().position(|o| *o == b).expect("all are there")));
            (at_sensor, (at_sensor - f64::from(veil.added[b])) / f64::from(veil.direct[b]))
        })
    });
    for (b, (left, right)) in means[0].iter().zip(&means[1]).enumerate() {
        assert!((left.1 / right.1 - 1.0).abs() < 0.002, "band {b}: {} and {} at the ground", left.1, right.1);
        assert!((left.0 / right.0 - 1.0).abs() < 0.05, "band {b}: {} and {} at the sensor", left.0, right.0);
        assert!(left.0 != right.0, "band {b}: the zeniths differ, and so does the air");
    }
}

/// Swapping the cameras swaps the images, bit by bit: nothing else tells the views apart.
#[test]
fn swapped_cameras_give_swapped_images() {
    let mut region = Region::by_name("toronto").expect("registered");
    if let Region::Toronto(p) = &mut region {
        p.radius_m = 80.0;
    }
    let scene = region.build(3);
    let tracer = Tracer::new(&scene);
    let light = Light::of(&tracer, &noon());
    let [a, b] = pair_of_cameras(96);
    let settings = of(Sensor::WORLDVIEW3_RGB, 4);
    let shot = |camera: &Camera, key: &str| expose(&tracer, camera, &light, settings, &SeedPath::root(key, 1));
    let there = develop(vec![shot(&a, "a"), shot(&b, "b")], settings.sensor);
    let back = develop(vec![shot(&b, "b"), shot(&a, "a")], settings.sensor);
    assert_eq!((&there[0], &there[1]), (&back[1], &back[0]));
    // The noise is all that the key decides.
    let quiet = Settings { sensor: Sensor { noise: Noise::NONE, ..settings.sensor }, ..settings };
    let of_key = |key: &str| render(&tracer, &a, &light, quiet, &SeedPath::root(key, 1));
    assert_eq!(of_key("a"), of_key("b"));
    assert_ne!(there[0], render(&tracer, &a, &light, settings, &SeedPath::root("b", 1)));
    // Little is lost at the ends of the scale.
    let ends = |image: &Image| image.bytes().iter().filter(|x| **x == 0 || **x == 255).count();
    let clipped = (ends(&there[0]) + ends(&there[1])) as f64 / (2 * 96 * 96 * 3) as f64;
    assert!(clipped < 0.01, "{clipped}");
}

/// A change of these bytes is a change of datasets of such sensors: it must be meant, and told in CHANGELOG.md.
#[test]
fn encodings_of_wider_images_have_not_changed() {
    let (width, height) = (301, 259);
    let ramp = || 0..width as usize * height as usize;
    let planes = [
        Pixels::Bytes4(ramp().flat_map(|i| [i as u8, 7, (i / 3) as u8, 200]).collect()),
        Pixels::Counts(1, ramp().map(|i| (i * 7 % 2048) as u16).collect()),
        Pixels::Counts(3, ramp().flat_map(|i| [(i % 2048) as u16, 9, 2047]).collect()),
        Pixels::Counts(4, ramp().flat_map(|i| [(i % 2048) as u16, 9, 0, 40]).collect()),
        Pixels::Radiance(1, ramp().map(|i| i as f32 * 0.01).collect()),
        Pixels::Radiance(3, ramp().flat_map(|i| [i as f32 * 0.01, 3.5, 0.0]).collect()),
        Pixels::Radiance(4, ramp().flat_map(|i| [i as f32 * 0.01, 3.5, 0.0, 90.0]).collect()),
    ];
    let found = planes.map(|pixels| {
        let plane = Plane { width, height, pixels };
        let short = |hash: blake3::Hash| hash.to_hex()[..16].to_owned();
        (short(blake3::hash(&plane.encode().expect("it fits its size"))), short(plane.pixel_hash()))
    });
    let expected = ENCODINGS.map(|(file, pixels)| (file.to_owned(), pixels.to_owned()));
    assert_eq!(found, expected);
}

const ENCODINGS: [(&str, &str); 7] = [
    ("3abbebf5e50b8878", "e0283d60f0368659"),
    ("4c1ef3bc7910ad2d", "039c7192b48f001b"),
    ("fd5bf77372ff4dec", "66dcc2006bea28c4"),
    ("653b030915f47a6a", "e021f68f7c61f672"),
    ("bd061d551ec25315", "a8d78b278c372556"),
    ("53c0058c4566823d", "6a57017654e03f9c"),
    ("774a36aabbf0d736", "9e4f9cfc67e1ce0e"),
];

/// Error of a pixel's mean against 1,024 samples, in units of the image's mean: what docs/images.md states.
#[test]
#[ignore = "minutes without optimisation: run by ./check --long"]
fn more_samples_err_less() {
    for name in Region::NAMES {
        let region = Region::by_name(name).expect("registered").with_radius_m(80.0);
        let scene = region.build(3);
        let tracer = Tracer::new(&scene);
        let light = Light::of(&tracer, &noon());
        let shot = |samples: u32| {
            let image = render(&tracer, &nadir(64), &light, of(Sensor::LINEAR, samples), &SeedPath::root("spp", 1));
            channel(&image, 1)
        };
        let reference = shot(1024);
        let scale = mean(&reference);
        let errors = [1, 4, 16, 64].map(|samples| {
            let mut differences: Vec<f64> = shot(samples).iter().zip(&reference).map(|(a, b)| (a - b).abs()).collect();
            let rms = (differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt() / scale;
            differences.sort_by(f64::total_cmp);
            let median = differences[differences.len() / 2] / scale;
            eprintln!("{name}, {samples} samples: rms {rms:.4}, median {median:.4} of the mean radiance");
            rms
        });
        for pair in errors.windows(2) {
            // Four times the samples at least halve the error, if they were independent; strata do better.
            assert!(pair[1] < 0.62 * pair[0], "{name}: {errors:?}");
        }
    }
}

/// What the shared lattice errs against sampling at each point, radiance at the sensor in means of 2 x 2 pixels: what
/// docs/images.md states. The reference's own noise is in the figures.
#[test]
#[ignore = "minutes without optimisation: run by ./check --long"]
fn the_lattice_errs_little() {
    for (name, seed) in [("canyon", 7), ("toronto", 3)] {
        let region = Region::by_name(name).expect("registered").with_radius_m(120.0);
        let scene = region.build(seed);
        let tracer = Tracer::new(&scene);
        let plain = Light::of(&tracer, &noon());
        let shared = plain.clone().with_ambient(AmbientMode::PerScene, scene.full_detail_radius_m);
        let cameras = pair_of_cameras(256);
        for (side, camera) in ["left", "right"].into_iter().zip(cameras) {
            let shot = |light: &Light| {
                let image = render(&tracer, &camera, light, of(Sensor::LINEAR, 64), &SeedPath::root("lattice", 1));
                let values = channel(&image, 1);
                let square = |i: usize| {
                    let (u, v) = (2 * (i % 128), 2 * (i / 128));
                    [0, 1, 256, 257].map(|k| values[v * 256 + u + k]).iter().sum::<f64>() / 4.0
                };
                (0..128 * 128).map(square).collect::<Vec<f64>>()
            };
            let reference = shot(&plain);
            let mut pairs: Vec<(f64, f64)> =
                shot(&shared).iter().zip(&reference).map(|(found, truth)| (*truth, found / truth - 1.0)).collect();
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let errors: Vec<f64> = pairs.iter().map(|(_, error)| *error).collect();
            let rms = |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            let dark = &errors[..errors.len() / 4];
            let mut sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let tail = sizes[sizes.len() * 99 / 100];
            let percent = |x: f64| 100.0 * x;
            eprintln!(
                "{name} {seed}, {side}: mean {:.2} %, rms {:.2} %; darkest quarter {:.2} %, {:.2} %; 99th percentile {:.1} %",
                percent(mean(&errors)),
                percent(rms(&errors)),
                percent(mean(dark)),
                percent(rms(dark)),
                percent(tail)
            );
            assert!(mean(&errors).abs() < 0.01 && rms(&errors) < 0.05 && mean(dark).abs() < 0.02);
        }
    }
}
