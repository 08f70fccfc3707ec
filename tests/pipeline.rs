//! The whole path, from a recipe to a dataset, in memory.
#![allow(clippy::unwrap_used)]

use satseed::dataset::{Entry, Layer, MemoryStore, Store, StoreError, View, parse_lines};
use satseed::labels::{self, explain};
use satseed::pipeline::{BuiltScene, Event, Merge, Options, Outcome, PipelineError, generate, make_sample, merge, rig};
use satseed::plan::{Plan, Shard};
use satseed::recipe::{Label, Recipe, Region};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex};
use std::time::Duration;
use support::small;

mod support;

/// Both regions: two scenes of two pairs.
fn recipe() -> Recipe {
    let text = small::recipe(&small::Recipe {
        gsd_m: 0.6,
        size_px: [64, 48],
        acquisition: "baseline_m = [40.0, 90.0]\nazimuth_deg = [20.0]",
        sensor: "worldview3_rgb",
        scenes: &["canyon = { radius_m = 60.0 }", "toronto = { radius_m = 60.0 }"],
    });
    Recipe::parse("test", &text).unwrap()
}

fn run(
    store: &dyn Store,
    jobs: usize,
    shard: &str,
    stop: &AtomicBool,
    report: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Outcome, PipelineError> {
    let shard: Shard = shard.parse().unwrap();
    run_with(store, Options { jobs, build_ahead: true, shard, stop, profile: None }, report)
}

fn run_with(
    store: &dyn Store,
    options: Options<'_>,
    report: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Outcome, PipelineError> {
    let recipe = recipe();
    generate(&recipe, &Plan::new(&recipe).unwrap(), store, options, report)
}

fn whole(jobs: usize) -> BTreeMap<String, Vec<u8>> {
    let store = MemoryStore::default();
    let outcome = run(&store, jobs, "1/1", &AtomicBool::new(false), &|_| {}).unwrap();
    assert!(matches!(outcome, Outcome::Complete(_)));
    store.into_files()
}

#[test]
fn threads_shards_and_stops_change_no_byte() {
    let expected = whole(1);
    let manifest = String::from_utf8(expected["manifest.jsonl"].clone()).unwrap();
    assert_eq!(parse_lines(&manifest).unwrap().len(), 4);
    assert!(whole(3) == expected, "three threads");

    let store = MemoryStore::default();
    let go = AtomicBool::new(false);
    for shard in ["3/3", "1/3", "1/3", "2/3"] {
        assert!(matches!(run(&store, 2, shard, &go, &|_| {}).unwrap(), Outcome::ShardDone));
    }
    let recipe = recipe();
    let plan = Plan::new(&recipe).unwrap();
    merge(&recipe, &plan, &store, Merge { from: &[], pages: true }).unwrap();
    assert!(store.into_files() == expected, "three shards, one of them twice");

    // Stopped after every pair, and taken up again.
    let store = MemoryStore::default();
    let mut runs = 0;
    loop {
        let stop = AtomicBool::new(false);
        let events = Mutex::new(Vec::new());
        let report = |event: Event<'_>| {
            if let Event::Pair { id, .. } = event {
                stop.store(true, Ordering::Relaxed);
                events.lock().unwrap().push(id.to_owned());
            }
        };
        let outcome = run(&store, 2, "1/1", &stop, &report).unwrap();
        runs += 1;
        if outcome != Outcome::Stopped {
            assert!(matches!(outcome, Outcome::Complete(_)));
            break;
        }
        // The pair that was being traced when the stop came is finished, since a sample's border is where it stops.
        assert!((1..=2).contains(&events.into_inner().unwrap().len()));
        assert!(store.size("manifest.jsonl").unwrap().is_none());
    }
    assert!(runs >= 2);
    assert!(store.into_files() == expected, "stopped and taken up again");
}

/// A store that refuses one file.
struct Refusing {
    inner: MemoryStore,
    ending: &'static str,
}

impl Store for Refusing {
    fn put(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        if path.ends_with(self.ending) {
            return Err(StoreError::Full { path: path.to_owned(), bytes: bytes.len() as u64 });
        }
        self.inner.put(path, bytes)
    }
    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError> {
        self.inner.get(path)
    }
    fn size(&self, path: &str) -> Result<Option<u64>, StoreError> {
        self.inner.size(path)
    }
    fn list(&self, prefix: &str) -> Result<Vec<Entry>, StoreError> {
        self.inner.list(prefix)
    }
    fn discard(&self, path: &str) -> Result<(), StoreError> {
        self.inner.discard(path)
    }
    fn clear_unfinished(&self) -> Result<(), StoreError> {
        self.inner.clear_unfinished()
    }
}

#[test]
fn the_next_scene_is_built_while_one_is_traced() {
    let plan = Plan::new(&recipe()).unwrap();
    for (jobs, build_ahead) in [(1, true), (2, false), (2, true)] {
        let ahead = jobs > 1 && build_ahead;
        // What was reported: scenes begun and pairs recorded.
        let (counts, changed) = (Mutex::new((0, 0)), Condvar::new());
        let report = |event: Event<'_>| {
            let mut counts = counts.lock().unwrap();
            match event {
                Event::Begun { .. } => {}
                Event::Scene { name } => {
                    assert_eq!(name, plan.scenes[counts.0].name, "scenes come in plan order");
                    counts.0 += 1;
                    // Otherwise the first scene is through; its last pair may still be in the writer's hands.
                    assert!(ahead || counts.0 == 1 || counts.1 >= 1, "built ahead with {jobs} threads");
                    changed.notify_all();
                }
                Event::Pair { id, .. } => {
                    assert_eq!(id, plan.pairs().nth(counts.1).unwrap().1.id, "pairs come in plan order");
                    counts.1 += 1;
                    // The first pair's writer stays here, and so the second pair cannot be the last: the scene is at work.
                    if ahead && counts.1 == 1 {
                        let long = Duration::from_secs(300);
                        let (_counts, waited) = changed.wait_timeout_while(counts, long, |c| c.0 < 2).unwrap();
                        assert!(!waited.timed_out(), "the second scene was not begun before the first was done");
                    }
                }
            }
        };
        let stop = AtomicBool::new(false);
        let options = Options { jobs, build_ahead, shard: Shard::WHOLE, stop: &stop, profile: None };
        let outcome = run_with(&MemoryStore::default(), options, &report).unwrap();
        assert!(matches!(outcome, Outcome::Complete(_)));
        assert_eq!(*counts.lock().unwrap(), (2, 4));
    }
}

