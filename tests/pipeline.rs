//! The whole path, from a recipe to a dataset, in memory.
#![allow(clippy::unwrap_used)]

use satseed::dataset::{Layer, MemoryStore, Store, View, parse_lines};
use satseed::labels::{self, explain};
use satseed::pipeline::{BuiltScene, Event, Options, Outcome, PipelineError, generate, make_sample, rig};
use satseed::plan::{Plan, Shard};
use satseed::recipe::{Label, Recipe, Region};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
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
    let recipe = recipe();
    let plan = Plan::new(&recipe).unwrap();
    let shard: Shard = shard.parse().unwrap();
    generate(&recipe, &plan, store, Options { jobs, shard, stop, profile: None }, report)
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
    for (shard, outcome) in [("3/3", "done"), ("1/3", "done"), ("1/3", "done"), ("2/3", "complete")] {
        match run(&store, 2, shard, &go, &|_| {}).unwrap() {
            Outcome::ShardDone => assert_eq!(outcome, "done"),
            Outcome::Complete(_) => assert_eq!(outcome, "complete"),
            Outcome::Stopped => panic!("nobody asked it to stop"),
        }
    }
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
