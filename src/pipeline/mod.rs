//! The loop from a plan to a dataset; the only module that knows every stage.
//!
//! Scene by scene in plan order: build, trees, surface models, then pair by pair. While one pair is traced the one
//! before it is encoded and written, so that one scene and two samples are all that memory ever holds. Nothing that is
//! written depends on how many threads there are, which shard this is, or how often the run was stopped.

mod contents;
mod pair;
mod regenerate;
mod scene;

pub use contents::{contents, recipe_text};
pub use pair::{make_sample, rig};
pub use regenerate::{chosen, regenerate, same_recipe_text};
pub use scene::{BuiltScene, SceneRecord};

use crate::dataset::{ManifestHash, ReadError, Sample, Store, WriteError, Writer};
use crate::plan::{Estimate, Plan, Shard};
use crate::recipe::Recipe;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pairs in memory at once: one being traced, one being written.
pub const SAMPLES_IN_FLIGHT: u32 = 2;

/// How a plan is run. None of it changes a byte of what is written.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Threads; at least 1.
    pub jobs: usize,
    /// Which part of the plan.
    pub shard: Shard,
    /// Set from outside to stop at the next sample's border.
    pub stop: &'a AtomicBool,
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
    /// A scene is being built.
    Scene {
        /// Its name.
        name: &'a str,
    },
    /// A pair is recorded.
    Pair {
        /// Its id.
        id: &'a str,
        /// Rays traced in its scene so far.
        rays: u64,
    },
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The dataset is complete.
    Complete(ManifestHash),
    /// This shard is done; others are not, so there is no manifest yet.
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
    /// The dataset could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
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

/// What a run of this plan costs, the surface models included.
pub fn estimate(recipe: &Recipe, plan: &Plan) -> Estimate {
    let mut estimate = Estimate::of(recipe, plan, SAMPLES_IN_FLIGHT);
    let models = plan.scenes.iter().map(|s| scene::surface_model_bytes(&s.region, recipe.camera().gsd_m)).max();
    estimate.memory_bytes += models.unwrap_or(0);
    // DSM and DTM, compressed: 1.4 bytes a cell in a city, 3.7 in a canyon. The nDSM adds 0.7 in a city and next to nothing in
    // a canyon, where it is 0 nearly everywhere.
    let cells: u64 = plan.scenes.iter().map(|s| scene::map_cells(&s.region, recipe.camera().gsd_m)).sum();
    estimate.disk_bytes += 4 * cells;
    estimate
}

/// How long a run takes, about, seconds: from runs of both regions, so a first idea and no promise.
pub fn estimate_seconds(recipe: &Recipe, plan: &Plan, jobs: usize) -> f64 {
    // All of one thread: a square metre of scene built, a ray traced and shaded, a cell of the surface models.
    const SECONDS_PER_M2: f64 = 1.3e-5;
    const RAYS_PER_SECOND: f64 = 8e5;
    const MAP_CELLS_PER_SECOND: f64 = 6e5;
    let cell_m = recipe.camera().gsd_m;
    let cells: f64 = plan.scenes.iter().map(|s| scene::map_cells(&s.region, cell_m) as f64).sum();
    let rays = Estimate::of(recipe, plan, SAMPLES_IN_FLIGHT).rays as f64;
    let seconds = cells * cell_m * cell_m * SECONDS_PER_M2 + rays / RAYS_PER_SECOND + cells / MAP_CELLS_PER_SECOND;
    seconds / jobs.max(1) as f64
}

/// Runs a plan into a store. The caller holds the folder's lock.
///
/// # Errors
/// Where the store holds something else or fails; what is recorded by then stands, and the same call goes on from there.
pub fn generate(
    recipe: &Recipe,
    plan: &Plan,
    store: &dyn Store,
    options: Options<'_>,
    report: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Outcome, PipelineError> {
    let pool = thread_pool(options.jobs)?;
    let writer = Writer::open(store, contents(recipe, plan))?;
    let shares = options.shard.of(plan);
    let pairs = || shares.iter().flat_map(|share| &plan.scenes[share.scene].pairs[share.pairs.clone()]);
    let standing = pairs().filter(|p| writer.is_recorded(&p.id)).count();
    report(Event::Begun { pairs: pairs().count(), standing });
    let stopped = || options.stop.load(Ordering::Relaxed);

    for share in &shares {
        let spec = &plan.scenes[share.scene];
        let todo: Vec<_> = spec.pairs[share.pairs.clone()].iter().filter(|p| !writer.is_recorded(&p.id)).collect();
        if !todo.is_empty() {
            if stopped() {
                return Ok(Outcome::Stopped);
            }
            report(Event::Scene { name: &spec.name });
            pool.install(|| {
                let scene = scene::build(spec)?;
                let built = BuiltScene::new(recipe, spec, &scene);
                if stopped() {
                    return Ok(());
                }
                if !writer.adopt_scene(&spec.name)? {
                    writer.put_scene(&spec.name, &built.files())?;
                }
                let write = |sample: Option<Sample>| -> Result<(), WriteError> {
                    if let Some(sample) = sample {
                        let id = sample.identity.id.clone();
                        writer.put_sample(sample)?;
                        report(Event::Pair { id: &id, rays: built.tracer.rays_traced() });
                    }
                    Ok(())
                };
                let mut finished = None;
                for pair in todo {
                    if stopped() {
                        break;
                    }
                    let before = finished.take();
                    let (sample, written) = rayon::join(|| make_sample(&built, pair), || write(before));
                    written?;
                    finished = Some(sample?);
                }
                write(finished)?;
                Ok::<(), PipelineError>(())
            })?;
            if stopped() && !spec.pairs[share.pairs.clone()].iter().all(|p| writer.is_recorded(&p.id)) {
                return Ok(Outcome::Stopped);
            }
        }
        writer.finish_scene(&spec.name)?;
    }
    Ok(writer.finish()?.map_or(Outcome::ShardDone, Outcome::Complete))
}
