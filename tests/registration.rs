//! Pictures and labels are registered: the right image, fetched by the left disparity, lies on the left image to
//! 0.02 px in both axes.
//!
//! The shift is what least-squares matching finds ([`registration::matching`]), with gain and offset of its own in every
//! window of 32 px, since the two views look through different air. Only Valid pixels count, away from mirrors and from
//! steps of depth, where optics mix what has no one disparity.

#![allow(clippy::print_stderr, reason = "the numbers are part of the proof")]

mod registration {
    pub(crate) mod matching;
}
mod support;

use glam::{DAffine3, DVec2, DVec3};
use registration::matching::{Counted, Grey, Levels, Match, matched};
use satseed::camera::{Camera, Datum, StereoRig};
use satseed::labels::{Extra, View, ViewLabels, extract};
use satseed::render::sensor::ImagePixels;
use satseed::render::{AmbientMode, Image, Light, Sensor, Settings, develop, expose};
use satseed_generators::Region;
use satseed_scene::{
    Bands, Class, Environment, Field, Fractal, Layer, Material, Scene, SeedPath, Space, gradient_noise_2d,
};
use satseed_tracer::{Hit, Tracer};
use support::solids::{cuboid, grid};
use support::stage::{RigCase, Stage, noon};

/// Steps of disparity that matching stays away from, px: here 0.2 m of height.
const STEP_PX: f64 = 0.1;

/// A scene under light.
struct Lit<'s> {
    tracer: Tracer<'s>,
    light: Light,
    sun: Environment,
}

/// Two pictures and what may be matched in them.
struct Pair {
    left: Grey,
    right: Grey,
    labels: ViewLabels,
    matt: Vec<bool>,
}

impl<'s> Lit<'s> {
    fn new(scene: &'s Scene) -> Self {
        let (tracer, sun) = (Tracer::new(scene), noon());
        let light = Light::of(&tracer, &sun).with_ambient(AmbientMode::PerScene, scene.full_detail_radius_m);
        Self { tracer, light, sun }
    }

    /// Both pictures, 16 samples a pixel.
    fn shot(&self, cameras: [&Camera; 2], sensor: Sensor) -> [Image; 2] {
        let settings = Settings { samples_per_pixel: 16, sensor };
        let sides = cameras.into_iter().zip(["left", "right"]);
        let exposures =
            sides.map(|(camera, side)| expose(&self.tracer, camera, &self.light, settings, &SeedPath::root(side, 5)));
        let images = develop(exposures.collect(), sensor);
        images.try_into().unwrap_or_else(|_| panic!("two views"))
    }

    /// A pair whose right picture is taken with its lens moved by `-planted_px`: what the labels do not know.
    fn pair(&self, rig: &StereoRig, sensor: Sensor, planted_px: DVec2) -> Pair {
        let mut moved = rig.right;
        moved.cx_px -= planted_px.x;
        moved.cy_px -= planted_px.y;
        let [left, right] = self.shot([&rig.left, &moved], sensor).map(|image| Grey::of(&image));
        let extra = Extra { edge: true, ..Extra::default() };
        let labels = extract(&self.tracer, rig, View::Left, &self.sun, extra);
        Pair { left, right, labels, matt: self.matt(&rig.left) }
    }

    /// Pixels whose surface is no mirror: what a coat or water shows has a parallax of its own.
    fn matt(&self, camera: &Camera) -> Vec<bool> {
        let ray = |v: u32| move |u: u32| camera.ray(f64::from(u), f64::from(v));
        let rays: Vec<_> = (0..camera.height_px).flat_map(|v| (0..camera.width_px).map(ray(v))).collect();
        let material = |hit: Hit| self.tracer.scene().material(hit.instance, hit.triangle);
        let hits = self.tracer.closest_all(&rays).into_iter();
        hits.map(|hit| hit.is_some_and(|hit| material(hit).brdf.mirror_index().is_none())).collect()
    }
}

impl Pair {
    fn counted(&self, step_px: f64) -> Counted<'_> {
        Counted { labels: &self.labels, matt: &self.matt, step_px }
    }

    fn matched(&self) -> Match {
        matched(&self.left, &self.right, self.counted(STEP_PX), Levels::Fitted)
    }
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

/// The shift of a pair, told and held against a bound, px.
fn prove(what: &str, found: Match, least: usize, bound_px: f64) {
    let Match { shift_px, textured } = found;
    eprintln!("{what}: shift ({:+.4}, {:+.4}) px over {textured} pixels", shift_px.x, shift_px.y);
    assert!(textured >= least, "{what}: only {textured} pixels have texture");
    assert!(shift_px.abs().max_element() <= bound_px, "{what}: off by {shift_px} px");
}

