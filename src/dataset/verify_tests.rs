//! What verify promises: every fault is named, and a sound dataset is not accused.

use super::sample::tests::synthetic;
use super::writer_tests::{contents, generate, scene_files};
use super::*;
use std::collections::BTreeMap;

/// Random numbers for a test.
struct Draws(blake3::OutputReader);

impl Draws {
    fn below(&mut self, n: u64) -> u64 {
        let mut word = [0; 8];
        self.0.fill(&mut word);
        u64::from_le_bytes(word) % n
    }

    fn pick<'a, T>(&mut self, items: &'a [T]) -> &'a T {
        &items[self.below(items.len() as u64) as usize]
    }
}

type Tree = BTreeMap<String, Vec<u8>>;

fn finished() -> Tree {
    let store = MemoryStore::default();
    generate(&store, &contents()).unwrap().unwrap();
    store.into_files()
}

fn store_of(tree: &Tree) -> MemoryStore {
    let store = MemoryStore::default();
    for (path, content) in tree {
        store.put(path, content).unwrap();
    }
    store
}

fn check(tree: &Tree) -> Report {
    let planned: Vec<String> = contents().ids().collect();
    verify(&store_of(tree), Some(&planned)).unwrap()
}

fn named(report: &Report) -> Vec<(&str, Fault)> {
    report.findings.iter().map(|f| (f.path.as_str(), f.fault)).collect()
}

#[test]
fn a_sound_dataset_is_fine() {
    let tree = finished();
    let report = check(&tree);
    assert_eq!(report.findings, []);
    assert_eq!((report.samples, report.files), (4, tree.len()));
    assert_eq!(report.root_hash, Some(ManifestHash::of(&tree["manifest.jsonl"]).hex()));
    assert_eq!(verify(&store_of(&tree), None).unwrap().findings, [], "also without its plan");
}

/// One random fault: the files that must be named, each with the faults it may be called.
fn break_once(tree: &mut Tree, rng: &mut Draws) -> Vec<(String, Vec<Fault>)> {
    let paths: Vec<String> = tree.keys().cloned().collect();
    let path = rng.pick(&paths).clone();
    match rng.below(6) {
        0 => {
            let content = tree.get_mut(&path).unwrap();
            let at = rng.below(content.len() as u64) as usize;
            content[at] ^= 1 << rng.below(8);
            vec![(path, vec![Fault::Changed, Fault::Truncated])]
        }
        1 => {
            let content = tree.get_mut(&path).unwrap();
            content.truncate(rng.below(content.len() as u64) as usize);
            vec![(path, vec![Fault::Truncated, Fault::Changed])]
        }
        2 => {
            tree.remove(&path);
            vec![(path, vec![Fault::Missing])]
        }
        3 => {
            let folder = path.rsplit_once('/').map_or(String::new(), |(f, _)| format!("{f}/"));
            let new = format!("{folder}extra-{}.png", rng.below(1000));
            tree.insert(new.clone(), tree[&path].clone());
            vec![(new, vec![Fault::Extra])]
        }
        4 => {
            let content = tree.get_mut(&path).unwrap();
            content.extend((0..=rng.below(9)).map(|_| b'x'));
            vec![(path, vec![Fault::Changed])]
        }
        _ => {
            // Two files of different content, which must both be named.
            let other = rng.pick(&paths).clone();
            let (a, b) = (tree[&path].clone(), tree[&other].clone());
            if a == b {
                return Vec::new();
            }
            tree.insert(path.clone(), b);
            tree.insert(other.clone(), a);
            let any = vec![Fault::Swapped, Fault::Changed, Fault::Truncated];
            vec![(path, any.clone()), (other, any)]
        }
    }
}

#[test]
fn a_thousand_random_faults_are_all_named() {
    let sound = finished();
    let mut rng = Draws(blake3::Hasher::new().update(b"faults").finalize_xof());
    let (mut faults, mut exact) = (0, 0);
    while faults < 1200 {
        let mut tree = sound.clone();
        let expected = break_once(&mut tree, &mut rng);
        if expected.is_empty() {
            continue;
        }
        faults += 1;
        let report = check(&tree);
        for (path, may_be) in &expected {
            let is_named = report.findings.iter().any(|f| f.path == *path && may_be.contains(&f.fault));
            assert!(is_named, "{path} should be {may_be:?}, but: {:#?}", report.findings);
        }
        exact += usize::from(report.findings.len() == expected.len());
    }
    // Nothing else is accused; only a swap of the manifest with its hash leaves nothing to hold others against.
    assert!(exact * 100 >= faults * 98, "{exact} of {faults} named exactly what was broken");
}

