//! The pairs of one pivot: baselines crossed with azimuths, drawn by the pivot's own seed.

use super::{PairSpec, Split};
use crate::recipe::{Acquisition, Azimuths, PivotAlongBaseline, Recipe, Region};
use satseed_scene::SeedPath;

/// How many pairs every pivot has.
pub(super) fn per_pivot(acquisition: &Acquisition) -> u64 {
    let crossed = u64::from(acquisition.baselines.count()) * u64::from(acquisition.azimuths.count());
    acquisition.pairs_per_pivot.map_or(crossed, |n| crossed.min(u64::from(n)))
}

/// The pairs of a pivot. What is drawn depends on region, variant and scene seed, not on the scene's other parameters:
/// scenes that differ in one parameter are seen from the same places, and each pivot of a recipe from its own.
pub(super) fn of_pivot(recipe: &Recipe, region: &Region, seed: u64, scene: &str) -> Vec<PairSpec> {
    let acquisition = recipe.acquisition();
    let mut path = SeedPath::root("acquisition", seed).child(region.name());
    // The usual variant has the draws of its region, as when variants were no part of the key.
    if Region::by_name(region.name()).is_none_or(|usual| usual.variant() != region.variant()) {
        path = path.child("variant").child(region.variant());
    }
    let baselines_m = acquisition.baselines.lengths_m(recipe.camera().altitude_m);
    let azimuths_deg = azimuths_deg(&acquisition.azimuths, &path);
    chosen(acquisition, &path)
        .into_iter()
        .map(|(b, a)| PairSpec {
            id: format!("{scene}/b{b:02}-a{a:02}"),
            baseline_step: b,
            baseline_m: baselines_m[b as usize],
            azimuth_index: a,
            azimuth_deg: azimuths_deg[a as usize],
            pivot_along_baseline: match acquisition.pivot_along_baseline {
                PivotAlongBaseline::Fixed(t) => t,
                PivotAlongBaseline::Random => {
                    let path = path.child("pivot_along_baseline").index(u64::from(b)).index(u64::from(a));
                    rounded(path.rng().unit())
                }
            },
            split: Split::Train,
        })
        .collect()
}

/// Draws are rounded to 1/1000, so that a plan prints what it means.
fn rounded(x: f64) -> f64 {
    libm::floor(x * 1000.0 + 0.5) / 1000.0
}

fn azimuths_deg(azimuths: &Azimuths, path: &SeedPath) -> Vec<f64> {
    match azimuths {
        Azimuths::List(values) => values.clone(),
        Azimuths::Drawn { from_deg, to_deg, draws } => (0..u64::from(*draws))
            .map(|i| {
                // Each by its own key: more draws leave the first ones as they are.
                let x = path.child("azimuth").index(i).rng().range(*from_deg, *to_deg);
                rounded(x).clamp(*from_deg, *to_deg)
            })
            .collect(),
    }
}

/// Baseline step and azimuth index of every pair, in order.
fn chosen(acquisition: &Acquisition, path: &SeedPath) -> Vec<(u32, u32)> {
    let (steps, draws) = (acquisition.baselines.count(), acquisition.azimuths.count());
    let Some(n) = acquisition.pairs_per_pivot else {
        return (0..steps).flat_map(|b| (0..draws).map(move |a| (b, a))).collect();
    };
    // Along the diagonals of a shuffled table: n pairs spread over as many baselines and azimuths as there are.
    let (mut rows, mut columns): (Vec<u32>, Vec<u32>) = ((0..steps).collect(), (0..draws).collect());
    path.child("choice").child("baseline").rng().shuffle(&mut rows);
    path.child("choice").child("azimuth").rng().shuffle(&mut columns);
    let diagonals = (0..draws).flat_map(|j| (0..steps).map(move |r| (r, (r + j) % draws)));
    let mut pairs: Vec<_> = diagonals.take(n as usize).map(|(r, c)| (rows[r as usize], columns[c as usize])).collect();
    pairs.sort_unstable();
    pairs
}
