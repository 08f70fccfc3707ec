//! Which scenes, which pairs, which split: a pure and cheap function of a [`Recipe`].
//!
//! Nothing here depends on threads, shards or the order of work. A scene is keyed by region, variant, parameters and
//! seed; what the camera does is no part of its key, so one scene serves every pair of its pivot.

mod cost;
mod estimate;
mod pairs;
mod reach;
mod shard;
mod split;

pub use cost::{Costs, HOW_MEASURED, Measured, RegionTotal, SceneCost, TABLE};
pub use estimate::Estimate;
pub use reach::{DatumBounds, frame_reach_m};
pub use shard::{MAX_SHARDS, Shard, ShardError, Share};
pub use split::Split;

use crate::recipe::{MAX_PIVOTS, PairGeometry, Pivots, Recipe, Region, changed_parameters, parameters_text};
use std::collections::{BTreeMap, BTreeSet};

/// Most pairs of a plan; more are refused, since a plan stands in memory.
pub const MAX_PAIRS: u64 = 1_000_000;

/// Everything that a dataset holds, before any of it is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scenes in plan order: that of the recipe.
    pub scenes: Vec<SceneSpec>,
    /// What a reader of the plan should know, one sentence each, such as a split that stays empty.
    pub notes: Vec<String>,
    /// BLAKE3 of the resolved recipe, 64 hexadecimal digits: a folder belongs to one plan.
    pub hash: String,
}

/// One scene, the acquisition centre ("pivot") of its pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpec {
    /// Name and folder: `<region>-<variant>-<seed>`, and `-<8 hex of the parameters' hash>` where they are not the
    /// variant's defaults.
    pub name: String,
    /// The region with its parameters.
    pub region: Region,
    /// The scene's own seed.
    pub seed: u64,
    /// BLAKE3 of all parameters (the variant is one of them), 64 hexadecimal digits.
    pub params_hash: String,
    /// Its pairs, by baseline step, then azimuth.
    pub pairs: Vec<PairSpec>,
}

/// One stereo pair of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct PairSpec {
    /// `<scene>/b03-a17`: baseline step 3, azimuth 17.
    pub id: String,
    /// Which of the recipe's baselines, from 0.
    pub baseline_step: u32,
    /// Distance of the cameras, m.
    pub baseline_m: f64,
    /// Which of the pivot's azimuths, from 0.
    pub azimuth_index: u32,
    /// Direction from the left to the right camera, degrees clockwise from north.
    pub azimuth_deg: f64,
    /// Where the pivot's foot stands along the baseline: 0 under the left camera, 1 under the right one.
    pub pivot_along_baseline: f64,
    /// Which part of the dataset it belongs to.
    pub split: Split,
}

impl PairSpec {
    /// What its cameras are made of, beside the recipe's `[camera]`.
    pub fn geometry(&self) -> PairGeometry {
        PairGeometry {
            baseline_m: self.baseline_m,
            azimuth_deg: self.azimuth_deg,
            pivot_along_baseline: self.pivot_along_baseline,
        }
    }

    /// The pair's folder within its scene's: `b03-a17`.
    pub fn folder(&self) -> &str {
        self.id.split_once('/').map_or(self.id.as_str(), |(_, folder)| folder)
    }
}

/// Why a recipe has no plan. Keys are named as `--set` takes them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// Too many pairs.
    #[error(
        "the recipe asks for {pairs} pairs, but a plan holds at most {MAX_PAIRS}: fewer pivots, baselines, azimuths, \
         or a smaller acquisition.pairs_per_pivot"
    )]
    TooManyPairs {
        /// How many.
        pairs: u64,
    },
    /// Two scenes would be the same.
    #[error("scene {name} stands twice in the recipe: same region, parameters and seed")]
    Duplicate {
        /// Its name.
        name: String,
    },
    /// Two scenes whose names are the same though their parameters differ.
    #[error("two scenes would share the name {name} though their parameters differ: change a seed")]
    NameCollision {
        /// Their name.
        name: String,
    },
    /// The cameras stand among the geometry.
    #[error(
        "scene {name} may rise to {highest_m} m, but the cameras stand at camera.altitude_m = {altitude_m}: at least \
         {needed_m} is needed"
    )]
    TooLow {
        /// The scene.
        name: String,
        /// Highest point that it may have, m.
        highest_m: f64,
        /// The recipe's altitude, m.
        altitude_m: f64,
        /// Lowest altitude that would do, m.
        needed_m: f64,
    },
    /// The datum is not between the ground and the cameras.
    #[error("camera.datum is {datum_m} m, but scene {name} lies between {lowest_m} m and {highest_m} m")]
    DatumOutside {
        /// The scene.
        name: String,
        /// The recipe's datum, m.
        datum_m: f64,
        /// Lowest point that the scene may have, m.
        lowest_m: f64,
        /// Highest point that it may have, m.
        highest_m: f64,
    },
    /// Frames would see beyond what stands in full detail.
    #[error(
        "pair {id} sees as far as {reach_m:.1} m from the pivot, but scene.{region}.radius_m = {radius_m}: it must be \
         at least {needed_m}, or frames smaller, baselines shorter, pivot_along_baseline nearer 0.5"
    )]
    BeyondDetail {
        /// The pair.
        id: String,
        /// Its region.
        region: &'static str,
        /// How far its frames see, m.
        reach_m: f64,
        /// The scene's radius of full detail, m.
        radius_m: f64,
        /// The smallest whole number that would do for every pair of the plan, m.
        needed_m: f64,
    },
}

