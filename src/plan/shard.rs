//! A plan dealt to several machines.

use super::cost::{Costs, SceneCost};
use super::{Plan, SceneSpec};
use crate::recipe::Recipe;
use std::ops::Range;
use std::str::FromStr;

/// One part of a plan's pairs, `I/N` with I from 1 to N.
///
/// Pairs are dealt in runs of plan order, so that a scene is built by as few shards as possible, and of equal cost as the
/// table of [`Costs`] has it, a scene's own included for each shard that has pairs of it: the dearest shard is as cheap
/// as runs allow. All shards together hold every pair once, whatever N is; where N is large the last ones may be empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

/// Most shards of a plan.
pub const MAX_SHARDS: u32 = 100_000;

/// What a shard has to do of one scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Share {
    /// Index into [`Plan::scenes`].
    pub scene: usize,
    /// Indices into the scene's pairs.
    pub pairs: Range<usize>,
}

/// A text that is no shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a shard is I/N with 1 <= I <= N <= 100000, such as 2/8, not \"{0}\"")]
pub struct ShardError(String);

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let parse = || {
            let (index, count) = text.split_once('/')?;
            let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit()).then(|| s.parse::<u32>().ok())?;
            let (index, count) = (digits(index)?, digits(count)?);
            Self::new(index, count)
        };
        parse().ok_or_else(|| ShardError(text.chars().take(40).collect()))
    }
}

impl Shard {
    /// The only shard of one.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Shard `index` of `count`, from 1; none where there is no such shard.
    pub fn new(index: u32, count: u32) -> Option<Self> {
        (1 <= index && index <= count && count <= MAX_SHARDS).then_some(Self { index, count })
    }

    /// Whether it is all of the plan.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }

    /// The shard's pairs, scene by scene in plan order: the recipe is that of the plan.
    pub fn of(self, recipe: &Recipe, plan: &Plan) -> Vec<Share> {
        if self.is_whole() {
            let whole = |(scene, spec): (usize, &SceneSpec)| Share { scene, pairs: 0..spec.pairs.len() };
            return plan.scenes.iter().enumerate().map(whole).filter(|share| !share.pairs.is_empty()).collect();
        }
        let costs = Costs::of(recipe);
        let scenes: Vec<_> = plan.scenes.iter().map(|spec| (costs.scene(spec), spec.pairs.len())).collect();
        let most_ms = least_most_ms(&scenes, self.count);
        let mut shares = Vec::new();
        deal(&scenes, most_ms, &mut |shard, share| {
            if shard == self.index - 1 {
                shares.push(share);
            }
            shard < self.index
        });
        shares
    }
}

/// The least that the dearest of `count` shards can cost, ms.
fn least_most_ms(scenes: &[(SceneCost, usize)], count: u32) -> u64 {
    let one_pair = scenes.iter().map(|(cost, _)| cost.of_pairs(1)).max().unwrap_or(0);
    let all: u64 = scenes.iter().map(|(cost, pairs)| cost.of_pairs(*pairs)).sum();
    let fits = |most_ms| {
        let mut fits = true;
        deal(scenes, most_ms, &mut |shard, _| {
            fits = shard < count;
            fits
        });
        fits
    };
    let (mut low, mut high) = (one_pair, all.max(one_pair));
    while low < high {
        let middle = low + (high - low) / 2;
        if fits(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// Fills shard after shard up to `most_ms`, at least what any scene with one pair costs. `each` is told every share with
/// the number of its shard, from 0, and says whether to go on.
fn deal(scenes: &[(SceneCost, usize)], most_ms: u64, each: &mut dyn FnMut(u32, Share) -> bool) {
    let (mut shard, mut room_ms) = (0, most_ms);
    for (scene, (cost, pairs)) in scenes.iter().enumerate() {
        let mut next = 0;
        while next < *pairs {
            let fitting = room_ms.saturating_sub(cost.scene_ms) / cost.pair_ms;
            if fitting == 0 {
                (shard, room_ms) = (shard + 1, most_ms);
                continue;
            }
            let to = *pairs.min(&(next + fitting as usize));
            if !each(shard, Share { scene, pairs: next..to }) {
                return;
            }
            room_ms -= cost.of_pairs(to - next);
            next = to;
        }
    }
}
