//! Manifests, camera files and arrays out of thin air: whatever the bytes, they are read or refused in one sentence, and never a
//! panic. What is read can be written and read again.
//!
//! Predictions have a test of their own in `src/evaluate/prediction`, recipes and seed lists in `tests/recipe_fuzz.rs`.

#![allow(clippy::unwrap_used)]

mod support;

use satseed::dataset::formats::{HeightMap, PixelKind, Pixels, Plane, decode_height_map, encode_height_map};
use satseed::dataset::{
    Dataset, DiskStore, MANIFEST, MemoryStore, ROOT_HASH, Store, check_path, is_name, parse_lines, verify,
};
use satseed_scene::{Rng, SeedPath};
use std::process::Command;
use support::{mutate::mutate, small};

/// Texts that readers of records and cameras trip over.
const WORDS: &[&str] = &[
    "nan",
    "NaN",
    "1e999",
    "-0.0",
    "-1",
    "18446744073709551616",
    "1e-400",
    "null",
    "true",
    "{",
    "}",
    "[",
    "]",
    "\"",
    ",",
    ":",
    "\n",
    "\\",
    "\\u0000",
    "\\ud800",
    "\0",
    "../",
    "/",
    "..",
    ".",
    "\u{feff}",
    "é",
    "\u{202e}",
    "canyon",
    "\"id\":\"\"",
    "\"files\":{}",
    "\"width_px\": 4294967295",
    "[[[[[[[[[[[[[[[[",
];

/// A dataset of two pairs, made by the program, in memory.
fn dataset() -> MemoryStore {
    let folder = tempfile::tempdir().unwrap();
    let recipe = small::recipe(&small::Recipe {
        gsd_m: 1.2,
        size_px: [24, 20],
        acquisition: "baseline_m = [40.0]\nazimuth_deg = { from = -90.0, to = 90.0, draws = 2 }",
        sensor: "ideal",
        scenes: &["toronto = { radius_m = 60.0, trees = 0.0, vehicles = 0.0 }"],
    });
    std::fs::write(folder.path().join("recipe.toml"), recipe).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_satseed"));
    let run =
        command.arg("generate").arg(folder.path().join("recipe.toml")).arg("--out").arg(folder.path().join("out"));
    let run = run.arg("--quiet").output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let disk = DiskStore::open(&folder.path().join("out")).unwrap();
    let memory = MemoryStore::default();
    for entry in disk.list("").unwrap() {
        memory.put(&entry.path, &disk.get(&entry.path).unwrap()).unwrap();
    }
    memory
}

/// The same dataset with other content of a file.
fn with(sound: &MemoryStore, path: &str, content: &[u8]) -> MemoryStore {
    let changed = MemoryStore::default();
    for entry in sound.list("").unwrap() {
        let bytes = if entry.path == path { content.to_vec() } else { sound.get(&entry.path).unwrap() };
        changed.put(&entry.path, &bytes).unwrap();
    }
    changed
}

/// An error is one short line that a terminal can show.
fn judge(told: &str, input: &[u8]) {
    let input = || String::from_utf8_lossy(&input[..input.len().min(400)]).into_owned();
    assert!(!told.is_empty() && told.len() < 1000, "{} characters: {told}\nfrom {}", told.len(), input());
    assert!(!told.chars().any(char::is_control), "{told:?}\nfrom {}", input());
}

/// Whether a manifest was read: names and paths are those of a dataset, and each record is written as it is read.
fn manifest_is_read(bytes: &[u8]) -> bool {
    match parse_lines(&String::from_utf8_lossy(bytes)) {
        Ok(records) => {
            for record in records {
                assert!(record.id().split('/').count() == 2 && record.id().split('/').all(is_name));
                assert!(record.files.values().all(|file| check_path(&file.path).is_ok()));
                assert_eq!(parse_lines(&record.to_line()).unwrap(), [record]);
            }
            true
        }
        Err(error) => {
            judge(&error.to_string(), bytes);
            false
        }
    }
}

/// Pixels of each kind that a dataset can hold, 7 x 5.
fn planes(rng: &mut Rng) -> Vec<Plane> {
    let mut bytes = |n: usize| (0..35 * n).map(|_| rng.below(256) as u8).collect::<Vec<u8>>();
    let floats =
        |bytes: Vec<u8>| bytes.into_iter().map(|b| if b == 7 { f32::NAN } else { f32::from(b) / 3.0 }).collect();
    let counts = |bytes: Vec<u8>| bytes.into_iter().map(|b| u16::from(b) * 8).collect();
    let mut all = vec![
        Pixels::Gray(bytes(1)),
        Pixels::Rgb(bytes(3)),
        Pixels::Bytes4(bytes(4)),
        Pixels::Float(floats(bytes(1))),
        Pixels::Id(bytes(1).into_iter().map(u32::from).collect()),
        Pixels::Vector(bytes(3).into_iter().map(i16::from).collect()),
    ];
    for n in [1, 3, 4] {
        all.push(Pixels::Counts(n, counts(bytes(n.into()))));
        all.push(Pixels::Radiance(n, floats(bytes(n.into()))));
        all.push(Pixels::SceneLinear(n, floats(bytes(n.into()))));
    }
    all.into_iter().map(|pixels| Plane { width: 7, height: 5, pixels }).collect()
}

