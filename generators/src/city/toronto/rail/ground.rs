//! What lies on the ground in and along the corridor, and the streets that come to it.

use super::{Corridor, Crossing, VERGE_M, WALL_M};
use crate::city::toronto::traffic::{self, SegmentPlan};
use crate::city::toronto::{Params, ground_slot};
use crate::kit::ground::Patch;
use crate::kit::polygon;
use crate::kit::streets::{Segment, Street, StreetPlan};
use glam::DVec2;
use satseed_scene::SeedPath;

/// Raised ground goes this far over a street that ends at the corridor, m.
const STREET_END_M: f64 = 6.0;

fn wound(mut outline: Vec<DVec2>) -> Vec<DVec2> {
    if polygon::area(&outline) < 0.0 {
        outline.reverse();
    }
    outline
}

impl Corridor {
    fn patch(&self, outline: Vec<DVec2>, slot: u16, left_m: f64) -> Patch {
        Patch {
            outline: wound(outline),
            slot,
            origin_m: self.line.at(0.0, left_m),
            axis: self.line.direction,
            lowered: false,
        }
    }

    /// A strip along the whole corridor.
    fn strip(&self, reach_m: f64, left_m: [f64; 2], slot: u16) -> Patch {
        let at = |along: f64, left: f64| self.line.at(along, left);
        let outline =
            vec![at(-reach_m, left_m[0]), at(reach_m, left_m[0]), at(reach_m, left_m[1]), at(-reach_m, left_m[1])];
        self.patch(outline, slot, f64::midpoint(left_m[0], left_m[1]))
    }

    /// Land between two lines parallel to two streets and two parallel to the corridor.
    fn land(&self, [a, z]: [(&Street, f64); 2], left_m: [f64; 2], slot: u16) -> Patch {
        let at = |(street, offset): (&Street, f64), left: f64| street.crossing(offset, &self.line, left);
        let outline = vec![at(a, left_m[0]), at(z, left_m[0]), at(z, left_m[1]), at(a, left_m[1])];
        self.patch(outline, slot, left_m[0])
    }
}

/// All of it, the later on top, out to a distance along the corridor.
pub(in super::super) fn patches(corridor: &Corridor, reach_m: f64) -> Vec<Patch> {
    let mut out = Vec::new();
    let half = corridor.half_m;
    let roadway = |s: &Street| s.section.roadway_m / 2.0;
    // Grass along the edges, streets that end there, sidewalks that lead onto bridges.
    let near: Vec<_> = corridor
        .crossings
        .iter()
        .filter(|(_, s, _)| corridor.line.along(s.crossing(0.0, &corridor.line, 0.0)).abs() < reach_m)
        .collect();
    let border = |(_, s, c): &(i64, Street, Crossing)| match c {
        Crossing::Road => s.section.right_of_way_m() / 2.0,
        Crossing::Foot | Crossing::None => roadway(s),
    };
    for side in [-1.0, 1.0] {
        let strip = |from: f64, to: f64| if side > 0.0 { [from, to] } else { [-to, -from] };
        for pair in near.windows(2) {
            // Lines of the family go from right to left: the first's left border faces the second's right one.
            let between = [(&pair[0].1, border(pair[0])), (&pair[1].1, -border(pair[1]))];
            out.push(corridor.land(between, strip(half - 0.2, half + VERGE_M - 0.3), ground_slot::VERGE));
        }
        for (_, street, crossing) in near.iter().copied() {
            let r = roadway(street);
            match crossing {
                Crossing::Road => {
                    let w = street.section.right_of_way_m() / 2.0;
                    for between in [[(street, -w), (street, -r)], [(street, r), (street, w)]] {
                        out.push(corridor.land(between, strip(half - 0.2, half + VERGE_M), ground_slot::SIDEWALK));
                    }
                }
                Crossing::Foot | Crossing::None => {
                    let slot = if *crossing == Crossing::Foot { ground_slot::PLAZA } else { ground_slot::YARD };
                    let between = [(street, -r), (street, r)];
                    out.push(corridor.land(between, strip(half - 0.2, half + STREET_END_M), slot));
                }
            }
        }
    }
    // The cutting from edge to edge: walls or banks, and the floor.
    let [right, left] = corridor.floor_m();
    let slope = |run: f64| if run > WALL_M { ground_slot::VERGE } else { ground_slot::PAVING };
    out.push(corridor.strip(reach_m, [-half, right], slope(corridor.run_m[0])));
    out.push(corridor.strip(reach_m, [left, half], slope(corridor.run_m[1])));
    out.push(corridor.strip(reach_m, [right, left], ground_slot::GRAVEL));
    // One bed of ballast for each group.
    let groups = corridor.tracks.iter().map(|t| t.group).max().unwrap_or(0);
    for group in 0..=groups {
        let of = || corridor.tracks.iter().filter(|t| t.group == group).map(|t| t.left_m);
        let (low, high) = (of().fold(f64::MAX, f64::min), of().fold(f64::MIN, f64::max));
        out.push(corridor.strip(reach_m, [low - 2.5, high + 2.5], ground_slot::BALLAST));
    }
    for track in &corridor.tracks {
        let strip = corridor.strip(reach_m, [track.left_m - 1.25, track.left_m + 1.25], ground_slot::TRACK);
        let [from, to] = track.span_m.map(|s| s.clamp(-reach_m, reach_m));
        let at = |along: f64, left: f64| corridor.line.at(along, track.left_m + left);
        let outline = vec![at(from, -1.25), at(to, -1.25), at(to, 1.25), at(from, 1.25)];
        if to - from > 20.0 {
            out.push(Patch { outline: wound(outline), ..strip });
        }
    }
    out
}

