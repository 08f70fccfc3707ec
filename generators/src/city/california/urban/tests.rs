use super::Use;
use crate::city::california::assemble::{self, CityPlan, building_mesh};
use crate::city::california::lot::{Building, Kind};
use crate::city::california::tests::{FRAME_HALF_M, cover};
use crate::city::california::{DETAIL_MARGIN_M, Params, Variant, build};
use crate::kit::buildings::Detail;
use crate::kit::mesh_builder::open_edges;
use crate::kit::{checks, polygon};
use glam::DVec2;
use satseed_scene::{Class, SeedPath};
use std::collections::BTreeSet;

const BOTH: [Variant; 2] = [Variant::Downtown, Variant::Lowrise];

fn sized(variant: Variant, radius_m: f64) -> Params {
    Params { variant, radius_m, ..Params::default() }
}

fn planned_with(params: &Params, seed: u64) -> CityPlan {
    assemble::plan(params, &SeedPath::root("california", seed).child(params.variant()))
}

fn planned(variant: Variant, seed: u64, radius_m: f64) -> CityPlan {
    planned_with(&sized(variant, radius_m), seed)
}

fn buildings(plan: &CityPlan) -> Vec<&(String, Building)> {
    plan.parts.iter().flat_map(|(_, c)| &c.buildings).collect()
}

fn in_frame(b: &Building) -> bool {
    b.plan.centre_m.abs().max_element() < FRAME_HALF_M
}

/// Feet of all buildings that reach a height, world.
fn feet(plan: &CityPlan, least_m: f64) -> Vec<Vec<DVec2>> {
    let masses = buildings(plan).into_iter().flat_map(|(_, b)| b.plan.masses.iter().map(move |m| (b, m)));
    masses.filter(|(_, m)| m.roof_m >= least_m).map(|(b, m)| b.plan.world_outline(m)).collect()
}

