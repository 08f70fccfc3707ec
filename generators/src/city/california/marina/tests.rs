use super::harbour::{Harbour, WATER_M};
use super::*;
use crate::city::california::assemble::{self, CityPlan, building_mesh};
use crate::city::california::lot::{Building, Kind};
use crate::city::california::{Variant, build};
use crate::kit::buildings::Detail;
use crate::kit::checks;
use crate::kit::mesh_builder::open_edges;
use crate::kit::polygon;
use std::collections::{BTreeMap, BTreeSet};

/// Half side of a frame of 2048 pixels at 0.3 m.
const FRAME_HALF_M: f64 = 307.0;

fn params(radius_m: f64) -> Params {
    Params { variant: Variant::Waterfront, radius_m, ..Params::default() }
}

fn planned(seed: u64, radius_m: f64) -> CityPlan {
    assemble::plan(&params(radius_m), &SeedPath::root("california", seed).child("waterfront"))
}

fn harbour(plan: &CityPlan) -> &Harbour {
    plan.land.harbour().unwrap()
}

fn in_frame(p: DVec2) -> bool {
    p.abs().max_element() < FRAME_HALF_M
}

#[test]
fn a_frame_has_its_water_boats_and_houses() {
    let mut faults = Vec::new();
    for seed in 0..8 {
        let plan = planned(seed, 330.0);
        let steps = 150;
        let at = |k: i32| (f64::from(k) + 0.5) * 2.0 * FRAME_HALF_M / f64::from(steps) - FRAME_HALF_M;
        let wet = (0..steps * steps)
            .filter(|k| harbour(&plan).is_water(plan.land.turned_back(DVec2::new(at(k % steps), at(k / steps)))))
            .count();
        let share = wet as f64 / f64::from(steps * steps);
        let boats: Vec<&Afloat> = plan.marina.boats.iter().filter(|b| in_frame(b.at)).collect();
        let kinds: BTreeSet<Boat> = boats.iter().map(|b| b.boat).collect();
        let masts = boats.iter().filter(|b| matches!(b.boat, Boat::Sloop | Boat::Catamaran)).count();
        let count = |kind: Kind| {
            let all = plan.parts.iter().flat_map(|(_, c)| &c.buildings);
            all.filter(|(_, b)| b.kind == kind && in_frame(b.plan.centre_m)).count()
        };
        let palms = plan.parts.iter().flat_map(|(_, c)| &c.plants);
        let palms = palms.filter(|p| p.plant == crate::city::california::lot::Plant::Palm && in_frame(p.at)).count();
        let line = format!(
            "seed {seed}: water {share:.3} boats {} masts {masts} docks {} flats {} shops {} houses {} palms {palms} piers {}",
            boats.len(),
            plan.marina.docks.iter().filter(|d| in_frame(d.at)).count(),
            count(Kind::Apartments),
            count(Kind::Shop),
            count(Kind::House),
            plan.marina.piers.len(),
        );
        let sound = (0.2..=0.5).contains(&share)
            && (130..1500).contains(&boats.len())
            && kinds.len() >= 5
            && (0.15..0.6).contains(&(masts as f64 / boats.len() as f64))
            && count(Kind::Apartments) >= 6
            && count(Kind::Shop) >= 2
            && palms > 60;
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Outlines of boats in the world, by name.
fn outlines(boats: &[Afloat]) -> Vec<(&Afloat, Vec<DVec2>)> {
    boats
        .iter()
        .map(|b| {
            let [l, w] = b.boat.size_m(b.individual);
            (b, polygon::oriented_rectangle(b.at, b.axis, DVec2::new(l, w) / 2.0))
        })
        .collect()
}

#[test]
fn boats_lie_in_deep_water_apart_and_beside_no_clone() {
    for seed in 0..3 {
        let plan = planned(seed, 250.0);
        let all = outlines(&plan.marina.boats);
        assert!(all.len() > 100, "{}", all.len());
        for (k, (boat, outline)) in all.iter().enumerate() {
            for p in outline {
                let depth = harbour(&plan).depth_m(plan.land.turned_back(*p));
                assert!(depth > 1.2, "seed {seed}: {} lies in {depth} m of water", boat.name);
            }
            for (other, theirs) in &all[k + 1..] {
                let distance = boat.at.distance(other.at);
                assert!(
                    distance > 26.0 || !polygon::convex_overlap(outline, theirs),
                    "{} and {}",
                    boat.name,
                    other.name
                );
                let same = (boat.boat, boat.individual) == (other.boat, other.individual);
                let (row, n) = boat.name.rsplit_once('/').unwrap();
                let (other_row, m) = other.name.rsplit_once('/').unwrap();
                if let (true, Ok(n), Ok(m)) = (row == other_row, n.parse::<i32>(), m.parse::<i32>()) {
                    assert!((n - m).abs() != 1 || !same, "{} and {} are alike", boat.name, other.name);
                }
            }
        }
    }
}

#[test]
fn docks_float_clear_of_the_land_and_of_each_other() {
    assert!((0.3..=0.8).contains(&docks::FREEBOARD_M));
    for seed in 0..3 {
        let plan = planned(seed, 250.0);
        let walks: Vec<Vec<DVec2>> = plan
            .marina
            .docks
            .iter()
            .map(|d| {
                let m = d.dock.mesh(&mut SeedPath::root("dock", seed).rng());
                let decks = m.triangles.iter().zip(&m.slots).filter(|(_, s)| **s == docks::slot::DECK);
                let points: Vec<[f32; 3]> = decks.flat_map(|(t, _)| t.map(|v| m.positions_m[v as usize])).collect();
                let of = |axis: usize| {
                    let all = points.iter().map(|p| f64::from(p[axis]));
                    all.fold([f64::MAX, f64::MIN], |[l, h], x| [l.min(x), h.max(x)])
                };
                let (x, y, z) = (of(0), of(1), of(2));
                assert!(z[0] > 0.25 && z[1] <= 0.8, "{z:?}");
                let at = |x: f64, y: f64| d.at + d.axis * x + d.axis.perp() * y;
                vec![at(x[0], y[0]), at(x[1], y[0]), at(x[1], y[1]), at(x[0], y[1])]
            })
            .collect();
        assert!(walks.len() > 8);
        for (k, a) in walks.iter().enumerate() {
            assert!(a.iter().all(|p| harbour(&plan).depth_m(plan.land.turned_back(*p)) > 1.0));
            assert!(walks[k + 1..].iter().all(|b| !polygon::convex_overlap(a, b)), "two docks run into each other");
        }
    }
}

#[test]
fn the_ground_is_whole_and_water_is_level() {
    for (seed, radius_m) in [(0, 90.0), (1, 60.0), (5, 130.0)] {
        let plan = planned(seed, radius_m);
        let ground = assemble::ground(&params(radius_m), &plan);
        checks::assert_whole(&ground, 2400.0);
        let m = &ground.mesh;
        let mut steepest: f64 = 0.0;
        for (t, s) in m.triangles.iter().zip(&m.slots) {
            let z = t.map(|v| f64::from(m.positions_m[v as usize][2]));
            if *s == crate::city::california::ground_slot::WATER {
                assert!(z.iter().all(|z| (z - WATER_M).abs() < 2e-3), "seed {seed}: {z:?}");
            } else if *s == crate::city::california::ground_slot::SAND {
                let corners = t.map(|v| m.positions_m[v as usize].map(f64::from)).map(glam::DVec3::from_array);
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                // Slivers between neighbours' outlines say nothing.
                if normal.z > 2.0 {
                    steepest = steepest.max(normal.truncate().length() / normal.z);
                }
            }
        }
        assert!(steepest < 0.7, "seed {seed}: a beach rises {steepest}");
    }
}

#[test]
fn no_building_floats_or_stands_in_the_water() {
    for seed in [1, 2, 3] {
        let plan = planned(seed, 250.0);
        let mut flats = 0;
        for (name, building) in plan.parts.iter().flat_map(|(_, c)| &c.buildings) {
            let b = &building.plan;
            let mesh = building_mesh(building, Detail::Full);
            assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{name}");
            for mass in b.masses.iter().filter(|m| m.low_m < 0.0) {
                let outline = polygon::subdivided(&b.world_outline(mass), 2.0);
                let heights: Vec<f64> = outline.iter().map(|p| plan.land.height_m(*p)).collect();
                let lowest = heights.iter().copied().fold(f64::MAX, f64::min);
                assert!(b.ground_m + mass.low_m <= lowest - 0.5, "{name}");
                assert!(!outline.iter().any(|p| harbour(&plan).is_water(plan.land.turned_back(*p))), "{name}");
            }
            if building.kind == Kind::Apartments {
                flats += 1;
                let storeys = (building.ridge_m / 3.05).round();
                assert!((2.0..=5.0).contains(&storeys), "{name}: {}", building.ridge_m);
            }
        }
        assert!(flats > 4, "seed {seed}: {flats}");
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let of = |radius_m| {
        let plan = planned(7, radius_m);
        let boats: BTreeMap<String, Afloat> = plan.marina.boats.into_iter().map(|b| (b.name.clone(), b)).collect();
        let docks: BTreeMap<String, Moored> = plan.marina.docks.into_iter().map(|d| (d.name.clone(), d)).collect();
        let buildings: BTreeMap<String, Building> = plan.parts.into_iter().flat_map(|(_, c)| c.buildings).collect();
        (boats, docks, buildings)
    };
    let (small, large) = (of(120.0), of(330.0));
    assert!(small.0.len() > 20 && small.1.len() > 4 && small.2.len() > 20);
    assert!(small.0.iter().all(|(name, boat)| large.0.get(name) == Some(boat)));
    assert!(small.1.iter().all(|(name, dock)| large.1.get(name) == Some(dock)));
    assert!(small.2.iter().all(|(name, building)| large.2.get(name) == Some(building)));
}

#[test]
fn any_seed_builds_within_its_bounds() {
    for seed in 20..24 {
        let params = params(60.0);
        let scene = build(&params, SeedPath::root("california", seed));
        checks::assert_within_bounds(&scene, params.height_bounds_m(), params.memory_bound_bytes(), "waterfront");
    }
}
