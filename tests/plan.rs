//! What a plan promises: the published composition, splits, reach, shards, and independence of order.

use glam::DVec3;
use satseed::camera::{Camera, Datum as RigDatum, StereoRig};
use satseed::plan::{Plan, PlanError, Shard, Split, frame_reach_m};
use satseed::recipe::{PRESETS, Preset, Recipe, seed_list_line};
use satseed_generators::Region;
use satseed_scene::SeedPath;
use std::collections::{BTreeMap, BTreeSet};

fn recipe(text: &str, set: &[&str]) -> Recipe {
    let set: Vec<_> = set.iter().map(|s| (*s).to_owned()).collect();
    Recipe::parse_with("test", text, &set).unwrap_or_else(|e| panic!("{e}"))
}

fn plan(text: &str, set: &[&str]) -> Plan {
    Plan::new(&recipe(text, set)).unwrap_or_else(|e| panic!("{e}"))
}

/// Scenes of the default size, baselines and azimuths; `scenes` are whole `[[scene]]`s.
fn with_scenes(rule: &str, scenes: &[(&str, u32)]) -> String {
    let scenes = scenes.iter().map(|(region, pivots)| format!("[[scene]]\n{region}\npivots = {pivots}\n"));
    format!("[split]\nrule = \"{rule}\"\n{}", scenes.collect::<String>())
}

#[test]
fn baselines_and_azimuths_are_the_published_ones() {
    let plan = plan(Preset::by_name("satunreal").unwrap().text, &[]);
    assert_eq!((plan.scenes.len(), plan.pairs().count()), (25, 10_000));
    assert_eq!(plan.split_counts(), [6646, 500, 2854]);
    let pivots = |region: &str| plan.scenes.iter().filter(|s| s.region.name() == region).count();
    assert_eq!(["california", "toronto", "venice"].map(pivots), [8, 10, 2]);
    assert_eq!(["forest", "canyon", "coast", "desert", "field"].map(pivots), [1; 5]);
    let mut all = Vec::new();
    let mut different = BTreeSet::new();
    for scene in &plan.scenes {
        assert_eq!(scene.pairs.len(), 400);
        for (i, pair) in scene.pairs.iter().enumerate() {
            assert_eq!((pair.baseline_step as usize, pair.azimuth_index as usize), (i / 20, i % 20));
            assert_eq!(pair.id, format!("{}/b{:02}-a{:02}", scene.name, i / 20, i % 20));
            assert_eq!(pair.folder(), format!("b{:02}-a{:02}", i / 20, i % 20));
            assert_eq!(pair.baseline_m, 50.0 + f64::from(pair.baseline_step) * 150.0 / 19.0);
            assert_eq!(pair.pivot_along_baseline, 0.5);
            assert!((-90.0..=90.0).contains(&pair.azimuth_deg));
        }
        let draws: Vec<f64> = scene.pairs[..20].iter().map(|pair| pair.azimuth_deg).collect();
        different.insert(draws.iter().map(|a| a.to_bits()).collect::<Vec<_>>());
        all.extend(draws);
    }
    assert_eq!(different.len(), 25, "each pivot draws its own");
    let variants = |region: &str| -> Vec<&str> {
        plan.scenes.iter().filter(|s| s.region.name() == region).map(|s| s.region.variant()).collect()
    };
    let count = |variant: &str| variants("toronto").into_iter().filter(|v| *v == variant).count();
    assert_eq!(["core", "slabs", "rail"].map(count), [6, 2, 2]);
    let variants = variants("california");
    for variant in ["downtown", "lowrise", "suburb", "hill", "waterfront"] {
        assert!(variants.contains(&variant), "{variant} in {variants:?}");
    }
    assert!(variants.iter().filter(|v| **v == "interchange").count() >= 2, "{variants:?}");
    // Uniform: Kolmogorov-Smirnov with n = 500 stays below 0.073 in 99 of 100 cases.
    all.sort_by(f64::total_cmp);
    let worst = all.iter().enumerate().map(|(i, a)| ((a + 90.0) / 180.0 - (i as f64 + 0.5) / 500.0).abs());
    assert!(worst.fold(0.0, f64::max) < 0.073);
}

