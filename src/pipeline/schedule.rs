//! How the scenes and pairs of a plan go through the stages side by side.
//!
//! Three lanes, each with threads of its own: one builds scenes, one traces pairs, one writes samples. While a scene's
//! pairs are traced the next scene is built, and while a pair is traced the one before it is encoded and written. So two
//! scenes and two samples are all that memory ever holds, and no lane waits for another while there is work of its own.
//! Where one thread is asked for, or memory is too short for two scenes, the same pool builds and traces in turn.
//!
//! Lanes have pools of their own since a thread of rayon that waits takes whatever work it finds: one that waits for the
//! last rows of a pair would take up the building of a scene, and keep the pair waiting for all of it.

use super::profile::{Meter, Stage};
use super::scene::{self, BuiltScene};
use super::{Event, Options, Outcome, PipelineError, SCENES_IN_FLIGHT, contents, pair, thread_pool};
use crate::card::ensure_card;
use crate::dataset::{Sample, Store, WriteError, Writer};
use crate::gallery::ensure_gallery;
use crate::plan::{PairSpec, Plan, SceneSpec, Share};
use crate::recipe::Recipe;
use rayon::ThreadPool;
use satseed_scene::Scene;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;
use std::time::Duration;

/// Runs a plan, or a shard of it, into a store. The caller holds the folder's lock, shared where it is a shard: shards are
/// joined by [`merge`](super::merge), and by nothing else.
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
    let lanes = Lanes::new(options.jobs, options.build_ahead)?;
    let meter = Meter(options.profile.cloned());
    let shares = options.shard.of(recipe, plan);
    let contents = contents::contents_of(recipe, plan, &shares);
    let open =
        || if options.shard.is_whole() { Writer::open(store, contents) } else { Writer::open_part(store, contents) };
    let writer = lanes.files.install(|| meter.stage(Stage::Open, open))?;
    let run = Run { recipe, plan, writer, lanes, meter, stop: options.stop, closed: AtomicBool::new(false), report };
    let pairs = || shares.iter().flat_map(|share| &plan.scenes[share.scene].pairs[share.pairs.clone()]);
    let standing = || pairs().filter(|p| run.writer.is_recorded(&p.id)).count();
    report(Event::Begun { pairs: pairs().count(), standing: standing() });
    run.all(&shares)?;
    if standing() < pairs().count() {
        return Ok(Outcome::Stopped);
    }
    if !options.shard.is_whole() {
        return Ok(Outcome::ShardDone);
    }
    let finished = run.lanes.files.install(|| run.meter.stage(Stage::Finish, || run.writer.finish()))?;
    let Some(root_hash) = finished else { return Ok(Outcome::Stopped) };
    run.lanes.files.install(|| run.meter.stage(Stage::Finish, || ensure_card(store)))?;
    run.lanes.files.install(|| run.meter.stage(Stage::Finish, || ensure_gallery(store)))?;
    Ok(Outcome::Complete(root_hash))
}

/// The pools of the lanes.
struct Lanes {
    build: Arc<ThreadPool>,
    pairs: Arc<ThreadPool>,
    files: Arc<ThreadPool>,
    /// Scenes alive at once.
    scenes: usize,
}

impl Lanes {
    fn new(jobs: usize, build_ahead: bool) -> Result<Self, PipelineError> {
        let pool = || thread_pool(jobs).map(Arc::new);
        let (pairs, files) = (pool()?, pool()?);
        if jobs > 1 && build_ahead {
            return Ok(Self { build: pool()?, pairs, files, scenes: SCENES_IN_FLIGHT });
        }
        Ok(Self { build: Arc::clone(&pairs), pairs, files, scenes: 1 })
    }
}

/// A traced pair on its way to the writer.
struct Traced {
    sample: Sample,
    /// Rays that it took.
    rays: u64,
    /// Whether it is the last of its scene in this run.
    last: bool,
}

/// The way to the writer, for the one scene whose turn to be traced it is.
type PairsTurn = Mutex<SyncSender<Traced>>;

struct Run<'a> {
    recipe: &'a Recipe,
    plan: &'a Plan,
    writer: Writer<'a>,
    lanes: Lanes,
    meter: Meter,
    stop: &'a AtomicBool,
    /// Something failed: no further scene is begun. A scene whose pairs are being traced is not the worse for it.
    closed: AtomicBool,
    report: &'a (dyn Fn(Event<'_>) + Sync),
}

