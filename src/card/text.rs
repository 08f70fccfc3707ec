//! The card: Markdown with a YAML header, as dataset hosts read it.

use super::Facts;
use crate::dataset::{Histogram, RegionSummary, SampleRecord};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The card of a dataset, without its seal.
pub(super) fn card(facts: &Facts, records: &[SampleRecord], croissant_blake3: &str) -> String {
    let mut out = String::new();
    write(&mut out, facts, records, croissant_blake3).expect("writing to a String cannot fail");
    out
}

fn write(
    out: &mut String,
    facts: &Facts,
    records: &[SampleRecord],
    croissant_blake3: &str,
) -> Result<(), std::fmt::Error> {
    let s = &facts.summary;
    let size = match s.samples {
        0..1000 => "n<1K",
        1000..10_000 => "1K<n<10K",
        10_000..100_000 => "10K<n<100K",
        100_000..1_000_000 => "100K<n<1M",
        _ => "n>1M",
    };
    write!(
        out,
        "---\nlicense: cc0-1.0\npretty_name: satseed {short}\ntask_categories:\n- depth-estimation\ntags:\n- stereo-matching\n\
         - disparity\n- satellite\n- remote-sensing\n- synthetic\nsize_categories:\n- {size}\n---\n\n\
         # Synthetic satellite-stereo pairs with exact labels\n\n\
         {} pairs of {} scenes, {} bytes, {}. Every scene is grown from a seed, every image is rendered, every label is exact; \
         no photograph and no licensed asset is in it. Licence: CC0 1.0, do with it what you like.\n\n\
         Disparity is u_L - u_R in pixels, signed, pixel centres at integers, also where the right camera does not see the \
         point; `validity_left.png` has 0 nothing hit, 1 valid, 2 occluded, 3 out of frame. `gallery.html` shows all of it.\n\n",
        s.samples,
        s.scenes,
        s.bytes,
        words(&s.splits),
        short = &s.root_hash[..12],
    )?;
    write!(
        out,
        "## Make it again, check it\n\n    satseed generate recipe.toml --out again\n    satseed verify again --regenerate 3\n\n\
         | what | |\n|---|---|\n| root hash (BLAKE3 of `manifest.jsonl`, for citation) | {} |\n| program | {} |\n\
         | libraries (BLAKE3 of the lock file) | {} |\n| recipe (BLAKE3 of `recipe.toml`) | {} |\n| plan | {} |\n\
         | `croissant.json` (BLAKE3) | {croissant_blake3} |\n\n",
        s.root_hash, facts.program, facts.lock_blake3, facts.recipe_blake3, facts.plan
    )?;
    out.push_str("Seeds, by region and variant (parameters other than the defaults stand in `recipe.toml`):\n\n");
    let mut seeds: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
    for record in records {
        let r = &record.identity;
        seeds.entry(format!("{}/{}", r.region, r.variant)).or_default().insert(r.scene_seed);
    }
    for (name, seeds) in seeds {
        let seeds: Vec<_> = seeds.iter().map(u64::to_string).collect();
        writeln!(out, "- {name}: {}", seeds.join(", "))?;
    }
    out.push_str("\n## What is in it\n\nMeans over the pairs of a region; disparities are those of all hit pixels of the left views.\n\n");
    out.push_str("| region | scenes | pairs | splits | valid | occluded | out of frame | disparity, px |\n|---|---|---|---|---|---|---|---|\n");
    for r in &s.regions {
        let own = records.iter().filter(|x| x.identity.region == r.region && x.identity.variant == r.variant);
        let mean = |of: fn(&SampleRecord) -> f64| {
            let sum: f64 = own.clone().map(of).sum();
            format!("{:.2} %", 100.0 * sum / r.samples.max(1) as f64)
        };
        writeln!(
            out,
            "| {}/{} | {} | {} | {} | {} | {} | {} | {:.2} to {:.2} |",
            r.region,
            r.variant,
            r.scenes.len(),
            r.samples,
            words(&r.splits),
            mean(|x| x.valid_fraction),
            mean(|x| x.occluded_fraction),
            mean(|x| x.out_of_frame_fraction),
            r.disparity.from.first().unwrap_or(&0.0),
            r.disparity.to
        )?;
    }
    for (title, unit, of) in HISTOGRAMS {
        write!(out, "\n### {title}\n\n")?;
        histograms(out, &s.regions, unit, of)?;
    }
    out.push_str(
        "\n## What it is not\n\nNo real place, no real sensor. Cameras are ideal pinholes at the altitude that `camera.json` tells, \
         lower than an orbit, so towers lean more; there is one sun and one clear sky a dataset, and nothing moves between the views. Scores on it tell how a method \
         does on these scenes; hold them against real pairs before you conclude more.\n\n",
    );
    Ok(())
}

/// Title, unit, and which histogram of a region.
type Shown = (&'static str, &'static str, fn(&RegionSummary) -> &Histogram);

const HISTOGRAMS: [Shown; 3] = [
    ("Disparity of hit pixels", "px", |r| &r.disparity),
    ("Pairs by occluded share", "", |r| &r.occlusion),
    ("Pixels by local contrast (deviation in 9 x 9 pixels, grey levels)", "", |r| &r.texture),
];

/// One line a region: shares between borders.
fn histograms(
    out: &mut String,
    regions: &[RegionSummary],
    unit: &str,
    of: fn(&RegionSummary) -> &Histogram,
) -> Result<(), std::fmt::Error> {
    for r in regions {
        let h = of(r);
        let total = h.counts.iter().sum::<u64>().max(1) as f64;
        let bins: Vec<String> = h
            .counts
            .iter()
            .enumerate()
            .filter(|(_, n)| **n > 0)
            .map(|(i, n)| {
                let to = h.from.get(i + 1).copied().unwrap_or(h.to);
                format!("{} to {}: {:.2} %", short(h.from[i]), short(to), 100.0 * *n as f64 / total)
            })
            .collect();
        let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
        writeln!(out, "- {}/{}{unit}: {}", r.region, r.variant, bins.join(", "))?;
    }
    Ok(())
}

/// A border of a histogram, without digits that say nothing.
fn short(x: f64) -> String {
    let text = format!("{x:.*}", if x.abs() < 1.0 { 4 } else { 2 });
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn words(splits: &BTreeMap<String, usize>) -> String {
    splits.iter().map(|(name, n)| format!("{n} {name}")).collect::<Vec<_>>().join(", ")
}
