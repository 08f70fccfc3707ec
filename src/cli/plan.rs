//! `satseed plan`

use super::Exit;
use super::args::{PlanArgs, PlanFormat};
use super::output::{bytes_text, write_stdout};
use satseed::pipeline::estimate;
use satseed::plan::{Estimate, PairSpec, Plan, SceneSpec, Split};
use satseed::recipe::Recipe;
use serde::Serialize;
use std::io::{self, Write};

pub(crate) fn run(args: &PlanArgs) -> anyhow::Result<Exit> {
    let recipe = args.recipe.load()?;
    let plan = Plan::new(&recipe)?;
    match args.format {
        PlanFormat::Table => write_stdout(|out| write_table(out, &recipe, &plan))?,
        PlanFormat::Jsonl => {
            for note in &plan.notes {
                tracing::warn!("{note}");
            }
            write_stdout(|out| write_jsonl(out, &recipe, &plan))?;
        }
    }
    Ok(Exit::Fine)
}

fn write_table(out: &mut dyn Write, recipe: &Recipe, plan: &Plan) -> io::Result<()> {
    let width = plan.scenes.iter().map(|s| s.name.len()).max().unwrap_or(0).max("scene".len());
    writeln!(out, "{:width$}  {:>6} {:>6} {:>6} {:>6}", "scene", "pairs", "train", "val", "test")?;
    for scene in &plan.scenes {
        let mut counts = [0; 3];
        for pair in &scene.pairs {
            counts[pair.split as usize] += 1;
        }
        let [train, val, test] = counts;
        writeln!(out, "{:width$}  {:>6} {train:>6} {val:>6} {test:>6}", scene.name, scene.pairs.len())?;
    }
    writeln!(out)?;
    write_summary(out, &estimate(recipe, plan), plan)
}

/// Totals, cost and notes of a plan; `--dry-run` prints the same.
pub(crate) fn write_summary(out: &mut dyn Write, estimate: &Estimate, plan: &Plan) -> io::Result<()> {
    let shares = plan.split_counts();
    let shares: Vec<_> = Split::ALL.iter().map(|s| format!("{} {}", shares[*s as usize], s.word())).collect();
    writeln!(out, "pairs    {} of {} scenes: {}", estimate.pairs, estimate.scenes, shares.join(", "))?;
    writeln!(out, "disk     about {}", bytes_text(estimate.disk_bytes))?;
    let scenes = if estimate.scenes > 1 { ", two scenes at once" } else { "" };
    writeln!(out, "memory   at most {}{scenes}", bytes_text(estimate.memory_bytes))?;
    writeln!(out, "plan     {}", plan.hash)?;
    plan.notes.iter().try_for_each(|note| writeln!(out, "note     {note}"))
}

/// One pair as a line of JSON; keys as in a manifest where both have them.
#[derive(Serialize)]
struct Line<'a> {
    id: &'a str,
    region: &'a str,
    variant: &'a str,
    scene_seed: u64,
    split: &'a str,
    scene_params_hash: &'a str,
    baseline_m: f64,
    azimuth_deg: f64,
    convergence_deg: f64,
    pivot_along_baseline: f64,
}

fn write_jsonl(out: &mut dyn Write, recipe: &Recipe, plan: &Plan) -> io::Result<()> {
    plan.pairs().try_for_each(|(scene, pair)| {
        serde_json::to_writer(&mut *out, &line(recipe, scene, pair))?;
        out.write_all(b"\n")
    })
}

fn line<'a>(recipe: &Recipe, scene: &'a SceneSpec, pair: &'a PairSpec) -> Line<'a> {
    Line {
        id: &pair.id,
        region: scene.region.name(),
        variant: scene.region.variant(),
        scene_seed: scene.seed,
        split: pair.split.word(),
        scene_params_hash: &scene.params_hash,
        baseline_m: pair.baseline_m,
        azimuth_deg: pair.azimuth_deg,
        convergence_deg: recipe.camera().convergence_deg(pair.baseline_m),
        pivot_along_baseline: pair.pivot_along_baseline,
    }
}