/// Cameras stand at least so far above anything that a scene may hold, m.
const CLEARANCE_M: f64 = 50.0;

impl Plan {
    /// The plan of a recipe.
    pub fn new(recipe: &Recipe) -> Result<Self, PlanError> {
        let mut scenes = scenes(recipe)?;
        reach::check(recipe, &scenes)?;
        let notes = split::deal(recipe, &mut scenes);
        Ok(Self { scenes, notes, hash: hash_of("satseed 2026 plan v1", &recipe.to_toml()) })
    }

    /// All pairs in plan order, each with its scene.
    pub fn pairs(&self) -> impl Iterator<Item = (&SceneSpec, &PairSpec)> {
        self.scenes.iter().flat_map(|scene| scene.pairs.iter().map(move |pair| (scene, pair)))
    }

    /// How many pairs.
    pub fn pair_count(&self) -> usize {
        self.scenes.iter().map(|scene| scene.pairs.len()).sum()
    }

    /// A region as each of its variants has it first, in plan order; none if no scene is of that name.
    pub fn variants(&self, region: &str) -> Vec<Region> {
        let mut found: Vec<Region> = Vec::new();
        for scene in self.scenes.iter().filter(|scene| scene.region.name() == region) {
            if found.iter().all(|known| known.variant() != scene.region.variant()) {
                found.push(scene.region.clone());
            }
        }
        found
    }

    /// How many pairs of each split, in the order of [`Split::ALL`].
    pub fn split_counts(&self) -> [usize; 3] {
        let mut counts = [0; 3];
        for (_, pair) in self.pairs() {
            counts[pair.split as usize] += 1;
        }
        counts
    }
}

/// The scenes of a recipe with their pairs, all in the training split; whether frames see beyond what stands in full
/// detail is not looked at, since a scene by itself has no frames.
pub fn scenes(recipe: &Recipe) -> Result<Vec<SceneSpec>, PlanError> {
    let per_pivot = pairs::per_pivot(recipe.acquisition());
    let pivots: u64 = recipe.scenes().iter().map(|s| s.pivots.count() as u64).sum();
    if pivots * per_pivot > MAX_PAIRS {
        return Err(PlanError::TooManyPairs { pairs: pivots * per_pivot });
    }
    let mut scenes: Vec<SceneSpec> = Vec::with_capacity(pivots as usize);
    // How many pivots of each kind of scene the recipe's seed has numbered so far.
    let mut numbered: BTreeMap<(&str, String), u64> = BTreeMap::new();
    for entry in recipe.scenes() {
        let parameters = parameters_text(&entry.region);
        let naming = Naming::of(&entry.region, &parameters);
        let seeds = match &entry.pivots {
            Pivots::Seeds(seeds) => seeds.clone(),
            Pivots::Count(n) => {
                let first = numbered.entry((entry.region.name(), parameters)).or_insert(0);
                let from = *first;
                *first += u64::from(*n);
                (from..*first).map(|number| recipe.seed() * MAX_PIVOTS + number).collect()
            }
        };
        scenes.extend(seeds.into_iter().map(|seed| naming.scene(recipe, &entry.region, seed)));
    }
    refuse_duplicates(&scenes)?;
    Ok(scenes)
}

impl SceneSpec {
    /// A region and a seed with the pairs that the recipe's cameras make of them, whether or not they stand in the recipe.
    pub fn of(recipe: &Recipe, region: &Region, seed: u64) -> Self {
        Naming::of(region, &parameters_text(region)).scene(recipe, region, seed)
    }

    /// Whether all frames see nothing but what stands in full detail, with the cameras above it.
    pub fn check_frames(&self, recipe: &Recipe) -> Result<(), PlanError> {
        reach::check(recipe, std::slice::from_ref(self))
    }
}

/// What the names of one kind of scene share.
struct Naming {
    stem: String,
    params_hash: String,
    is_default: bool,
}

impl Naming {
    fn of(region: &Region, parameters: &str) -> Self {
        Self {
            stem: format!("{}-{}", region.name(), region.variant()),
            params_hash: hash_of("satseed 2026 scene parameters v1", parameters),
            is_default: changed_parameters(region).is_empty(),
        }
    }

    fn name(&self, seed: u64) -> String {
        let Self { stem, params_hash, is_default } = self;
        if *is_default { format!("{stem}-{seed}") } else { format!("{stem}-{seed}-{}", &params_hash[..8]) }
    }

    fn scene(&self, recipe: &Recipe, region: &Region, seed: u64) -> SceneSpec {
        let name = self.name(seed);
        let pairs = pairs::of_pivot(recipe, region, seed, &name);
        SceneSpec { name, region: region.clone(), seed, params_hash: self.params_hash.clone(), pairs }
    }
}

fn hash_of(context: &'static str, text: &str) -> String {
    blake3::Hasher::new_derive_key(context).update(text.as_bytes()).finalize().to_hex().to_string()
}

fn refuse_duplicates(scenes: &[SceneSpec]) -> Result<(), PlanError> {
    let mut names = BTreeMap::new();
    for scene in scenes {
        if let Some(other) = names.insert(&scene.name, &scene.params_hash) {
            let name = scene.name.clone();
            let same = *other == scene.params_hash;
            return Err(if same { PlanError::Duplicate { name } } else { PlanError::NameCollision { name } });
        }
    }
    debug_assert_eq!(names.into_keys().collect::<BTreeSet<_>>().len(), scenes.len());
    Ok(())
}
