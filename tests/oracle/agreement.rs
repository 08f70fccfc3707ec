//! The tracer's labels against brute force on hundreds of small scenes, and the bin oracle against brute force.

use super::bins::Bins;
use super::brute::{Everything, expand};
use super::compare::{Outcome, compare};
use super::scenes::{ALTITUDES_M, FAMILIES, Family, member};
use satseed_tracer::Tracer;

fn prove(family: &Family, seeds: u64) -> Outcome {
    let mut total = Outcome::default();
    for altitude_m in ALTITUDES_M {
        let mut part = Outcome::default();
        for seed in 0..seeds {
            let (scene, rig) = member(family, seed, altitude_m);
            let rows = 0..rig.left.height_px;
            part.add(compare(&Everything(expand(&scene)), &Tracer::new(&scene), &rig, rows));
        }
        part.print(&format!("{} x {seeds} at {altitude_m} m", family.name));
        total.add(part);
    }
    total
}

/// 12 families x 2 altitudes x 9 seeds = 216 scenes.
#[test]
fn small_scenes_agree_with_brute_force() {
    let mut failed = Vec::new();
    for family in &FAMILIES {
        let outcome = prove(family, 9);
        if outcome.wrong > 0 {
            failed.push(format!("{}: {} wrong; {}", family.name, outcome.wrong, outcome.first.unwrap_or_default()));
        } else {
            outcome.demand(family.most_in_band);
        }
        assert!(outcome.by_validity[1] > 0, "{}: some pixels must be valid", family.name);
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

/// The same with a hundred seeds.
#[test]
#[ignore = "long: 2,400 scenes"]
fn many_small_scenes_agree_with_brute_force() {
    for family in &FAMILIES {
        prove(family, 100).demand(family.most_in_band);
    }
}

/// The bin oracle gives what brute force gives, bit by bit.
#[test]
fn bins_lose_nothing() {
    for family in &FAMILIES {
        let (scene, rig) = member(family, 77, ALTITUDES_M[0]);
        let all = Everything(expand(&scene));
        for rows in [0..17, 17..rig.left.height_px] {
            let bins = Bins::new(&scene, &rig, rows.clone());
            for view in super::compare::VIEWS {
                for pixel in rows.clone().flat_map(|v| (0..rig.left.width_px).map(move |u| [u, v])) {
                    let a = super::brute::answer(&all, &rig, view, pixel);
                    let b = super::brute::answer(&bins, &rig, view, pixel);
                    let key = |x: &super::brute::Answer| {
                        (x.hit.map(|t| t.id()), x.validity, x.disparity_px.to_bits(), x.t.to_bits())
                    };
                    assert_eq!(key(&a), key(&b), "{}: {view:?} {pixel:?}", family.name);
                }
            }
        }
    }
}
