//! Golden hashes: the bytes of a small scene and pair of each region, held in a file of their own.
//!
//! `SATSEED_BLESS=1 cargo test --test golden` writes the files anew and says what changed. A change of bytes needs a
//! raised version (the generator's, or a stage's in src/recipe/versions.rs) and an entry in CHANGELOG.md.

#![allow(clippy::print_stderr)]

use glam::DVec3;
use rayon::ThreadPoolBuilder;
use satseed::camera::{Datum, RigSpec, StereoRig};
use satseed::labels::{Extra, View, ViewLabels, extract};
use satseed::render::{AmbientMode, Light, Sensor, Settings, develop, expose};
use satseed_generators::Region;
use satseed_scene::{Environment, SeedPath};
use satseed_tracer::Tracer;
use std::fmt::Write as _;
use std::path::PathBuf;

const SEED: u64 = 7;
const RADIUS_M: f64 = 70.0;

/// A region at a size that a test can afford.
fn small(name: &str) -> Region {
    Region::by_name(name).expect("registered").with_radius_m(RADIUS_M)
}

/// What a region's file says: its version, and the hashes of scene, labels and images.
fn report(name: &str) -> String {
    let region = small(name);
    let scene = region.build(SEED);
    scene.validate().expect("a legal scene");
    let tracer = Tracer::new(&scene);
    let spec = RigSpec {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [160, 160],
        baseline_m: 150.0,
        azimuth_rad: 0.6,
        pivot_along_baseline: 0.5,
        pivot_m: DVec3::new(0.0, 0.0, scene.pivot_height_m),
        datum: Datum::Height(scene.pivot_height_m),
    };
    let rig = StereoRig::new(spec);
    let environment = Environment { sun_elevation_rad: 0.733, sun_azimuth_rad: 2.53, aerosol_optical_depth: 0.12 };
    let all = Extra { elevation: true, class: true, instance: true, normal: true, shadow: true, edge: true };
    let mut text = String::new();
    let mut line = |key: &str, bytes: &[u8]| {
        writeln!(text, "{key} {}", blake3::hash(bytes).to_hex()).expect("a string takes all");
    };
    line("scene", &scene.hash());
    let settings = Settings { samples_per_pixel: 4, sensor: Sensor::WORLDVIEW3_RGB };
    let light = Light::of(&tracer, &environment).with_ambient(AmbientMode::PerScene, scene.full_detail_radius_m);
    let sides = [("left", View::Left), ("right", View::Right)];
    let exposures = sides.map(|(side, view)| {
        let noise = SeedPath::root("golden", SEED).child(side);
        expose(&tracer, view.cameras(&rig).0, &light, settings, &noise)
    });
    for ((side, view), image) in sides.into_iter().zip(develop(exposures.into(), settings.sensor)) {
        let labels = extract(&tracer, &rig, view, &environment, all);
        line(&format!("{side} labels"), &label_bytes(&labels));
        line(&format!("{side} image"), image.bytes());
    }
    // From 16 samples on, those of a quarter of a pixel share what they can.
    let settings = Settings { samples_per_pixel: 16, ..settings };
    let rig = StereoRig::new(RigSpec { size_px: [64, 64], ..spec });
    let noise = SeedPath::root("golden", SEED).child("16");
    let exposure = expose(&tracer, View::Left.cameras(&rig).0, &light, settings, &noise);
    line("left image of 16 samples", develop(vec![exposure], settings.sensor)[0].bytes());
    format!("version {}\n{text}", region.version())
}

fn label_bytes(l: &ViewLabels) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut floats = |values: &[f32]| bytes.extend(values.iter().flat_map(|v| v.to_bits().to_le_bytes()));
    floats(&l.disparity_px);
    floats(l.elevation_m.as_ref().expect("asked for"));
    floats(l.normal.as_ref().expect("asked for").as_flattened());
    bytes.extend_from_slice(&l.validity);
    for map in [&l.class, &l.shadow, &l.edge] {
        bytes.extend_from_slice(map.as_ref().expect("asked for"));
    }
    bytes.extend(l.instance.as_ref().expect("asked for").iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn on_threads(threads: usize, name: &str) -> String {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| report(name))
}

fn golden_file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.txt"))
}

fn check(name: &str) {
    let found = on_threads(2, name);
    let path = golden_file(name);
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    if std::env::var_os("SATSEED_BLESS").is_some() {
        for (old, new) in kept.lines().zip(found.lines()).filter(|(a, b)| a != b) {
            eprintln!("{name}: {old} -> {new}");
        }
        std::fs::write(&path, &found).expect("the golden file is written");
    } else {
        assert_eq!(
            found, kept,
            "{name}: bytes changed; if that is meant, raise the generator's VERSION (scene) or a stage's in \
             src/recipe/versions.rs (labels, images), run `SATSEED_BLESS=1 cargo test --test golden`, and say why in \
             CHANGELOG.md"
        );
    }
    // The masked run has the threads' comparison behind it.
    if std::env::var_os("SATSEED_MASKED").is_some() {
        return;
    }
    assert_eq!(found, on_threads(1, name), "{name}: one thread gives other bytes than two");
}

#[test]
fn california() {
    check("california");
}

#[test]
fn canyon() {
    check("canyon");
}

#[test]
fn coast() {
    check("coast");
}

#[test]
fn desert() {
    check("desert");
}

#[test]
fn field() {
    check("field");
}

#[test]
fn forest() {
    check("forest");
}

#[test]
fn toronto() {
    check("toronto");
}

#[test]
fn venice() {
    check("venice");
}

/// The platform's libm picks other code on processors without FMA; ours must not notice. The masked run is this test
/// binary again, against the same files.
#[test]
fn without_fma() {
    if std::env::var_os("SATSEED_MASKED").is_some() || std::env::var_os("SATSEED_BLESS").is_some() {
        return;
    }
    let me = std::env::current_exe().expect("a test has a path");
    let run = std::process::Command::new(me)
        .args(["--exact", "california", "canyon", "coast", "desert", "field", "forest", "toronto", "venice"])
        .env("SATSEED_MASKED", "1")
        .env("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2_Usable,-AVX2")
        .output()
        .expect("the test binary runs");
    let text = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && text.contains("8 passed"), "{text}{}", String::from_utf8_lossy(&run.stderr));
}
