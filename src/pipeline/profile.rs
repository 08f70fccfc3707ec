//! Where the time of a run goes, stage by stage.
//!
//! Time is that of processors, not of clocks on the wall: a stage's is what the processor clocks of all threads of its
//! pool gained between its beginning and its end. A pool does one stage at a time (see `schedule`), so whichever thread
//! took whichever part of the work, nested or stolen, it counts for the stage that it was done for; and what another
//! pool does meanwhile has clocks of its own.
//!
//! How much of it was serial is told by the thread that worked most: with a serial part S of the time C on N threads it
//! has S + (C - S) / N of it, if the others share what is left evenly. Where they do not, since its pieces are few or the
//! machine gave them less, S comes out larger. Other processes do not lengthen C, as they do the time on the wall.

use rustix::time::{ClockId, Timespec, clock_gettime};
use satseed_tracer::{RayCounts, Tracer};
use serde::Serialize;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A part of a run, in the order of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The store is opened, and what stands there is looked through.
    Open,
    /// A generator makes a scene, and the scene is checked.
    BuildScene,
    /// The trees that rays go through.
    BuildTrees,
    /// DSM, DTM and nDSM.
    SurfaceModels,
    /// A scene's own files: encoded, hashed and written.
    SceneFiles,
    /// The label maps of both views.
    Labels,
    /// The images of both views.
    Render,
    /// A sample's files: checked, encoded, hashed and written.
    SampleFiles,
    /// Parts and manifest.
    Finish,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 9] = [
        Self::Open,
        Self::BuildScene,
        Self::BuildTrees,
        Self::SurfaceModels,
        Self::SceneFiles,
        Self::Labels,
        Self::Render,
        Self::SampleFiles,
        Self::Finish,
    ];

    /// Its name for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::BuildScene => "build scene",
            Self::BuildTrees => "build trees",
            Self::SurfaceModels => "surface models",
            Self::SceneFiles => "scene files",
            Self::Labels => "labels",
            Self::Render => "render",
            Self::SampleFiles => "sample files",
            Self::Finish => "finish",
        }
    }
}

/// What a stage took so far.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    runs: u64,
    wall: Duration,
    cpu: Duration,
    serial: Duration,
    rays: RayCounts,
}

/// Rays by their kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RayKinds {
    /// First hits, of labels and of samples.
    pub primary: u64,
    /// From a first hit to the other camera.
    pub label: u64,
    /// To the sun's disc: from first hits for the shadow label and for samples, and from what the sky's rays meet.
    pub sun: u64,
    /// Into the sky's dome and, from coated surfaces, into the mirrored direction: what is met there is shaded too.
    pub sky: u64,
}

impl From<RayCounts> for RayKinds {
    fn from(counts: RayCounts) -> Self {
        Self { primary: counts.first, label: counts.line, sun: counts.open, sky: counts.onward }
    }
}

/// The account of one run; it costs nothing that could be measured, and changes no byte.
#[derive(Debug)]
pub struct Profile {
    begun: Instant,
    cpu_before: Duration,
    stages: Mutex<[Tally; Stage::ALL.len()]>,
}

/// What a stage took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageReport {
    /// Which.
    pub stage: Stage,
    /// How often it was run.
    pub runs: u64,
    /// Sum of its runs' lengths, s. Stages of different lanes overlap, and wait for a processor while others have it.
    pub wall_s: f64,
    /// Processor time of all threads, s.
    pub cpu_s: f64,
    /// Part of it that only one thread could do, s: at most, see the module. All of it where there is one thread.
    pub serial_cpu_s: f64,
    /// Rays traced, of every kind; each sample of light is one.
    pub rays: u64,
    /// The same, kind by kind.
    pub rays_by_kind: RayKinds,
}

/// What a run took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileReport {
    /// Version of the program.
    pub version: &'static str,
    /// Threads of each lane.
    pub jobs: usize,
    /// From the profile's beginning, s.
    pub wall_s: f64,
    /// Processor time of the whole process from the profile's beginning, s.
    pub cpu_s: f64,
    /// What of it no stage has, s.
    pub other_cpu_s: f64,
    /// Rays of all stages.
    pub rays: u64,
    /// The same, kind by kind.
    pub rays_by_kind: RayKinds,
    /// Highest resident memory of the process, bytes; none where the system does not tell (other than Linux).
    pub memory_peak_bytes: Option<u64>,
    /// Every stage, in order.
    pub stages: Vec<StageReport>,
}

