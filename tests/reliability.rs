//! Nothing is lost: kills, full disks, signals, second processes, faults, shards, through the program itself.
//!
//! The short versions run always; `cargo test -- --ignored` runs the long ones.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A small scene of twelve pairs with all labels. (tests/pipeline.rs has two scenes of both regions.)
const RECIPE: &str = r#"
seed = 3
[camera]
altitude_m = 1000.0
gsd_m = 1.2
size_px = [32, 24]
datum = "pivot"
[acquisition]
baseline_m = { from = 40.0, to = 60.0, steps = 3 }
azimuth_deg = { from = -90.0, to = 90.0, draws = 4 }
[sensor]
preset = "ideal"
samples_per_pixel = 1
[labels]
write = ["disparity_right", "class", "elevation", "instance", "normal", "shadow", "edge"]
[[scene]]
toronto = { radius_m = 60.0, trees = 0.0, vehicles = 0.0 }
pivots = 1
"#;

/// Larger frames: a run that takes long enough to be met in the middle.
const SLOW: [&str; 3] = ["--set=camera.size_px=[96, 96]", "--set=camera.gsd_m=0.4", "--set=sensor.samples_per_pixel=1"];

type Tree = BTreeMap<PathBuf, Vec<u8>>;

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("recipe.toml"), RECIPE).unwrap();
        Self { folder }
    }

    fn out(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn generate(&self, out: &Path, extra: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_satseed"));
        command.arg("generate").arg(self.folder.path().join("recipe.toml")).arg("--out").arg(out).args(extra);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// The tree of an undisturbed run.
    fn undisturbed(&self, extra: &[&str]) -> Tree {
        let out = self.out("undisturbed");
        succeeds(&mut self.generate(&out, extra));
        tree(&out)
    }
}

fn succeeds(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", text(&output.stderr));
    output
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn tree(folder: &Path) -> Tree {
    fn walk(folder: &Path, root: &Path, tree: &mut Tree) {
        for entry in fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            if entry.file_type().unwrap().is_dir() {
                walk(&entry.path(), root, tree);
            } else {
                let path = entry.path().strip_prefix(root).unwrap().to_owned();
                tree.insert(path, fs::read(entry.path()).unwrap());
            }
        }
    }
    let mut tree = Tree::new();
    walk(folder, folder, &mut tree);
    tree
}

fn assert_same(found: &Tree, expected: &Tree, when: &str) {
    assert!(found.keys().eq(expected.keys()), "{when}: {:?}", found.keys().collect::<Vec<_>>());
    for (path, content) in expected {
        assert!(found[path] == *content, "{when}: {} differs", path.display());
    }
}

fn verify(out: &Path, extra: &[&str]) -> (i32, serde_json::Value) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_satseed")).arg("verify").arg(out).arg("--json").args(extra).output().unwrap();
    let report = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    (output.status.code().unwrap(), report)
}

/// Whether a folder was left in the middle of a sample: files, or an unfinished one, but no record.
fn in_a_sample(out: &Path) -> bool {
    let Ok(scenes) = fs::read_dir(out) else { return false };
    let folders = |path: PathBuf| fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
    scenes.flatten().filter(|s| s.path().is_dir()).flat_map(|s| folders(s.path())).any(|sample| {
        sample.is_dir()
            && !sample.join("sample.json").exists()
            && fs::read_dir(&sample).is_ok_and(|mut d| d.next().is_some())
    })
}

/// Random numbers: the moments of kills need no seed, but the same ones on each run help to repeat a failure.
struct Draws(u64);

