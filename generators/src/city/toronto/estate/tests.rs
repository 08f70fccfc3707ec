use super::STOREYS;
use crate::city::toronto::assemble::CityPlan;
use crate::city::toronto::massing::{Building, Kind};
use crate::city::toronto::tests::{FRAME_HALF_M, census, planned, sized};
use crate::city::toronto::{DETAIL_MARGIN_M, Variant, build};
use crate::kit::buildings::{self, Detail};
use crate::kit::mesh_builder::open_edges;
use crate::kit::{checks, polygon};
use glam::DVec2;
use satseed_scene::SeedPath;
use std::collections::BTreeSet;

fn blocks_of_flats(plan: &CityPlan) -> Vec<&(String, Building)> {
    plan.blocks.iter().flat_map(|(_, b)| &b.buildings).filter(|(_, b)| b.kind == Kind::Flats).collect()
}

fn in_frame(p: DVec2) -> bool {
    p.abs().max_element() < FRAME_HALF_M
}

/// Towers in a park: about one to a hectare, of 10 to 20 storeys, long rather than square, over a tenth to a quarter of the
/// land, with lots and trees between them.
#[test]
fn an_estate_has_its_blocks_lawns_lots_and_trees() {
    let mut faults = Vec::new();
    for seed in 0..10 {
        let plan = planned(seed, Variant::Slabs);
        let c = census(&plan);
        let flats: Vec<&Building> =
            blocks_of_flats(&plan).into_iter().map(|(_, b)| b).filter(|b| in_frame(b.plan.centre_m)).collect();
        let mut heights: Vec<f64> = flats.iter().map(|b| b.plan.masses[0].roof_m).collect();
        heights.sort_by(f64::total_cmp);
        let median = heights[heights.len() / 2];
        let long = flats
            .iter()
            .filter(|b| {
                let (low, high) = polygon::bounds(&b.plan.masses[0].outline);
                high.x - low.x > 2.5 * (high.y - low.y)
            })
            .count();
        let stalls = plan.blocks.iter().flat_map(|(_, b)| &b.stalls).filter(|s| in_frame(s.centre)).count();
        let trees = plan.blocks.iter().flat_map(|(_, b)| &b.trees).filter(|p| in_frame(**p)).count();
        let line = format!(
            "seed {seed}: built {:.3} flats {} long {long} heights {:.0} {median:.0} {:.0} stalls {stalls} trees {trees}",
            c.built,
            flats.len(),
            heights[0],
            heights[heights.len() - 1]
        );
        let sound = (0.10..=0.25).contains(&c.built)
            && (20..=45).contains(&flats.len())
            && long * 2 > flats.len()
            && heights[0] >= 27.0
            && heights[heights.len() - 1] <= 61.0
            && (36.0..=50.0).contains(&median)
            && stalls > 500
            && trees > 700;
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn storeys_are_those_of_the_age() {
    let plan = planned(3, Variant::Slabs);
    let mut seen = BTreeSet::new();
    for (name, b) in blocks_of_flats(&plan) {
        let m = &b.plan.masses[0];
        let storeys = 1.0 + (m.roof_m - m.first_floor_m) / m.floor_m;
        assert!((storeys - storeys.round()).abs() < 1e-6, "{name}: {storeys}");
        assert!((STOREYS[0]..=STOREYS[1]).contains(&(storeys.round() as u32)), "{name}: {storeys}");
        assert!(m.balconies.iter().all(|b| (1.5..=1.8).contains(&b.depth_m)));
        seen.insert(storeys.round() as u32);
    }
    assert!(seen.len() >= 9, "{seen:?}");
}

#[test]
fn neighbours_differ_and_keep_apart() {
    for seed in [2, 9] {
        let plan = planned(seed, Variant::Slabs);
        let round = |x: f64| libm::round(5.0 * x) as i64;
        let all: Vec<(&String, &Building, Vec<[i64; 2]>)> = blocks_of_flats(&plan)
            .into_iter()
            .map(|(name, b)| (name, b, b.plan.masses[0].outline.iter().map(|p| [round(p.x), round(p.y)]).collect()))
            .collect();
        assert!(all.len() > 40);
        for (k, (name, a, shape)) in all.iter().enumerate() {
            for (other, b, other_shape) in &all[k + 1..] {
                let distance = a.plan.centre_m.distance(b.plan.centre_m);
                assert!(distance > 150.0 || shape != other_shape, "{name} and {other} are alike");
                let apart = |a: &Building, b: &Building| {
                    let (p, q) = (a.plan.world_outline(&a.plan.masses[0]), b.plan.world_outline(&b.plan.masses[0]));
                    p.iter().all(|c| !polygon::contains(&q, *c) && polygon::border_distance(&q, *c) > 9.0)
                };
                assert!(distance > 150.0 || (apart(a, b) && apart(b, a)), "{name} and {other} stand too near");
            }
        }
    }
}

#[test]
fn buildings_are_closed_and_stand_in_the_ground() {
    let plan = planned(5, Variant::Slabs);
    for (name, building) in plan.blocks.iter().flat_map(|(_, b)| &b.buildings) {
        let b = &building.plan;
        let mesh = buildings::mesh(b, Detail::Full);
        assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{name}");
        for mass in b.masses.iter().filter(|m| m.low_m < 0.0) {
            let outline = polygon::subdivided(&b.world_outline(mass), 2.0);
            let lowest = outline.iter().map(|p| plan.relief.height_m(*p)).fold(f64::MAX, f64::min);
            assert!(b.ground_m + mass.low_m <= lowest - 0.5, "{name}");
        }
        assert!(b.masses[0].low_m < 0.0, "{name} has no foot");
    }
}

/// Cars stand on lots and drives: not in a building, and not in another car.
#[test]
fn cars_stand_clear() {
    let plan = planned(7, Variant::Slabs);
    for (block, content) in &plan.blocks {
        let feet: Vec<Vec<DVec2>> = content
            .buildings
            .iter()
            .flat_map(|(_, b)| b.plan.masses.iter().filter(|m| m.low_m < 0.0).map(|m| b.plan.world_outline(m)))
            .collect();
        for (k, s) in content.stalls.iter().enumerate() {
            assert!(feet.iter().all(|f| !polygon::contains(f, s.centre)), "{:?}: a car in a building", block.index);
            for other in &content.stalls[k + 1..] {
                assert!(s.centre.distance(other.centre) > 1.9, "{:?}: two cars in one place", block.index);
            }
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let [crop, whole] = [60.0, 170.0].map(|r| build(&sized(Variant::Slabs, r), SeedPath::root("toronto", 9)));
    checks::assert_same_things(&crop, &whole, 60.0 + DETAIL_MARGIN_M, 60);
}
