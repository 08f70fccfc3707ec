use super::assemble::{self, CityPlan, building_mesh};
use super::lot::Kind;
use super::*;
use crate::kit::buildings::Detail;
use crate::kit::checks;
use crate::kit::mesh_builder::open_edges;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::Class;
use std::collections::BTreeMap;

/// Half side of a frame of 2048 pixels at 0.3 m.
pub(super) const FRAME_HALF_M: f64 = 307.0;

fn params(radius_m: f64) -> Params {
    Params { radius_m, ..Params::default() }
}

fn city(seed: u64) -> SeedPath {
    SeedPath::root("california", seed).child("suburb")
}

fn planned(seed: u64, radius_m: f64) -> CityPlan {
    assemble::plan(&params(radius_m), &city(seed))
}

/// A share of a square around the pivot, sampled every 2 m, that convex or simple outlines cover.
pub(super) fn cover(outlines: &[Vec<DVec2>], half_m: f64) -> f64 {
    let bounds: Vec<(DVec2, DVec2)> = outlines.iter().map(|o| polygon::bounds(o)).collect();
    let step = 2.0;
    let n = (2.0 * half_m / step) as usize;
    let mut hit = vec![false; n * n];
    for (o, (low, high)) in outlines.iter().zip(bounds) {
        let index = |x: f64| (((x + half_m) / step).max(0.0) as usize).min(n);
        for j in index(low.y)..(index(high.y) + 1).min(n) {
            for i in index(low.x)..(index(high.x) + 1).min(n) {
                let p = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * step - DVec2::splat(half_m);
                hit[j * n + i] |= polygon::contains(o, p);
            }
        }
    }
    hit.iter().filter(|h| **h).count() as f64 / (n * n) as f64
}

/// Roof outlines with their eaves.
fn roofs(plan: &CityPlan) -> Vec<Vec<DVec2>> {
    let buildings = plan.parts.iter().flat_map(|(_, c)| &c.buildings);
    buildings
        .flat_map(|(_, b)| {
            b.plan.masses.iter().map(|m| {
                let eaves = match m.roof {
                    crate::kit::buildings::Roof::Gable { eaves_m, .. } => eaves_m,
                    crate::kit::buildings::Roof::Flat { .. } => 0.0,
                };
                polygon::mitred(&b.plan.world_outline(m), -eaves)
            })
        })
        .collect()
}

#[test]
fn a_suburb_has_its_cover_heights_and_pools() {
    let mut faults = Vec::new();
    let mut mean = 0.0;
    for seed in 0..8 {
        let plan = planned(seed, 330.0);
        let built = cover(&roofs(&plan), FRAME_HALF_M);
        let lots = plan.parts.iter().filter(|(name, _)| name.contains("/lot/")).count();
        let contents: Vec<_> = plan.parts.iter().map(|(_, c)| c).collect();
        let houses: Vec<f64> = contents
            .iter()
            .flat_map(|c| &c.buildings)
            .filter(|(_, b)| b.kind == Kind::House)
            .map(|(_, b)| b.ridge_m)
            .collect();
        let share = |f: &dyn Fn(f64) -> bool| houses.iter().filter(|h| f(**h)).count() as f64 / houses.len() as f64;
        let low = share(&|h| (4.5..=5.6).contains(&h));
        let high = share(&|h| (6.9..=8.5).contains(&h));
        let pools = f64::from(contents.iter().map(|c| c.pools).sum::<u32>()) / lots as f64;
        let solar = f64::from(contents.iter().map(|c| c.solar).sum::<u32>()) / lots as f64;
        let line = format!(
            "seed {seed}: built {built:.3} lots {} houses {} low {low:.2} high {high:.2} pools {pools:.2} solar {solar:.2}",
            lots,
            houses.len()
        );
        mean += built / 8.0;
        // A frame with a school or a park in it is thinner than the mean.
        let sound = (0.24..=0.38).contains(&built)
            && (0.5..=0.75).contains(&low)
            && low + high > 0.99
            && (0.15..=0.30).contains(&pools)
            && (0.10..=0.25).contains(&solar)
            && houses.len() as f64 > 0.88 * lots as f64;
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty() && (0.28..=0.38).contains(&mean), "{mean:.3} {faults:#?}");
}

