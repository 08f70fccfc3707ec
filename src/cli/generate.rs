//! `satseed generate`

use super::Exit;
use super::args::GenerateArgs;
use super::cost::write_costs;
use super::output::{bytes_text, write_stdout};
use super::place::Place;
use super::plan::write_summary;
use super::profile::ProfileFile;
use super::progress::Progress;
use anyhow::Context as _;
use satseed::pipeline::{Options, Outcome, estimate, estimate_seconds, generate, second_scene_bytes};
use satseed::plan::{Plan, Shard};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub(crate) fn run(args: &GenerateArgs) -> anyhow::Result<Exit> {
    let recipe = args.recipe.load()?;
    let plan = Plan::new(&recipe)?;
    let jobs = args.jobs.map_or_else(default_jobs, |n| n as usize);
    let mut cost = estimate(&recipe, &plan);
    if args.dry_run {
        write_stdout(|out| {
            write_summary(out, &cost, &plan)?;
            writeln!(
                out,
                "time     about {} on {jobs} threads",
                duration_text(estimate_seconds(&recipe, &plan, jobs))
            )?;
            write_costs(out, &recipe, &plan, cost.disk_bytes)
        })?;
        return Ok(Exit::Fine);
    }
    let build_ahead = args.max_memory.is_none_or(|most| cost.memory_bytes <= most);
    if !build_ahead {
        cost.memory_bytes -= second_scene_bytes(&plan);
    }
    if let Some(most) = args.max_memory.filter(|most| cost.memory_bytes > *most) {
        anyhow::bail!(
            "the plan may need {} of memory, more than the {} of --max-memory: smaller frames, a smaller radius_m of \
             its scenes, or a larger --max-memory; nothing was written",
            bytes_text(cost.memory_bytes),
            bytes_text(most)
        );
    }
    for note in &plan.notes {
        tracing::warn!("{note}");
    }

    let shard = args.shard.map_or(Ok(Shard::WHOLE), |choice| choice.resolve(&|name| std::env::var(name).ok()))?;
    let place = if shard.is_whole() { Place::create(&args.out)? } else { Place::create_shared(&args.out)? };
    let profile = args.profile.as_deref().map(|file| ProfileFile::begin(file, &args.out)).transpose()?;
    let stop = stop_on_signals().context("cannot listen for signals")?;
    let progress = Progress::new(&cost);
    let options = Options { jobs, build_ahead, shard, stop: &stop, profile: profile.as_ref().map(|p| &p.profile) };
    let outcome = generate(&recipe, &plan, place.store(), options, &|event| progress.report(event));
    let standing = progress.end();
    let outcome = outcome?;
    if let Some(profile) = profile {
        profile.end(&plan.hash, jobs, cost.memory_bytes)?;
    }
    match outcome {
        Outcome::Complete(root_hash) => {
            write_stdout(|out| writeln!(out, "{}", root_hash.hex()))?;
            Ok(Exit::Fine)
        }
        Outcome::ShardDone => {
            progress.tell("this shard is done; `satseed merge` joins them when all are");
            Ok(Exit::Fine)
        }
        Outcome::Stopped => {
            progress.stopped(standing);
            Ok(Exit::Stopped)
        }
    }
}

pub(super) fn default_jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// A flag that SIGTERM and SIGINT set. A second signal ends the process at once: nothing is lost by that either.
pub(super) fn stop_on_signals() -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGTERM, SIGINT] {
        flag::register_conditional_shutdown(signal, 75, Arc::clone(&stop))?;
        flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// Seconds for people: `2 h 05 min`.
pub(super) fn duration_text(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match minutes {
        0..2 => format!("{seconds:.0} s"),
        2..120 => format!("{minutes} min"),
        _ => format!("{} h {:02} min", minutes / 60, minutes % 60),
    }
}
