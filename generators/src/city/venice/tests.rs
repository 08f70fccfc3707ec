use super::assemble::{self, CityPlan};
use super::fabric::Open;
use super::houses::{EAVES_M, House};
use super::*;
use crate::kit::checks::{assert_rises, assert_same_things, assert_whole, assert_within_bounds, vertices};
use crate::kit::mesh_builder::open_edges;
use crate::kit::polygon;
use fabric::Use;
use glam::DVec2;
use rayon::prelude::*;

/// Half side of a frame of 2048 pixels at 0.3 m.
const FRAME_HALF_M: f64 = 307.0;

fn city(seed: u64, params: &Params) -> SeedPath {
    SeedPath::root("venice", seed).child(params.variant())
}

fn planned(seed: u64, params: &Params) -> CityPlan {
    assemble::plan(params, &city(seed, params))
}

fn sized(radius_m: f64, variant: Variant) -> Params {
    Params { variant, radius_m, ..Params::default() }
}

/// Shares of a frame and what is counted in it.
#[derive(Debug)]
#[allow(dead_code, reason = "all of it is printed")]
struct Census {
    water: f64,
    built_of_land: f64,
    eaves_median: f64,
    bridges: usize,
    campi: usize,
    houses: usize,
}

fn in_frame(p: DVec2) -> bool {
    p.abs().max_element() < FRAME_HALF_M
}

fn census(plan: &CityPlan) -> Census {
    let bounded = |o: Vec<DVec2>| (polygon::bounds(&o), o);
    let land: Vec<_> = plan.isles.iter().map(|i| bounded(i.shore.outline.clone())).collect();
    let walls: Vec<_> = plan.isles.iter().flat_map(|i| i.houses.iter()).map(|h| bounded(h.world_outline())).collect();
    let inside = |all: &[((DVec2, DVec2), Vec<DVec2>)], p: DVec2| {
        all.iter().any(|((low, high), o)| p.cmpge(*low).all() && p.cmple(*high).all() && polygon::contains(o, p))
    };
    let churches: Vec<_> = plan
        .isles
        .iter()
        .filter_map(|i| i.church.as_ref())
        .map(|c| bounded(polygon::oriented_rectangle(c.centre_m, c.axis, c.half_m)))
        .collect();
    let step = 2.5;
    let n = (2.0 * FRAME_HALF_M / step) as i64;
    let counts: Vec<[u32; 2]> = (0..n)
        .into_par_iter()
        .map(|j| {
            let mut count = [0; 2];
            for i in 0..n {
                let p = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * step - DVec2::splat(FRAME_HALF_M);
                if inside(&land, p) {
                    count[0] += 1;
                    count[1] += u32::from(inside(&walls, p) || inside(&churches, p));
                }
            }
            count
        })
        .collect();
    let [land, built] = counts.iter().fold([0.0; 2], |s, c| [s[0] + f64::from(c[0]), s[1] + f64::from(c[1])]);
    let mut eaves: Vec<f64> = plan
        .isles
        .iter()
        .flat_map(|i| &i.houses)
        .filter(|h| in_frame(h.centre_m) && h.used == Use::House)
        .map(|h| h.eaves_m)
        .collect();
    eaves.sort_by(f64::total_cmp);
    let opens = plan.isles.iter().flat_map(|i| &i.opens);
    let campi = opens.filter(|(o, open, _)| *open == Open::Campo && in_frame(polygon::centroid(o))).count();
    Census {
        water: 1.0 - land / (n * n) as f64,
        built_of_land: built / land,
        eaves_median: eaves[eaves.len() / 2],
        bridges: plan.spans.iter().filter(|s| in_frame(s.centre_m)).count(),
        campi,
        houses: eaves.len(),
    }
}