impl Profile {
    /// Begins to count.
    pub fn begin() -> Arc<Self> {
        let cpu_before = cpu_time(ClockId::ProcessCPUTime);
        Arc::new(Self { begun: Instant::now(), cpu_before, stages: Mutex::default() })
    }

    /// What was counted so far, of a run with `jobs` threads a lane.
    pub fn report(&self, jobs: usize) -> ProfileReport {
        let cpu = cpu_time(ClockId::ProcessCPUTime).saturating_sub(self.cpu_before);
        let tallies = *self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        let in_stages: Duration = tallies.iter().map(|t| t.cpu).sum();
        let report = |(stage, t): (Stage, Tally)| StageReport {
            stage,
            runs: t.runs,
            wall_s: t.wall.as_secs_f64(),
            cpu_s: t.cpu.as_secs_f64(),
            serial_cpu_s: t.serial.as_secs_f64(),
            rays: t.rays.sum(),
            rays_by_kind: t.rays.into(),
        };
        let rays = tallies.iter().fold(RayCounts::default(), |sum, t| sum + t.rays);
        ProfileReport {
            version: env!("CARGO_PKG_VERSION"),
            jobs,
            wall_s: self.begun.elapsed().as_secs_f64(),
            cpu_s: cpu.as_secs_f64(),
            other_cpu_s: cpu.saturating_sub(in_stages).as_secs_f64(),
            rays: rays.sum(),
            rays_by_kind: rays.into(),
            memory_peak_bytes: memory_peak_bytes(),
            stages: Stage::ALL.into_iter().zip(tallies).map(report).collect(),
        }
    }

    /// Adds a run: its length, the time of each thread, and its rays.
    fn add(&self, stage: Stage, wall: Duration, threads: &[Duration], rays: RayCounts) {
        let (cpu, most) = (threads.iter().sum(), threads.iter().max().copied().unwrap_or_default());
        let others = threads.len().saturating_sub(1) as u32;
        let serial = (most * threads.len() as u32).saturating_sub(cpu).checked_div(others).unwrap_or(cpu);
        let tally = &mut self.stages.lock().unwrap_or_else(PoisonError::into_inner)[stage as usize];
        tally.runs += 1;
        tally.wall += wall;
        tally.cpu += cpu;
        tally.serial += serial;
        tally.rays = tally.rays + rays;
    }
}

/// A profile, or none.
#[derive(Clone, Debug, Default)]
pub(super) struct Meter(pub(super) Option<Arc<Profile>>);

impl Meter {
    /// Does a stage's work. The current rayon pool must have nothing else to do meanwhile.
    pub(super) fn stage<R>(&self, stage: Stage, work: impl FnOnce() -> R) -> R {
        self.count(stage, RayCounts::default, work)
    }

    /// Does a stage's work, of which the rays of a tracer are a part.
    pub(super) fn traced<R>(&self, stage: Stage, tracer: &Tracer<'_>, work: impl FnOnce() -> R) -> R {
        self.count(stage, || tracer.rays_traced(), work)
    }

    fn count<R>(&self, stage: Stage, rays: impl Fn() -> RayCounts, work: impl FnOnce() -> R) -> R {
        let Some(profile) = &self.0 else { return work() };
        let (begun, before, traced) = (Instant::now(), pool_times(), rays());
        let result = work();
        let wall = begun.elapsed();
        let threads: Vec<_> =
            pool_times().into_iter().zip(before).map(|(after, before)| after.saturating_sub(before)).collect();
        profile.add(stage, wall, &threads, rays() - traced);
        result
    }
}

/// The processor time of each thread of the current pool, or of this thread where it is in none. Each reads its own clock.
fn pool_times() -> Vec<Duration> {
    match rayon::current_thread_index() {
        Some(_) => rayon::broadcast(|_| cpu_time(ClockId::ThreadCPUTime)),
        None => vec![cpu_time(ClockId::ThreadCPUTime)],
    }
}

