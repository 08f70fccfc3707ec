use super::assemble::{self, CityPlan};

use super::*;
use crate::kit::buildings::{self, BuildingPlan, Detail};
use crate::kit::checks::{assert_whole, assert_within_bounds};
use crate::kit::mesh_builder::open_edges;
use crate::kit::polygon;
use std::collections::BTreeMap;

/// Half side of a frame of 2048 pixels at 0.3 m.
pub(super) const FRAME_HALF_M: f64 = 307.0;

pub(super) fn sized(variant: Variant, radius_m: f64) -> Params {
    Params { variant, radius_m, ..Params::default() }
}

pub(super) fn planned(seed: u64, variant: Variant) -> CityPlan {
    let params = sized(variant, 400.0);
    let city = SeedPath::root("toronto", seed).child(params.variant());
    assemble::plan(&params, &city)
}

fn small() -> Params {
    Params { radius_m: 170.0, ..Params::default() }
}

/// Shares of a frame and its towers' heights.
pub(super) struct Census {
    pub(super) built: f64,
    tall: f64,
    towers: Vec<f64>,
}

pub(super) fn census(plan: &CityPlan) -> Census {
    let mut out = Census { built: 0.0, tall: 0.0, towers: Vec::new() };
    let all: Vec<&BuildingPlan> =
        plan.blocks.iter().flat_map(|(_, b)| b.buildings.iter().map(|(_, b)| &b.plan)).collect();
    let masses: Vec<(Vec<DVec2>, (DVec2, DVec2), f64)> = all
        .iter()
        .flat_map(|b| b.masses.iter().map(|m| (b.world_outline(m), m.roof_m)))
        .map(|(o, h)| (o.clone(), polygon::bounds(&o), h))
        .collect();
    let step = 3.0;
    let n = (2.0 * FRAME_HALF_M / step) as i64;
    for j in 0..n {
        for i in 0..n {
            let p = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * step - DVec2::splat(FRAME_HALF_M);
            let top = masses
                .iter()
                .filter(|(_, (low, high), _)| p.cmpge(*low).all() && p.cmple(*high).all())
                .filter(|(o, _, _)| polygon::contains(o, p))
                .map(|m| m.2)
                .fold(0.0, f64::max);
            out.built += f64::from(u8::from(top > 0.0));
            out.tall += f64::from(u8::from(top > 60.0));
        }
    }
    out.built /= (n * n) as f64;
    out.tall /= (n * n) as f64;
    for b in all {
        if b.centre_m.abs().max_element() < FRAME_HALF_M && b.roof_m() > 60.0 {
            out.towers.push(b.roof_m());
        }
    }
    out.towers.sort_by(f64::total_cmp);
    out
}

#[test]
fn the_core_has_the_citys_cover_and_heights() {
    let mut faults = Vec::new();
    for seed in 0..14 {
        let c = census(&planned(seed, Variant::Core));
        let median = c.towers[c.towers.len() / 2];
        let line = format!(
            "seed {seed}: built {:.3} tall {:.3} towers {} median {median:.0}",
            c.built,
            c.tall,
            c.towers.len()
        );
        let sound = (0.45..=0.60).contains(&c.built)
            && (0.05..=0.12).contains(&c.tall)
            && (25..=45).contains(&c.towers.len())
            && (110.0..=140.0).contains(&median);
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn midtown_is_lower_than_the_core_and_still_a_city() {
    for seed in 0..3 {
        let (core, mid) = (census(&planned(seed, Variant::Core)), census(&planned(seed, Variant::Midtown)));
        assert!(mid.towers.len() * 2 < core.towers.len() && !mid.towers.is_empty());
        assert!((0.25..0.6).contains(&mid.built), "{}", mid.built);
    }
}

#[test]
fn one_tree_or_train_more_moves_no_house() {
    for (variant, name) in [(Variant::Core, "core"), (Variant::Slabs, "slabs"), (Variant::Rail, "rail")] {
        let city = SeedPath::root("toronto", 4).child(name);
        let houses = |trees, vehicles| {
            let params = Params { variant, radius_m: 60.0, trees, vehicles, ..Params::default() };
            assemble::plan(&params, &city).blocks.into_iter().flat_map(|(_, b)| b.buildings).collect::<Vec<_>>()
        };
        assert!(houses(1.0, 1.0) == houses(2.0, 0.3), "{name}");
    }
}

#[test]
fn the_scene_holds_what_its_bound_says() {
    for radius_m in [60.0, 200.0] {
        let params = Params { radius_m, ..Params::default() };
        let scene = build(&params, SeedPath::root("toronto", 6));
        let (held, _) = scene.triangle_counts();
        // A triangle with its three corners, texture coordinates and share of a tree takes less than 200 bytes; the
        // triangulation of the ground and the plan go when the scene stands.
        let bytes = held * 200 + scene.instances.len() * 400;
        assert!((bytes as u64) < params.memory_bound_bytes(), "{bytes}");
    }
}

#[test]
fn same_scene_with_one_and_two_threads() {
    for params in [small(), sized(Variant::Slabs, 60.0), sized(Variant::Rail, 60.0)] {
        let hash = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&params, SeedPath::root("toronto", 3)).hash())
        };
        assert_eq!(hash(1), hash(2));
    }
}

