//! What a plan costs, and what more of its kind would.

use super::output::bytes_text;
use satseed::plan::{Costs, HOW_MEASURED, Plan};
use satseed::recipe::Recipe;
use std::io::{self, Write};

/// Core-hours by region and of larger plans with the same mix of regions and as many pairs a scene.
pub(super) fn write_costs(out: &mut dyn Write, recipe: &Recipe, plan: &Plan, disk_bytes: u64) -> io::Result<()> {
    let totals = Costs::of(recipe).by_region(plan);
    let hours = |ms: u64| ms as f64 / 3.6e6;
    writeln!(out, "\nregion    scenes  pairs  s a scene  pairs a core-hour  core-hours")?;
    for total in &totals {
        let scene_s = total.scenes_ms as f64 / 1000.0 / total.scenes as f64;
        let rate = if total.pairs == 0 { 0.0 } else { total.pairs as f64 / hours(total.all_ms) };
        let note = if total.is_measured { "" } else { "  not measured: as the dearest that is" };
        writeln!(
            out,
            "{:9} {:6} {:6} {scene_s:10.1} {rate:18.1} {:11.2}{note}",
            total.region,
            total.scenes,
            total.pairs,
            hours(total.all_ms)
        )?;
    }
    let (pairs, all_ms) = totals.iter().fold((0, 0), |(pairs, ms), t| (pairs + t.pairs, ms + t.all_ms));
    if pairs == 0 {
        return Ok(());
    }
    let line = |out: &mut dyn Write, what: &str, n: u64| {
        let share = n as f64 / pairs as f64;
        let bytes = (disk_bytes as f64 * share) as u64;
        writeln!(out, "{what:9} {n:13} {:15.1}  {}", hours(all_ms) * share, bytes_text(bytes))
    };
    writeln!(out, "\nof this mix       pairs      core-hours  on disk")?;
    line(out, "this plan", pairs)?;
    for (what, n) in [("10 k", 10_000), ("1 M", 1_000_000), ("100 M", 100_000_000)] {
        line(out, what, n)?;
    }
    writeln!(out, "\ncores are those of the table: {HOW_MEASURED}")
}