#[test]
fn crowns_cover_an_eighth_to_a_quarter() {
    let mut shares = Vec::new();
    for seed in [2, 5] {
        let scene = build(&params(150.0), SeedPath::root("california", seed));
        let crowns: Vec<Vec<DVec2>> = scene
            .instances
            .iter()
            .filter(|i| scene.objects[i.object as usize].class == Class::Tree)
            .map(|i| {
                let (low, high) = scene.meshes[i.mesh as usize].bounds_m().unwrap();
                let middle = i.world_from_object.transform_point3((low + high) * 0.5).truncate();
                let scale = i.world_from_object.matrix3.x_axis.length();
                // Crowns are lopsided: their mean radius is about 0.85 of half their bounds.
                let r = (high - low).truncate().element_sum() / 4.0 * scale * 0.85;
                (0..12)
                    .map(|k| {
                        let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 12.0);
                        middle + DVec2::new(c, s) * r
                    })
                    .collect()
            })
            .collect();
        shares.push(cover(&crowns, 100.0));
    }
    assert!(shares.iter().all(|s| (0.12..=0.25).contains(s)), "{shares:?}");
}

#[test]
fn one_tree_more_moves_no_house() {
    let plan = |trees, vehicles| {
        let params = Params { trees, vehicles, ..params(60.0) };
        let plan = assemble::plan(&params, &city(4));
        let houses: Vec<_> = plan.parts.into_iter().flat_map(|(_, c)| c.buildings).collect();
        houses
    };
    assert!(plan(1.0, 1.0) == plan(2.0, 0.3));
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let names = |radius_m| -> BTreeMap<String, super::lot::Building> {
        planned(7, radius_m).parts.into_iter().flat_map(|(_, c)| c.buildings).collect()
    };
    let (small, large) = (names(60.0), names(300.0));
    assert!(small.len() > 50);
    for (name, building) in &small {
        assert!(large.get(name) == Some(building), "{name}");
    }
}

#[test]
fn parameters_move_what_they_say() {
    let measure = |p: Params| {
        let plan = assemble::plan(&p, &city(3));
        let count =
            |f: &dyn Fn(&super::lot::Content) -> usize| plan.parts.iter().map(|(_, c)| f(c)).sum::<usize>() as f64;
        [count(&|c| c.buildings.len()), count(&|c| c.plants.len()), count(&|c| c.vehicles.len())]
    };
    let at = |density, trees, vehicles| measure(Params { density, trees, vehicles, ..params(120.0) });
    checks::assert_rises("density", &[0.3, 0.6, 1.0].map(|d| at(d, 1.0, 1.0)[0]));
    checks::assert_rises("trees", &[0.0, 0.6, 1.2, 2.4].map(|t| at(1.0, t, 1.0)[1]));
    checks::assert_rises("vehicles", &[0.0, 0.5, 1.0, 2.0].map(|v| at(1.0, 1.0, v)[2]));
}

#[test]
fn same_scene_with_one_and_two_threads() {
    let hash = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build(&params(80.0), SeedPath::root("california", 3)).hash())
    };
    assert_eq!(hash(1), hash(2));
}

#[test]
fn a_scene_is_legal_within_its_bounds_and_its_memory() {
    for seed in 0..3 {
        let params = params(90.0);
        let scene = build(&params, SeedPath::root("california", seed));
        checks::assert_within_bounds(&scene, params.height_bounds_m(), params.memory_bound_bytes(), "suburb");
    }
}

#[test]
fn the_ground_has_no_crack_and_no_t_junction() {
    for (seed, radius_m) in [(0, 150.0), (1, 60.0), (2, 333.3)] {
        let ground = assemble::ground(&params(radius_m), &planned(seed, radius_m));
        checks::assert_whole(&ground, 2400.0);
    }
}

