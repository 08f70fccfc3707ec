//! The loop from a plan to a dataset; the only module that knows every stage.
//!
//! Scene by scene in plan order: build, trees, surface models, then pair by pair; `schedule` says what goes on side by
//! side. Nothing that is written depends on how many threads there are, which shard this is, or how often the run was
//! stopped.

mod contents;
mod merge;
mod pair;
mod profile;
mod regenerate;
mod scene;
mod schedule;

pub use contents::{contents, recipe_text};
pub use merge::{Merge, merge};
pub use pair::{make_sample, rig};
pub use profile::{Profile, ProfileReport, RayKinds, Stage, StageReport};
pub use regenerate::{chosen, regenerate, same_recipe_text};
pub use scene::{BuiltScene, SceneRecord, build_scene};
pub use schedule::generate;

use crate::card::CardError;
use crate::dataset::{JoinError, ManifestHash, ReadError, WriteError};
use crate::gallery::GalleryError;
use crate::plan::{Costs, Estimate, Plan, Shard};
use crate::recipe::Recipe;
use crate::render;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Pairs in memory at once: one being traced, one being written.
pub const SAMPLES_IN_FLIGHT: u32 = 2;

/// Scenes in memory at once: one whose pairs are traced, one being built.
pub const SCENES_IN_FLIGHT: usize = 2;

/// How a plan is run. None of it changes a byte of what is written.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Threads that trace; at least 1. As many build the next scene beside them, unless it is 1, and as many write files.
    pub jobs: usize,
    /// Whether the next scene may be built while one is traced. Without, [`second_scene_bytes`] less are needed.
    pub build_ahead: bool,
    /// Which part of the plan.
    pub shard: Shard,
    /// Set from outside to stop at the next sample's border.
    pub stop: &'a AtomicBool,
    /// Where to count what the stages take.
    pub profile: Option<&'a Arc<Profile>>,
}

/// What happens while a plan is run.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// The work is known: how many pairs of this shard there are, and how many of them stand already.
    Begun {
        /// All of this shard.
        pairs: usize,
        /// Recorded by an earlier run.
        standing: usize,
    },
    /// A scene is being built; pairs of the scene before it may still come.
    Scene {
        /// Its name.
        name: &'a str,
    },
    /// A pair is recorded.
    Pair {
        /// Its id.
        id: &'a str,
        /// Rays that it took.
        rays: u64,
    },
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The dataset is complete.
    Complete(ManifestHash),
    /// This shard is done; the manifest comes when all are merged.
    ShardDone,
    /// It was asked to stop and did, at a sample's border.
    Stopped,
}

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The dataset could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// What shards wrote could not be joined.
    #[error(transparent)]
    Join(Box<JoinError>),
    /// The dataset could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The card could not be made.
    #[error(transparent)]
    Card(#[from] CardError),
    /// The gallery could not be made.
    #[error(transparent)]
    Gallery(#[from] GalleryError),
    /// A generator made something illegal.
    #[error("scene {name} is not legal: {reason}; this is a bug in its generator")]
    Scene {
        /// Which scene.
        name: String,
        /// Why.
        reason: satseed_scene::SceneError,
    },
    /// A ray of a planned frame met nothing.
    #[error(
        "sample `{id}`: the ray of pixel ({}, {}) of the {view} view meets nothing ({others} more pixels like it), but the \
         scene fills every planned frame: this is a bug in the terrain that its generator lays around it, or in the \
         tracer; nothing of the sample was written",
        pixel[0], pixel[1]
    )]
    Hole {
        /// Which sample.
        id: String,
        /// `left` or `right`.
        view: &'static str,
        /// The first such pixel: column, row.
        pixel: [u32; 2],
        /// How many more there are in this view.
        others: usize,
    },
    /// Threads could not be started.
    #[error("cannot start {jobs} threads: {reason}")]
    Threads {
        /// How many.
        jobs: usize,
        /// The system's reason.
        reason: String,
    },
}

impl From<JoinError> for PipelineError {
    fn from(error: JoinError) -> Self {
        Self::Join(Box::new(error))
    }
}

/// A pool of `jobs` threads.
///
/// # Errors
/// Where the system refuses them.
pub fn thread_pool(jobs: usize) -> Result<rayon::ThreadPool, PipelineError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(jobs.max(1))
        .build()
        .map_err(|e| PipelineError::Threads { jobs, reason: e.to_string() })
}

/// What a run of this plan costs, the surface models and a scene that is built ahead included.
pub fn estimate(recipe: &Recipe, plan: &Plan) -> Estimate {
    let mut estimate = Estimate::of(recipe, plan, SAMPLES_IN_FLIGHT);
    estimate.memory_bytes += second_scene_bytes(plan);
    let models = plan.scenes.iter().map(|s| scene::surface_model_bytes(&s.region, recipe.camera().gsd_m)).max();
    estimate.memory_bytes += models.unwrap_or(0);
    let mode = recipe.light().ambient;
    let light = plan.scenes.iter().map(|s| render::Light::most_bytes(mode, s.region.full_detail_radius_m())).max();
    estimate.memory_bytes += light.unwrap_or(0);
    // DSM and DTM, compressed: 1.4 bytes a cell in a city, 3.7 in a canyon. The nDSM adds 0.7 in a city and next to nothing in
    // a canyon, where it is 0 nearly everywhere.
    let cells: u64 = plan.scenes.iter().map(|s| scene::map_cells(&s.region, recipe.camera().gsd_m)).sum();
    estimate.disk_bytes += 4 * cells;
    estimate
}

/// What a run of this plan may need for building a scene ahead, bytes: its largest scene but one, since any two may follow
/// each other in a shard or where a run is taken up again.
pub fn second_scene_bytes(plan: &Plan) -> u64 {
    let mut scenes: Vec<u64> = plan.scenes.iter().map(|s| s.region.memory_bound_bytes()).collect();
    scenes.sort_unstable_by_key(|bytes| std::cmp::Reverse(*bytes));
    scenes.iter().take(SCENES_IN_FLIGHT).skip(1).sum()
}

/// How long a run takes, about, seconds: what [`Costs`] says, shared by the threads.
pub fn estimate_seconds(recipe: &Recipe, plan: &Plan, jobs: usize) -> f64 {
    Costs::of(recipe).plan_ms(plan) as f64 / 1000.0 / jobs.max(1) as f64
}
