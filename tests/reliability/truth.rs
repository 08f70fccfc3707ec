//! What `verify` and `info` say of a dataset.

use super::bench::{Bench, Draws, Tree, assert_same, succeeds, text, tree, verify};
use satseed::dataset::formats::{PixelKind, Pixels, Plane};
use satseed::dataset::{FileRecord, MANIFEST, ManifestHash, PAGES, PART, RECIPE, ROOT_HASH, SAMPLE, parse_lines};
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

/// A forger who changes a label and every hash after it passes all checks but one: what the seed makes. For that the recipe and
/// the manifest are enough, however little of the dataset lies beside them.
#[test]
fn making_again_finds_a_forged_label() {
    let bench = Bench::new();
    let out = bench.out("forged");
    succeeds(&mut bench.generate(&out, &[]));
    for page in PAGES {
        fs::remove_file(out.join(page)).unwrap();
    }
    let named = |report: &serde_json::Value, fault: &str| -> Vec<serde_json::Value> {
        report["findings"].as_array().unwrap().iter().filter(|f| f["fault"] == fault).cloned().collect()
    };
    let manifest_alone = |name: &str| {
        let part = bench.out(name);
        fs::create_dir(&part).unwrap();
        for file in [RECIPE, MANIFEST, ROOT_HASH] {
            fs::copy(out.join(file), part.join(file)).unwrap();
        }
        verify(&part, &["--regenerate", "12"]).1
    };
    let report = manifest_alone("sound-manifest");
    assert!(named(&report, "missing").len() > 100 && named(&report, "not-reproduced").is_empty(), "{report:#}");

    let manifest = fs::read_to_string(out.join(MANIFEST)).unwrap();
    let mut record = parse_lines(&manifest).unwrap().swap_remove(5);
    let old_line = record.to_line();
    let file = record.files["disparity_left"].clone();
    let mut plane = Plane::decode(&fs::read(out.join(&file.path)).unwrap(), PixelKind::Float, 32, 24).unwrap();
    let Pixels::Float(disparity_px) = &mut plane.pixels else { panic!("floats") };
    // Neither the lowest nor the highest, so that the record's statistics still hold.
    let [low, high] = [record.disparity_min_px.unwrap(), record.disparity_max_px.unwrap()];
    let at = disparity_px.iter().rposition(|d| *d > low && *d < high - 0.01).unwrap();
    disparity_px[at] += 0.01;
    let forged = disparity_px[at];
    let bytes = plane.encode().unwrap();
    let forged_file = FileRecord::of(file.path.clone(), &bytes, Some(plane.pixel_hash()));
    record.files.insert("disparity_left".to_owned(), forged_file.clone());
    let manifest = manifest.replace(&old_line, &record.to_line());
    fs::write(out.join(&file.path), bytes).unwrap();
    fs::write(out.join(record.id()).join(SAMPLE), record.to_line()).unwrap();
    fs::write(out.join(record.scene()).join(PART), &manifest).unwrap();
    fs::write(out.join(MANIFEST), &manifest).unwrap();
    fs::write(out.join(ROOT_HASH), ManifestHash::of(manifest.as_bytes()).to_file()).unwrap();
    let (code, report) = verify(&out, &[]);
    assert_eq!((code, report["findings"].as_array().unwrap().len()), (0, 0), "{report:#}");

    let (code, report) = verify(&out, &["--regenerate", "12"]);
    let findings = report["findings"].as_array().unwrap();
    assert_eq!((code, findings.len()), (1, 1), "{report:#}");
    let hashes = [&forged_file, &file].map(|f| f.pixels_blake3.clone().unwrap());
    let told = |finding: &serde_json::Value| {
        assert_eq!((&finding["path"], &finding["fault"]), (&file.path.clone().into(), &"not-reproduced".into()));
        let detail = finding["detail"].as_str().unwrap().to_owned();
        assert!(hashes.iter().all(|hash| detail.contains(hash)), "{detail}");
        detail
    };
    let place = format!("first at pixel ({}, {}): {forged} ", at % 32, at / 32);
    let detail = told(&findings[0]);
    assert!(detail.contains(&place), "{detail} / {place}");
    let report = manifest_alone("forged-manifest");
    let findings = named(&report, "not-reproduced");
    assert_eq!(findings.len(), 1, "{report:#}");
    told(&findings[0]);
}
