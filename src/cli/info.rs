//! `satseed info`

use super::Exit;
use super::args::InfoArgs;
use super::output::{bytes_text, write_stdout};
use super::place::open_store;
use super::verify::planned;
use satseed::dataset::{Dataset, Histogram, RegionSummary, Summary, summarise};
use satseed::pipeline::thread_pool;
use satseed::recipe::seed_list_line;
use std::io::{self, Write};

pub(crate) fn run(args: &InfoArgs) -> anyhow::Result<Exit> {
    let store = open_store(&args.dir)?;
    let store = store.as_ref();
    if args.seeds {
        let (_, plan) = planned(store, &args.dir)?;
        write_stdout(|out| {
            plan.scenes.iter().try_for_each(|scene| writeln!(out, "{}", seed_list_line(&scene.region, scene.seed)))
        })?;
        return Ok(Exit::Fine);
    }
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    let dataset = Dataset::open(store)?;
    let summary = thread_pool(jobs)?.install(|| summarise(&dataset))?;
    write_stdout(|out| {
        if args.json {
            serde_json::to_writer_pretty(&mut *out, &summary)?;
            writeln!(out)
        } else {
            write_text(out, &summary)
        }
    })?;
    Ok(Exit::Fine)
}

fn write_text(out: &mut dyn Write, summary: &Summary) -> io::Result<()> {
    let (samples, scenes) = (summary.samples, summary.scenes);
    writeln!(out, "{samples} samples of {scenes} scenes, {}: {}", bytes_text(summary.bytes), splits(&summary.splits))?;
    writeln!(out, "root hash {}", summary.root_hash)?;
    summary.regions.iter().try_for_each(|region| write_region(out, region))
}

fn splits(splits: &std::collections::BTreeMap<String, usize>) -> String {
    splits.iter().map(|(name, n)| format!("{n} {name}")).collect::<Vec<_>>().join(", ")
}

fn percent(share: f64) -> String {
    format!("{:.2} %", share * 100.0)
}

fn write_region(out: &mut dyn Write, region: &RegionSummary) -> io::Result<()> {
    let RegionSummary { region: name, variant, samples, .. } = region;
    writeln!(
        out,
        "\n{name}/{variant}: {samples} samples of {} scenes: {}",
        region.scenes.len(),
        splits(&region.splits)
    )?;

    writeln!(out, "\n  {:>10} {:>8} {:>9} {:>9} {:>13}", "baseline", "samples", "valid", "occluded", "out of frame")?;
    for b in &region.baselines {
        let baseline = format!("{:.1} m", b.baseline_m);
        let [valid, occluded, lost] = [b.valid_fraction, b.occluded_fraction, b.out_of_frame_fraction].map(percent);
        writeln!(out, "  {baseline:>10} {:>8} {valid:>9} {occluded:>9} {lost:>13}", b.samples)?;
    }

    writeln!(out, "\n  disparity of hit pixels, left")?;
    write_histogram(out, &region.disparity, |x| format!("{x:.2} px"))?;
    writeln!(out, "\n  samples by occluded share")?;
    write_histogram(out, &region.occlusion, percent)?;

    writeln!(out, "\n  pixels by local contrast, left (deviation in 9 x 9, grey levels)")?;
    write_histogram(out, &region.texture, |x| format!("{x:.1}"))?;

    if let (Some(classes), Some(built)) = (&region.classes, region.built_fraction) {
        let mut seen: Vec<_> = classes.iter().filter(|(_, share)| **share > 0.0).collect();
        seen.sort_by(|a, b| b.1.total_cmp(a.1));
        let seen: Vec<_> = seen.into_iter().map(|(class, share)| format!("{class} {}", percent(*share))).collect();
        writeln!(out, "\n  pixels   {}", seen.join(", "))?;
        writeln!(out, "  built    {} (roofs among what is no facade)", percent(built))?;
    }
    writeln!(out)?;
    for scene in &region.scenes {
        let f = &scene.figures;
        let towers = f.tower_height_median_m.map_or("no towers".to_owned(), |median| {
            format!("{} towers above 60 m of median {median:.0} m on {}", f.towers, percent(f.above_60_m_fraction))
        });
        writeln!(
            out,
            "  {}: relief {:.0} m, steeper than 60 deg {}, raised 2.5 m {}, several layers {}, {towers}",
            scene.name,
            f.relief_m,
            percent(f.steeper_than_60_deg_fraction),
            percent(f.raised_fraction),
            percent(scene.multi_layer_fraction),
        )?;
    }
    Ok(())
}

fn write_histogram(out: &mut dyn Write, histogram: &Histogram, text: impl Fn(f64) -> String) -> io::Result<()> {
    let total = histogram.counts.iter().sum::<u64>().max(1);
    let most = histogram.counts.iter().copied().max().unwrap_or(0).max(1);
    for (i, count) in histogram.counts.iter().enumerate() {
        let to = histogram.from.get(i + 1).copied().unwrap_or(histogram.to);
        let share = percent(*count as f64 / total as f64);
        let bar = "#".repeat((count * 40).div_ceil(most) as usize);
        writeln!(out, "  {:>10} .. {:>10} {share:>9} {bar}", text(histogram.from[i]), text(to))?;
    }
    Ok(())
}
