//! What shards wrote becomes the dataset of one run, or nothing does.

use super::bench::{Bench, assert_same, stderr_of, succeeds, text, tree};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn refused(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert_eq!(said.lines().filter(|line| !line.starts_with(" WARN")).count(), 1, "one sentence: {said}");
    said
}

fn first_sample(folder: &Path) -> PathBuf {
    let own = |path: &&PathBuf| path.ends_with("sample.json");
    folder.join(tree(folder).keys().find(own).unwrap().parent().unwrap())
}

#[test]
fn shards_at_once_in_one_folder() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    let out = bench.out("at-once");
    // Two of each: whoever comes second finds what it would have written.
    let shards: Vec<_> = ["1/3", "2/3", "3/3", "1/3", "2/3", "3/3"]
        .map(|shard| bench.generate(&out, &["--shard", shard, "--jobs", "1"]).spawn().unwrap())
        .into();
    for mut shard in shards {
        let status = shard.wait().unwrap();
        assert!(status.success(), "{}", stderr_of(&mut shard));
    }
    succeeds(&mut bench.merge(&out, &[]));
    assert_same(&tree(&out), &expected, "six writers of three shards");
    succeeds(&mut bench.merge(&out, &[]));
    assert_same(&tree(&out), &expected, "merged again");
}

#[test]
fn shards_of_job_arrays() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    let out = bench.out("array");
    for index in 0..2 {
        let mut task = bench.generate(&out, &["--shard", "auto/2"]);
        succeeds(task.env("JOB_COMPLETION_INDEX", index.to_string()).env_remove("SLURM_ARRAY_TASK_ID"));
    }
    succeeds(&mut bench.merge(&out, &["--no-pages"]));
    assert!(out.join("manifest.blake3").exists() && !out.join("gallery.html").exists());
    succeeds(&mut bench.merge(&out, &[]));
    assert_same(&tree(&out), &expected, "as a job array");
    let mut nowhere = bench.generate(&out, &["--shard", "auto"]);
    let said = refused(nowhere.env_remove("JOB_COMPLETION_INDEX").env_remove("SLURM_ARRAY_TASK_ID"));
    assert!(said.contains("neither is set"), "{said}");
}

#[test]
fn missing_samples_are_told_and_nothing_is_joined() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    let out = bench.out("missing");
    let said = refused(&mut bench.merge(&out, &[]));
    assert!(said.contains("missing"), "{said}");
    assert!(!out.exists());
    succeeds(&mut bench.generate(&out, &["--shard", "2/3"]));
    let before = tree(&out);
    let said = refused(&mut bench.merge(&out, &[]));
    assert!(said.contains("8 of 12 samples are missing, the first of them `toronto-core-"), "{said}");
    assert_same(&tree(&out), &before, "after a refusal");
    // A run without shards makes the rest.
    succeeds(&mut bench.generate(&out, &[]));
    assert_same(&tree(&out), &expected, "finished by one run");
}

#[test]
fn shards_in_folders_of_their_own() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    let own: Vec<String> = (1..=3).map(|i| format!("own-{i}")).collect();
    for (i, name) in own.iter().enumerate() {
        succeeds(&mut bench.generate(&bench.out(name), &["--shard", &format!("{}/3", i + 1)]));
    }
    let from: Vec<&str> = own.iter().flat_map(|name| ["--from", name.as_str()]).collect();
    let joined = bench.out("joined");
    let said = refused(&mut bench.merge(&joined, &from[..4]));
    assert!(said.contains("4 of 12 samples are missing"), "{said}");
    succeeds(&mut bench.merge(&joined, &from));
    assert_same(&tree(&joined), &expected, "three folders joined");

    // A file that is not what its record says, and then a record that agrees with it: another machine's sample.
    let sample = first_sample(&bench.out("own-1"));
    let file = sample.join("left.png");
    let (old, record) = (fs::read(&file).unwrap(), fs::read_to_string(sample.join("sample.json")).unwrap());
    let mut new = old.clone();
    *new.last_mut().unwrap() ^= 1;
    let [old_hash, new_hash] = [&old, &new].map(|content| blake3::hash(content).to_hex().to_string());
    fs::write(&file, &new).unwrap();
    let said = refused(&mut bench.merge(&bench.out("damaged"), &from));
    assert!(said.contains("left.png") && said.contains(&old_hash) && said.contains(&new_hash), "{said}");
    fs::write(sample.join("sample.json"), record.replace(&old_hash, &new_hash)).unwrap();
    let said = refused(&mut bench.merge(&joined, &from));
    assert!(said.contains("left.png") && said.contains(&old_hash) && said.contains(&new_hash), "{said}");
    assert_same(&tree(&joined), &expected, "after a difference");

    // Another plan's shard.
    succeeds(&mut bench.generate(&bench.out("other"), &["--seed", "4", "--shard", "1/3"]));
    let said = refused(&mut bench.merge(&joined, &["--from", "other"]));
    assert!(said.contains("holds another dataset"), "{said}");
}

#[test]
fn a_shard_that_finds_other_bytes_shows_both_hashes() {
    let bench = Bench::new();
    let out = bench.out("differs");
    succeeds(&mut bench.generate(&out, &["--shard", "1/3"]));
    let sample = first_sample(&out);
    fs::remove_file(sample.join("sample.json")).unwrap();
    let old = fs::read(sample.join("left.png")).unwrap();
    fs::write(sample.join("left.png"), b"of another machine").unwrap();
    let said = refused(&mut bench.generate(&out, &["--shard", "1/3"]));
    for content in [&old[..], b"of another machine"] {
        assert!(said.contains(blake3::hash(content).to_hex().as_str()), "{said}");
    }
    // Alone in the folder, a run knows that nobody else was promised it.
    succeeds(&mut bench.generate(&out, &[]));
    assert_eq!(fs::read(sample.join("left.png")).unwrap(), old);
}

#[test]
fn a_whole_run_and_a_shard_exclude_each_other() {
    let bench = Bench::new();
    let out = bench.out("locked");
    fs::create_dir(&out).unwrap();
    let alone = satseed::dataset::FolderLock::take(&out).unwrap();
    assert!(refused(&mut bench.generate(&out, &["--shard", "1/3"])).contains("another satseed is writing"));
    drop(alone);
    let _shard = satseed::dataset::FolderLock::share(&out).unwrap();
    assert!(refused(&mut bench.generate(&out, &[])).contains("another satseed is writing"));
    succeeds(&mut bench.generate(&out, &["--shard", "1/3"]));
    assert!(refused(&mut bench.merge(&out, &[])).contains("another satseed is writing"));
}
