//! The program itself on a small recipe in a fresh folder, and trees of files to compare.

use crate::support::small;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A scene of twelve pairs. (tests/pipeline.rs has two scenes of both regions.)
fn recipe() -> String {
    small::recipe(&small::Recipe {
        gsd_m: 1.2,
        size_px: [32, 24],
        acquisition: "baseline_m = { from = 40.0, to = 60.0, steps = 3 }\nazimuth_deg = { from = -90.0, to = 90.0, draws = 4 }",
        sensor: "ideal",
        scenes: &["toronto = { radius_m = 60.0, trees = 0.0, vehicles = 0.0 }"],
    })
}

/// Larger frames: a run that takes long enough to be met in the middle.
pub(crate) const SLOW: [&str; 3] =
    ["--set=camera.size_px=[96, 96]", "--set=camera.gsd_m=0.4", "--set=sensor.samples_per_pixel=1"];

pub(crate) type Tree = BTreeMap<PathBuf, Vec<u8>>;

pub(crate) struct Bench {
    pub(crate) folder: tempfile::TempDir,
}

impl Bench {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("recipe.toml"), recipe()).unwrap();
        Self { folder }
    }

    pub(crate) fn out(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn generate(&self, out: &Path, extra: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_satseed"));
        command.arg("generate").arg(self.folder.path().join("recipe.toml")).arg("--out").arg(out).args(extra);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub(crate) fn merge(&self, out: &Path, extra: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_satseed"));
        command.arg("merge").arg(out).args(extra).current_dir(self.folder.path());
        command
    }

    /// The tree of an undisturbed run.
    pub(crate) fn undisturbed(&self, extra: &[&str]) -> Tree {
        let out = self.out("undisturbed");
        succeeds(&mut self.generate(&out, extra));
        tree(&out)
    }
}

pub(crate) fn succeeds(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", text(&output.stderr));
    output
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub(crate) fn tree(folder: &Path) -> Tree {
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

pub(crate) fn assert_same(found: &Tree, expected: &Tree, when: &str) {
    assert!(found.keys().eq(expected.keys()), "{when}: {:?}", found.keys().collect::<Vec<_>>());
    for (path, content) in expected {
        assert!(found[path] == *content, "{when}: {} differs", path.display());
    }
}

pub(crate) fn verify(out: &Path, extra: &[&str]) -> (i32, serde_json::Value) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_satseed")).arg("verify").arg(out).arg("--json").args(extra).output().unwrap();
    let report = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    (output.status.code().unwrap(), report)
}

/// Whether a folder was left in the middle of a sample: files, or an unfinished one, but no record.
pub(crate) fn in_a_sample(out: &Path) -> bool {
    let Ok(scenes) = fs::read_dir(out) else { return false };
    let folders = |path: PathBuf| fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
    scenes.flatten().filter(|s| s.path().is_dir()).flat_map(|s| folders(s.path())).any(|sample| {
        sample.is_dir()
            && !sample.join("sample.json").exists()
            && fs::read_dir(&sample).is_ok_and(|mut d| d.next().is_some())
    })
}

pub(crate) fn stderr_of(child: &mut Child) -> String {
    let mut said = String::new();
    if let Some(mut stderr) = child.stderr.take() {
        let _ = std::io::Read::read_to_string(&mut stderr, &mut said);
    }
    said
}

/// Waits until a run has recorded its first sample.
pub(crate) fn wait_for_a_sample(out: &Path, child: &mut Child) {
    let started = Instant::now();
    while !tree_has_a_record(out) {
        assert!(child.try_wait().unwrap().is_none(), "it ended too early: {}", stderr_of(child));
        assert!(started.elapsed() < Duration::from_secs(300), "no sample after 300 s");
        std::thread::sleep(Duration::from_millis(2));
    }
}

pub(crate) fn tree_has_a_record(out: &Path) -> bool {
    let folders = |path: &Path| fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
    folders(out).any(|scene| folders(&scene).any(|sample| sample.join("sample.json").exists()))
}

/// Random numbers: the moments of kills need no seed, but the same ones on each run help to repeat a failure.
pub(crate) struct Draws(pub(crate) u64);

impl Draws {
    pub(crate) fn unit(&mut self) -> f64 {
        // SplitMix64 (Steele, Lea, Flood 2014).
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