#[test]
fn swapped_files_are_told_from_changed_ones() {
    let mut tree = finished();
    let (a, b) = ("canyon-gorge-7/b00-a00/left.png", "canyon-gorge-7/b00-a01/right.png");
    let (x, y) = (tree[a].clone(), tree[b].clone());
    tree.insert(a.into(), y);
    tree.insert(b.into(), x);
    let report = check(&tree);
    assert_eq!(named(&report), [(a, Fault::Swapped), (b, Fault::Swapped)]);
    assert!(report.findings[0].detail.contains(b));
}

#[test]
fn whole_samples_and_scenes_that_are_gone_are_named() {
    for gone in ["canyon-gorge-7/b00-a01/", "canyon-gorge-7/"] {
        let mut tree = finished();
        let lost: Vec<String> = tree.keys().filter(|p| p.starts_with(gone)).cloned().collect();
        tree.retain(|p, _| !p.starts_with(gone));
        let report = check(&tree);
        assert!(report.findings.iter().all(|f| f.fault == Fault::Missing));
        assert!(report.findings.iter().map(|f| &f.path).eq(&lost), "{:?}", report.findings);
    }
}

#[test]
fn a_manifest_that_lost_a_sample_does_not_agree_with_its_recipe() {
    // A forger who takes a sample out everywhere and makes all hashes new is found by the plan.
    let store = MemoryStore::default();
    let mut contents = contents();
    contents.scenes[0].samples.pop();
    generate(&store, &contents).unwrap();
    let report = check(&store.into_files());
    assert_eq!(named(&report), [("canyon-gorge-7/b01-a00/sample.json", Fault::Missing)]);
}

#[test]
fn an_unfinished_dataset_says_how_much_is_made() {
    let store = MemoryStore::default();
    let contents = contents();
    let writer = Writer::open(&store, contents.clone()).unwrap();
    let scene = &contents.scenes[0].name;
    writer.put_scene(scene, &scene_files(scene)).unwrap();
    writer.put_sample(synthetic(scene, "b00-a01", 12, 9)).unwrap();
    store.put("canyon-gorge-7/b00-a00/left.png", b"left over").unwrap();
    let mut tree = store.into_files();
    let report = check(&tree);
    assert_eq!(named(&report), [("manifest.jsonl", Fault::Missing)]);
    assert!(report.findings[0].detail.contains("1 of 4 samples are made"), "{:?}", report.findings);
    assert_eq!((report.samples, report.samples_to_make), (1, 3));
    // What is recorded is still held to it.
    tree.get_mut("canyon-gorge-7/b00-a01/left.png").unwrap()[60] ^= 1;
    let report = check(&tree);
    assert!(named(&report).contains(&("canyon-gorge-7/b00-a01/left.png", Fault::Changed)));
}

/// Labels that contradict each other are found although every hash is right: made by a writer that did not look.
#[test]
fn labels_that_cannot_be_are_found_behind_right_hashes() {
    let mut tree = finished();
    let id = "toronto-core-7-9f03c1aa/b00-a00";
    let mut record =
        SampleRecord::from_line(&String::from_utf8(tree[&format!("{id}/sample.json")].clone()).unwrap()).unwrap();
    let validity = formats::Plane { width: 12, height: 9, pixels: formats::Pixels::Gray(vec![1; 108]) };
    let bytes = validity.encode().unwrap();
    let path = format!("{id}/validity_left.png");
    record.files.insert("validity_left".into(), FileRecord::of(path.clone(), &bytes, Some(validity.pixel_hash())));
    tree.insert(path, bytes);
    let line = record.to_line();
    let old = String::from_utf8(tree[&format!("{id}/sample.json")].clone()).unwrap();
    let manifest = String::from_utf8(tree["manifest.jsonl"].clone()).unwrap().replace(&old, &line);
    tree.insert(format!("{id}/sample.json"), line.clone().into_bytes());
    tree.insert("toronto-core-7-9f03c1aa/part.jsonl".into(), line.into_bytes());
    tree.insert("manifest.blake3".into(), ManifestHash::of(manifest.as_bytes()).to_file().into_bytes());
    tree.insert("manifest.jsonl".into(), manifest.into_bytes());
    let report = check(&tree);
    assert_eq!(named(&report), [("toronto-core-7-9f03c1aa/b00-a00/disparity_left.tif", Fault::Contradiction)]);
    assert!(report.findings[0].detail.contains("its validity is 1"), "{:?}", report.findings);
}
