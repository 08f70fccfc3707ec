//! `generate --profile`: what it says is what the system says, and it changes nothing.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use satseed::pipeline::{estimate, second_scene_bytes};
use satseed::plan::Plan;
use satseed::recipe::Recipe;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::small;

mod support;

fn generate(recipe: &Path, out: &Path, extra: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_satseed"));
    command.arg("generate").arg(recipe).arg("--out").arg(out).args(["--jobs", "2"]).args(extra);
    command.output().unwrap()
}

/// Processor time of all children that this process has waited for, s: fields 16 and 17 of proc(5)'s stat, in ticks of
/// 1/100 s.
fn childrens_cpu_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    fields[13..15].iter().map(|ticks| ticks.parse::<f64>().unwrap() / 100.0).sum()
}

fn files(folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else {
            found.insert(path.clone(), fs::read(path).unwrap());
        }
    }
}

/// One test only, since it reads what this process's children took.
#[test]
fn stages_add_up_to_what_the_process_took() {
    let folder = tempfile::tempdir().unwrap();
    let recipe = folder.path().join("recipe.toml");
    let text = small::recipe(&small::Recipe {
        gsd_m: 0.4,
        size_px: [96, 96],
        acquisition: "baseline_m = [40.0, 60.0]\nazimuth_deg = [20.0]",
        sensor: "worldview3_rgb",
        scenes: &["toronto = { radius_m = 70.0 }", "canyon = { radius_m = 60.0 }"],
    });
    fs::write(&recipe, &text).unwrap();
    let (plain, counted) = (folder.path().join("plain"), folder.path().join("counted"));
    // Too little memory for two scenes: built one after the other. Too little for one: refused.
    let plan = Plan::new(&Recipe::parse("recipe.toml", &text).unwrap()).unwrap();
    let two_scenes = estimate(&Recipe::parse("recipe.toml", &text).unwrap(), &plan).memory_bytes;
    let one_scene = two_scenes - second_scene_bytes(&plan);
    assert!(one_scene < two_scenes);
    let refused = generate(&recipe, &plain, &["--max-memory", &(one_scene - 1).to_string()]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(generate(&recipe, &plain, &["--max-memory", &one_scene.to_string()]).status.success());

    let file = folder.path().join("profile.json");
    let before_s = childrens_cpu_s();
    let output = generate(&recipe, &counted, &["--profile", file.to_str().unwrap()]);
    let cpu_s = childrens_cpu_s() - before_s;
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    let profile: serde_json::Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    eprintln!("{said}");

    // The system's own account has ticks of 10 ms; start and end of the process are in no stage.
    let number = |value: &serde_json::Value, key: &str| value[key].as_f64().unwrap();
    let stages = profile["stages"].as_array().unwrap();
    let sum_s: f64 = stages.iter().map(|s| number(s, "cpu_s")).sum();
    assert!(cpu_s > 1.0, "too short a run to be judged: {cpu_s} s");
    assert!(sum_s > 0.97 * cpu_s && sum_s < 1.01 * cpu_s + 0.05, "{sum_s} s in stages of {cpu_s} s:\n{said}");
    assert!((number(&profile, "other_cpu_s") + sum_s - number(&profile, "cpu_s")).abs() < 1e-6);

    let stage = |name: &str| stages.iter().find(|s| s["stage"] == name).unwrap();
    let runs = ["build_scene", "surface_models", "scene_files", "labels", "render", "sample_files"];
    // Rendering is two exposures and one coding of both for each of four pairs.
    assert_eq!(runs.map(|name| number(stage(name), "runs")), [2.0, 2.0, 2.0, 8.0, 12.0, 4.0]);
    // Four pairs of two views, each pixel with one ray for its label and one of its own for its colour at least.
    let pixels = f64::from(4 * 2 * 96 * 96);
    assert!(number(stage("labels"), "rays") > pixels && number(stage("render"), "rays") > pixels, "{said}");
    assert_eq!(number(stage("build_scene"), "rays"), 0.0);
    // Every pixel's label ray, and the corners of the edge label; one way back for each of what both cameras see at most.
    let kinds = |of: &serde_json::Value| {
        ["primary", "label", "sun", "sky"].map(|kind| of["rays_by_kind"][kind].as_f64().unwrap())
    };
    let labels = kinds(stage("labels"));
    assert_eq!(labels[0], pixels + f64::from(4 * 2 * 97 * 97));
    assert!(labels[1] > 0.3 * pixels && labels[1] <= pixels && labels[3] == 0.0, "{labels:?}");
    assert!(labels[2] <= 16.0 * pixels && labels[2] >= 4.0 * pixels, "{labels:?}");
    let render = kinds(stage("render"));
    assert!(render[0] > pixels && render[1] == 0.0 && render[2] > 0.0 && render[3] > 0.0, "{render:?}");
    for of in stages.iter().chain([&profile]) {
        assert_eq!(kinds(of).iter().sum::<f64>(), number(of, "rays"), "{said}");
    }
    assert!(stages.iter().all(|s| said.contains(&s["stage"].as_str().unwrap().replace('_', " "))), "{said}");
    // Two scenes are alive at once.
    let (peak, bound) = (number(&profile, "memory_peak_bytes"), number(&profile, "memory_bound_bytes"));
    assert!(peak > 1e7 && peak <= bound, "{peak} bytes of at most {bound}");
    assert_eq!(bound, two_scenes as f64);

    let (mut expected, mut found) = (BTreeMap::new(), BTreeMap::new());
    files(&plain, &mut expected);
    files(&counted, &mut found);
    let inside = |tree: BTreeMap<PathBuf, Vec<u8>>, root: &Path| -> BTreeMap<PathBuf, Vec<u8>> {
        tree.into_iter().map(|(path, bytes)| (path.strip_prefix(root).unwrap().to_owned(), bytes)).collect()
    };
    assert!(inside(found, &counted) == inside(expected, &plain), "a profile changes the dataset");

    // A file with times in it has no place in a dataset.
    let refused = generate(&recipe, &counted, &["--profile", counted.join("p.json").to_str().unwrap()]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(said.contains("choose a place outside"), "{said}");
    assert!(!counted.join("p.json").exists());
}
