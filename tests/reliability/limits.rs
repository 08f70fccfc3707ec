//! Memory and disk.

use super::bench::{Bench, assert_same, stderr_of, succeeds, text, tree, verify};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

/// The highest resident memory of a run that it says of itself, bytes.
fn peak_memory(command: &mut Command) -> u64 {
    let mut child = command.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        let kib = line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
        peak = peak.max(kib.unwrap_or(0) * 1024);
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(child.wait().unwrap().success(), "{}", stderr_of(&mut child));
    peak
}

#[test]
#[cfg(target_os = "linux")]
fn memory_stays_under_the_printed_bound() {
    use satseed::{pipeline::estimate, plan::Plan, recipe::Changes, recipe::Recipe};
    let bench = Bench::new();
    for (round, size) in [32, 128].into_iter().enumerate() {
        let set = vec![
            format!("camera.size_px=[{size}, {size}]"),
            format!("camera.gsd_m={}", 40.0 / f64::from(size)),
            "acquisition.pairs_per_pivot=2".to_owned(),
        ];
        let changes = Changes { set: set.clone(), seed: None, seed_list: None };
        let recipe = Recipe::load(bench.folder.path().join("recipe.toml").to_str().unwrap(), &changes).unwrap();
        let bound = estimate(&recipe, &Plan::new(&recipe).unwrap()).memory_bytes;
        let set: Vec<String> = set.into_iter().map(|s| format!("--set={s}")).collect();
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let peak = peak_memory(&mut bench.generate(&bench.out(&format!("run-{round}")), &set));
        eprintln!("{size} px: peak {} of at most {} MB", peak / 1_000_000, bound / 1_000_000);
        assert!(peak > 1_000_000, "the peak was not seen");
        assert!(peak <= bound, "{peak} bytes were used, but at most {bound} were told");
    }
}

/// A file system of a given size in memory; gone with this.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn mount(place: PathBuf, bytes: u64) -> Option<Self> {
        fs::create_dir_all(&place).unwrap();
        let size = format!("size={bytes}");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(&place).output();
        mounted.is_ok_and(|o| o.status.success()).then_some(Self(place))
    }

    fn grow(&self, bytes: u64) {
        let options = format!("remount,size={bytes}");
        assert!(Command::new("mount").args(["-o", &options]).arg(&self.0).status().unwrap().success());
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_says_so_and_keeps_what_stands() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    // What the tree takes in pages.
    let whole: u64 = expected.values().map(|c| (c.len() as u64).div_ceil(4096) * 4096).sum();
    for (i, share) in [0.002, 0.1, 0.35, 0.7, 0.97].into_iter().enumerate() {
        let size = ((whole as f64 * share) as u64).div_ceil(4096) * 4096;
        let Some(disk) = SmallDisk::mount(bench.out(&format!("disk-{i}")), size) else {
            eprintln!("skipped: a small file system can be mounted by root only");
            return;
        };
        let out = disk.0.join("data");
        let output = bench.generate(&out, &[]).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        let errors: Vec<_> = said.lines().filter(|l| l.starts_with("error: ")).collect();
        assert_eq!(errors.len(), 1, "{said}");
        assert!(errors[0].contains("no room for") && errors[0].contains("run the same command again"), "{said}");
        for (path, content) in tree(&disk.0) {
            let path = path.strip_prefix("data").unwrap().to_owned();
            assert!(expected.get(&path) == Some(&content), "{} is half a file", path.display());
        }
        // What is recorded verifies; the only thing wrong is that what is derived from records is not there yet.
        if out.join("recipe.toml").exists() {
            let (code, report) = verify(&out, &[]);
            // Where only the gallery found no room, nothing is wrong.
            assert_eq!(code, i32::from(!out.join("manifest.blake3").exists()));
            for finding in report["findings"].as_array().unwrap() {
                let path = finding["path"].as_str().unwrap();
                let derived = path.starts_with("manifest.") || path.ends_with("/part.jsonl");
                assert!(finding["fault"] == "missing" && derived, "{report:#}");
            }
        }
        disk.grow(4 * whole + (1 << 20));
        succeeds(&mut bench.generate(&out, &[]));
        assert_same(&tree(&out), &expected, "after the disk has grown");
    }
}