/// The first draws of two pivots. They may never change: datasets are cited by their seeds.
#[test]
fn golden_draws() {
    let plan = plan(Preset::by_name("satunreal").unwrap().text, &["acquisition.pivot_along_baseline=random"]);
    let first = |scene: usize| -> Vec<f64> { plan.scenes[scene].pairs[..4].iter().map(|p| p.azimuth_deg).collect() };
    assert_eq!(plan.scenes[0].name, "toronto-core-10000");
    assert_eq!(first(0), GOLDEN_TORONTO);
    assert_eq!(plan.scenes[10].name, "canyon-gorge-10000");
    assert_eq!(first(10), GOLDEN_CANYON);
    let along: Vec<f64> = plan.scenes[10].pairs[..4].iter().map(|p| p.pivot_along_baseline).collect();
    assert_eq!(along, GOLDEN_ALONG);
}

const GOLDEN_TORONTO: [f64; 4] = [-7.483, -50.018, -81.919, -30.307];
const GOLDEN_CANYON: [f64; 4] = [-82.889, 6.799, -77.322, 83.444];
const GOLDEN_ALONG: [f64; 4] = [0.659, 0.832, 0.579, 0.419];

#[test]
fn draws_depend_on_region_variant_and_seed_alone() {
    let azimuths = |set: &[&str]| -> Vec<f64> {
        plan(&with_scenes("published", &[("canyon = {}", 2)]), set).pairs().map(|(_, p)| p.azimuth_deg).collect()
    };
    let usual = azimuths(&[]);
    assert_eq!(azimuths(&["scene.canyon.roughness=0.5", "light.aerosol_optical_depth=0.3"]), usual);
    assert_eq!(azimuths(&["camera.altitude_m=1200"]), usual);
    assert_ne!(azimuths(&["seed=2"]), usual);
    let of = |variant: &str| -> Vec<f64> {
        let scene = format!("toronto = {{ variant = \"{variant}\" }}");
        plan(&with_scenes("published", &[(&scene, 1)]), &[]).pairs().map(|(_, p)| p.azimuth_deg).collect()
    };
    assert_ne!(of("core"), of("midtown"));
    let more = azimuths(&["acquisition.azimuth_deg={from=-90,to=90,draws=30}"]);
    assert_eq!(more[..20], usual[..20], "more draws leave the first ones as they are");
}

#[test]
fn the_published_split_is_exact() {
    let plan = plan(&with_scenes("published", &[("canyon = {}", 12), ("toronto = {}", 13)]), &[]);
    assert_eq!(plan.split_counts(), [6646, 500, 2854]);
    assert!(plan.notes.is_empty());
    let of_train = plan.scenes.iter().filter(|s| s.pairs.iter().all(|p| p.split == Split::Train)).count();
    assert_eq!(of_train, 0, "pairs are drawn one by one");
}

#[test]
fn by_pivot_deals_whole_pivots_nearest_to_the_shares() {
    for pivots in 1..=40_u32 {
        for other in [0, 1, 4, 11] {
            let scenes = [("canyon = {}", pivots), ("toronto = {}", other)];
            let scenes: Vec<_> = scenes.into_iter().filter(|(_, n)| *n > 0).collect();
            let plan = plan(&with_scenes("by-pivot", &scenes), &["acquisition.pairs_per_pivot=1"]);
            let total = f64::from(pivots + other);
            for (count, share) in plan.split_counts().into_iter().zip([0.6646, 0.05, 0.2854]) {
                assert!((count as f64 - total * share).abs() < 1.0, "{pivots} + {other}: {:?}", plan.split_counts());
            }
            // Within a region too, as near as whole pivots and the other region's allow.
            let mut train = BTreeMap::new();
            for (scene, pair) in plan.pairs() {
                *train.entry(scene.region.name()).or_insert(0) += i32::from(pair.split == Split::Train);
            }
            for (region, n) in [("canyon", pivots), ("toronto", other)] {
                let found = f64::from(train.get(region).copied().unwrap_or(0));
                assert!((found - f64::from(n) * 0.6646).abs() <= 1.5, "{region}: {found} of {n}");
            }
        }
    }
    let plan = plan(&with_scenes("by-pivot", &[("canyon = {}", 1), ("toronto = {}", 3)]), &[]);
    for scene in &plan.scenes {
        assert!(scene.pairs.iter().all(|p| p.split == scene.pairs[0].split), "no scene in two splits");
    }
    assert!(plan.notes.iter().any(|n| n.contains("region canyon has one pivot")), "{:?}", plan.notes);
    assert!(plan.notes.iter().any(|n| n == "split val stays empty"), "{:?}", plan.notes);
    assert!(!plan.notes.iter().any(|n| n.contains("toronto")), "{:?}", plan.notes);
}

