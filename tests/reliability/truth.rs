//! What `verify` and `info` say of a dataset.

use super::bench::{Bench, Draws, Tree, assert_same, succeeds, text, tree, verify};
use std::fs;
use std::path::PathBuf;
use std::process::Command;

#[test]
fn verify_and_info_tell_the_truth() {
    let bench = Bench::new();
    let out = bench.out("checked");
    succeeds(&mut bench.generate(&out, &[]));
    let (code, report) = verify(&out, &["--regenerate", "2"]);
    assert_eq!((code, report["findings"].as_array().unwrap().len()), (0, 0), "{report:#}");
    assert_eq!(report["samples"], 12);

    let paths: Vec<PathBuf> = tree(&out).into_keys().collect();
    let mut draws = Draws(11);
    for _ in 0..12 {
        let path = out.join(&paths[(draws.unit() * paths.len() as f64) as usize]);
        let sound = fs::read(&path).unwrap();
        let mut broken = sound.clone();
        let at = (draws.unit() * broken.len() as f64) as usize;
        broken[at] ^= 4;
        fs::write(&path, &broken).unwrap();
        let (code, report) = verify(&out, &[]);
        let findings = report["findings"].as_array().unwrap();
        assert_eq!(code, 1);
        assert_eq!(findings.len(), 1, "{report:#}");
        assert_eq!(out.join(findings[0]["path"].as_str().unwrap()), path);
        fs::write(&path, &sound).unwrap();
    }
    fs::write(out.join("notes.txt"), b"mine").unwrap();
    std::os::unix::fs::symlink("/etc/hostname", out.join("link.png")).unwrap();
    let (code, report) = verify(&out, &[]);
    let named: Vec<_> = report["findings"].as_array().unwrap().iter().map(|f| f["path"].as_str().unwrap()).collect();
    assert_eq!((code, named), (1, vec!["link.png", "notes.txt"]));
    fs::remove_file(out.join("notes.txt")).unwrap();
    fs::remove_file(out.join("link.png")).unwrap();

    let satseed = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_satseed"));
        command.arg(args[0]).arg(&out).args(&args[1..]);
        text(&succeeds(&mut command).stdout)
    };
    let info: serde_json::Value = serde_json::from_str(&satseed(&["info", "--json"])).unwrap();
    assert_eq!((&info["samples"], &info["scenes"]), (&12.into(), &1.into()));
    let pixels: u64 =
        info["regions"][0]["disparity"]["counts"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum();
    let hit: f64 = fs::read_to_string(out.join("manifest.jsonl"))
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap())
        .flat_map(|r| ["valid", "occluded", "out_of_frame"].map(|k| r[format!("{k}_fraction")].as_f64().unwrap()))
        .sum();
    assert_eq!(pixels, (hit * 32.0 * 24.0).round() as u64, "the histogram counts every hit pixel of the left views");
    let table = satseed(&["info"]);
    assert!(table.contains("toronto/core: 12 samples of 1 scenes") && table.contains("40.0 m"), "{table}");

    // The seed list makes the same scenes again.
    let seeds = bench.out("seeds.txt");
    fs::write(&seeds, satseed(&["info", "--seeds"])).unwrap();
    let again = bench.out("again");
    succeeds(&mut bench.generate(&again, &["--seeds", seeds.to_str().unwrap()]));
    let scene_files = |tree: Tree| -> Tree { tree.into_iter().filter(|(p, _)| p.ends_with("scene.json")).collect() };
    assert_same(&scene_files(tree(&again)), &scene_files(tree(&out)), "from the seed list");
}
