//! `satseed preview`

use super::Exit;
use super::args::{PreviewArgs, View};
use super::new_file::NewFile;
use super::one_scene::OneScene;
use glam::DVec3;
use satseed::camera::{Camera, Datum, RigSpec, StereoRig};
use satseed::dataset::formats::{Pixels, Plane};
use satseed::recipe::Recipe;
use satseed::render::{AmbientMode, Light, render};
use satseed_scene::SeedPath;
use satseed_tracer::Tracer;

pub(crate) fn run(args: &PreviewArgs) -> anyhow::Result<Exit> {
    let OneScene { recipe, spec } = OneScene::of(&args.scene, &[])?;
    let (region, seed) = (&spec.region, spec.seed);
    let output = NewFile::create(&args.output)?;
    let scene = region.build(seed);
    let (held, placed) = scene.triangle_counts();
    tracing::info!(region = region.name(), seed, triangles = held, placed, "scene built");
    let tracer = Tracer::new(&scene);
    let radius_m = region.full_detail_radius_m();
    let (camera, ambient) = match args.view {
        View::Nadir => (nadir(&recipe, scene.pivot_height_m, args.size), recipe.light().ambient),
        // Each pixel of a wide view lies at a place of its own: there is nothing to share.
        View::Oblique => (oblique(&tracer, scene.pivot_height_m, radius_m, args.size), AmbientMode::PerSample),
    };
    let noise = SeedPath::root("sensor", seed).child("preview");
    let light = Light::of(&tracer, &recipe.light().into()).with_ambient(ambient, radius_m);
    let mut settings = recipe.sensor().settings();
    settings.sensor = settings.sensor.for_the_eye();
    let image = render(&tracer, &camera, &light, settings, &noise);
    let bytes = image.bytes().to_vec();
    let pixels = if image.channels == 1 { Pixels::Gray(bytes) } else { Pixels::Rgb(bytes) };
    let picture = Plane { width: image.width, height: image.height, pixels };
    output.finish(&picture.encode()?)?;
    Ok(Exit::Fine)
}

/// The recipe's camera over the pivot, north up, as many pixels as asked for.
fn nadir(recipe: &Recipe, pivot_height_m: f64, size_px: u32) -> Camera {
    // A rig without baseline, its right towards the east.
    let rig = StereoRig::new(RigSpec {
        altitude_m: recipe.camera().altitude_m,
        gsd_m: recipe.camera().gsd_m,
        size_px: [size_px; 2],
        baseline_m: 0.0,
        azimuth_rad: core::f64::consts::FRAC_PI_2,
        pivot_along_baseline: 0.5,
        pivot_m: DVec3::new(0.0, 0.0, pivot_height_m),
        datum: Datum::None,
    });
    rig.left
}

/// From the south-west, so that the whole of the full detail is seen; above anything that stands there.
fn oblique(tracer: &Tracer, pivot_height_m: f64, radius_m: f64, size_px: u32) -> Camera {
    let pivot_m = DVec3::new(0.0, 0.0, pivot_height_m);
    let mut eye_m = pivot_m + DVec3::new(-0.62, -0.83, 0.75) * radius_m;
    let above = satseed_scene::Ray { origin: eye_m.with_z(20_000.0), direction: DVec3::NEG_Z };
    if let Some(hit) = tracer.closest(&above, 40_000.0) {
        eye_m.z = eye_m.z.max(hit.point.z + 0.1 * radius_m);
    }
    Camera::looking_at(eye_m, pivot_m, [size_px; 2], f64::from(size_px) * 0.9)
}
