//! The whole path, from a recipe to a dataset, in memory.
#![allow(clippy::unwrap_used)]

use satseed::dataset::{MemoryStore, Store, parse_lines};
use satseed::pipeline::{Event, Options, Outcome, PipelineError, generate};
use satseed::plan::{Plan, Shard};
use satseed::recipe::Recipe;
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Both regions, small: two scenes of two pairs.
const RECIPE: &str = r#"
seed = 3
[camera]
altitude_m = 1000.0
gsd_m = 0.6
size_px = [64, 48]
datum = "pivot"
[acquisition]
baseline_m = [40.0, 90.0]
azimuth_deg = [20.0]
[sensor]
preset = "worldview3_rgb"
samples_per_pixel = 1
[labels]
write = ["disparity_right", "class", "elevation", "instance", "normal", "shadow", "edge"]
[[scene]]
canyon = { radius_m = 60.0 }
pivots = 1
[[scene]]
toronto = { radius_m = 60.0 }
pivots = 1
"#;

fn run(
    store: &dyn Store,
    jobs: usize,
    shard: &str,
    stop: &AtomicBool,
    report: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Outcome, PipelineError> {
    let recipe = Recipe::parse("test", RECIPE).unwrap();
    let plan = Plan::new(&recipe).unwrap();
    let shard: Shard = shard.parse().unwrap();
    generate(&recipe, &plan, store, Options { jobs, shard, stop }, report)
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
