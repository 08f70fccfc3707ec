//! Streets in use: crossings and patches on the carriageway, trees and lights along it, cars on it.

use super::{Params, ground_slot, materials::ROAD_AGES};
use crate::kit::ground::Patch;
use crate::kit::polygon;
use crate::kit::streets::Segment;
use crate::kit::vehicles::Body;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// A vehicle on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::city) struct Parked {
    /// Centre, world.
    pub centre: DVec2,
    /// Where it points.
    pub axis: DVec2,
    /// What it is.
    pub body: Body,
}

/// What one segment of a street carries.
#[derive(Clone, Debug, Default)]
pub(in crate::city) struct SegmentPlan {
    /// Pieces of the carriageway, the later on top.
    pub patches: Vec<Patch>,
    /// Vehicles.
    pub vehicles: Vec<Parked>,
    /// Trees on the sidewalks.
    pub trees: Vec<DVec2>,
    /// Street lights: foot and direction to the road.
    pub lights: Vec<(DVec2, DVec2)>,
}

/// Lanes of a street kind: offset to the left of the middle, m, and direction of travel.
fn lanes(kind: u16) -> &'static [(f64, f64)] {
    // One-way streets run with their line; others keep right.
    match kind {
        0 => &[(-1.5, 1.0), (1.5, 1.0)],
        1 => &[(-1.6, 1.0), (1.6, -1.0)],
        2 => &[(-4.95, 1.0), (-1.7, 1.0), (1.7, -1.0), (4.95, -1.0)],
        _ => &[(-8.6, 1.0), (-5.3, 1.0), (-2.2, 1.0), (2.2, -1.0), (5.3, -1.0), (8.6, -1.0)],
    }
}

/// Parking lanes: offset to the left and side.
fn kerb_lanes(kind: u16) -> &'static [(f64, f64)] {
    match kind {
        0 => &[(-4.1, 1.0), (4.1, 1.0)],
        1 => &[(-4.2, 1.0), (4.2, -1.0)],
        _ => &[],
    }
}

/// A body drawn by its share in traffic.
pub(in crate::city) fn draw_body(rng: &mut Rng, heavy: bool) -> Body {
    let weights = if heavy {
        [0.27, 0.12, 0.32, 0.08, 0.07, 0.06, 0.04, 0.04]
    } else {
        [0.3, 0.16, 0.34, 0.08, 0.08, 0.04, 0.0, 0.0]
    };
    Body::ALL[rng.weighted(&weights)]
}

/// Distance from the crossing's kerb line to the begin of the marked carriageway, m.
const APPROACH_M: f64 = 7.0;

/// Plans a segment.
pub(in crate::city) fn plan(params: &Params, segment: &Segment, city: &SeedPath) -> SegmentPlan {
    let [f, i, j] = segment.index.map(|x| x as u64);
    let path = city.child("street").index(f).index(i).index(j);
    let mut out = SegmentPlan::default();
    let street = &segment.street;
    let half = street.section.roadway_m / 2.0;
    let [s0, s1] = segment.span_m;
    if s1 - s0 < 40.0 {
        return out;
    }
    let rect =
        |a: f64, b: f64, c: f64, d: f64| vec![street.at(a, c), street.at(b, c), street.at(b, d), street.at(a, d)];
    let patch = |outline: Vec<DVec2>, slot: u16| Patch {
        outline,
        slot,
        origin_m: street.through_m,
        axis: street.direction,
        lowered: true,
    };
    let edge = half - 0.45;
    let mut rng = path.child("surface").rng();
    let age = rng.below(u64::from(ROAD_AGES)) as u16;
    let (b0, b1) = (s0 + APPROACH_M, s1 - APPROACH_M);
    out.patches.push(patch(rect(b0, b1, -edge, edge), ground_slot::ROAD + street.section.kind * ROAD_AGES + age));
    let one_way = street.section.kind == 0;
    for (start, way) in [(s0, 1.0), (s1, -1.0)] {
        let (a, b) = (start + way * 1.2, start + way * 4.2);
        out.patches.push(patch(rect(a.min(b), a.max(b), -edge, edge), ground_slot::CROSSING));
        // Traffic that comes to this end stops before the crossing: at the far end those who run with the line.
        let (a, b) = (start + way * 5.4, start + way * 5.9);
        let stops = if way < 0.0 { [-edge, if one_way { edge } else { -0.2 }] } else { [0.2, edge] };
        if way < 0.0 || !one_way {
            out.patches.push(patch(rect(a.min(b), a.max(b), stops[0], stops[1]), ground_slot::STOP));
        }
    }
    let mut taken: Vec<Vec<DVec2>> = Vec::new();
    if street.section.kind == 3 && b1 - b0 > 40.0 && rng.chance(0.7) {
        // A raised median; being not lowered, it gets its own kerb.
        let outline = rect(b0 + 9.0, b1 - 9.0, -0.75, 0.75);
        taken.push(rect(b0 + 8.5, b1 - 8.5, -1.2, 1.2));
        let slot = if rng.chance(0.6) { ground_slot::YARD } else { ground_slot::PAVING };
        out.patches.push(Patch { lowered: false, ..patch(outline, slot) });
    }
    repairs(&patch, &rect, [b0 + 1.0, b1 - 1.0], edge - 0.3, taken, &mut rng, &mut out);
    traffic(params, segment, &path, &mut out);
    kerbside(params, segment, &path, &mut out);
    out
}

