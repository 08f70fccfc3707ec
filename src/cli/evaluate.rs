//! `satseed evaluate`

use super::Exit;
use super::args::EvaluateArgs;
use super::output::{sample_bar, write_stdout};
use super::sweep;
use anyhow::Context as _;
use satseed::dataset::{Dataset, DiskStore};
use satseed::evaluate::{Breakdown, Evaluation, Foreign, Options, Scores, Source, evaluate, html_report};
use satseed::pipeline::thread_pool;
use satseed::sweep::INDEX;
use std::io::{self, Write};

/// Lines of missing, unusable and strange files that the terminal shows; the JSON file has all.
const SHOWN: usize = 5;
/// Break-downs in the order in which they are shown.
const ORDER: [&str; 8] =
    ["texture", "disparity", "slope", "height", "class", "shadow", "boundary_distance", "baseline"];

pub(crate) fn run(args: &EvaluateArgs) -> anyhow::Result<Exit> {
    match args.truth_layout {
        None if args.dir.join(INDEX).is_file() => sweep::evaluate(args),
        None => {
            let store = DiskStore::open(&args.dir)?;
            run_on(args, Source::Dataset(&Dataset::open(&store)?))
        }
        Some(layout) => run_on(args, Source::Foreign(&Foreign::open(&args.dir, layout.into())?)),
    }
}

