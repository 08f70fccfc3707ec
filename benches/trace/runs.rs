//! Whole pairs and datasets, through the pipeline, with its own account of the stages.

use satseed::dataset::DiskStore;
use satseed::pipeline::{Options, Profile, generate};
use satseed::plan::{Plan, Shard};
use satseed::recipe::{Changes, Recipe};
use serde_json::{Value, json};
use std::sync::atomic::AtomicBool;

/// A run: a preset, and what is changed of it.
pub(crate) struct Run {
    preset: &'static str,
    set: &'static [&'static str],
}

const ALL_LABELS: &str =
    r#"labels.write=["disparity_right", "class", "elevation", "instance", "normal", "shadow", "edge"]"#;
const DEFAULT_LABELS: &str = r#"labels.write=["disparity_right", "class", "elevation"]"#;
const ONE_PAIR: [&str; 3] =
    ["acquisition.baseline_m=[100.0]", "acquisition.azimuth_deg=[23.0]", "camera.datum=\"pivot\""];

/// All runs, by name: the scene, its files and one pair of full size; and a small dataset.
pub(crate) const ALL: [(&str, Run); 7] = [
    ("pair/toronto", pair("toronto", &[ALL_LABELS, "sensor.samples_per_pixel=4"])),
    ("pair/canyon", pair("canyon", &[ALL_LABELS, "sensor.samples_per_pixel=4"])),
    ("pair/toronto-default-labels", pair("toronto", &[DEFAULT_LABELS, "sensor.samples_per_pixel=4"])),
    ("pair/canyon-default-labels", pair("canyon", &[DEFAULT_LABELS, "sensor.samples_per_pixel=4"])),
    ("pair/toronto-16-samples", pair("toronto", &[ALL_LABELS, "sensor.samples_per_pixel=16"])),
    ("pair/canyon-16-samples", pair("canyon", &[ALL_LABELS, "sensor.samples_per_pixel=16"])),
    ("dataset/quickstart", Run { preset: "quickstart", set: &[] }),
];

const fn pair(preset: &'static str, set: &'static [&'static str]) -> Run {
    Run { preset, set }
}

impl Run {
    /// Makes the dataset in a folder that is gone afterwards.
    pub(crate) fn measure(&self, name: &str, threads: usize) -> Value {
        let mut set: Vec<String> = self.set.iter().map(|s| (*s).to_owned()).collect();
        if name.starts_with("pair/") {
            set.extend(ONE_PAIR.map(str::to_owned));
            set.push(format!("scene=[{{{}={{}},seeds=[1]}}]", self.preset));
        }
        let recipe = Recipe::load(self.preset, &Changes { set, ..Changes::default() }).expect("a legal recipe");
        let plan = Plan::new(&recipe).expect("a legal plan");
        let folder = tempfile::tempdir().expect("a folder");
        let store = DiskStore::create(folder.path()).expect("a folder");
        let profile = Profile::begin();
        let options = Options {
            jobs: threads,
            build_ahead: true,
            shard: Shard::WHOLE,
            stop: &AtomicBool::new(false),
            profile: Some(&profile),
        };
        generate(&recipe, &plan, &store, options, &|_| ()).expect("the run ends well");
        let report = profile.report(threads);
        println!("{name}: {:.2} CPU s, {:.1} M rays", report.cpu_s, report.rays as f64 / 1e6);
        for s in report.stages.iter().filter(|s| s.runs > 0) {
            let rays = s.rays as f64 / 1e6;
            println!(
                "  {:15} {:8.2} CPU s {rays:8.1} M rays {:6.2} M a CPU s",
                s.stage.words(),
                s.cpu_s,
                rays / s.cpu_s
            );
        }
        json!({ "case": name, "pairs": plan.pair_count(), "profile": report })
    }
}