#[test]
#[allow(clippy::print_stderr, reason = "the numbers are what the acceptance table asks for")]
fn a_frame_has_the_citys_shares() {
    let mut faults = Vec::new();
    for seed in 0..6 {
        let c = census(&planned(seed, &sized(330.0, Variant::Dense)));
        eprintln!("{seed}: {c:?}");
        let sound = (0.12..=0.18).contains(&c.water)
            && (0.65..=0.76).contains(&c.built_of_land)
            && (12.5..=14.5).contains(&c.eaves_median)
            && (11..=30).contains(&c.bridges)
            && (4..=11).contains(&c.campi);
        if !sound {
            faults.push(format!("seed {seed}: {c:?}"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Height of water or paving at a place, m.
fn ground_m(plan: &CityPlan, p: DVec2) -> f64 {
    let dry = plan.isles.iter().any(|i| polygon::contains(&i.shore.outline, p));
    if dry { plan.lie.paving_m(p) } else { lie::WATER_M }
}

#[test]
fn the_grand_canal_is_wide_and_the_rest_as_dense() {
    for seed in 0..2 {
        let c = census(&planned(seed, &sized(330.0, Variant::Canal)));
        assert!((0.16..=0.32).contains(&c.water), "{c:?}");
        assert!((0.62..=0.78).contains(&c.built_of_land), "{c:?}");
    }
}

/// A side that turns around shows its back. (One did, at a flat corner: found by 200 seeds in tests/meshes.rs.)
#[test]
fn no_eaves_turn_around() {
    let mut short = 0;
    for seed in [15_532_437_443_006_573, 1, 2, 3, 4, 5] {
        let plan = planned(seed, &sized(100.0, Variant::Canal));
        for house in plan.isles.iter().flat_map(|i| &i.houses) {
            let houses::Cover::Tiles(roof) = &house.cover else { continue };
            assert!(!houses::turned_around(&house.outline, &roof.outline), "{seed}: {}", house.name);
            let uneven = houses::widened(&house.outline, |i| if i == 0 { 0.04 } else { 0.42 });
            short += u32::from(houses::turned_around(&house.outline, &uneven));
        }
    }
    assert!(short > 0, "no house has a corner so flat that it would");
}

#[test]
fn houses_are_closed_low_enough_and_under_roofs() {
    let plan = planned(3, &sized(150.0, Variant::Dense));
    let (mut houses, mut flat) = (0, 0);
    for house in plan.isles.iter().flat_map(|i| &i.houses) {
        let mesh = house_mesh::mesh(house, true);
        assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{}", house.name);
        if house.used == Use::House {
            assert!((EAVES_M[0]..=EAVES_M[1]).contains(&house.eaves_m), "{}: {}", house.name, house.eaves_m);
        }
        houses += 1;
        if let houses::Cover::Tiles(_) = house.cover {
            let tiles = mesh.slots.iter().filter(|s| **s == house_mesh::slot::ROOF).count();
            let ridge = mesh.positions_m.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
            flat += u32::from(tiles == 0 || f64::from(ridge) < house.eaves_m + 0.3);
        }
    }
    assert!(houses > 300, "{houses}");
    assert!(flat * 50 < houses, "{flat} of {houses} roofs did not close and lie flat");
}

#[test]
fn churches_are_closed() {
    let plan = planned(5, &sized(500.0, Variant::Dense));
    let churches: Vec<_> = plan.isles.iter().filter_map(|i| i.church.as_ref()).collect();
    assert!(churches.len() >= 8, "{}", churches.len());
    let mut highest: f64 = 0.0;
    for church in churches {
        let mesh = church::mesh(church);
        assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{church:?}");
        highest = highest.max(church.tower_m[2]);
    }
    assert!((45.0..=church::HIGHEST_M).contains(&highest), "{highest}");
}

#[test]
fn the_ground_has_no_crack_and_outlines_do_not_cross() {
    for (seed, variant, radius_m) in [(0, Variant::Dense, 200.0), (1, Variant::Canal, 60.0), (2, Variant::Canal, 330.0)]
    {
        let params = sized(radius_m, variant);
        let ground = assemble::ground(&params, &planned(seed, &params));
        assert_whole(&ground, 1700.0);
    }
}

#[test]
fn bridges_land_in_streets() {
    let plan = planned(4, &sized(330.0, Variant::Dense));
    let walls: Vec<Vec<DVec2>> = plan.isles.iter().flat_map(|i| &i.houses).map(House::world_outline).collect();
    let spans: Vec<_> = plan.spans.iter().filter(|s| in_frame(s.centre_m)).collect();
    for span in &spans {
        for end in [-1.0, 1.0] {
            for beyond_m in [0.5, 2.4] {
                let p = span.centre_m + span.axis * (end * (span.length_m / 2.0 + beyond_m));
                assert!(ground_m(&plan, p) > lie::WATER_M, "bridge {} ends in the water", span.key);
                let near = walls.iter().filter(|w| polygon::contains(w, p)).count();
                assert_eq!(near, 0, "bridge {} ends in a house", span.key);
            }
        }
        let under = ground_m(&plan, span.centre_m);
        assert!(under == lie::WATER_M, "bridge {} spans land", span.key);
    }
    assert!(spans.len() > 12, "{}", spans.len());
}

#[test]
fn one_tree_more_moves_no_house() {
    let houses = |trees, boats| {
        let params = Params { trees, boats, ..sized(60.0, Variant::Dense) };
        planned(4, &params).isles.into_iter().flat_map(|i| i.houses).collect::<Vec<_>>()
    };
    assert!(houses(1.0, 1.0) == houses(2.0, 0.3));
}

#[test]
fn parameters_move_what_they_say() {
    let count = |params: &Params, class: satseed_scene::Class| {
        let scene = build(params, SeedPath::root("venice", 6));
        scene.objects.iter().filter(|o| o.class == class).count() as f64
    };
    let base = sized(100.0, Variant::Canal);
    let trees = [0.0, 1.0, 3.0].map(|trees| count(&Params { trees, ..base.clone() }, satseed_scene::Class::Tree));
    assert_rises("trees", &trees);
    let boats = [0.0, 0.6, 1.4].map(|boats| count(&Params { boats, ..base.clone() }, satseed_scene::Class::Boat));
    assert_rises("boats", &boats);
    let built = [0.5, 1.0, 1.4].map(|density| {
        let plan = planned(2, &Params { density, ..sized(150.0, Variant::Dense) });
        let area: f64 = plan.isles.iter().flat_map(|i| &i.houses).map(|h| polygon::area(&h.outline)).sum();
        area
    });
    assert_rises("density", &built);
}

/// A scene of a seed with the extremes of all parameters in turn.
fn any(seed: u64) -> Params {
    let pick = |values: [f64; 3], turn: u64| values[((seed / turn) % 3) as usize];
    Params {
        variant: [Variant::Dense, Variant::Canal][(seed % 2) as usize],
        radius_m: 60.0,
        density: pick([1.0, 1.4, 0.5], 2),
        trees: pick([1.0, 0.0, 3.0], 3),
        boats: pick([1.0, 1.5, 0.0], 4),
        texture_contrast: pick([1.0, 0.0, 2.0], 5),
    }
}

fn seeds_build(seeds: impl IntoParallelIterator<Item = u64>) {
    seeds.into_par_iter().for_each(|seed| {
        let params = any(seed);
        let scene = build(&params, SeedPath::root("venice", seed));
        let of = format!("{seed}, {params:?}");
        assert_within_bounds(&scene, params.height_bounds_m(), params.memory_bound_bytes(), &of);
        let plan = planned(seed, &params);
        for i in scene.instances.iter().filter(|i| i.object != 0) {
            let below = vertices(&scene, i).map(|p| p.z - ground_m(&plan, p.truncate())).fold(f64::MAX, f64::min);
            assert!(below < -0.02, "{seed}, {}: {below}", scene.objects[i.object as usize].path);
        }
    });
}

#[test]
fn any_seed_builds_within_its_bounds_and_nothing_floats() {
    seeds_build(vec![2, 3, 5, 6]);
}

#[test]
#[ignore = "long: 200 scenes"]
fn two_hundred_seeds_build_within_their_bounds() {
    seeds_build(1000..1200);
}

#[test]
fn same_scene_with_one_and_two_threads() {
    let hash = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build(&sized(60.0, Variant::Canal), SeedPath::root("venice", 3)).hash())
    };
    assert_eq!(hash(1), hash(2));
}

/// What stands in a small scene stands in a large one, at the same places and with the same triangles.
#[test]
fn a_crop_is_a_part_of_the_whole() {
    for variant in [Variant::Dense, Variant::Canal] {
        let [crop, whole] = [60.0, 140.0].map(|radius_m| build(&sized(radius_m, variant), SeedPath::root("venice", 9)));
        assert_eq!(crop.pivot_height_m.to_bits(), whole.pivot_height_m.to_bits());
        assert_same_things(&crop, &whole, 60.0 + DETAIL_MARGIN_M, 60);
    }
}