#[test]
fn a_scene_is_legal_and_within_its_bounds() {
    use Variant::{Core, Rail, Slabs};
    let all = [(Core, 0), (Core, 1), (Core, 2), (Slabs, 0), (Slabs, u64::MAX), (Rail, 0), (Rail, 1), (Rail, u64::MAX)];
    for (variant, seed) in all {
        let params = sized(variant, if variant == Core { 120.0 } else { 60.0 });
        let scene = build(&params, SeedPath::root("toronto", seed));
        let of = format!("{} {seed}", params.variant());
        assert_within_bounds(&scene, params.height_bounds_m(), params.memory_bound_bytes(), &of);
    }
}

#[test]
fn the_ground_has_no_crack_and_no_t_junction() {
    use Variant::{Core, Rail, Slabs};
    let core = [(0, 250.0), (1, 60.0), (2, 700.0), (3, 333.3)].map(|(seed, radius_m)| (Core, seed, radius_m));
    let others = [(Slabs, 0, 150.0), (Slabs, 1, 60.0), (Rail, 0, 150.0), (Rail, 1, 60.0), (Rail, 2, 60.0)];
    for (variant, seed, radius_m) in core.into_iter().chain(others) {
        let params = sized(variant, radius_m);
        let city = SeedPath::root("toronto", seed).child(params.variant());
        let ground = assemble::ground(&params, &assemble::plan(&params, &city));
        assert_whole(&ground, 2400.0);
    }
}

#[test]
fn no_building_floats_and_all_are_closed() {
    for (seed, variant) in [(1, Variant::Core), (2, Variant::Midtown)] {
        let plan = planned(seed, variant);
        let mut kinds = BTreeMap::new();
        for (name, building) in plan.blocks.iter().flat_map(|(_, b)| &b.buildings) {
            let b = &building.plan;
            let mesh = buildings::mesh(b, Detail::Full);
            assert_eq!((mesh.validate(), open_edges(&mesh)), (Ok(()), 0), "{name}");
            let base = b.ground_m + f64::from(mesh.positions_m.iter().map(|p| p[2]).fold(f32::MAX, f32::min));
            for mass in b.masses.iter().filter(|m| m.low_m < 0.0) {
                let outline = polygon::subdivided(&b.world_outline(mass), 2.0);
                let lowest = outline.iter().map(|p| plan.relief.height_m(*p)).fold(f64::MAX, f64::min);
                assert!(base <= lowest - 0.5 && b.ground_m + mass.low_m <= lowest - 0.5, "{name}");
            }
            assert!(b.masses[0].low_m < 0.0, "{name} has no foot");
            *kinds.entry(format!("{:?}", building.kind)).or_insert(0) += 1;
        }
        assert!(kinds.len() >= 5, "{kinds:?}");
    }
}
