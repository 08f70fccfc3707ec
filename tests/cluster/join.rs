//! Joining very many samples: memory stays flat and time grows in proportion.

use satseed::dataset::{Entry, SampleRecord, SceneContents, Store, StoreError, join};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const RECIPE: &str = "# satseed\nseed = 1\n";
const PAIRS: usize = 400;

/// A finished dataset of any size that is made as it is asked for: records as large as those of the published recipe.
struct Endless {
    /// A record between the places where its scene's name, its sample's name and a hash of its own stand: what is asked
    /// for is the joining, so that a record must cost little beside it.
    pieces: Vec<(String, Part)>,
    written: AtomicU64,
}

/// What follows a piece of a record.
#[derive(Clone, Copy)]
enum Part {
    Scene,
    Sample,
    Hash,
    /// That of a file which the scene's samples share.
    SceneHash,
    End,
}

/// Words that look like hashes, one after the other.
struct Hashes(u64);

impl Hashes {
    fn of(text: &str) -> Self {
        Self(
            text.bytes()
                .fold(0xcbf2_9ce4_8422_2325, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)),
        )
    }

    fn next(&mut self, line: &mut String) {
        for _ in 0..4 {
            self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            let word = self.0 ^ self.0 >> 29;
            line.extend((0..16).map(|k| char::from(b"0123456789abcdef"[(word >> (4 * k) & 15) as usize])));
        }
    }
}

impl Endless {
    fn new() -> Self {
        let file = |name: &str| {
            let (folder, hash) =
                if ["dsm", "dtm"].contains(&name) { ("<scene>", "scene hash") } else { ("<scene>/<sample>", "hash") };
            format!(
                "\"{name}\":{{\"path\":\"{folder}/{name}.tif\",\"bytes\":1000,\"blake3\":\"<{hash}>\",\"pixels_blake3\":\"<{hash}>\"}}"
            )
        };
        let recipe = format!(
            "\"recipe\":{{\"path\":\"recipe.toml\",\"bytes\":{},\"blake3\":\"{}\"}}",
            RECIPE.len(),
            blake3::hash(RECIPE.as_bytes()).to_hex()
        );
        // By name, as a record has them.
        let before = ["camera", "disparity_left", "disparity_right", "dsm", "dtm", "left"].map(file);
        let after = ["right", "validity_left", "validity_right"].map(file);
        let files = [&before[..], &[recipe], &after].concat().join(",");
        let template = format!(
            "{{\"id\":\"<scene>/<sample>\",\"region\":\"canyon\",\"variant\":\"gorge\",\"scene_seed\":7,\"split\":\"train\",\
             \"scene_params_hash\":\"9f03c1aa\",\"baseline_m\":100.0,\"azimuth_deg\":12.5,\"convergence_deg\":5.7,\
             \"valid_fraction\":0.5,\"occluded_fraction\":0.25,\"out_of_frame_fraction\":0.25,\"disparity_min_px\":-3.5,\
             \"disparity_max_px\":12.25,\"files\":{{{files}}}}}\n"
        );
        let mut pieces = Vec::new();
        let mut rest = template.as_str();
        while let Some((before, after)) = rest.split_once('<') {
            let (name, after) = after.split_once('>').unwrap();
            let part = match name {
                "scene" => Part::Scene,
                "sample" => Part::Sample,
                "hash" => Part::Hash,
                "scene hash" => Part::SceneHash,
                _ => unreachable!("{name}"),
            };
            pieces.push((before.to_owned(), part));
            rest = after;
        }
        pieces.push((rest.to_owned(), Part::End));
        Self { pieces, written: AtomicU64::new(0) }
    }

    /// A sample's record; every file has a hash of its own.
    fn record(&self, scene: &str, sample: &str, line: &mut String) {
        let mut of_scene = Hashes::of(scene);
        let mut of_sample = Hashes(of_scene.0 ^ Hashes::of(sample).0);
        for (text, part) in &self.pieces {
            line.push_str(text);
            match part {
                Part::Scene => line.push_str(scene),
                Part::Sample => line.push_str(sample),
                Part::Hash => of_sample.next(line),
                Part::SceneHash => of_scene.next(line),
                Part::End => {}
            }
        }
    }

    fn sample(n: usize) -> String {
        format!("b{:02}-a{:02}", n / 20, n % 20)
    }
}

