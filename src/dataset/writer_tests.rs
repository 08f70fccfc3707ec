//! What the writer promises, held against stores that fail.

use super::formats::HeightMap;
use super::sample::tests::synthetic;
use super::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};

pub(crate) fn contents() -> Contents {
    let scene = |name: &str, samples: &[&str]| SceneContents {
        name: name.to_owned(),
        samples: samples.iter().map(|s| (*s).to_owned()).collect(),
    };
    let layers = synthetic("a", "b", 4, 4).planes.iter().map(|(l, v, p)| (*l, *v, p.kind())).collect();
    Contents {
        recipe_toml: "# satseed 0.1.0\n# plan 0123\nseed = 1\n".into(),
        scenes: vec![
            scene("canyon-gorge-7", &["b00-a00", "b00-a01", "b01-a00"]),
            scene("toronto-core-7-9f03c1aa", &["b00-a00"]),
        ],
        layers,
    }
}

pub(crate) fn scene_files(scene: &str) -> SceneFiles {
    let map = |z: f32| HeightMap {
        west_m: -2.0,
        south_m: -2.0,
        cell_m: 1.0,
        width: 5,
        height: 5,
        heights_m: (0..25).map(|i| z + i as f32).collect(),
    };
    SceneFiles { scene_json: format!("{{\"name\": \"{scene}\"}}\n"), dsm: map(10.0), dtm: map(0.0), ndsm: map(3.0) }
}

/// Makes a whole dataset, or as much of it as the store allows.
pub(crate) fn generate(store: &dyn Store, contents: &Contents) -> Result<Option<ManifestHash>, WriteError> {
    let writer = Writer::open(store, contents.clone())?;
    for scene in &contents.scenes {
        writer.put_scene(&scene.name, &scene_files(&scene.name))?;
        for sample in &scene.samples {
            let sample = synthetic(&scene.name, sample, 12, 9);
            if !writer.is_recorded(&sample.identity.id) {
                writer.put_sample(sample)?;
            }
        }
        assert!(writer.finish_scene(&scene.name)?);
    }
    writer.finish()
}

fn tree(store: &dyn Store) -> BTreeMap<String, Vec<u8>> {
    store.list("").unwrap().into_iter().map(|e| (e.path.clone(), store.get(&e.path).unwrap())).collect()
}

/// Fails at the n-th change and at every later one, as a process does that was killed there.
struct Mortal<'a> {
    store: &'a MemoryStore,
    changes_left: AtomicU32,
}

impl Mortal<'_> {
    fn live(&self, path: &str) -> Result<(), StoreError> {
        let left = self.changes_left.load(Ordering::Relaxed);
        if left == 0 {
            return Err(StoreError::Full { path: path.to_owned(), bytes: 0 });
        }
        self.changes_left.store(left - 1, Ordering::Relaxed);
        Ok(())
    }
}

impl Store for Mortal<'_> {
    fn put(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        // A put that meets its path taken changes nothing.
        if self.store.size(path)?.is_none() {
            self.live(path)?;
        }
        self.store.put(path, bytes)
    }
    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError> {
        self.store.get(path)
    }
    fn size(&self, path: &str) -> Result<Option<u64>, StoreError> {
        self.store.size(path)
    }
    fn list(&self, prefix: &str) -> Result<Vec<Entry>, StoreError> {
        self.store.list(prefix)
    }
    fn discard(&self, path: &str) -> Result<(), StoreError> {
        self.live(path)?;
        self.store.discard(path)
    }
    fn clear_unfinished(&self) -> Result<(), StoreError> {
        Ok(())
    }
}

fn finished() -> (MemoryStore, ManifestHash) {
    let store = MemoryStore::default();
    let hash = generate(&store, &contents()).unwrap().unwrap();
    (store, hash)
}

#[test]
fn the_tree_is_what_the_plan_says() {
    let (store, hash) = finished();
    let tree = tree(&store);
    assert!(tree.keys().eq(contents().paths().iter()));
    let manifest = String::from_utf8(tree["manifest.jsonl"].clone()).unwrap();
    let records = parse_lines(&manifest).unwrap();
    assert!(records.iter().map(|r| r.id().to_owned()).eq(contents().ids()), "in plan order");
    assert_eq!(tree["manifest.blake3"], hash.to_file().as_bytes());
    for record in &records {
        for (name, file) in &record.files {
            let content = &tree[&file.path];
            assert_eq!(file.bytes, content.len() as u64);
            assert_eq!(file.blake3, blake3::hash(content).to_hex().to_string());
            assert_eq!(file.pixels_blake3.is_none(), matches!(name.as_str(), "recipe" | "scene" | "camera"), "{name}");
        }
        // Every file but the derived ones is named by some record, so the root hash covers the tree.
        assert_eq!(record.files.len(), contents().layers.len() + 6);
    }
}

#[test]
fn a_death_between_any_two_changes_loses_nothing() {
    let expected = tree(&finished().0);
    let mut deaths = 0;
    for changes in 0.. {
        let store = MemoryStore::default();
        let mortal = Mortal { store: &store, changes_left: AtomicU32::new(changes) };
        let survived = generate(&mortal, &contents()).is_ok();
        let half = tree(&store);
        for (path, content) in &half {
            assert_eq!(content, &expected[path], "what stands is final");
        }
        generate(&store, &contents()).unwrap();
        assert_eq!(tree(&store), expected, "after {changes} changes");
        if survived {
            break;
        }
        deaths += 1;
    }
    assert_eq!(deaths, expected.len(), "one death before each file");
}