/// A PNG's chunks with sums that fit what was changed in them: else nothing behind the first sum is ever reached.
fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while at + 12 <= bytes.len() {
        let length = u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]) as usize;
        let Some(end) = at.checked_add(8 + length).filter(|end| end + 4 <= bytes.len()) else { break };
        // CRC-32 of the PNG specification, annex D.
        let mut crc = u32::MAX;
        for byte in &bytes[at + 4..end] {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
            }
        }
        bytes[end..end + 4].copy_from_slice(&(!crc).to_be_bytes());
        at = end + 4;
    }
}

/// Whether an array was read: it has the size and kind that were asked for, and is encoded and read again as the same.
fn plane_is_read(bytes: &[u8], kind: PixelKind) -> bool {
    match Plane::decode(bytes, kind, 7, 5) {
        Ok(plane) => {
            assert_eq!((plane.width, plane.height, plane.kind()), (7, 5, kind));
            let again = Plane::decode(&plane.encode().unwrap(), kind, 7, 5).unwrap();
            assert_eq!(again.pixel_hash(), plane.pixel_hash());
            true
        }
        Err(error) => {
            judge(&error.to_string(), bytes);
            false
        }
    }
}

fn height_map() -> HeightMap {
    let heights_m = (0..35).map(|i| if i == 3 { f32::NAN } else { i as f32 * 0.5 - 4.0 }).collect();
    HeightMap { west_m: -3.0, south_m: -2.0, cell_m: 0.5, width: 7, height: 5, heights_m }
}

/// 3,000 manifests, 2,000 cameras, 6,000 arrays read in three ways, 2,000 height maps.
fn mutate_and_judge(seed: u64) {
    let mut rng = SeedPath::root("dataset-fuzz", seed).rng();
    let mut legal = [0; 4];
    let sound = dataset();
    let manifest = sound.get(MANIFEST).unwrap();
    assert!(manifest_is_read(&manifest) && verify(&sound, None).unwrap().is_fine());
    for k in 0..3000 {
        let mut bytes = manifest.clone();
        mutate(&mut bytes, WORDS, &mut rng);
        legal[0] += u32::from(manifest_is_read(&bytes));
        // The whole dataset now and then: verify names what is wrong, or nothing is.
        if k % 30 == 0 {
            let path = [MANIFEST, ROOT_HASH][k / 30 % 2];
            let mut bytes = sound.get(path).unwrap();
            mutate(&mut bytes, WORDS, &mut rng);
            let report = verify(&with(&sound, path, &bytes), None).unwrap();
            assert_eq!(report.is_fine(), bytes == sound.get(path).unwrap(), "{report:?}");
            report.findings.iter().for_each(|finding| judge(&finding.detail, &bytes));
        }
    }
    let dataset = Dataset::open(&sound).unwrap();
    let record = &dataset.records()[0];
    let camera = sound.get(&record.files["camera"].path).unwrap();
    for _ in 0..2000 {
        let mut bytes = camera.clone();
        mutate(&mut bytes, WORDS, &mut rng);
        let changed = MemoryStore::default();
        changed.put(MANIFEST, &manifest).unwrap();
        changed.put(&record.files["camera"].path, &bytes).unwrap();
        match Dataset::open(&changed).unwrap().camera(record) {
            Ok(camera) => {
                assert!(
                    [&camera.left, &camera.right].iter().all(|c| (1..=16384).contains(&c.width_px.max(c.height_px)))
                );
                legal[1] += 1;
            }
            Err(error) => judge(&error.to_string(), &bytes),
        }
    }
    for plane in planes(&mut rng) {
        let encoded = plane.encode().unwrap();
        assert!(plane_is_read(&encoded, plane.kind()));
        for _ in 0..400 {
            let mut bytes = encoded.clone();
            mutate(&mut bytes, WORDS, &mut rng);
            if plane.kind().extension() == "png" && rng.chance(0.8) {
                mend_png(&mut bytes);
            }
            legal[2] += u32::from(plane_is_read(&bytes, plane.kind()));
            // What says of itself what it is, and of another size than was asked for.
            let kinds = [PixelKind::Rgb, PixelKind::Gray, PixelKind::Counts(3), PixelKind::SceneLinear(1)];
            let _ = Plane::decode_one_of(&bytes, &kinds, 7, 5).map_err(|e| judge(&e.to_string(), &bytes));
            let _ = Plane::decode(&bytes, plane.kind(), 16384, 16384).map_err(|e| judge(&e.to_string(), &bytes));
        }
    }
    let encoded = encode_height_map(&height_map()).unwrap();
    for _ in 0..2000 {
        let mut bytes = encoded.clone();
        mutate(&mut bytes, WORDS, &mut rng);
        match decode_height_map(&bytes, 1000) {
            Ok(map) => {
                assert_eq!(map.heights_m.len(), map.width as usize * map.height as usize);
                assert!(map.heights_m.len() <= 1000 && map.cell_m > 0.0 && map.west_m.is_finite());
                legal[3] += 1;
            }
            Err(error) => judge(&error.to_string(), &bytes),
        }
    }
    // The mutations are mild enough that some stay legal: both ways are walked.
    assert!(legal.iter().all(|n| *n > 50), "{legal:?}");
}

#[test]
fn mutated_datasets_never_panic() {
    mutate_and_judge(20);
}

/// Over a million inputs.
#[test]
#[ignore = "long: run by ./check --long"]
fn many_mutated_datasets_never_panic() {
    (100..150).for_each(mutate_and_judge);
}
