use super::*;
use crate::city::california::assemble::{self, CityPlan, building_mesh};
use crate::city::california::lot::{Building, Kind};
use crate::city::california::{Variant, build};
use crate::kit::buildings::Detail;
use crate::kit::checks;
use crate::kit::mesh_builder::open_edges;
use std::collections::BTreeMap;

/// Half side of a frame of 2048 pixels at 0.3 m.
const FRAME_HALF_M: f64 = 307.0;

fn params(radius_m: f64) -> Params {
    Params { variant: Variant::Hill, radius_m, ..Params::default() }
}

fn planned(seed: u64, radius_m: f64) -> CityPlan {
    assemble::plan(&params(radius_m), &SeedPath::root("california", seed).child("hill"))
}

fn hills(plan: &CityPlan) -> &Hills {
    plan.land.hills().unwrap()
}

/// Places of a frame, every few metres.
fn frame(step_m: f64) -> Vec<DVec2> {
    let n = (2.0 * FRAME_HALF_M / step_m) as i32;
    let at = |k: i32| (f64::from(k) + 0.5) * step_m - FRAME_HALF_M;
    (0..n * n).map(|k| DVec2::new(at(k % n), at(k / n))).collect()
}

#[test]
fn a_frame_has_its_relief_and_houses() {
    let mut faults = Vec::new();
    for seed in 0..8 {
        let plan = planned(seed, 330.0);
        let places = frame(6.0);
        let heights: Vec<f64> = places.iter().map(|p| plan.land.height_m(*p)).collect();
        let relief =
            heights.iter().copied().fold(f64::MIN, f64::max) - heights.iter().copied().fold(f64::MAX, f64::min);
        let roofs: Vec<Vec<DVec2>> = plan
            .parts
            .iter()
            .flat_map(|(_, c)| &c.buildings)
            .flat_map(|(_, b)| b.plan.masses.iter().map(|m| b.plan.world_outline(m)))
            .collect();
        let bounds: Vec<(DVec2, DVec2)> = roofs.iter().map(|o| polygon::bounds(o)).collect();
        let roofed = |p: &&DVec2| {
            roofs
                .iter()
                .zip(&bounds)
                .any(|(o, (low, high))| p.cmpge(*low).all() && p.cmple(*high).all() && polygon::contains(o, **p))
        };
        let built = places.iter().filter(roofed).count() as f64 / places.len() as f64;
        let count = |kind: Kind| {
            let all = plan.parts.iter().flat_map(|(_, c)| &c.buildings);
            all.filter(|(_, b)| b.kind == kind && b.plan.centre_m.abs().max_element() < FRAME_HALF_M).count()
        };
        let shrubs = plan.parts.iter().flat_map(|(_, c)| &c.plants).filter(|p| p.plant == Plant::Chaparral).count();
        let pools: u32 = plan.parts.iter().map(|(_, c)| c.pools).sum();
        let (houses, villas) = (count(Kind::House), count(Kind::Villa));
        let line = format!(
            "seed {seed}: relief {relief:.1} built {built:.3} houses {houses} villas {villas} pools {pools} shrubs {shrubs}"
        );
        let sound = (50.0..=130.0).contains(&relief)
            && (0.05..=0.2).contains(&built)
            && houses >= 20
            && villas >= 15
            && pools > 10
            && shrubs > 3000;
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn streets_are_no_steeper_than_cars_climb() {
    for seed in 0..12 {
        let land =
            Land::over(Hills::new(&SeedPath::root("california", seed).child("hill")), &SeedPath::root("x", seed));
        let mut steepest: f64 = 0.0;
        for ridge in &land.hills().unwrap().ridges {
            for p in ridge.points.windows(2) {
                let run = p[0].truncate().distance(p[1].truncate());
                steepest = steepest.max((p[1].z - p[0].z).abs() / run);
                // The ground of a street is the street's, and level across, where no other is near.
                let (middle, along) = ((p[0] + p[1]) * 0.5, (p[1] - p[0]).truncate() / run);
                if middle.truncate().length() < 400.0 && ridge.crest != Crest::Wild {
                    for left in [-ROW_M + 0.2, 0.0, ROW_M - 0.2] {
                        let at = land.world(middle.truncate() + along.perp() * left);
                        let h = land.height_m(at);
                        assert!((h - middle.z).abs() < 0.9, "seed {seed}: {h} for {}", middle.z);
                    }
                }
            }
        }
        assert!((0.06..0.12).contains(&steepest), "seed {seed}: {steepest}");
    }
}

#[test]
fn pads_are_level_and_banks_no_steeper_than_told() {
    for seed in 0..3 {
        let plan = planned(seed, 60.0);
        let hills = hills(&plan);
        let mut seen = 0;
        for lot in hills.lots.iter().filter(|l| polygon::centroid(&l.outline).length() < 400.0) {
            seen += 1;
            for p in polygon::subdivided(&lot.outline, 4.0) {
                let h = hills.height_m(p);
                assert!((h - lot.height_m).abs() < 0.01, "seed {seed}: {h} on a pad at {}", lot.height_m);
            }
        }
        assert!(seen > 60, "{seen}");
        // Where something was built the land is no steeper than banks, or than the land was.
        let mut steepest: f64 = 0.0;
        for p in frame(3.0) {
            let slope = |f: &dyn Fn(DVec2) -> f64| {
                let d = |v: DVec2| (f(p + v) - f(p - v)) / (2.0 * v.length());
                DVec2::new(d(DVec2::new(0.25, 0.0)), d(DVec2::new(0.0, 0.25))).length()
            };
            let built = slope(&|q| hills.height_m(q));
            steepest = steepest.max(built);
        }
        assert!(steepest < 1.15, "seed {seed}: {steepest}");
    }
}

#[test]
fn the_ground_is_whole() {
    for (seed, radius_m) in [(0, 90.0), (1, 60.0), (5, 130.0)] {
        let ground = assemble::ground(&params(radius_m), &planned(seed, radius_m));
        checks::assert_whole(&ground, 2400.0);
    }
}

#[test]
fn no_house_floats_or_is_buried() {
    for seed in 0..3 {
        let plan = planned(seed, 250.0);
        let mut kinds = BTreeMap::new();
        for (name, building) in plan.parts.iter().flat_map(|(_, c)| &c.buildings) {
            let b = &building.plan;
            let mesh = building_mesh(building, Detail::Full);
            assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{name}");
            for mass in b.masses.iter().filter(|m| m.low_m < 0.0) {
                let outline = polygon::subdivided(&b.world_outline(mass), 2.0);
                for p in outline {
                    let h = plan.land.height_m(p);
                    assert!(b.ground_m + mass.low_m <= h - 0.5, "{name} stands on air");
                    assert!(h < b.ground_m + 0.6, "{name} is buried {} m", h - b.ground_m);
                }
            }
            *kinds.entry(format!("{:?}", building.kind)).or_insert(0) += 1;
        }
        assert!(kinds.len() >= 3, "{kinds:?}");
        // Pools are as level as their pads, and no street is covered.
        for (name, patch) in plan.parts.iter().flat_map(|(n, c)| c.patches.iter().map(move |p| (n, p))) {
            if patch.0 == Layer::Water {
                let z: Vec<f64> = patch.1.outline.iter().map(|p| plan.land.height_m(*p)).collect();
                let spread = z.iter().copied().fold(f64::MIN, f64::max) - z.iter().copied().fold(f64::MAX, f64::min);
                assert!(spread < 0.02, "{name}: a pool with {spread} m of fall");
            }
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let of = |radius_m| -> BTreeMap<String, Building> {
        planned(7, radius_m).parts.into_iter().flat_map(|(_, c)| c.buildings).collect()
    };
    let (small, large) = (of(60.0), of(330.0));
    assert!(small.len() > 30, "{}", small.len());
    assert!(small.iter().all(|(name, building)| large.get(name) == Some(building)));
}

#[test]
fn any_seed_builds_within_its_bounds() {
    for seed in 20..24 {
        let params = params(60.0);
        let scene = build(&params, SeedPath::root("california", seed));
        checks::assert_within_bounds(&scene, params.height_bounds_m(), params.memory_bound_bytes(), "hill");
    }
}
