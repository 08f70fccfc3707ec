//! Folders that hold something else.

use super::bench::{Bench, assert_same, succeeds, text, tree, verify};
use satseed::recipe::STAGES;
use std::fs;
use std::process::Command;

#[test]
fn other_plans_and_foreign_files_are_refused() {
    let bench = Bench::new();
    let out = bench.out("taken");
    succeeds(&mut bench.generate(&out, &[]));
    let before = tree(&out);
    let other = bench.generate(&out, &["--seed", "4"]).output().unwrap();
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("holds another dataset"), "{}", text(&other.stderr));
    assert_same(&tree(&out), &before, "after another plan");

    let photos = bench.out("photos");
    fs::create_dir(&photos).unwrap();
    fs::write(photos.join("holiday.jpg"), b"mine").unwrap();
    let refused = bench.generate(&photos, &[]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("`holiday.jpg` stands in the folder"), "{}", text(&refused.stderr));
    assert_eq!(tree(&photos).len(), 1);

    let small = bench.out("small");
    let refused = bench.generate(&small, &["--max-memory", "1MB"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("more than the 1.0 MB of --max-memory"), "{}", text(&refused.stderr));
    assert!(!small.exists());
    assert!(succeeds(&mut bench.generate(&small, &["--dry-run"])).stdout.starts_with(b"pairs    12 of 1 scenes"));
    assert!(!small.exists());
}

/// A dataset that another version of a stage began is neither gone on with nor held against what this one makes.
#[test]
fn another_versions_dataset_is_told_in_a_sentence() {
    let bench = Bench::new();
    let out = bench.out("begun-by-another");
    succeeds(&mut bench.generate(&out, &["--shard", "1/3"]));
    let recipe = out.join("recipe.toml");
    let own = fs::read_to_string(&recipe).unwrap();
    let line = |version: u32| format!("[stages]\nplan = {}\nrender = {version}\n", STAGES[0].version);
    let other = own.replace(&line(STAGES[1].version), &line(STAGES[1].version + 6));
    assert_ne!(own, other);
    fs::write(&recipe, &other).unwrap();
    let before = tree(&out);

    let resumed = bench.generate(&out, &[]).output().unwrap();
    let said = text(&resumed.stderr);
    assert_eq!(resumed.status.code(), Some(2), "{said}");
    let versions = format!("begun with version {} of stage `render`, but this one has version", STAGES[1].version + 6);
    assert!(said.contains(&versions) && said.contains("would be mixed"), "{said}");
    assert_same(&tree(&out), &before, "after another version's run");

    let (_, report) = verify(&out, &[]);
    let notes = report["notes"].to_string();
    assert!(notes.contains("against its own hashes only") && notes.contains("of stage render, this build"), "{notes}");
    let mut again = Command::new(env!("CARGO_BIN_EXE_satseed"));
    let again = again.arg("verify").arg(&out).args(["--regenerate", "1"]).output().unwrap();
    let said = text(&again.stderr);
    assert_eq!(again.status.code(), Some(2), "{said}");
    assert!(said.contains("other bytes would come out"), "{said}");
}