impl Run<'_> {
    /// Whether it was asked to stop.
    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Whether no further scene is to be begun.
    fn is_closed(&self) -> bool {
        self.is_stopped() || self.closed.load(Ordering::Relaxed)
    }

    /// Makes and writes what is missing of some shares, until it is done, asked to stop, or fails.
    fn all(&self, shares: &[Share]) -> Result<(), PipelineError> {
        // No place to wait in: a traced pair stays with its maker until the one before it is written, so two are alive.
        let (to_writer, traced) = sync_channel(0);
        let pairs_turn = Arc::new(Mutex::new(to_writer));
        let build_turn = Mutex::new(shares.iter().enumerate());
        thread::scope(|scope| {
            let scenes: Vec<_> = (0..self.lanes.scenes)
                .map(|_| {
                    let (pairs_turn, build_turn) = (Arc::clone(&pairs_turn), &build_turn);
                    scope.spawn(move || self.scene_after_scene(build_turn, &pairs_turn))
                })
                .collect();
            // With the last scene the way to the writer ends, and so does the writer.
            drop(pairs_turn);
            let written = self.write(traced);
            self.closed.fetch_or(written.is_err(), Ordering::Relaxed);
            let made = scenes.into_iter().map(|s| s.join().unwrap_or_else(|panic| resume_unwind(panic)));
            // Of several errors that of the first scene is told, as if they had come one after the other.
            let first = made.filter_map(Result::err).min_by_key(|(scene, _)| *scene);
            written?;
            first.map_or(Ok(()), |(_, error)| Err(error))
        })
    }

    /// Builds a scene in its turn and traces its pairs in its turn, and so on with the next that nobody has begun. The
    /// turn to trace is taken before the turn to build is given away: so scenes keep their order.
    fn scene_after_scene<'s>(
        &self,
        build_turn: &Mutex<impl Iterator<Item = (usize, &'s Share)>>,
        pairs_turn: &PairsTurn,
    ) -> Result<(), (usize, PipelineError)> {
        loop {
            // Only a panic poisons a turn, and it is told by the thread that had it.
            let Ok(mut turn) = build_turn.lock() else { return Ok(()) };
            if self.is_closed() {
                return Ok(());
            }
            let Some((index, share)) = turn.next() else { return Ok(()) };
            let spec = &self.plan.scenes[share.scene];
            let missing = |pair: &&PairSpec| !self.writer.is_recorded(&pair.id);
            let todo: Vec<_> = spec.pairs[share.pairs.clone()].iter().filter(missing).collect();
            let done = if todo.is_empty() {
                self.finish_scene(&spec.name).map_err(Into::into)
            } else {
                self.scene(spec, &todo, turn, pairs_turn)
            };
            self.closed.fetch_or(done.is_err(), Ordering::Relaxed);
            done.map_err(|error| (index, error))?;
        }
    }

    /// Builds a scene and traces its missing pairs. It is gone from memory when this ends.
    fn scene<T>(
        &self,
        spec: &SceneSpec,
        todo: &[&PairSpec],
        build_turn: MutexGuard<'_, T>,
        pairs_turn: &PairsTurn,
    ) -> Result<(), PipelineError> {
        (self.report)(Event::Scene { name: &spec.name });
        let Lanes { build, pairs, .. } = &self.lanes;
        let Some(scene) = self.build(spec)? else { return Ok(()) };
        let built =
            build.install(|| self.meter.stage(Stage::BuildTrees, || BuiltScene::new(self.recipe, spec, &scene)));
        if !self.is_closed() && !self.writer.adopt_scene(&spec.name)? {
            let files = build.install(|| self.meter.stage(Stage::SurfaceModels, || built.files()));
            build.install(|| self.meter.stage(Stage::SceneFiles, || self.writer.put_scene(&spec.name, &files)))?;
        }
        let Ok(to_writer) = pairs_turn.lock() else { return Ok(()) };
        if self.is_closed() {
            return Ok(());
        }
        drop(build_turn);
        for (n, pair) in todo.iter().enumerate() {
            if self.is_stopped() {
                break;
            }
            let before = built.tracer.rays_traced();
            let sample = pairs.install(|| pair::sample(&built, pair, &self.meter))?;
            let rays = (built.tracer.rays_traced() - before).sum();
            if to_writer.send(Traced { sample, rays, last: n + 1 == todo.len() }).is_err() {
                // The writer is gone, and has said why.
                self.closed.store(true, Ordering::Relaxed);
                break;
            }
        }
        Ok(())
    }

    /// Builds a scene, or nothing if it is asked to stop before that is done. A generator cannot be asked to stop, and a
    /// scene ahead may take minutes: so it is left to itself then, and ends with the process at the latest.
    fn build(&self, spec: &SceneSpec) -> Result<Option<Scene>, PipelineError> {
        const LOOK_UP: Duration = Duration::from_millis(50);
        let (done, built) = sync_channel(1);
        let (pool, meter, spec) = (Arc::clone(&self.lanes.build), self.meter.clone(), spec.clone());
        let building = thread::spawn(move || {
            let scene = pool.install(|| meter.stage(Stage::BuildScene, || scene::build_scene(&spec)));
            // An error means that nobody waits for it any more.
            let _ = done.send(scene);
        });
        loop {
            match built.recv_timeout(LOOK_UP) {
                Ok(scene) => return scene.map(Some),
                Err(RecvTimeoutError::Timeout) if self.is_closed() => return Ok(None),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => match building.join() {
                    Err(panic) => resume_unwind(panic),
                    Ok(()) => unreachable!("it sends before it ends"),
                },
            }
        }
    }

    /// Writes samples until there are no more.
    fn write(&self, traced: Receiver<Traced>) -> Result<(), WriteError> {
        for Traced { sample, rays, last } in traced {
            let (id, scene) = (sample.identity.id.clone(), sample.identity.scene().to_owned());
            let put = || self.meter.stage(Stage::SampleFiles, || self.writer.put_sample(sample));
            self.lanes.files.install(put)?;
            (self.report)(Event::Pair { id: &id, rays });
            if last {
                self.finish_scene(&scene)?;
            }
        }
        Ok(())
    }

    fn finish_scene(&self, name: &str) -> Result<(), WriteError> {
        self.writer.finish_scene(name).map(|_| ())
    }
}