#[test]
fn the_order_of_scenes_changes_no_pair() {
    let scenes = [("canyon = {}", 5), ("toronto = {}", 4), ("toronto = { variant = \"midtown\" }", 3)];
    for rule in ["published", "by-pivot"] {
        let pairs = |order: [usize; 3]| -> BTreeMap<String, String> {
            let plan = plan(&with_scenes(rule, &order.map(|i| scenes[i])), &[]);
            plan.pairs().map(|(_, pair)| (pair.id.clone(), format!("{pair:?}"))).collect()
        };
        let usual = pairs([0, 1, 2]);
        assert_eq!(usual.len(), 12 * 400);
        assert_eq!(pairs([2, 1, 0]), usual, "{rule}");
        assert_eq!(pairs([1, 2, 0]), usual, "{rule}");
    }
}

#[test]
fn shards_hold_every_pair_once() {
    let recipe = recipe(
        &with_scenes("published", &[("canyon = {}", 3), ("toronto = {}", 2)]),
        &["acquisition.pairs_per_pivot=7"],
    );
    let plan = Plan::new(&recipe).unwrap();
    for count in [1, 2, 3, 5, 8, 34, 35, 36, 100] {
        let mut seen = Vec::new();
        let mut scenes_built = 0;
        for index in 1..=count {
            let shard: Shard = format!("{index}/{count}").parse().unwrap();
            let shares = shard.of(&recipe, &plan);
            assert_eq!(shares, shard.of(&recipe, &plan), "the same on each machine");
            scenes_built += shares.len();
            for share in shares {
                seen.extend(plan.scenes[share.scene].pairs[share.pairs].iter().map(|p| p.id.clone()));
            }
        }
        let all: Vec<_> = plan.pairs().map(|(_, p)| p.id.clone()).collect();
        assert_eq!(seen, all, "in order, none twice");
        assert!(scenes_built < 5 + count, "a scene is built again only where a border cuts it");
    }
    assert_eq!(Shard::WHOLE.of(&recipe, &plan).len(), 5);
    for bad in ["", "1", "0/2", "3/2", "1/0", "1/2/3", "-1/2", "a/b", "1/ 2", "+1/2", "1/99999999999"] {
        assert!(bad.parse::<Shard>().is_err(), "{bad}");
    }
}

/// How far the frames of a rig see at a height, by following the rays through their corners.
fn seen_m(camera: &Camera, z_m: f64) -> f64 {
    let (w, h) = (f64::from(camera.width_px) - 0.5, f64::from(camera.height_px) - 0.5);
    let corner = |(u, v)| {
        let ray = camera.ray(u, v);
        let p = ray.origin + ray.direction * ((z_m - ray.origin.z) / ray.direction.z);
        libm::sqrt(p.x * p.x + p.y * p.y)
    };
    [(-0.5, -0.5), (w, -0.5), (-0.5, h), (w, h)].map(corner).into_iter().fold(0.0, f64::max)
}