#[test]
fn a_downtown_has_its_towers_and_its_cover() {
    let mut faults = Vec::new();
    for seed in 0..14 {
        let plan = planned(Variant::Downtown, seed, 700.0);
        let mut towers: Vec<f64> = buildings(&plan)
            .iter()
            .map(|(_, b)| b)
            .filter(|b| in_frame(b) && b.ridge_m >= 80.0)
            .map(|b| b.ridge_m)
            .collect();
        towers.sort_by(f64::total_cmp);
        let highest = buildings(&plan).iter().map(|(_, b)| b.ridge_m).fold(0.0, f64::max);
        let built = cover(&feet(&plan, 2.0), FRAME_HALF_M);
        let tall = cover(&feet(&plan, 60.0), FRAME_HALF_M);
        let frame = |p: DVec2| p.abs().max_element() < FRAME_HALF_M;
        let decks: usize =
            plan.parts.iter().map(|(_, c)| c.raised.iter().filter(|(v, _)| frame(v.centre)).count()).sum();
        let median = towers.get(towers.len() / 2).copied().unwrap_or(0.0);
        let line = format!(
            "seed {seed}: towers {} median {median:.0} highest {highest:.0} built {built:.3} tall {tall:.3} cars on decks {decks}",
            towers.len()
        );
        let sound = (12..=20).contains(&towers.len())
            && (90.0..=150.0).contains(&median)
            && (150.0..=215.0).contains(&highest)
            && (0.30..=0.50).contains(&built)
            && (0.03..=0.10).contains(&tall)
            && decks > 60;
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn low_blocks_have_their_cover_heights_and_cars() {
    let mut faults = Vec::new();
    for seed in 0..10 {
        let plan = planned(Variant::Lowrise, seed, 400.0);
        let built = cover(&feet(&plan, 2.0), FRAME_HALF_M);
        let heights: Vec<f64> = buildings(&plan)
            .iter()
            .map(|(_, b)| b)
            .filter(|b| in_frame(b) && b.plan.footprint_m2() > 40.0)
            .map(|b| b.ridge_m)
            .collect();
        let low = heights.iter().filter(|h| (4.0..=13.0).contains(*h)).count() as f64 / heights.len() as f64;
        let highest = heights.iter().copied().fold(0.0, f64::max);
        let frame = |p: DVec2| p.abs().max_element() < FRAME_HALF_M;
        let off_street: usize =
            plan.parts.iter().map(|(_, c)| c.vehicles.iter().filter(|v| !v.lowered && frame(v.centre)).count()).sum();
        let line = format!(
            "seed {seed}: built {built:.3} buildings {} low {low:.2} highest {highest:.0} cars off streets {off_street}",
            heights.len()
        );
        let sound = (0.25..=0.45).contains(&built)
            && low >= 0.8
            && (13.0..=36.0).contains(&highest)
            && heights.len() > 90
            && off_street > 350;
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Masses of a plan, to 20 cm.
fn shape(b: &Building) -> Vec<Vec<i64>> {
    let round = |x: f64| libm::round(5.0 * x) as i64;
    b.plan
        .masses
        .iter()
        .map(|m| m.outline.iter().flat_map(|p| [round(p.x), round(p.y)]).chain([round(m.roof_m)]).collect())
        .collect()
}

#[test]
fn neighbours_have_different_plans() {
    for variant in BOTH {
        let plan = planned(variant, 4, 300.0);
        let all: Vec<(&String, DVec2, Vec<Vec<i64>>)> = buildings(&plan)
            .into_iter()
            .filter(|(_, b)| b.plan.footprint_m2() > 60.0)
            .map(|(name, b)| (name, b.plan.centre_m, shape(b)))
            .collect();
        assert!(all.len() > 60, "{}", all.len());
        for (k, (name, at, a)) in all.iter().enumerate() {
            for (other, there, b) in &all[k + 1..] {
                assert!(at.distance(*there) > 90.0 || a != b, "{name} and {other}");
            }
        }
    }
}

#[test]
fn no_building_floats_and_all_are_closed() {
    for variant in BOTH {
        let plan = planned(variant, 3, 260.0);
        let mut uses = BTreeSet::new();
        for (name, building) in buildings(&plan) {
            let b = &building.plan;
            for detail in [Detail::Full, Detail::Massing] {
                let mesh = building_mesh(building, detail);
                assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{name}");
            }
            let Kind::Urban(usage) = building.kind else { panic!("{name}") };
            uses.insert(usage);
            for mass in b.masses.iter().filter(|m| m.low_m < 0.0) {
                let outline = polygon::subdivided(&b.world_outline(mass), 2.0);
                let lowest = outline.iter().map(|p| plan.land.height_m(*p)).fold(f64::MAX, f64::min);
                assert!(b.ground_m + mass.low_m <= lowest - 0.5, "{name}");
            }
            // What does not stand on the ground stands on, or in, a mass that reaches above its foot.
            for mass in b.masses.iter().filter(|m| m.low_m >= 0.0 && usage != Use::Footbridge) {
                let at = polygon::centroid(&mass.outline);
                let near = |o: &[DVec2]| polygon::contains(o, at) || polygon::border_distance(o, at) < 8.0;
                assert!(
                    b.masses
                        .iter()
                        .any(|m| m != mass && m.roof_m >= mass.low_m && m.low_m < mass.low_m && near(&m.outline)),
                    "{name}"
                );
            }
            assert!(usage == Use::Footbridge || b.masses[0].low_m < 0.0, "{name} has no foot");
        }
        let wanted: &[Use] = if variant == Variant::Downtown {
            &[Use::Office, Use::Residence, Use::Block, Use::Garage, Use::Store, Use::Footbridge]
        } else {
            &[Use::Store, Use::Works, Use::Apartments]
        };
        assert!(wanted.iter().all(|u| uses.contains(u)), "{uses:?}");
    }
}

#[test]
fn buildings_of_different_sites_keep_apart() {
    for variant in BOTH {
        let plan = planned(variant, 6, 220.0);
        // Outlines of L and U shape are tested by their corners and the middles of their edges.
        let feet: Vec<(String, Vec<Vec<DVec2>>)> = buildings(&plan)
            .into_iter()
            .filter(|(_, b)| b.kind != Kind::Urban(Use::Footbridge))
            .map(|(name, b)| {
                let grounded = b.plan.masses.iter().filter(|m| m.low_m < 3.0);
                (name.clone(), grounded.map(|m| polygon::mitred(&b.plan.world_outline(m), 0.05)).collect())
            })
            .collect();
        for (k, (name, a)) in feet.iter().enumerate() {
            for (other, b) in &feet[k + 1..] {
                for (p, q) in a.iter().flat_map(|p| b.iter().map(move |q| (p, q))) {
                    if polygon::centroid(p).distance(polygon::centroid(q)) < 120.0 {
                        let inside = |p: &[DVec2], q: &[DVec2]| {
                            polygon::subdivided(p, 3.0).iter().any(|c| polygon::contains(q, *c))
                        };
                        assert!(!inside(p, q) && !inside(q, p), "{name} and {other}");
                    }
                }
            }
        }
    }
}

#[test]
fn the_footbridge_joins_two_buildings_over_a_street() {
    let mut found = 0;
    for seed in 0..6 {
        let plan = planned(Variant::Downtown, seed, 120.0);
        let all = buildings(&plan);
        let Some((_, bridge)) = all.iter().find(|(_, b)| b.kind == Kind::Urban(Use::Footbridge)) else { continue };
        found += 1;
        let mass = &bridge.plan.masses[0];
        let half = mass.outline.iter().map(|p| p.x).fold(0.0, f64::max);
        let holds = |p: DVec2| {
            let stands = |b: &Building| {
                b.plan
                    .masses
                    .iter()
                    .any(|m| m.low_m < 0.0 && m.roof_m > mass.roof_m && polygon::contains(&b.plan.world_outline(m), p))
            };
            all.iter().filter(|(_, b)| stands(b)).map(|(name, _)| name.clone()).next()
        };
        let ends = [-half + 0.1, half - 0.1].map(|x| holds(bridge.plan.to_world(DVec2::new(x, 0.0))));
        assert!(ends.iter().all(Option::is_some) && ends[0] != ends[1], "{seed}: {ends:?}");
        assert!(holds(bridge.plan.centre_m).is_none(), "{seed}");
    }
    assert!(found >= 4, "{found}");
}

#[test]
fn the_ground_has_no_crack_and_no_t_junction() {
    for (variant, seed, radius_m) in [
        (Variant::Downtown, 0, 150.0),
        (Variant::Downtown, 5, 60.0),
        (Variant::Lowrise, 1, 150.0),
        (Variant::Lowrise, 2, 60.0),
    ] {
        let params = sized(variant, radius_m);
        checks::assert_whole(&assemble::ground(&params, &planned_with(&params, seed)), 2400.0);
    }
}

#[test]
fn no_plan_of_any_seed_has_a_mass_too_thin_or_inside_out() {
    for (variant, seed) in BOTH.into_iter().flat_map(|v| (1000..1040).map(move |s| (v, s))) {
        for (name, b) in buildings(&planned(variant, seed, 60.0)) {
            assert!(b.plan.masses.iter().all(super::site::sound), "{variant:?} {seed}: {name}");
        }
    }
}

#[test]
fn any_seed_builds_within_its_bounds() {
    for (variant, seed) in BOTH.into_iter().flat_map(|v| [11, 1012, u64::MAX].map(|s| (v, s))) {
        let params = sized(variant, 60.0);
        let scene = build(&params, SeedPath::root("california", seed));
        checks::assert_within_bounds(&scene, params.height_bounds_m(), params.memory_bound_bytes(), params.variant());
        let raised = scene.objects.iter().any(|o| o.class == Class::Vehicle && o.path.contains("/raised/"));
        assert!(variant == Variant::Downtown || !raised);
    }
}

#[test]
#[ignore = "long: 2 x 100 scenes"]
fn two_hundred_seeds_build_within_their_bounds() {
    for (variant, seed) in BOTH.into_iter().flat_map(|v| (1000..1100).map(move |s| (v, s))) {
        let params = sized(variant, 60.0);
        let scene = build(&params, SeedPath::root("california", seed));
        scene.validate().unwrap();
        checks::assert_between(&scene, params.height_bounds_m(), params.variant());
    }
}

#[test]
fn same_scene_with_one_and_two_threads() {
    for variant in BOTH {
        let hash = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&sized(variant, 60.0), SeedPath::root("california", 3)).hash())
        };
        assert_eq!(hash(1), hash(2));
    }
}

/// What stands in a small scene stands in a large one, at the same places and with the same triangles and materials.
#[test]
fn a_crop_is_a_part_of_the_whole() {
    for variant in BOTH {
        let [crop, whole] =
            [60.0, 170.0].map(|radius_m| build(&sized(variant, radius_m), SeedPath::root("california", 9)));
        assert_eq!(crop.pivot_height_m.to_bits(), whole.pivot_height_m.to_bits());
        checks::assert_same_things(&crop, &whole, 60.0 + DETAIL_MARGIN_M, 60);
    }
}

#[test]
fn parameters_move_what_they_say() {
    for variant in BOTH {
        let measure = |p: &Params| {
            let plan = planned_with(p, 3);
            let sum = |f: &dyn Fn(&crate::city::california::lot::Content) -> usize| {
                plan.parts.iter().map(|(_, c)| f(c)).sum::<usize>() as f64
            };
            [cover(&feet(&plan, 2.0), 200.0), sum(&|c| c.plants.len()), sum(&|c| c.vehicles.len() + c.raised.len())]
        };
        let at = |density, trees, vehicles| measure(&Params { density, trees, vehicles, ..sized(variant, 120.0) });
        checks::assert_rises("density", &[0.3, 0.6, 1.0].map(|d| at(d, 1.0, 1.0)[0]));
        checks::assert_rises("trees", &[0.0, 0.6, 1.2].map(|t| at(1.0, t, 1.0)[1]));
        checks::assert_rises("vehicles", &[0.0, 0.5, 1.0, 2.0].map(|v| at(1.0, 1.0, v)[2]));
        let houses = |trees, vehicles| {
            let p = Params { trees, vehicles, ..sized(variant, 60.0) };
            planned_with(&p, 4).parts.into_iter().flat_map(|(_, c)| c.buildings).collect::<Vec<_>>()
        };
        assert!(houses(1.0, 1.0) == houses(2.0, 0.3));
    }
}