fn run_on(args: &EvaluateArgs, source: Source<'_>) -> anyhow::Result<Exit> {
    let options = Options { split: args.split.clone(), png_scale: args.png_scale };
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    let bar = sample_bar();
    let done = |id: &str| {
        tracing::debug!("evaluated {id}");
        bar.inc(1);
    };
    let evaluation = thread_pool(jobs)?.install(|| evaluate(source, &args.predictions, &options, &done));
    bar.finish_and_clear();
    let evaluation = evaluation?;
    if let Some(file) = &args.json {
        let mut text = serde_json::to_string_pretty(&evaluation)?;
        text.push('\n');
        std::fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = &args.report {
        let page = html_report(source, &args.predictions, &options, &evaluation)?;
        std::fs::write(file, page).with_context(|| format!("cannot write {}", file.display()))?;
    }
    let exceeded: Vec<String> = args.fail_above.iter().filter_map(|limit| limit.exceeded(&evaluation)).collect();
    write_stdout(|out| {
        write_text(out, &evaluation)?;
        exceeded.iter().try_for_each(|told| writeln!(out, "failed: {told}"))
    })?;
    Ok(if evaluation.is_complete() && exceeded.is_empty() { Exit::Fine } else { Exit::CheckFailed })
}

fn write_text(out: &mut dyn Write, e: &Evaluation) -> io::Result<()> {
    let split = e.split.as_ref().map(|s| format!(" of split {s}")).unwrap_or_default();
    writeln!(out, "{} of {} samples{split} evaluated", e.evaluated, e.samples)?;
    let missing: Vec<String> = e.missing.iter().map(|id| format!("{id} has no prediction")).collect();
    let unusable: Vec<String> = e.unusable.iter().map(|u| format!("{} cannot be used: {}", u.file, u.reason)).collect();
    let strangers: Vec<String> = e.strangers.iter().map(|f| format!("{f} belongs to no sample")).collect();
    write_list(out, "failed", "more without a prediction", &missing)?;
    write_list(out, "failed", "more that cannot be used", &unusable)?;
    write_list(out, "note", "more files that belong to no sample", &strangers)?;
    for m in &e.likely_mistakes {
        writeln!(out, "likely mistake in {} of {} samples, {}", m.samples, e.evaluated, m.told)?;
    }

    writeln!(
        out,
        "\n{:9} {:>11} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>11}",
        "", "pixels", "EPE px", "of images", "bias px", "< 1 px", "< 3 px", "bad 1", "bad 3", "D1", "unpredicted"
    )?;
    let (s, images, zone) = (&e.total.scores, &e.total.epe_images_px, &e.total.boundary.within_5_px);
    for (name, scores, of_images) in [
        ("noc", &s.noc, images.noc),
        ("occ", &s.occ, images.occ),
        ("all", &s.all, images.all),
        ("boundary", &zone.all, None),
    ] {
        writeln!(
            out,
            "{name:9} {:>11} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>11}",
            scores.pixels,
            px(scores.epe_px),
            px(of_images),
            px(scores.bias_px),
            percent(scores.within_1),
            percent(scores.within_3),
            percent(scores.bad_1),
            percent(scores.bad_3),
            percent(scores.d1),
            percent(scores.unpredicted)
        )?;
    }
    let b = &e.total.boundary;
    writeln!(
        out,
        "soft edges, {} px beside a jump: {} px in 3 x 3, {} px in 5 x 5",
        b.jump_pixels,
        px(b.see_3_px),
        px(b.see_5_px)
    )?;
    writeln!(
        out,
        "not counted: {} px beyond the right frame, {} px where nothing was hit",
        e.total.out_of_frame_pixels, e.total.nothing_hit_pixels
    )?;

    write_heading(out, "region")?;
    for region in &e.regions {
        let name = format!("{}/{}", region.region, region.variant);
        write_row(out, &name, &region.group.scores.noc, &region.group.scores.occ)?;
    }
    for by in ORDER {
        if let Some(breakdown) = e.total.by.get(by) {
            write_breakdown(out, by, breakdown)?;
        }
    }
    write_texture_by_region(out, e)?;
    e.notes.iter().try_for_each(|note| writeln!(out, "note: {note}"))
}

fn write_list(out: &mut dyn Write, word: &str, others: &str, lines: &[String]) -> io::Result<()> {
    lines.iter().take(SHOWN).try_for_each(|line| writeln!(out, "{word}: {line}"))?;
    match lines.len().saturating_sub(SHOWN) {
        0 => Ok(()),
        more => writeln!(out, "{word}: {more} {others}"),
    }
}

fn write_breakdown(out: &mut dyn Write, by: &str, breakdown: &Breakdown) -> io::Result<()> {
    write_heading(out, &by.replace('_', " "))?;
    for row in &breakdown.rows {
        let grey = if by == "texture" { texture_levels(row.from, row.to) } else { String::new() };
        write_row(out, &format!("{}{grey}", row.name), &row.scores.noc, &row.scores.occ)?;
    }
    writeln!(out, "({})", breakdown.of)
}

fn texture_levels(from: Option<f64>, to: Option<f64>) -> String {
    format!(": {:.1} to {:.1}", from.unwrap_or(0.0), to.unwrap_or(0.0))
}

fn write_heading(out: &mut dyn Write, by: &str) -> io::Result<()> {
    writeln!(
        out,
        "\n{:28} {:>11} {:>9} {:>8} {:>8} {:>11} {:>11}",
        format!("by {by}"),
        "noc pixels",
        "EPE px",
        "bad 1",
        "bad 3",
        "occ pixels",
        "occ EPE px"
    )
}

fn write_row(out: &mut dyn Write, name: &str, noc: &Scores, occ: &Scores) -> io::Result<()> {
    writeln!(
        out,
        "  {name:26} {:>11} {:>9} {:>8} {:>8} {:>11} {:>11}",
        noc.pixels,
        px(noc.epe_px),
        percent(noc.bad_1),
        percent(noc.bad_3),
        occ.pixels,
        px(occ.epe_px)
    )
}

/// The stress test in one table: at the same contrast, where does it fail?
fn write_texture_by_region(out: &mut dyn Write, e: &Evaluation) -> io::Result<()> {
    let Some(all) = e.total.by.get("texture").filter(|_| e.regions.len() > 1) else { return Ok(()) };
    let heads: Vec<String> = e.regions.iter().map(|r| format!("{}/{}", r.region, r.variant)).collect();
    write!(out, "\n{:28}", "EPE px of noc by texture")?;
    heads.iter().try_for_each(|head| write!(out, " {head:>18}"))?;
    writeln!(out)?;
    for row in &all.rows {
        write!(out, "  {:26}", format!("{}{}", row.name, texture_levels(row.from, row.to)))?;
        for region in &e.regions {
            let own = region.group.by.get("texture").and_then(|b| b.rows.iter().find(|r| r.name == row.name));
            write!(out, " {:>18}", px(own.and_then(|r| r.scores.noc.epe_px)))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

pub(super) fn px(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.3}"))
}

pub(super) fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), |s| format!("{:.2} %", s * 100.0))
}