#[test]
fn reach_is_what_the_cameras_see_and_no_more() {
    let mut rng = SeedPath::root("reach", 1).rng();
    let mut compared = 0;
    for case in 0..500 {
        let heights_m = [rng.range(-250.0, 0.0), rng.range(0.0, 350.0)];
        let datum = [None, Some([12.5, 12.5]), Some(heights_m)][case % 3];
        let text = format!(
            "[camera]\naltitude_m = {:?}\nsize_px = [{}, {}]\ndatum = \"pivot\"\n[acquisition]\nbaseline_m = {:?}\n\
             azimuth_deg = {:?}\npivot_along_baseline = {:?}\n[[scene]]\ncanyon = {{ radius_m = 900.0 }}",
            rng.range(450.0, 700_000.0),
            rng.below(2000) + 8,
            rng.below(2000) + 8,
            rng.range(1.0, 250.0),
            rng.range(-180.0, 180.0),
            rng.range(-2.0, 3.0),
        );
        let recipe = recipe(&text, &[]);
        let pair = match Plan::new(&recipe) {
            Ok(plan) => plan.scenes[0].pairs[0].geometry(),
            Err(PlanError::BeyondDetail { .. }) => continue,
            Err(e) => panic!("{e}"),
        };
        let stated = frame_reach_m(recipe.camera(), pair.baseline_m, pair.pivot_along_baseline, heights_m, datum);
        let mut greatest = 0.0_f64;
        for i in 0..=4 {
            let at = |[low, high]: [f64; 2]| low + (high - low) * f64::from(i) / 4.0;
            for j in 0..=4 {
                let z_m = heights_m[0] + (heights_m[1] - heights_m[0]) * f64::from(j) / 4.0;
                let rig_datum = datum.map_or(RigDatum::None, |bounds| RigDatum::Height(at(bounds)));
                let rig = StereoRig::new(recipe.camera().rig_spec(&pair, DVec3::ZERO, rig_datum));
                greatest = greatest.max(seen_m(&rig.left, z_m)).max(seen_m(&rig.right, z_m));
            }
        }
        assert!((greatest - stated).abs() < 1e-6 * stated, "{case}: sees {greatest}, stated {stated}");
        compared += 1;
    }
    assert!(compared > 250, "{compared}");
}

#[test]
fn the_scene_extent_of_the_published_rig() {
    let recipe = recipe(Preset::by_name("satunreal").unwrap().text, &[]);
    let reach = |t| frame_reach_m(recipe.camera(), 200.0, t, [-180.0, 60.0], None);
    // "a frame's corner reaches 588 m from the pivot at t = 0.5 and 669 m at t = 0 or 1"
    assert_eq!(reach(0.5).round(), 588.0);
    assert_eq!(reach(0.0).round(), 669.0);
    assert_eq!(reach(1.0).round(), 669.0);
}

#[test]
fn a_true_orbit_keeps_the_angle() {
    let text = "[camera]\naltitude_m = 617000\ndatum = \"pivot\"\n[acquisition]\nconvergence_deg = [5.724810452223496]\n\
                [[scene]]\ncanyon = {}";
    let recipe = recipe(text, &[]);
    let plan = Plan::new(&recipe).unwrap();
    let pair = &plan.scenes[0].pairs[0];
    assert!((pair.baseline_m - 61_700.0).abs() < 1e-6, "B / H is that of 100 m at 1 km: {}", pair.baseline_m);
    assert!((recipe.camera().convergence_deg(pair.baseline_m) - 5.724810452223496).abs() < 1e-12);
}

#[test]
fn names_and_hashes() {
    let names = |set: &[&str]| -> Vec<String> {
        let text = with_scenes("by-pivot", &[("canyon = {}", 1), ("toronto = { variant = \"midtown\" }", 1)]);
        plan(&text, set).scenes.into_iter().map(|s| s.name).collect()
    };
    assert_eq!(names(&[]), ["canyon-gorge-10000", "toronto-midtown-10000"]);
    assert_eq!(names(&["seed=7"]), ["canyon-gorge-70000", "toronto-midtown-70000"]);
    let changed = names(&["scene.canyon.relief_m=150"]);
    assert_eq!(changed[1], "toronto-midtown-10000");
    let hash = changed[0].strip_prefix("canyon-gorge-10000-").unwrap();
    assert!(hash.len() == 8 && hash.bytes().all(|b| b.is_ascii_hexdigit()));

    let hash = |text: &str, set: &[&str]| plan(text, set).hash;
    let text = "[[scene]]\ncanyon = {}";
    let usual = hash(text, &[]);
    assert_eq!(usual.len(), 64);
    assert_eq!(hash("# the same\nseed = 1\n[[scene]]\ncanyon = { relief_m = 190 }\npivots = 1", &[]), usual);
    for other in
        ["seed=2", "camera.gsd_m=0.31", "light.sun.azimuth_deg=1", "sensor.samples_per_pixel=17", "scene.pivots=2"]
    {
        assert_ne!(hash(text, &[other]), usual, "{other}");
    }
}