impl Store for Endless {
    fn put(&self, _: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.written.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        Ok(())
    }
    fn put_chunks(&self, _: &str, chunks: &mut satseed::dataset::Chunks<'_>) -> Result<(), StoreError> {
        for chunk in chunks {
            self.written.fetch_add(chunk?.len() as u64, Ordering::Relaxed);
        }
        Ok(())
    }
    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError> {
        if let Some(scene) = path.strip_suffix("/part.jsonl") {
            let mut lines = String::new();
            for n in 0..PAIRS {
                self.record(scene, &Self::sample(n), &mut lines);
            }
            return Ok(lines.into_bytes());
        }
        let id = path.strip_suffix("/sample.json").unwrap();
        let (scene, sample) = id.split_once('/').unwrap();
        let mut line = String::new();
        self.record(scene, sample, &mut line);
        Ok(line.into_bytes())
    }
    fn size(&self, _: &str) -> Result<Option<u64>, StoreError> {
        Ok(None)
    }
    fn list(&self, scene: &str) -> Result<Vec<Entry>, StoreError> {
        assert!(!scene.is_empty(), "all of a dataset is too much to list");
        let entry = |path: String| Entry { path, bytes: Some(1000) };
        let mut entries = vec![entry(format!("{scene}/dsm.tif")), entry(format!("{scene}/dtm.tif"))];
        for n in 0..PAIRS {
            let sample = Self::sample(n);
            for name in
                ["camera", "disparity_left", "disparity_right", "left", "right", "validity_left", "validity_right"]
            {
                entries.push(entry(format!("{scene}/{sample}/{name}.tif")));
            }
            entries.push(entry(format!("{scene}/{sample}/sample.json")));
        }
        Ok(entries)
    }
    fn discard(&self, _: &str) -> Result<(), StoreError> {
        unreachable!("joining removes nothing")
    }
    fn clear_unfinished(&self) -> Result<(), StoreError> {
        Ok(())
    }
}

/// Memory of this process now, bytes.
#[cfg(target_os = "linux")]
fn resident_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    line.split_whitespace().next().unwrap().parse::<u64>().unwrap() * 1024
}

/// Joins so many samples: time, and the most memory that was seen between scenes.
#[cfg(target_os = "linux")]
fn joined(samples: usize) -> (Duration, u64) {
    let store = Endless::new();
    let most = AtomicU64::new(0);
    let names: Vec<String> = (0..PAIRS).map(Endless::sample).collect();
    let scenes = || {
        (0..samples / PAIRS).map(|i| {
            if i % 25 == 0 {
                most.fetch_max(resident_bytes(), Ordering::Relaxed);
            }
            SceneContents { name: format!("canyon-gorge-{i}"), samples: names.clone() }
        })
    };
    let began = Instant::now();
    let joined = join(&store, RECIPE, scenes).unwrap();
    let took = began.elapsed();
    assert_eq!(joined.samples, samples as u64);
    let mut line = String::new();
    store.record("canyon-gorge-1", "b00-a00", &mut line);
    let line = line.len() as u64;
    let written = store.written.load(Ordering::Relaxed);
    assert!(written > 2 * line * samples as u64, "parts and manifest: {written}");
    let most = most.into_inner();
    eprintln!(
        "{samples} samples: {:.2} s, {:.1} MB written, {:.1} MB resident",
        took.as_secs_f64(),
        written as f64 / 1e6,
        most as f64 / 1e6
    );
    (took, most)
}

#[cfg(target_os = "linux")]
fn holds(sizes: &[usize]) {
    let mut line = String::new();
    Endless::new().record("a", "b", &mut line);
    assert_eq!(SampleRecord::from_line(&line).unwrap().to_line(), line);
    joined(sizes[0]);
    let runs: Vec<_> = sizes.iter().map(|n| (*n, joined(*n))).collect();
    let (first, last) = (&runs[0], &runs[runs.len() - 1]);
    // A few MB are the allocator's; that of a list with every sample would be hundreds.
    assert!(last.1.1 < first.1.1 + (16 << 20), "{} and {} bytes resident", first.1.1, last.1.1);
    let per_sample = |run: &(usize, (Duration, u64))| run.1.0.as_secs_f64() / run.0 as f64;
    let ratio = per_sample(last) / per_sample(first);
    assert!((0.4..2.5).contains(&ratio), "time grows in proportion: {ratio}");
}

#[test]
#[cfg(target_os = "linux")]
fn memory_is_flat_and_time_in_proportion() {
    holds(&[8_000, 16_000, 32_000]);
}

/// Ten million, or as many as `SATSEED_SAMPLES` says, such as 100000000.
#[test]
#[ignore = "long"]
#[cfg(target_os = "linux")]
fn very_many_samples() {
    let most = std::env::var("SATSEED_SAMPLES").map_or(10_000_000, |text| text.parse().unwrap());
    holds(&[most / 100, most / 10, most]);
}
