use super::{Corridor, Crossing, DEPTH_M, PITCH_M, RAIL_M, consists, parts};
use crate::city::toronto::assemble::CityPlan;
use crate::city::toronto::tests::{FRAME_HALF_M, census, planned, sized};
use crate::city::toronto::{DETAIL_MARGIN_M, Variant, build};
use crate::kit::mesh_builder::open_edges;
use crate::kit::{checks, polygon};
use glam::{DVec2, DVec3};
use satseed_scene::{Class, SeedPath};

fn corridor(plan: &CityPlan) -> &Corridor {
    plan.corridor.as_ref().expect("rail has a corridor")
}

fn in_frame(p: DVec2) -> bool {
    p.abs().max_element() < FRAME_HALF_M
}

#[test]
fn a_corridor_has_its_tracks_bridges_and_trains() {
    let mut faults = Vec::new();
    let mut stations = 0;
    for seed in 0..12 {
        let plan = planned(seed, Variant::Rail);
        let c = corridor(&plan);
        let cars = consists(c, &plan.relief, 1.0, 440.0);
        let seen = cars.iter().filter(|c| in_frame(c.world_from_object.translation.truncate())).count();
        let bridges = |kind: Crossing| {
            let at = |s: &crate::kit::streets::Street| s.crossing(0.0, &c.line, 0.0);
            c.crossings.iter().filter(|(_, s, k)| *k == kind && in_frame(at(s))).count()
        };
        let roads = bridges(Crossing::Road);
        let built = census(&plan).built;
        stations += usize::from(c.station_m.is_some());
        let line = format!(
            "seed {seed}: tracks {} width {:.0} bridges {roads} and {} cars {seen} built {built:.3}",
            c.tracks.len(),
            2.0 * c.half_m,
            bridges(Crossing::Foot)
        );
        let sound = (6..=15).contains(&c.tracks.len())
            && (30.0..=110.0).contains(&(2.0 * c.half_m))
            && (1..=5).contains(&roads)
            && (12..=130).contains(&seen)
            && (0.30..=0.56).contains(&built);
        if !sound {
            faults.push(line);
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    assert!((5..=11).contains(&stations), "{stations} stations");
}

/// Tracks keep their distance; leads begin and end on tracks, in their direction.
#[test]
fn tracks_keep_apart_and_leads_join_them() {
    let mut leads = 0;
    for seed in 0..8 {
        let plan = planned(seed, Variant::Rail);
        let c = corridor(&plan);
        let [right, left] = c.floor_m();
        for pair in c.tracks.windows(2) {
            assert!(pair[1].left_m - pair[0].left_m > PITCH_M - 1e-9);
        }
        for track in &c.tracks {
            assert!(track.left_m - right > 2.9 && left - track.left_m > 2.9, "a track in the wall");
            for lead in &track.leads {
                leads += 1;
                for (end, at) in lead.left_m.iter().zip(lead.span_m) {
                    let of =
                        |t: &&super::Track| (t.left_m - end).abs() < 1e-9 && t.span_m[0] <= at && t.span_m[1] >= at;
                    assert!(c.tracks.iter().any(|t| of(&t)), "seed {seed}: a lead from nowhere");
                }
                assert!((lead.span_m[1] - lead.span_m[0]) / (lead.left_m[1] - lead.left_m[0]).abs() > 8.0);
            }
        }
    }
    assert!(leads > 60, "{leads}");
}

/// Cars stand on the rails, and no two are in one place.
#[test]
fn trains_stand_on_their_rails_and_apart() {
    for seed in [1, 6] {
        let plan = planned(seed, Variant::Rail);
        let c = corridor(&plan);
        let cars = consists(c, &plan.relief, 1.5, 440.0);
        assert!(cars.len() > 40, "{}", cars.len());
        let feet: Vec<Vec<DVec2>> = cars
            .iter()
            .map(|car| {
                let (low, high) = car.body.mesh().bounds_m().expect("a car");
                let outline = polygon::rectangle(low.truncate() + 0.02, high.truncate() - 0.02);
                outline.iter().map(|p| car.world_from_object.transform_point3(p.extend(0.0)).truncate()).collect()
            })
            .collect();
        for (k, (car, a)) in cars.iter().zip(&feet).enumerate() {
            for x in [-8.0, 0.0, 8.0] {
                let wheel = car.world_from_object.transform_point3(DVec3::new(x, 0.0, 0.0));
                let rail = plan.relief.height_m(wheel.truncate()) - DEPTH_M + RAIL_M;
                assert!((wheel.z - rail).abs() < 0.05, "{}: {} over {rail}", car.name, wheel.z);
                assert!(c.tracks.iter().any(|t| (c.local(wheel.truncate()).y - t.left_m).abs() < 1e-6), "{}", car.name);
            }
            for (other, b) in cars.iter().zip(&feet).skip(k + 1) {
                assert!(!polygon::convex_overlap(a, b), "{} and {}", car.name, other.name);
            }
        }
    }
}

/// All that is built is closed, and reaches into the ground; decks clear the trains below them.
#[test]
fn works_are_closed_rooted_and_high_enough() {
    for seed in [2, 5, 8] {
        let plan = planned(seed, Variant::Rail);
        let c = corridor(&plan);
        let mut kinds = std::collections::BTreeSet::new();
        for part in parts(c, &plan.relief, 440.0) {
            assert_eq!((part.mesh.validate(), open_edges(&part.mesh)), (Ok(()), 0), "{}", part.name);
            kinds.insert(part.name.split('/').nth(1).expect("a kind").to_owned());
            let (low, _) = part.mesh.bounds_m().expect("triangles");
            let floor = plan.relief.height_m(part.origin.truncate()) - DEPTH_M;
            assert!(part.origin.z + low.z < floor + 0.3, "{} hangs in the air", part.name);
            if part.class == Class::Bridge {
                // Over each track the lowest point of the deck lies above the tallest train.
                let columns = |p: DVec3| c.tracks.iter().any(|t| (c.local(p.truncate()).y - t.left_m).abs() < 1.6);
                for v in &part.mesh.positions_m {
                    let d = DVec3::from_array(v.map(f64::from));
                    let world =
                        (part.origin.truncate() + part.axis * d.x + part.axis.perp() * d.y).extend(part.origin.z + d.z);
                    let clear = world.z - (plan.relief.height_m(world.truncate()) - DEPTH_M + RAIL_M);
                    assert!(!columns(world) || clear > 5.1, "{}: {clear} m over the rails", part.name);
                }
            }
        }
        for kind in ["tracks", "walls", "bridge"] {
            assert!(kinds.contains(kind), "seed {seed}: no {kind} in {kinds:?}");
        }
    }
}

/// The ground falls by the cutting's depth, and no house or street stands in it.
#[test]
fn the_cutting_is_open() {
    for seed in 0..5 {
        let plan = planned(seed, Variant::Rail);
        let c = corridor(&plan);
        let middle = c.line.at(30.0, f64::midpoint(c.floor_m()[0], c.floor_m()[1]));
        assert!((plan.relief.height_m(middle) - plan.ground_m(middle) - DEPTH_M).abs() < 1e-9);
        for (name, b) in plan.blocks.iter().flat_map(|(_, b)| &b.buildings) {
            let outline = polygon::subdivided(&b.plan.world_outline(&b.plan.masses[0]), 5.0);
            assert!(outline.iter().all(|p| !c.holds(*p, 3.0)), "{name} stands in the cutting");
        }
        for (segment, content) in &plan.segments {
            let crosses = c.crossings.iter().any(|x| x.0 == segment.index[1] && x.2 == Crossing::Road);
            for v in content.vehicles.iter().filter(|v| c.holds(v.centre, 0.0)) {
                assert!(segment.index[0] == 0 && crosses, "{:?} in the air at {}", v.body, v.centre);
            }
            assert!(content.trees.iter().all(|p| !c.holds(*p, 1.0)));
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let [crop, whole] = [60.0, 170.0].map(|r| build(&sized(Variant::Rail, r), SeedPath::root("toronto", 9)));
    checks::assert_same_things(&crop, &whole, 60.0 - DETAIL_MARGIN_M, 4);
}