/// The streets' segments: those that reach the corridor go on over it, or end at its edge.
pub(in super::super) fn segments(
    corridor: &Corridor,
    streets: &StreetPlan,
    reach_m: f64,
    params: &Params,
    city: &SeedPath,
) -> Vec<(Segment, SegmentPlan)> {
    let all = streets.segments(reach_m);
    let half = |s: &Segment| (s.span_m[1] - s.span_m[0]) / 2.0;
    let mut out = Vec::new();
    for segment in &all {
        let [family, line, across] = segment.index;
        // The corridor's own; and the second half of what is joined below.
        if family == 1 && line == 0 {
            continue;
        }
        let beside = family == 0 && (across == 0 || across == 1);
        let crossing = corridor.crossings.iter().find(|c| c.0 == line).map_or(Crossing::None, |c| c.2);
        if !beside {
            out.push((*segment, traffic::plan(params, segment, city)));
            continue;
        }
        if crossing == Crossing::Road {
            let other = all.iter().find(|s| s.index == [0, line, 1]);
            if let (0, Some(other)) = (across, other) {
                let span_m = [segment.span_m[0].min(other.span_m[0]), segment.span_m[1].max(other.span_m[1])];
                let joined = Segment { span_m, ..*segment };
                let mut plan = traffic::plan(params, &joined, city);
                plan.trees.retain(|p| !corridor.holds(*p, 2.0));
                out.push((joined, plan));
            }
            continue;
        }
        let mut plan = traffic::plan(params, segment, city);
        let clear = STREET_END_M + 1.0;
        plan.trees.retain(|p| !corridor.holds(*p, 2.0));
        plan.lights.retain(|(p, _)| !corridor.holds(*p, 1.0));
        plan.vehicles.retain(|v| !corridor.holds(v.centre, clear + 3.0));
        // No crossing and no stop line where nothing crosses.
        let marked = half(segment).min(14.0) + clear;
        plan.patches.retain(|p| {
            let mark = [ground_slot::CROSSING, ground_slot::STOP].contains(&p.slot);
            !mark || !corridor.holds(polygon::centroid(&p.outline), marked)
        });
        out.push((*segment, plan));
    }
    out
}
