//! Train, val and test.

use super::{PairSpec, SceneSpec};
use crate::recipe::{Recipe, SplitRule};
use satseed_scene::SeedPath;
use std::collections::BTreeMap;

/// A part of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Split {
    /// For training.
    Train,
    /// For choosing among trained nets.
    Val,
    /// For judging them.
    Test,
}

impl Split {
    /// All three, in the order of their discriminants.
    pub const ALL: [Self; 3] = [Self::Train, Self::Val, Self::Test];

    /// `train`, `val` or `test`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Val => "val",
            Self::Test => "test",
        }
    }
}

/// The published composition: 6,646 train, 500 val, 2,854 test pairs (Kim et al., CVPR-W `EarthVision` 2026).
const PUBLISHED: [u64; 3] = [6646, 500, 2854];

/// Gives every pair its split and returns what should be said aloud.
pub(super) fn deal(recipe: &Recipe, scenes: &mut [SceneSpec]) -> Vec<String> {
    let path = SeedPath::root("split", recipe.seed());
    let mut notes = match recipe.split() {
        SplitRule::Published => {
            published(scenes, &path);
            Vec::new()
        }
        SplitRule::ByPivot => by_pivot(scenes, &path),
    };
    let mut counts = [0_usize; 3];
    for pair in scenes.iter().flat_map(|scene| &scene.pairs) {
        counts[pair.split as usize] += 1;
    }
    for split in Split::ALL {
        if counts[split as usize] == 0 {
            notes.push(format!("split {} stays empty", split.word()));
        }
    }
    notes
}

/// `n` in the proportions of `weights`, by largest remainders; ties go to the first. Exact at the published 10,000.
fn apportion(n: u64, weights: [u64; 3]) -> [u64; 3] {
    let total: u64 = weights.iter().sum();
    if total == 0 {
        return [n, 0, 0];
    }
    let mut parts = weights.map(|w| n * w / total);
    let mut order = [0, 1, 2];
    order.sort_by_key(|i| (std::cmp::Reverse(n * weights[*i] % total), *i));
    let left = n - parts.iter().sum::<u64>();
    for i in order.into_iter().take(left as usize) {
        parts[i] += 1;
    }
    parts
}

/// What a pivot's split is drawn by: its region and seed and no other parameter, so that in an ablation every cell has
/// the same pivots in the same splits, and none is trained on that another is tested with.
fn pivot(path: &SeedPath, scene: &SceneSpec) -> SeedPath {
    path.child(scene.region.name()).index(scene.seed)
}

/// Exact counts, drawn pair by pair: the order is that of hashes keyed by the pairs' pivots and names.
fn published(scenes: &mut [SceneSpec], path: &SeedPath) {
    let key =
        |scene: &SceneSpec, pair: &PairSpec| (pivot(path, scene).child(pair.folder()).hash_u64(), pair.id.clone());
    let keyed = |scene: &SceneSpec| scene.pairs.iter().map(|pair| key(scene, pair)).collect::<Vec<_>>();
    let keys: Vec<_> = scenes.iter().flat_map(keyed).collect();
    let mut pairs: Vec<_> = keys.into_iter().zip(scenes.iter_mut().flat_map(|scene| &mut scene.pairs)).collect();
    pairs.sort_by(|(a, _), (b, _)| a.cmp(b));
    let counts = apportion(pairs.len() as u64, PUBLISHED);
    let splits = Split::ALL.into_iter().zip(counts).flat_map(|(split, n)| std::iter::repeat_n(split, n as usize));
    for ((_, pair), split) in pairs.into_iter().zip(splits) {
        pair.split = split;
    }
}

/// Whole pivots. All pivots of a recipe have equally many pairs, so pivots are counted instead of pairs.
///
/// The counts over all regions are the nearest to the published shares. Regions follow each other from the one with most
/// pivots to the one with fewest, and each takes its part of what is left, so that large regions stand in every split and
/// single pivots fill the gaps; equal ones follow each other as the seed has it.
fn by_pivot(scenes: &mut [SceneSpec], path: &SeedPath) -> Vec<String> {
    let mut left = apportion(scenes.len() as u64, PUBLISHED);
    let mut regions: BTreeMap<&'static str, Vec<&mut SceneSpec>> = BTreeMap::new();
    for scene in scenes {
        regions.entry(scene.region.name()).or_default().push(scene);
    }
    let mut regions: Vec<_> = regions.into_iter().collect();
    regions.sort_by_cached_key(|(name, pivots)| {
        (std::cmp::Reverse(pivots.len()), path.child("region").child(name).hash_u64(), *name)
    });
    let mut alone = Vec::new();
    for (name, mut pivots) in regions {
        pivots.sort_by_cached_key(|scene| (pivot(path, scene).hash_u64(), scene.name.clone()));
        let parts = apportion(pivots.len() as u64, left);
        let splits = Split::ALL.into_iter().zip(parts).flat_map(|(split, n)| std::iter::repeat_n(split, n as usize));
        let single = pivots.len() == 1;
        for (scene, split) in pivots.into_iter().zip(splits) {
            left[split as usize] -= 1;
            for pair in &mut scene.pairs {
                pair.split = split;
            }
            if single {
                alone.push((name, split));
            }
        }
    }
    alone.sort_unstable();
    let note = |(name, split): (&str, Split)| {
        format!("region {name} has one pivot, which falls into {} alone (rule by-pivot)", split.word())
    };
    alone.into_iter().map(note).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_counts_are_exact_and_scale() {
        assert_eq!(apportion(10_000, PUBLISHED), [6646, 500, 2854]);
        assert_eq!(apportion(25, PUBLISHED), [17, 1, 7]);
        assert_eq!(apportion(2, PUBLISHED), [1, 0, 1]);
        assert_eq!(apportion(0, PUBLISHED), [0, 0, 0]);
        for n in 0..2000 {
            let parts = apportion(n, PUBLISHED);
            assert_eq!(parts.iter().sum::<u64>(), n);
            for (part, weight) in parts.iter().zip(PUBLISHED) {
                let exact = n as f64 * weight as f64 / 10_000.0;
                assert!((*part as f64 - exact).abs() < 1.0, "{n}: {parts:?}");
            }
        }
    }
}