fn cpu_time(clock: ClockId) -> Duration {
    let Timespec { tv_sec, tv_nsec } = clock_gettime(clock);
    Duration::new(tv_sec as u64, tv_nsec as u32)
}

/// The kernel's own high-water mark.
fn memory_peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::thread_pool;
    use rayon::prelude::*;

    /// Keeps this thread's processor busy for a while of its own clock.
    fn work(ms: u64) {
        let until = cpu_time(ClockId::ThreadCPUTime) + Duration::from_millis(ms);
        while cpu_time(ClockId::ThreadCPUTime) < until {
            std::hint::spin_loop();
        }
    }

    /// Two pools at work at once, both with nested parallel parts, one of them with much less to do.
    #[test]
    fn whoever_does_the_work_it_counts_for_its_stage() {
        let meter = Meter(Some(Profile::begin()));
        let [large, small] = [3, 2].map(|threads| thread_pool(threads).unwrap());
        let nested = |parts: u32, ms: u64| {
            (0..parts).into_par_iter().for_each(|_| {
                rayon::join(|| work(ms), || work(ms));
            });
        };
        std::thread::scope(|scope| {
            scope.spawn(|| large.install(|| meter.stage(Stage::Render, || nested(12, 10))));
            scope.spawn(|| {
                small.install(|| {
                    meter.stage(Stage::SampleFiles, || nested(3, 10));
                    // Between stages: no stage's.
                    nested(2, 10);
                    meter.stage(Stage::SampleFiles, || work(20));
                });
            });
        });
        let report = meter.0.as_ref().unwrap().report(3);
        let of = |stage: Stage| &report.stages[stage as usize];
        assert_eq!((of(Stage::Render).runs, of(Stage::SampleFiles).runs, of(Stage::Labels).runs), (1, 2, 0));
        // 240 and 80 ms of work; threads that look for more of it take a little, too.
        for (stage, worked_s) in [(Stage::Render, 0.24), (Stage::SampleFiles, 0.08)] {
            let cpu_s = of(stage).cpu_s;
            assert!(cpu_s >= worked_s && cpu_s < worked_s * 1.3 + 0.01, "{stage:?}: {cpu_s} s for {worked_s} s");
        }
        assert_eq!(of(Stage::Labels).cpu_s, 0.0);
        let serial_s = of(Stage::SampleFiles).serial_cpu_s;
        // A thread that looks for work takes a little time, too, so that the other one stands out by less.
        assert!(serial_s > 0.016 && serial_s <= of(Stage::SampleFiles).cpu_s, "{serial_s} s for 0.02 s");
        let sum: f64 = report.stages.iter().map(|s| s.cpu_s).sum();
        // Other tests run in this process meanwhile, so it may have taken more.
        assert!((report.cpu_s - sum - report.other_cpu_s).abs() < 1e-9 && report.other_cpu_s >= 0.04, "{report:?}");
        assert!(report.memory_peak_bytes.is_none_or(|bytes| bytes > 1_000_000));
    }

    #[test]
    fn the_busiest_thread_tells_the_serial_part() {
        let profile = Profile::begin();
        let serial_s = |threads: &[u64]| {
            let threads: Vec<_> = threads.iter().map(|s| Duration::from_secs(*s)).collect();
            let before = profile.report(1).stages[Stage::Open as usize];
            profile.add(Stage::Open, Duration::ZERO, &threads, RayCounts::default());
            let after = profile.report(1).stages[Stage::Open as usize];
            (after.cpu_s - before.cpu_s, after.serial_cpu_s - before.serial_cpu_s)
        };
        assert_eq!(serial_s(&[5, 5, 5]), (15.0, 0.0));
        // 6 s by one thread alone, then 9 s shared.
        assert_eq!(serial_s(&[3, 9, 3]), (15.0, 6.0));
        assert_eq!(serial_s(&[0, 0, 7]), (7.0, 7.0));
        assert_eq!(serial_s(&[4]), (4.0, 4.0));
    }

    #[test]
    fn stages_stand_at_their_place() {
        assert!(Stage::ALL.iter().enumerate().all(|(i, stage)| *stage as usize == i));
    }
}