/// Trench strips, patches and manholes, none touching another.
fn repairs(
    patch: &impl Fn(Vec<DVec2>, u16) -> Patch,
    rect: &impl Fn(f64, f64, f64, f64) -> Vec<DVec2>,
    [b0, b1]: [f64; 2],
    edge: f64,
    mut taken: Vec<Vec<DVec2>>,
    rng: &mut Rng,
    out: &mut SegmentPlan,
) {
    let wanted = 6 + rng.below(9);
    for _ in 0..wanted {
        let (length, width, slot) = match rng.weighted(&[0.3, 0.2, 0.2, 0.3]) {
            0 => (rng.range(8.0, 50.0), rng.range(0.6, 1.5), ground_slot::PATCH_NEW),
            1 => (
                rng.range(0.7, 1.4),
                rng.range(3.0, 2.0 * edge),
                if rng.chance(0.6) { ground_slot::PATCH_NEW } else { ground_slot::PATCH_OLD },
            ),
            2 => (rng.range(1.5, 7.0), rng.range(1.2, 3.2), ground_slot::PATCH_NEW),
            _ => (0.75, 0.75, ground_slot::MANHOLE),
        };
        let a = rng.range(b0, (b1 - length).max(b0 + 0.1));
        let width = width.min(1.99 * edge);
        let c = rng.range(-edge, edge - width);
        if a + length > b1 {
            continue;
        }
        let grown = rect(a - 0.1, a + length + 0.1, c - 0.1, c + width + 0.1);
        if taken.iter().any(|t| polygon::convex_overlap(t, &grown)) {
            continue;
        }
        taken.push(grown);
        out.patches.push(patch(rect(a, a + length, c, c + width), slot));
    }
}

/// Moving and waiting vehicles, 15 to 35 a kilometre and lane; a queue at the stop bar now and then.
fn traffic(params: &Params, segment: &Segment, path: &SeedPath, out: &mut SegmentPlan) {
    let street = &segment.street;
    let [s0, s1] = segment.span_m;
    for (l, (left, way)) in lanes(street.section.kind).iter().enumerate() {
        let mut rng = path.child("lane").index(l as u64).rng();
        let per_m = rng.range(15.0, 35.0) / 1000.0 * params.vehicles;
        if per_m <= 0.0 {
            continue;
        }
        // Distances run from the stop bar backwards.
        let stop = if *way > 0.0 { s1 - 6.4 } else { s0 + 6.4 };
        let mut back = if rng.chance(0.35) { 0.0 } else { rng.range(10.0, 70.0) };
        let mut queued = if back == 0.0 { 1 + rng.below(4) } else { 0 };
        let mut last_end = -3.0;
        while back < s1 - s0 - 14.0 {
            let body = draw_body(&mut rng, street.section.kind > 0);
            let length = body.size_m()[0];
            let front = back.max(last_end + 2.0);
            let along = stop - way * (front + length / 2.0);
            let wobble = rng.signed() * 0.25;
            if front + length < s1 - s0 - 14.0 {
                out.vehicles.push(Parked {
                    centre: street.at(along, left + wobble),
                    axis: street.direction * *way,
                    body,
                });
            }
            last_end = front + length;
            if queued > 0 {
                queued -= 1;
                back = last_end + rng.range(1.6, 3.0);
            } else {
                back = last_end + 5.0 - libm::log(1.0 - rng.unit()) / per_m;
            }
        }
    }
    for (l, (left, way)) in kerb_lanes(street.section.kind).iter().enumerate() {
        let mut rng = path.child("kerb").index(l as u64).rng();
        let occupancy = rng.range(0.4, 0.8) * params.vehicles.min(1.2);
        let mut s = s0 + APPROACH_M + 5.0;
        while s < s1 - APPROACH_M - 5.0 {
            if rng.chance(occupancy) {
                let body = draw_body(&mut rng, false);
                let at = street.at(s, left + rng.signed() * 0.12);
                let way = if rng.chance(0.03) { -way } else { *way };
                out.vehicles.push(Parked { centre: at, axis: street.direction * way, body });
            }
            s += rng.range(6.0, 6.8);
        }
    }
}

/// Trees every 8 to 12 m on some sides, lights every 30 to 40 m.
fn kerbside(params: &Params, segment: &Segment, path: &SeedPath, out: &mut SegmentPlan) {
    let street = &segment.street;
    let half = street.section.roadway_m / 2.0;
    let [s0, s1] = segment.span_m;
    for (k, side) in [(0, 1.0), (1, -1.0)] {
        let mut rng = path.child("side").index(k).rng();
        let planted = rng.chance(0.82);
        let pitch = rng.range(8.0, 11.0);
        let kept = rng.range(0.6, 0.95) * params.trees;
        let mut s = s0 + rng.range(9.0, 15.0);
        while planted && s < s1 - 9.0 {
            if rng.chance(kept.min(1.0)) {
                out.trees.push(street.at(s, side * (half + rng.range(1.1, 1.5))));
            }
            s += pitch * rng.range(0.85, 1.15);
        }
        let mut rng = path.child("lights").index(k).rng();
        let mut s = s0 + if k == 0 { 8.0 } else { 24.0 };
        while s < s1 - 6.0 {
            out.lights.push((street.at(s, side * (half + 0.5)), -street.direction.perp() * side));
            s += rng.range(30.0, 40.0);
        }
    }
}
