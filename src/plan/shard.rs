//! A plan dealt to several machines.

use super::Plan;
use std::ops::Range;
use std::str::FromStr;

/// One part of a plan's pairs, `I/N` with I from 1 to N.
///
/// Pairs are dealt in runs of plan order, as equal as can be, so that a scene is built by as few shards as possible. All
/// shards together hold every pair once, whatever N is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

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
            (1 <= index && index <= count && count <= 100_000).then_some(Self { index, count })
        };
        parse().ok_or_else(|| ShardError(text.chars().take(40).collect()))
    }
}

impl Shard {
    /// The only shard of one.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// The shard's pairs, scene by scene in plan order.
    pub fn of(self, plan: &Plan) -> Vec<Share> {
        let total = plan.pair_count() as u64;
        let border = |i: u32| (total * u64::from(i) / u64::from(self.count)) as usize;
        let (from, to) = (border(self.index - 1), border(self.index));
        let mut first = 0;
        let mut shares = Vec::new();
        for (scene, spec) in plan.scenes.iter().enumerate() {
            let n = spec.pairs.len();
            let pairs = from.clamp(first, first + n) - first..to.clamp(first, first + n) - first;
            if !pairs.is_empty() {
                shares.push(Share { scene, pairs });
            }
            first += n;
        }
        shares
    }
}