#[test]
fn no_building_floats_and_all_are_closed() {
    for seed in [1, 2] {
        let plan = planned(seed, 200.0);
        let mut kinds = BTreeMap::new();
        for (name, building) in plan.parts.iter().flat_map(|(_, c)| &c.buildings) {
            let b = &building.plan;
            let mesh = building_mesh(building, Detail::Full);
            assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{name}");
            for mass in b.masses.iter().filter(|m| m.low_m < 0.0) {
                let outline = polygon::subdivided(&b.world_outline(mass), 2.0);
                let lowest = outline.iter().map(|p| plan.land.height_m(*p)).fold(f64::MAX, f64::min);
                assert!(b.ground_m + mass.low_m <= lowest - 0.5, "{name}");
            }
            assert!(b.masses[0].low_m < 0.0, "{name} has no foot");
            *kinds.entry(format!("{:?}", building.kind)).or_insert(0) += 1;
        }
        assert!(kinds.len() >= 3, "{kinds:?}");
    }
}

#[test]
fn houses_keep_to_their_lots_and_apart() {
    let plan = planned(6, 200.0);
    let feet: Vec<(String, Vec<Vec<DVec2>>)> = plan
        .parts
        .iter()
        .filter_map(|(name, c)| {
            let (_, b) = c.buildings.first().filter(|(_, b)| b.kind == Kind::House)?;
            Some((name.clone(), b.plan.masses.iter().map(|m| b.plan.world_outline(m)).collect()))
        })
        .collect();
    let centre = |f: &[Vec<DVec2>]| polygon::centroid(&f[0]);
    for (k, (name, a)) in feet.iter().enumerate() {
        for (other, b) in &feet[k + 1..] {
            if centre(a).distance(centre(b)) < 50.0 {
                let meet = a.iter().any(|p| b.iter().any(|q| polygon::convex_overlap(p, q)));
                assert!(!meet, "{name} and {other}");
            }
        }
    }
    assert!(feet.len() > 100);
}

#[test]
fn the_interchange_is_closed_rooted_and_open_below() {
    for seed in 0..6 {
        let params = Params { variant: Variant::Interchange, ..params(330.0) };
        let city = SeedPath::root("california", seed).child("interchange");
        let plan = assemble::plan(&params, &city);
        let stack = &plan.interchange;
        assert_eq!(stack.pieces.len(), 10);
        for (name, mesh) in &stack.pieces {
            assert_eq!((mesh.validate(), open_edges(mesh)), (Ok(()), 0), "{name}");
            let below = mesh.positions_m.iter().map(|p| {
                let p = p.map(f64::from);
                p[2] - plan.land.height_m(DVec2::new(p[0], p[1]))
            });
            assert!(below.fold(f64::MAX, f64::min) < -0.4, "{name} does not reach the ground");
        }
        let open = cover(&stack.spans, FRAME_HALF_M);
        assert!((0.03..=0.08).contains(&open), "seed {seed}: {open:.3} of the frame lie below decks");
        // Heights of the decks' highest places, each level a lorry and its clearance apart.
        assert!(freeway::LEVELS_M.windows(2).all(|l| (7.0..=9.0).contains(&(l[1] - l[0]))));
        assert!(stack.vehicles.len() > 300, "{}", stack.vehicles.len());
    }
}

#[test]
fn nothing_stands_in_the_way_of_a_freeway() {
    let params = Params { variant: Variant::Interchange, ..params(330.0) };
    let plan = assemble::plan(&params, &SeedPath::root("california", 1).child("interchange"));
    let decks: Vec<((DVec2, DVec2), &Vec<DVec2>)> =
        plan.interchange.decks.iter().map(|d| (polygon::bounds(d), d)).collect();
    let under = |p: DVec2| {
        decks.iter().any(|((low, high), d)| p.cmpge(*low).all() && p.cmple(*high).all() && polygon::contains(d, p))
    };
    for (name, building) in plan.parts.iter().flat_map(|(_, c)| &c.buildings) {
        for mass in &building.plan.masses {
            assert!(!building.plan.world_outline(mass).iter().any(|p| under(*p)), "{name}");
        }
    }
    for (name, content) in &plan.parts {
        let tall = content.plants.iter().filter(|p| p.plant != super::lot::Plant::Shrub).any(|p| under(p.at));
        assert!(!tall, "a tree of {name} grows through a deck");
    }
}