impl Draws {
    fn unit(&mut self) -> f64 {
        // SplitMix64 (Steele, Lea, Flood 2014).
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// How many samples were begun.
fn begun(out: &Path) -> usize {
    let folders = |path: &Path| -> Vec<PathBuf> {
        let all = fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
        all.filter(|p| p.is_dir()).collect()
    };
    folders(out).iter().map(|scene| folders(scene).len()).sum()
}

/// Kills a run at random moments again and again until it is complete, until `kills` kills are done. Every third kill
/// comes at a random moment of the whole run, the others at a random moment of the time that a sample takes to write,
/// since a scene takes longer to build than its samples to write.
fn kill_and_resume(kills: usize) {
    let bench = Bench::new();
    let out = bench.out("undisturbed");
    let started = Instant::now();
    let mut child = bench.generate(&out, &[]).spawn().unwrap();
    while begun(&out) == 0 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    let first = Instant::now();
    while !tree_has_a_record(&out) && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    let one_sample = first.elapsed();
    assert!(child.wait().unwrap().success());
    let whole = started.elapsed();
    let expected = tree(&out);
    let (mut done, mut in_samples, mut rounds) = (0, 0, 0);
    let mut draws = Draws(7);
    // On a slow machine a kill comes late and misses its sample, so it goes on until half of the kills have met one.
    let enough = |done: usize, in_samples: usize| done >= kills && 2 * in_samples >= kills;
    while !enough(done, in_samples) {
        assert!(done < 4 * kills, "only {in_samples} of {done} kills met a sample's writes");
        let out = bench.out(&format!("killed-{rounds}"));
        rounds += 1;
        loop {
            let before = begun(&out);
            let mut child = bench.generate(&out, &[]).spawn().unwrap();
            if done % 3 == 0 {
                std::thread::sleep(whole.mul_f64(draws.unit()));
            } else {
                while begun(&out) == before && child.try_wait().unwrap().is_none() {
                    std::thread::sleep(Duration::from_micros(200));
                }
                std::thread::sleep(one_sample.mul_f64(draws.unit()));
            }
            // SIGKILL; an error means that it has ended by itself.
            child.kill().unwrap();
            let status = child.wait().unwrap();
            if status.success() {
                break;
            }
            assert_eq!(status.code(), None, "killed, not failed: {}", stderr_of(&mut child));
            done += 1;
            in_samples += usize::from(in_a_sample(&out));
            if enough(done, in_samples) {
                succeeds(&mut bench.generate(&out, &[]));
                break;
            }
        }
        assert_same(&tree(&out), &expected, &format!("after {done} kills"));
        fs::remove_dir_all(&out).unwrap();
    }
    eprintln!("{done} kills in {rounds} runs, {in_samples} of them in the middle of a sample");
}

fn stderr_of(child: &mut Child) -> String {
    let mut said = String::new();
    if let Some(mut stderr) = child.stderr.take() {
        let _ = std::io::Read::read_to_string(&mut stderr, &mut said);
    }
    said
}

#[test]
fn kills_lose_nothing() {
    kill_and_resume(12);
}

#[test]
#[ignore = "long: 200 kills"]
fn two_hundred_kills_lose_nothing() {
    kill_and_resume(200);
}

/// Waits until a run has recorded its first sample.
fn wait_for_a_sample(out: &Path, child: &mut Child) {
    let started = Instant::now();
    while !tree_has_a_record(out) {
        assert!(child.try_wait().unwrap().is_none(), "it ended too early: {}", stderr_of(child));
        assert!(started.elapsed() < Duration::from_secs(300), "no sample after 300 s");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn tree_has_a_record(out: &Path) -> bool {
    let folders = |path: &Path| fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
    folders(out).any(|scene| folders(&scene).any(|sample| sample.join("sample.json").exists()))
}

#[test]
fn signals_stop_at_a_samples_border() {
    let bench = Bench::new();
    let out = bench.out("stopped");
    for (round, signal) in ["-TERM", "-INT"].into_iter().enumerate() {
        let mut child = bench.generate(&out, &SLOW).spawn().unwrap();
        if round == 0 {
            wait_for_a_sample(&out, &mut child);
        } else {
            std::thread::sleep(Duration::from_millis(100));
        }
        let sent = Command::new("kill").arg(signal).arg(child.id().to_string()).status().unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(75), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("run the same command again"), "{}", text(&output.stderr));
        assert!(!in_a_sample(&out), "stopped within a sample");
        assert!(!out.join("manifest.jsonl").exists());
    }
    succeeds(&mut bench.generate(&out, &SLOW));
    assert_same(&tree(&out), &bench.undisturbed(&SLOW), "after two signals");
}

#[test]
fn a_second_process_is_refused_and_a_dead_owners_lock_is_taken_over() {
    let bench = Bench::new();
    let out = bench.out("shared");
    let mut first = bench.generate(&out, &SLOW).spawn().unwrap();
    wait_for_a_sample(&out, &mut first);
    let second = bench.generate(&out, &SLOW).output().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).contains("another satseed is writing into"), "{}", text(&second.stderr));
    first.kill().unwrap();
    first.wait().unwrap();
    succeeds(&mut bench.generate(&out, &SLOW));
    assert_same(&tree(&out), &bench.undisturbed(&SLOW), "after the owner's death");
}

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

#[test]
fn runs_shards_threads_and_surroundings_give_equal_trees() {
    let bench = Bench::new();
    let expected = bench.undisturbed(&[]);
    let out = bench.out("elsewhere");
    let mut other = bench.generate(&out, &["--jobs", "3"]);
    other.current_dir("/").env("LC_ALL", "tr_TR.UTF-8").env("TZ", "Asia/Kathmandu").env("TMPDIR", "/nowhere");
    let printed = succeeds(&mut other).stdout;
    assert_same(&tree(&out), &expected, "elsewhere");
    let root = &expected[Path::new("manifest.blake3")];
    assert_eq!(text(&printed).trim(), &text(root)[..64]);

    let shards = bench.out("shards");
    for shard in ["2/3", "3/3", "2/3", "1/3"] {
        succeeds(&mut bench.generate(&shards, &["--shard", shard, "--jobs", "1"]));
    }
    assert_same(&tree(&shards), &expected, "three shards in one folder");
    // Shards on machines of their own: the union of their files, without what the last one derives.
    let mut union = Tree::new();
    for shard in ["1/3", "2/3", "3/3"] {
        let own = bench.out(&format!("own-{}", &shard[..1]));
        succeeds(&mut bench.generate(&own, &["--shard", shard]));
        for (path, content) in tree(&own) {
            let other = union.insert(path.clone(), content.clone());
            assert!(other.is_none_or(|o| o == content), "{} differs between shards", path.display());
        }
    }
    let derived =
        |p: &Path| p.ends_with("part.jsonl") || p.starts_with("manifest.jsonl") || p.starts_with("manifest.blake3");
    union.retain(|p, _| !derived(p));
    let samples: Tree = expected.into_iter().filter(|(p, _)| !derived(p)).collect();
    assert_same(&union, &samples, "the shards' union");
}

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
            assert_eq!(code, 1);
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
