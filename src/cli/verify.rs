//! `satseed verify`

use super::Exit;
use super::args::VerifyArgs;
use super::generate::default_jobs;
use super::output::{bytes_text, write_stdout};
use super::place::{URL_JOBS, is_url, open_store};
use anyhow::Context as _;
use satseed::dataset::{Dataset, RECIPE, Report, Store, verify};
use satseed::pipeline::{chosen, regenerate, same_recipe_text, thread_pool};
use satseed::plan::Plan;
use satseed::recipe::{MAX_RECIPE_BYTES, Recipe};
use std::io::{self, Write};
use std::path::Path;

pub(crate) fn run(args: &VerifyArgs) -> anyhow::Result<Exit> {
    let store = open_store(&args.dir)?;
    let store = store.as_ref();
    let jobs = if is_url(&args.dir) { URL_JOBS } else { default_jobs() };
    let pool = thread_pool(jobs)?;
    let planned = planned(store, &args.dir);
    let ids: Option<Vec<String>> = match &planned {
        Ok((_, plan)) => Some(plan.pairs().map(|(_, pair)| pair.id.clone()).collect()),
        Err(_) => None,
    };
    let mut report = pool.install(|| verify(store, ids.as_deref()))?;
    if let Err(reason) = &planned {
        report.notes.push(format!("held against its own hashes only, not against its plan: {reason:#}"));
    }
    if args.regenerate > 0 {
        let (recipe, plan) =
            planned.context("samples can only be made again from the recipe that the dataset was made of")?;
        let dataset = Dataset::open(store).context("samples of an unfinished dataset are not made again")?;
        let ids = chosen(&dataset, args.regenerate as usize);
        let made = |id: &str| tracing::info!("made {id} again");
        report.add(pool.install(|| regenerate(&recipe, &plan, &dataset, &ids, &made))?);
        report.notes.push(format!("made again from their seeds: {}", ids.join(", ")));
    }
    let fine = report.is_fine();
    write_stdout(|out| if args.json { write_json(out, &report) } else { write_text(out, &report) })?;
    Ok(if fine { Exit::Fine } else { Exit::CheckFailed })
}

/// The recipe of a dataset and its plan; an error where this build would not make the same bytes of it.
pub(crate) fn planned(store: &dyn Store, dir: &Path) -> anyhow::Result<(Recipe, Plan)> {
    let name = dir.join(RECIPE).display().to_string();
    let bytes = store.size(RECIPE)?.with_context(|| format!("{name} is missing"))?;
    if bytes > MAX_RECIPE_BYTES {
        anyhow::bail!("{name} has {bytes} bytes, but a recipe has at most {MAX_RECIPE_BYTES}");
    }
    let text = String::from_utf8(store.get(RECIPE)?).with_context(|| format!("{name} is no text"))?;
    let recipe = Recipe::parse(&name, &text)?;
    let plan = Plan::new(&recipe)?;
    same_recipe_text(&recipe, &plan, &text)
        .map_err(|e| anyhow::anyhow!("{name} is not what this program writes: {e}"))?;
    Ok((recipe, plan))
}

fn write_json(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, report)?;
    writeln!(out)
}

fn write_text(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    for finding in &report.findings {
        writeln!(out, "{:14} {}: {}", finding.fault.word(), finding.path, finding.detail)?;
    }
    for note in &report.notes {
        writeln!(out, "note           {note}")?;
    }
    let (samples, files, bytes) = (report.samples, report.files, bytes_text(report.bytes));
    let verdict = match report.findings.len() {
        0 => "all as recorded".to_owned(),
        1 => "1 fault".to_owned(),
        n => format!("{n} faults"),
    };
    writeln!(out, "{samples} samples, {files} files, {bytes}: {verdict}")?;
    match &report.root_hash {
        Some(hash) => writeln!(out, "root hash      {hash}"),
        None => Ok(()),
    }
}