#[test]
fn a_finished_dataset_is_left_alone() {
    let (store, hash) = finished();
    let closed = Mortal { store: &store, changes_left: AtomicU32::new(0) };
    let writer = Writer::open(&closed, contents()).unwrap();
    assert_eq!(writer.recorded(), 4);
    drop(writer);
    // Only reads are needed to find everything in place: puts meet what stands.
    assert_eq!(generate(&store, &contents()).unwrap(), Some(hash));
}

#[test]
fn a_scenes_files_are_adopted_from_its_records() {
    let store = MemoryStore::default();
    let contents = contents();
    let scene = &contents.scenes[0].name;
    let writer = Writer::open(&store, contents.clone()).unwrap();
    assert!(!writer.adopt_scene(scene).unwrap());
    writer.put_scene(scene, &scene_files(scene)).unwrap();
    let first = writer.put_sample(synthetic(scene, "b00-a00", 12, 9)).unwrap();
    drop(writer);
    let writer = Writer::open(&store, contents.clone()).unwrap();
    assert!(writer.adopt_scene(scene).unwrap());
    assert!(!writer.adopt_scene(&contents.scenes[1].name).unwrap());
    let second = writer.put_sample(synthetic(scene, "b00-a01", 12, 9)).unwrap();
    for name in ["scene", "dsm", "dtm", "ndsm", "recipe"] {
        assert_eq!(first.files[name], second.files[name]);
    }
}

#[test]
fn unfinished_means_no_part_and_no_manifest() {
    let store = MemoryStore::default();
    let contents = contents();
    let writer = Writer::open(&store, contents.clone()).unwrap();
    let scene = &contents.scenes[0].name;
    writer.put_scene(scene, &scene_files(scene)).unwrap();
    writer.put_sample(synthetic(scene, "b00-a01", 12, 9)).unwrap();
    assert!(!writer.finish_scene(scene).unwrap());
    assert_eq!(writer.finish().unwrap(), None);
    assert!(store.size("canyon-gorge-7/part.jsonl").unwrap().is_none());
    assert!(store.size("manifest.jsonl").unwrap().is_none());
}

#[test]
fn another_plan_is_refused() {
    let (store, _) = finished();
    let before = tree(&store);
    let other = Contents { recipe_toml: "# satseed 0.1.0\n# plan 4567\nseed = 2\n".into(), ..contents() };
    let error = generate(&store, &other).unwrap_err().to_string();
    assert!(error.contains("says `seed = 1` where this one says `seed = 2`"), "{error}");
    assert_eq!(tree(&store), before);
}

#[test]
fn foreign_files_are_refused_and_nothing_is_written() {
    for path in ["holiday.jpg", "canyon-gorge-7/notes.txt", "canyon-gorge-7/b00-a00/left.png"] {
        let store = MemoryStore::default();
        store.put(path, b"mine").unwrap();
        let error = generate(&store, &contents()).unwrap_err().to_string();
        assert!(error.contains(path) && error.contains("no part of this dataset"), "{error}");
        assert_eq!(store.list("").unwrap().len(), 1);
    }
    let (store, _) = finished();
    store.put("canyon-gorge-7/b00-a00/notes.txt", b"mine").unwrap();
    assert!(matches!(generate(&store, &contents()), Err(WriteError::Foreign { .. })));
}

#[test]
fn what_no_record_names_is_made_anew() {
    let expected = tree(&finished().0);
    let store = MemoryStore::default();
    store.put("recipe.toml", contents().recipe_toml.as_bytes()).unwrap();
    store.put("canyon-gorge-7/dsm.tif", b"half").unwrap();
    store.put("canyon-gorge-7/b00-a00/left.png", b"").unwrap();
    generate(&store, &contents()).unwrap();
    assert_eq!(tree(&store), expected);
}

#[test]
fn what_a_record_names_is_never_replaced() {
    for path in ["canyon-gorge-7/dsm.tif", "canyon-gorge-7/part.jsonl", "manifest.jsonl", "manifest.blake3"] {
        let (store, _) = finished();
        let mut content = store.get(path).unwrap();
        let last = content.len() - 2;
        content[last] ^= 1;
        store.discard(path).unwrap();
        store.put(path, &content).unwrap();
        let error = generate(&store, &contents()).unwrap_err().to_string();
        let new = blake3::hash(&finished().0.get(path).unwrap()).to_hex().to_string();
        assert!(error.contains(path) && error.contains(&new), "both hashes are shown: {error}");
        assert!(error.contains(blake3::hash(&content).to_hex().as_str()), "{error}");
        assert_eq!(store.get(path).unwrap(), content);
    }
}

#[test]
fn a_recorded_sample_that_lost_a_file_is_named() {
    let (store, _) = finished();
    store.discard("canyon-gorge-7/b00-a01/left.png").unwrap();
    let error = generate(&store, &contents()).unwrap_err().to_string();
    assert!(error.contains("remove the folder `canyon-gorge-7/b00-a01`"), "{error}");
    // And that is enough.
    for entry in store.list("canyon-gorge-7/b00-a01").unwrap() {
        store.discard(&entry.path).unwrap();
    }
    generate(&store, &contents()).unwrap();
    assert_eq!(tree(&store), tree(&finished().0));
}

#[test]
fn a_sample_that_contradicts_itself_is_not_recorded() {
    let store = MemoryStore::default();
    let contents = contents();
    let writer = Writer::open(&store, contents).unwrap();
    let mut sample = synthetic("canyon-gorge-7", "b00-a00", 12, 9);
    sample.camera.left.width_px = 13;
    let error = writer.put_sample(sample).unwrap_err().to_string();
    assert!(error.contains("the camera has 13 x 9"), "{error}");
    assert_eq!(store.list("").unwrap().len(), 1);
}
