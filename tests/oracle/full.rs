//! The bin oracle on whole scenes.

use super::bins::Bins;
use super::compare::{Outcome, compare};
use super::scenes::{ALTITUDES_M, pair, town};
use glam::DVec3;
use rayon::prelude::*;
use satseed::camera::{Datum, RigSpec, StereoRig};
use satseed_generators::Region;
use satseed_scene::Scene;
use satseed_tracer::Tracer;

const BAND_ROWS: u32 = 32;

#[allow(clippy::print_stderr, reason = "the counts are part of the proof")]
fn prove(what: &str, scene: &Scene, rig: &StereoRig) -> Outcome {
    let tracer = Tracer::new(scene);
    let height = rig.left.height_px;
    let bands: Vec<(Outcome, usize, f64)> = (0..height.div_ceil(BAND_ROWS))
        .into_par_iter()
        .map(|band| {
            let rows = band * BAND_ROWS..height.min((band + 1) * BAND_ROWS);
            let bins = Bins::new(scene, rig, rows.clone());
            let (triangles, depth) = bins.load();
            (compare(&bins, &tracer, rig, rows), triangles, depth)
        })
        .collect();
    let mut total = Outcome::default();
    let (mut most, mut depth) = (0, 0.0);
    let count = bands.len() as f64;
    for (outcome, triangles, load) in bands {
        total.add(outcome);
        most = most.max(triangles);
        depth += load / count;
    }
    total.print(&format!(
        "{what}: {} triangles, at most {most} in {BAND_ROWS} rows, {depth:.1} behind a pixel",
        scene.triangle_counts().1
    ));
    total.demand(2e-5);
    total
}

#[test]
fn town_agrees_with_the_bin_oracle() {
    let scene = town(2, 320, 0.4, 150);
    assert!(scene.triangle_counts().1 > 250_000);
    for altitude_m in ALTITUDES_M {
        let total = prove(&format!("town at {altitude_m} m"), &scene, &pair(altitude_m, [256, 256], 1.2));
        assert!(total.by_validity[2] > 1000, "a town has occlusions");
    }
}

#[test]
#[ignore = "long: 8.4 million pixels"]
fn large_town_agrees_with_the_bin_oracle() {
    let scene = town(5, 1600, 0.5, 4000);
    prove("large town", &scene, &pair(1000.0, [2048, 2048], -0.4));
}

fn region_pair(scene: &Scene, size_px: u32, altitude_m: f64) -> StereoRig {
    StereoRig::new(RigSpec {
        altitude_m,
        gsd_m: 0.3,
        size_px: [size_px, size_px],
        baseline_m: 0.2 * altitude_m,
        azimuth_rad: 0.6,
        pivot_along_baseline: 0.5,
        pivot_m: DVec3::new(0.0, 0.0, scene.pivot_height_m),
        datum: Datum::Height(scene.pivot_height_m),
    })
}

/// A region whose full detail reaches `radius_m` only.
fn reduced(name: &str, radius_m: f64) -> Region {
    Region::by_name(name).expect("registered").with_radius_m(radius_m)
}

#[test]
fn regions_agree_with_the_bin_oracle() {
    for name in Region::NAMES {
        let scene = reduced(name, 80.0).build(41);
        let total = prove(&format!("{name}, reduced"), &scene, &region_pair(&scene, 192, 1000.0));
        assert_eq!(total.by_validity[0], 0, "{name}: no miss in a planned frame");
    }
}

/// 2 x 2048 x 2048 pixels of every region at full size, at 1 km and at 617 km.
#[test]
#[ignore = "long: 8.4 million pixels of each region and altitude"]
fn regions_at_full_size_agree_with_the_bin_oracle() {
    for name in Region::NAMES {
        let scene = Region::by_name(name).expect("registered").build(1);
        for altitude_m in ALTITUDES_M {
            let rig = region_pair(&scene, 2048, altitude_m);
            let total = prove(&format!("{name} at {altitude_m} m"), &scene, &rig);
            assert_eq!(total.by_validity[0], 0, "{name}: no miss in a planned frame");
        }
    }
}