/// Where a lane fails the others come to an end, the sentence is that of the failure, and the same command goes on.
#[test]
fn a_failing_lane_ends_the_others() {
    let expected = whole(2);
    let plan = Plan::new(&recipe()).unwrap();
    let first = &plan.scenes[0];
    let part = format!("{}/part.jsonl", first.name);
    let second_left: &'static str = format!("{}/left.png", first.pairs[1].id).leak();
    let next_dsm: &'static str = format!("{}/dsm.tif", plan.scenes[1].name).leak();
    // Records that must stand, and whether the first scene is through.
    for (ending, records, through) in [(second_left, 1, false), (next_dsm, 2, true)] {
        let store = Refusing { inner: MemoryStore::default(), ending };
        let error = run(&store, 2, "1/1", &AtomicBool::new(false), &|_| {}).unwrap_err().to_string();
        assert!(error.contains(&format!("no room for `{ending}`")), "{error}");
        let standing = store.list("").unwrap().iter().filter(|e| e.path.ends_with("/sample.json")).count();
        assert_eq!(standing, records, "{ending}");
        assert_eq!(store.size(&part).unwrap().is_some(), through, "{ending}");
        run(&store.inner, 2, "1/1", &AtomicBool::new(false), &|_| {}).unwrap();
        assert!(store.inner.into_files() == expected, "{ending}");
    }
}

#[test]
fn a_hole_in_the_ground_is_an_error_and_no_label() {
    let recipe = recipe();
    let plan = Plan::new(&recipe).unwrap();
    let spec = plan.scenes.iter().find(|s| s.region.name() == "toronto").unwrap();
    let mut scene = spec.region.build(spec.seed);
    let whole = make_sample(&BuiltScene::new(&recipe, spec, &scene), &spec.pairs[0]).unwrap();
    assert!(whole.plane(Layer::Validity, View::Right).is_some());

    // Whatever reaches into a square of 6 m around the pivot is taken away.
    for instance in 0..scene.instances.len() {
        let mesh = scene.instances[instance].mesh as usize;
        let gone: Vec<bool> = (0..scene.meshes[mesh].triangles.len())
            .map(|t| {
                let corners = scene.corners(instance as u32, t as u32);
                let beyond = |axis: fn(&glam::DVec3) -> f64| {
                    corners.iter().all(|c| axis(c) > 3.0) || corners.iter().all(|c| axis(c) < -3.0)
                };
                !beyond(|c| c.x) && !beyond(|c| c.y)
            })
            .collect();
        let mesh = &mut scene.meshes[mesh];
        let mut kept = gone.iter().map(|g| !g);
        mesh.triangles.retain(|_| kept.next().unwrap());
        let mut kept = gone.iter().map(|g| !g);
        mesh.slots.retain(|_| kept.next().unwrap());
    }
    let built = BuiltScene::new(&recipe, spec, &scene);
    let error = make_sample(&built, &spec.pairs[0]).unwrap_err();
    let PipelineError::Hole { view: "left", pixel, others, .. } = error else { panic!("{error}") };
    let rig = rig(&built, &spec.pairs[0]);
    let nothing = |at: &[u32; 2]| explain(&built.tracer, &rig, labels::View::Left, *at).seen.is_none();
    let holes: Vec<_> = (0..48).flat_map(|v| (0..64).map(move |u| [u, v])).filter(nothing).collect();
    assert_eq!((pixel, others + 1), (holes[0], holes.len()));
    assert!(holes.contains(&[32, 24]), "the frame's centre sees the pivot");
    let said = error.to_string();
    let start =
        format!("sample `{}`: the ray of pixel ({}, {}) of the left view", spec.pairs[0].id, pixel[0], pixel[1]);
    assert!(said.starts_with(&start) && said.contains("this is a bug in the terrain"), "{said}");
}

/// tests/determinism.sh makes this recipe on every machine it knows.
#[test]
fn the_determinism_matrix_holds_every_region_and_label() {
    let recipe = Recipe::parse("recipe.toml", include_str!("determinism/recipe.toml")).unwrap();
    let plan = Plan::new(&recipe).unwrap();
    let regions: Vec<_> = plan.scenes.iter().map(|s| s.region.name()).collect();
    assert_eq!(regions, Region::NAMES, "each region has a scene in tests/determinism/recipe.toml");
    assert!(Label::ALL.iter().all(|(_, label)| recipe.labels().has(*label)));
}