#[test]
fn pictures_and_labels_are_registered() {
    let scene = textured();
    let lit = Lit::new(&scene);
    for (azimuth_rad, sensor) in [(0.4, Sensor::IDEAL), (-1.1, Sensor::WORLDVIEW3_RGB)] {
        let rig = rig(azimuth_rad, 0.0, 160);
        let found = lit.pair(&rig, sensor, DVec2::ZERO).matched();
        prove(&format!("textured, azimuth {azimuth_rad}"), found, 5000, 0.005);
        // The measure itself: it sees what a lens was moved by, whatever gain and offset the right picture has.
        for planted in [DVec2::new(0.05, 0.0), DVec2::new(-0.1, 0.0), DVec2::new(0.03, -0.05)] {
            let pair = lit.pair(&rig, sensor, planted);
            for (gain, offset) in [(1.0, 0.0), (1.05, 8.0), (0.95, -8.0)] {
                let right = pair.right.map(|x| gain * x + offset);
                let seen = matched(&pair.left, &right, pair.counted(STEP_PX), Levels::Fitted).shift_px - found.shift_px;
                let off = (seen - planted).abs().max_element();
                assert!(off < 0.003, "{planted} under gain {gain} and offset {offset} is seen as {seen}");
            }
        }
    }
}

/// Views from both sides look through air that the sun lights differently, and a picture's shadows all end on one side: so
/// unequal grey values alone read as a shift. Without the air they do not, and fitted levels find none in either.
#[test]
#[ignore = "long: run by ./check --long"]
fn air_is_no_shift() {
    let region = Region::by_name("canyon").expect("registered").with_radius_m(80.0);
    let scene = region.build(12);
    let lit = Lit::new(&scene);
    let pivot_m = DVec3::new(0.0, 0.0, scene.pivot_height_m);
    let rig = rig(-0.5, scene.pivot_height_m, 256);
    let mut pair = lit.pair(&rig, Sensor::LINEAR, DVec2::ZERO);
    let cameras = [&rig.left, &rig.right];
    let images = lit.shot(cameras, Sensor::LINEAR);
    let mut shifts = Vec::new();
    for with_air in [true, false] {
        // Blue, in which there is most air: the first of the scene's bands, the last of three in a pixel.
        let blue = |k: usize| -> Vec<f32> {
            let ImagePixels::Radiance(values) = &images[k].pixels else { panic!("asked for radiance") };
            let veil = lit.light.veil((cameras[k].position_m - pivot_m).normalize());
            let bare = |value: &f32| if with_air { *value } else { (value - veil.added[0]) / veil.direct[0] };
            values.iter().skip(2).step_by(3).map(bare).collect()
        };
        let views = [blue(0), blue(1)];
        // As pictures of 8 bits: from the dark end of both views, through a square root.
        let mut all = views.concat();
        all.sort_by(f32::total_cmp);
        let (dark, bright) = (all[all.len() * 3 / 1000], all[all.len() * 996 / 1000]);
        let tone = |value: &f32| 255.0 * ((value - dark) / (bright - dark)).clamp(0.0, 1.0).sqrt();
        let grey = |values: &Vec<f32>| Grey { data: values.iter().map(|x| f64::from(tone(x))).collect(), ..pair.left };
        [pair.left, pair.right] = views.each_ref().map(grey);
        for levels in [Levels::Equal, Levels::Fitted] {
            let found = matched(&pair.left, &pair.right, pair.counted(1.0), levels).shift_px;
            eprintln!("canyon, air {with_air}, levels {levels:?}: shift ({:+.4}, {:+.4}) px", found.x, found.y);
            shifts.push(found.abs().max_element());
        }
    }
    assert!(shifts[0] > 0.03, "the air reads as a shift: {shifts:?}");
    assert!(shifts[1..].iter().all(|s| *s <= 0.02), "nothing is left without it: {shifts:?}");
}

/// All regions, with their mirrors.
fn regions(azimuths_rad: impl Fn(&str) -> &'static [f64]) {
    for name in Region::NAMES {
        let region = Region::by_name(name).expect("registered").with_radius_m(80.0);
        // Where a coast's frame of 77 m holds its shore: on water alone there are only mirrors.
        let scene = region.build(if *name == "coast" { 1 } else { 12 });
        let lit = Lit::new(&scene);
        // In a wood nothing but steps is seen: those that the edge label names are left out.
        let step_px = if *name == "forest" { 1.0 } else { STEP_PX };
        for azimuth_rad in azimuths_rad(name) {
            let rig = rig(*azimuth_rad, scene.pivot_height_m, 256);
            let pair = lit.pair(&rig, Sensor::WORLDVIEW3_RGB, DVec2::ZERO);
            let found = matched(&pair.left, &pair.right, pair.counted(step_px), Levels::Fitted);
            let Match { shift_px, .. } = matched(&pair.left, &pair.right, pair.counted(1.0), Levels::Equal);
            eprintln!("{name}: with low steps and equal levels ({:+.4}, {:+.4}) px", shift_px.x, shift_px.y);
            prove(&format!("{name}, azimuth {azimuth_rad}"), found, 2000, 0.02);
        }
    }
}

#[test]
fn pictures_and_labels_of_regions_are_registered() {
    regions(|_| &[0.8]);
}

#[test]
#[ignore = "long: run by ./check --long"]
fn regions_are_registered_from_all_sides() {
    regions(|_| &[-1.1, -0.5, 0.1, 0.8, 1.4]);
}
