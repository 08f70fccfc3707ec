//! `satseed sweep`, and `satseed evaluate` over what it made.

use super::Exit;
use super::args::{EvaluateArgs, SweepArgs};
use super::evaluate::{percent, px};
use super::generate::{default_jobs, duration_text, stop_on_signals};
use super::new_file::NewFile;
use super::output::{bytes_text, sample_bar, write_stdout};
use super::progress::Progress;
use anyhow::Context as _;
use satseed::dataset::{DiskStore, FolderLock};
use satseed::evaluate::Options as EvaluateOptions;
use satseed::pipeline::{Options, Outcome, estimate, estimate_seconds, generate, thread_pool};
use satseed::plan::Shard;
use satseed::sweep::{Curves, INDEX, Sweep, SweepIndex, curves, html_report};
use std::fs;
use std::io::{self, Write};

pub(crate) fn run(args: &SweepArgs) -> anyhow::Result<Exit> {
    let sweep = Sweep::new(&args.recipe.recipe, &args.recipe.changes(), &args.vary)?;
    let jobs = args.jobs.map_or_else(default_jobs, |n| n as usize);
    if args.dry_run {
        write_stdout(|out| dry_run(out, &sweep, jobs))?;
        return Ok(Exit::Fine);
    }
    fs::create_dir_all(&args.out).with_context(|| format!("cannot make the folder {}", args.out.display()))?;
    let _lock = FolderLock::take(&args.out)?;
    put_index(args, &sweep.index)?;
    let stop = stop_on_signals().context("cannot listen for signals")?;
    for ((recipe, plan), cell) in sweep.cells.iter().zip(&sweep.index.cells) {
        let folder = args.out.join(&cell.name);
        let store = DiskStore::create(&folder)?;
        let _lock = FolderLock::take(&folder)?;
        tracing::info!("cell {}", cell.name);
        let progress = Progress::new(&estimate(recipe, plan));
        let options = Options { jobs, build_ahead: true, shard: Shard::WHOLE, stop: &stop, profile: None };
        let outcome = generate(recipe, plan, &store, options, &|event| progress.report(event));
        let standing = progress.end();
        match outcome.with_context(|| format!("cell {}", cell.name))? {
            Outcome::Complete(hash) => write_stdout(|out| writeln!(out, "{}  {}", hash.hex(), cell.name))?,
            Outcome::ShardDone | Outcome::Stopped => {
                progress.stopped(standing);
                return Ok(Exit::Stopped);
            }
        }
    }
    Ok(Exit::Fine)
}

/// Writes the index, or finds the same one.
fn put_index(args: &SweepArgs, index: &SweepIndex) -> anyhow::Result<()> {
    let file = args.out.join(INDEX);
    let text = index.to_text();
    match fs::read_to_string(&file) {
        Ok(standing) if standing == text => return Ok(()),
        Ok(_) => anyhow::bail!(
            "{} holds another sweep: choose an empty folder, or run its own recipe and --vary again",
            args.out.display()
        ),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
        Err(e) => return Err(e).with_context(|| format!("cannot read {}", file.display())),
    }
    for entry in fs::read_dir(&args.out)? {
        let name = entry?.file_name();
        if name.to_string_lossy().starts_with(INDEX) {
            // What a run that was killed left of its index.
            continue;
        }
        anyhow::bail!("{} is not empty: `{}` is no part of a sweep", args.out.display(), name.display());
    }
    NewFile::create(&file)?.finish(text.as_bytes())
}

fn dry_run(out: &mut dyn Write, sweep: &Sweep, jobs: usize) -> io::Result<()> {
    let (mut pairs, mut bytes, mut seconds) = (0, 0, 0.0);
    for ((recipe, plan), cell) in sweep.cells.iter().zip(&sweep.index.cells) {
        let cost = estimate(recipe, plan);
        let time = estimate_seconds(recipe, plan, jobs);
        writeln!(
            out,
            "{:40} {:>7} pairs {:>10} {:>10}",
            cell.name,
            plan.pair_count(),
            bytes_text(cost.disk_bytes),
            duration_text(time)
        )?;
        pairs += plan.pair_count();
        bytes += cost.disk_bytes;
        seconds += time;
    }
    let cells = sweep.cells.len();
    writeln!(
        out,
        "{cells} cells, {pairs} pairs, {}, about {} on {jobs} threads",
        bytes_text(bytes),
        duration_text(seconds)
    )
}

/// Evaluates every cell of a sweep, and tells the curves.
pub(super) fn evaluate(args: &EvaluateArgs) -> anyhow::Result<Exit> {
    let file = args.dir.join(INDEX);
    let text = fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
    let index = SweepIndex::from_text(&text).map_err(|e| anyhow::anyhow!("{}: {e}", file.display()))?;
    let options = EvaluateOptions { split: args.split.clone(), png_scale: args.png_scale };
    let bar = sample_bar();
    let done = |id: &str| {
        tracing::debug!("evaluated {id}");
        bar.inc(1);
    };
    let made = thread_pool(default_jobs())?.install(|| curves(&args.dir, index, &args.predictions, &options, &done));
    bar.finish_and_clear();
    let curves = made.map_err(|(cell, e)| anyhow::Error::new(e).context(format!("cell {cell}")))?;
    if let Some(file) = &args.json {
        let text = serde_json::to_string_pretty(&curves)? + "\n";
        fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = &args.report {
        fs::write(file, html_report(&curves)).with_context(|| format!("cannot write {}", file.display()))?;
    }
    let mut failed: Vec<String> = Vec::new();
    for scores in &curves.scores {
        let e = &scores.evaluation;
        let told = args.fail_above.iter().filter_map(|limit| limit.exceeded(e));
        failed.extend(told.map(|told| format!("cell {}: {told}", scores.cell)));
        failed.extend(e.missing.iter().map(|id| format!("cell {}: {id} has no prediction", scores.cell)));
        failed.extend(
            e.unusable.iter().map(|u| format!("cell {}: {} cannot be used: {}", scores.cell, u.file, u.reason)),
        );
    }
    write_stdout(|out| {
        write_curves(out, &curves)?;
        failed.iter().try_for_each(|told| writeln!(out, "failed: {told}"))
    })?;
    Ok(if failed.is_empty() { Exit::Fine } else { Exit::CheckFailed })
}

fn write_curves(out: &mut dyn Write, curves: &Curves) -> io::Result<()> {
    let width = curves.scores.iter().map(|s| s.cell.len()).max().unwrap_or(0).max(4);
    writeln!(
        out,
        "{:width$} {:>7} {:>9} {:>8} {:>9} {:>19} {:>9}",
        "cell", "samples", "noc EPE", "bad 1", "bad 3", "EPE of the scenes", "occ EPE"
    )?;
    for s in &curves.scores {
        let (noc, occ) = (&s.evaluation.total.scores.noc, &s.evaluation.total.scores.occ);
        let scenes: Vec<f64> = s.scenes.iter().filter_map(|scene| scene.noc_epe_px).collect();
        let low = scenes.iter().copied().reduce(f64::min);
        let high = scenes.iter().copied().reduce(f64::max);
        let spread = format!("{} to {}", px(low), px(high));
        writeln!(
            out,
            "{:width$} {:>7} {:>9} {:>8} {:>9} {spread:>19} {:>9}",
            s.cell,
            s.evaluation.evaluated,
            px(noc.epe_px),
            percent(noc.bad_1),
            percent(noc.bad_3),
            px(occ.epe_px)
        )?;
    }
    Ok(())
}