#[test]
fn equal_entries_count_on_and_equal_seeds_are_refused() {
    let twice = plan(&with_scenes("by-pivot", &[("canyon = {}", 2), ("canyon = {}", 1)]), &[]);
    let seeds: Vec<_> = twice.scenes.iter().map(|s| s.seed).collect();
    assert_eq!(seeds, [10000, 10001, 10002]);
    let error = Plan::new(&recipe("[[scene]]\ncanyon = {}\nseeds = [1, 2]\n[[scene]]\ncanyon = {}\nseeds = [2]", &[]));
    assert_eq!(error.unwrap_err(), PlanError::Duplicate { name: "canyon-gorge-2".to_owned() });
}

#[test]
fn a_plan_as_a_seed_list_makes_the_same_scenes() {
    let text = with_scenes(
        "by-pivot",
        &[
            ("canyon = { relief_m = 150.5 }", 2),
            ("toronto = {}", 1),
            ("toronto = { variant = \"midtown\", trees = 2 }", 1),
        ],
    );
    let plan = plan(&text, &[]);
    let list: String = plan.scenes.iter().map(|s| seed_list_line(&s.region, s.seed) + "\n").collect();
    assert_eq!(
        list,
        "canyon 10000 relief_m=150.5\ncanyon 10001 relief_m=150.5\ntoronto/core 10000\ntoronto/midtown 10000 trees=2.0\n"
    );
    let satunreal = Preset::by_name("satunreal").unwrap();
    let again = Recipe::parse_with_seed_list(satunreal, "list", &list).unwrap();
    let names = |plan: &Plan| plan.scenes.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&Plan::new(&again).unwrap()), names(&plan));
    assert_eq!(Recipe::parse("again", &again.to_toml()).unwrap(), again);
}

#[test]
fn presets_read_back_equal() {
    for preset in PRESETS {
        let recipe = Recipe::parse(preset.name, preset.text).unwrap();
        let text = recipe.to_toml();
        let again = Recipe::parse("again", &text).unwrap();
        assert_eq!(again, recipe);
        assert_eq!(again.to_toml(), text);
        assert_eq!(Plan::new(&again).unwrap(), Plan::new(&recipe).unwrap());
        assert!(!preset.summary().is_empty());
    }
}

#[test]
fn a_region_for_a_preview() {
    let recipe = recipe("[[scene]]\ntoronto = { trees = 2 }", &[]);
    assert_eq!(recipe.region("toronto", None).unwrap(), recipe.scenes()[0].region);
    let midtown = recipe.region("toronto", Some("midtown")).unwrap();
    assert_eq!(seed_list_line(&midtown, 1), "toronto/midtown 1 trees=2.0");
    assert_eq!(recipe.region("canyon", None).unwrap().variant(), "gorge");
    for (name, variant) in [("atlantis", None), ("toronto", Some("x")), ("canyon", Some("x"))] {
        let told = recipe.region(name, variant).unwrap_err().to_string();
        assert!(told.contains(variant.unwrap_or(name)), "{told}");
    }
}

/// Every recipe in the documentation is one, and the one with all keys shows the defaults.
#[test]
fn the_documented_recipe_is_legal_and_shows_the_defaults() {
    let page = include_str!("../docs/recipe.md");
    let blocks: Vec<_> = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(blocks.len(), 1);
    let version = Region::by_name("canyon").unwrap().version();
    let documented = recipe(&blocks[0].replace("\ncanyon = 1\n", &format!("\ncanyon = {version}\n")), &[]);
    assert!(Plan::new(&documented).is_ok());
    let default = recipe("[[scene]]\ncanyon = {}", &[]);
    assert_eq!(documented.seed(), default.seed());
    assert_eq!(documented.camera(), default.camera());
    assert_eq!(documented.acquisition().baselines, default.acquisition().baselines);
    assert_eq!(documented.acquisition().azimuths, default.acquisition().azimuths);
    assert_eq!(documented.acquisition().pivot_along_baseline, default.acquisition().pivot_along_baseline);
    assert_eq!(documented.light(), default.light());
    assert_eq!(documented.sensor(), default.sensor());
    assert_eq!(documented.labels(), default.labels());
    assert_eq!(documented.split(), default.split());
}
