//! Left-right consistency: what both cameras see, both find at the same place.

use super::brute::{Everything, expand, in_band};
use super::scenes::{ALTITUDES_M, FAMILIES, member, pair, town};
use rayon::prelude::*;
use satseed::camera::StereoRig;
use satseed::labels::{Validity, View, explain};
use satseed_scene::{Ray, Scene};
use satseed_tracer::Tracer;

/// Most that a point found again may be off, px.
const WITHIN_PX: f64 = 1e-6;

/// Every Valid pixel's point is found again from the other camera. Gives (Valid pixels, worst distance, lost beside an
/// edge); anything else that is lost fails.
fn found_again(scene: &Scene, rig: &StereoRig, view: View) -> (u64, f64, u64) {
    let tracer = Tracer::new(scene);
    let (camera, other) = view.cameras(rig);
    let rows: Vec<(u64, f64, u64)> = (0..camera.height_px)
        .into_par_iter()
        .map(|v| {
            let (mut valid, mut worst, mut lost) = (0, 0.0_f64, 0);
            for u in 0..camera.width_px {
                let e = explain(&tracer, rig, view, [u, v]);
                if e.validity != Validity::Valid {
                    continue;
                }
                valid += 1;
                let seen = e.seen.expect("valid");
                let there = e.in_other_px.expect("valid");
                assert!(other.in_frame(there));
                let ray: Ray = other.ray(there.x, there.y);
                let back = tracer.closest(&ray, 1e7).and_then(|hit| camera.project(hit.point));
                let off = back.map_or(f64::INFINITY, |b| (b - glam::DVec2::new(u.into(), v.into())).length());
                if off <= WITHIN_PX {
                    worst = worst.max(off);
                } else {
                    let all = Everything(expand(scene));
                    assert!(
                        in_band(&all, rig, view, [u, v], &[seen.point_m]),
                        "{view:?} ({u}, {v}) is seen at {} and found again {off} px away",
                        seen.point_m
                    );
                    lost += 1;
                }
            }
            (valid, worst, lost)
        })
        .collect();
    rows.into_iter().fold((0, 0.0, 0), |a, b| (a.0 + b.0, a.1.max(b.1), a.2 + b.2))
}

#[allow(clippy::print_stderr, reason = "the counts are part of the proof")]
fn prove(what: &str, scene: &Scene, rig: &StereoRig) {
    for view in [View::Left, View::Right] {
        let (valid, worst, lost) = found_again(scene, rig, view);
        eprintln!(
            "{what}, {view:?}: {valid} valid pixels found again within {worst:.1e} px, {lost} lost beside an edge"
        );
        assert!(valid > 0);
        assert!(lost as f64 <= 1e-4 * valid as f64, "{lost} of {valid} lost beside an edge");
    }
}

#[test]
fn valid_points_are_found_again() {
    let scene = town(11, 128, 0.8, 120);
    for altitude_m in ALTITUDES_M {
        prove(&format!("town at {altitude_m} m"), &scene, &pair(altitude_m, [256, 256], 0.77));
    }
}

#[test]
fn valid_points_of_hard_scenes_are_found_again() {
    let names = ["soup", "height fields", "same surface twice", "turned and scaled instances", "closed solids"];
    for family in FAMILIES.iter().filter(|f| names.contains(&f.name)) {
        let (scene, rig) = member(family, 3, ALTITUDES_M[0]);
        prove(family.name, &scene, &rig);
    }
}
