//! What is built along the corridor: retaining walls, fences, platforms with their roofs, signals.

use super::bridges::{foot_bridge, road_bridge};
use super::tracks;
use super::{Corridor, Crossing, DEPTH_M, PIECE_M, Piece, RAIL_M, VERGE_M, WALL_M};
use crate::city::toronto::relief::Swells;
use crate::kit::mesh_builder::MeshBuilder;
use crate::kit::sweep;
use glam::{DVec2, DVec3};
use satseed_scene::{Class, Mesh};

/// Slots of walls, platforms, bridges and signals.
pub(in super::super) mod slot {
    pub(in super::super::super) const CONCRETE: u16 = 0;
    pub(in super::super::super) const STEEL: u16 = 1;
    pub(in super::super::super) const PLATFORM: u16 = 2;
    pub(in super::super::super) const ROOF: u16 = 3;
    pub(in super::super::super) const SIDEWALK: u16 = 4;
    pub(in super::super::super) const GLASS: u16 = 5;
    pub(in super::super::super) const DARK: u16 = 6;
    /// A bridge's carriageway; each bridge has its own.
    pub(in super::super::super) const ROAD: u16 = 7;
}

/// One thing of the railway with its frame: x along it, z up.
#[derive(Clone, Debug)]
pub(in super::super) struct Part {
    pub(in super::super) name: String,
    pub(in super::super) mesh: Mesh,
    pub(in super::super) class: Class,
    /// Origin, world.
    pub(in super::super) origin: DVec3,
    /// Direction of x, world.
    pub(in super::super) axis: DVec2,
    /// Made of tracks' materials, else of works'.
    pub(in super::super) track: bool,
    /// Kind of the street that it carries.
    pub(in super::super) street_kind: u16,
}

/// Height of a platform over the rails, m: low, as the city's are.
const PLATFORM_M: f64 = RAIL_M + 0.2;

/// From a track's middle to a platform's edge, m.
const EDGE_M: f64 = 1.7;

/// Half the width of what is open for a footbridge, m.
const FOOT_HALF_M: f64 = 2.5;

/// Everything within a distance of the pivot.
pub(in super::super) fn parts(corridor: &Corridor, relief: &Swells, reach_m: f64) -> Vec<Part> {
    let mut out = Vec::new();
    let count = libm::ceil(reach_m / PIECE_M) as i64 + 1;
    for k in -count..=count {
        let piece = Piece::new(corridor, relief, k as f64 * PIECE_M);
        let middle = corridor.line.at(piece.middle_m, 0.0);
        if middle.length() > reach_m {
            continue;
        }
        let mut add = |what: &str, mesh: Mesh, track: bool| {
            if !mesh.triangles.is_empty() {
                out.push(Part {
                    name: format!("rail/{what}/{k}"),
                    mesh,
                    class: Class::OtherStructure,
                    origin: middle.extend(piece.base_m),
                    axis: corridor.line.direction,
                    track,
                    street_kind: 0,
                });
            }
        };
        add("tracks", tracks::mesh(&piece), true);
        add("walls", walls(&piece), false);
        add("platforms", platforms(&piece), false);
        add("signals", signals(&piece), false);
    }
    for (index, street, crossing) in &corridor.crossings {
        if corridor.line.along(street.crossing(0.0, &corridor.line, 0.0)).abs() < reach_m + 60.0 {
            let key = corridor.key.child("bridge").index(*index as u64);
            match crossing {
                Crossing::Road => out.push(road_bridge(corridor, relief, *index, street, &key)),
                Crossing::Foot => out.push(foot_bridge(corridor, relief, *index, street, &key)),
                Crossing::None => {}
            }
        }
    }
    out
}

/// A box along the corridor between two places, swept so that it follows the ground at `left`.
fn run(b: &mut MeshBuilder, piece: &Piece<'_>, along: [f64; 2], left: f64, section: &[DVec2], slots: &[u16]) {
    let steps = libm::ceil((along[1] - along[0]) / 15.0).max(1.0) as usize;
    let station = |k: usize| piece.station(along[0] + (along[1] - along[0]) * k as f64 / steps as f64, left);
    sweep::solid(b, &station, 0..=steps, &|_| section.to_vec(), slots);
}

/// Corners of a rectangle of a section by its right and left, low and high borders.
fn bar(right: f64, left: f64, low: f64, high: f64) -> [DVec2; 4] {
    // Offsets of a section are counted to the right.
    [(-left, low), (-right, low), (-right, high), (-left, high)].map(|(x, y)| DVec2::new(x, y))
}

/// Whether a bridge leads over a place at the corridor's edge, or ends within a distance of it.
fn open(c: &Corridor, along: f64, left: f64, clear_m: f64) -> bool {
    let p = c.line.at(along, left);
    c.crossings.iter().any(|(_, s, crossing)| {
        let half = match crossing {
            Crossing::Road => s.section.right_of_way_m() / 2.0,
            Crossing::Foot => FOOT_HALF_M,
            Crossing::None => return false,
        };
        s.direction.perp_dot(p - s.through_m).abs() < half + clear_m
    })
}

/// Retaining walls with their parapets, and fences on the edges.
fn walls(piece: &Piece<'_>) -> Mesh {
    let mut b = MeshBuilder::default();
    let c = piece.corridor;
    let span = [piece.middle_m - PIECE_M / 2.0, piece.middle_m + PIECE_M / 2.0];
    // Pieces of a length that lie outside of bridges.
    let closed = |pitch: f64, left: f64, clear_m: f64| {
        let pieces = (0..(PIECE_M / pitch) as u32).map(move |k| span[0] + pitch * f64::from(k));
        pieces.filter(move |a| !open(c, *a, left, clear_m) && !open(c, a + pitch, left, clear_m)).collect::<Vec<f64>>()
    };
    for (side, run_m) in [(-1.0, c.run_m[0]), (1.0, c.run_m[1])] {
        let edge = side * c.half_m;
        let outward = |from: f64, to: f64| if side > 0.0 { [from, to] } else { [-to, -from] };
        if run_m <= WALL_M {
            // Wider than the strip over which the ground falls, so that this is hidden in it; its top ends inside decks.
            let [r, l] = outward(-0.75, 0.25);
            run(&mut b, piece, span, edge, &bar(r, l, -1.0, DEPTH_M - 0.3), &[slot::CONCRETE; 4]);
            let pitch = 1.5;
            for from in closed(pitch, edge, -0.2) {
                let [r, l] = outward(-0.72, 0.22);
                run(
                    &mut b,
                    piece,
                    [from, from + pitch],
                    edge,
                    &bar(r, l, DEPTH_M - 0.5, DEPTH_M + 0.9),
                    &[slot::CONCRETE; 4],
                );
                let [r, l] = outward(-0.85, 0.35);
                run(
                    &mut b,
                    piece,
                    [from, from + pitch],
                    edge,
                    &bar(r, l, DEPTH_M + 0.85, DEPTH_M + 1.0),
                    &[slot::CONCRETE; 4],
                );
            }
            // Buttresses.
            for k in 0..(PIECE_M / 7.5) as u32 {
                let along = span[0] + 3.75 + 7.5 * f64::from(k);
                let at = DVec2::new(along - piece.middle_m, edge - side * 0.85);
                let z = piece.floor_m(along, edge);
                b.block(slot::CONCRETE, slot::CONCRETE, at, DVec2::X, DVec2::new(0.3, 0.2), z - 1.0, z + DEPTH_M - 0.4);
            }
        }
        // A fence a little inside the property line, open where a street is.
        let fence = edge + side * (VERGE_M - 0.9);
        let pitch = 3.0;
        for from in closed(pitch, fence, 1.0) {
            let z = piece.floor_m(from, fence) + DEPTH_M;
            let at = DVec2::new(from + 0.04 - piece.middle_m, fence);
            b.block(slot::STEEL, slot::STEEL, at, DVec2::X, DVec2::splat(0.04), z - 0.6, z + 2.0);
            for h in [0.15, 0.75, 1.35, 1.9] {
                let section = bar(-0.02, 0.02, DEPTH_M + h - 0.02, DEPTH_M + h + 0.02);
                run(&mut b, piece, [from, from + pitch], fence, &section, &[slot::STEEL; 4]);
            }
        }
    }
    b.finish()
}

/// Platforms in the gaps between groups of tracks, with roofs on posts, or a shed from platform to platform.
fn platforms(piece: &Piece<'_>) -> Mesh {
    let mut b = MeshBuilder::default();
    let c = piece.corridor;
    let Some([from, to]) = c.station_m else { return b.finish() };
    let span = [from.max(piece.middle_m - PIECE_M / 2.0), to.min(piece.middle_m + PIECE_M / 2.0)];
    if span[1] - span[0] < 1.0 {
        return b.finish();
    }
    let half = super::GAP_M / 2.0 - EDGE_M;
    for (n, gap) in c.gaps_m.iter().enumerate() {
        let mut rng = c.key.child("platform").index(n as u64).rng();
        let slots = [slot::CONCRETE, slot::CONCRETE, slot::PLATFORM, slot::CONCRETE];
        run(&mut b, piece, span, *gap, &bar(-half, half, -0.6, PLATFORM_M), &slots);
        // Roofs begin and end by themselves, in thirds of the platform.
        let length = to - from;
        let roofed = if c.shed {
            [from + 6.0, to - 6.0]
        } else {
            [from + length * rng.range(0.04, 0.3), to - length * rng.range(0.04, 0.35)]
        };
        let w = if c.shed { half + EDGE_M + super::PITCH_M / 2.0 - 0.75 } else { half + rng.range(-0.4, 0.9) };
        let (a, z) = (roofed[0].max(span[0]), roofed[1].min(span[1]));
        let eaves = RAIL_M + 5.35;
        if z - a > 0.5 {
            // Wings fall gently to the gutter in the middle.
            let dip = if c.shed { -0.12 } else { 0.3 };
            let section = [
                (-w, eaves),
                (0.0, eaves - dip),
                (w, eaves),
                (w, eaves + 0.28),
                (0.0, eaves + 0.28 - dip),
                (-w, eaves + 0.28),
            ]
            .map(|(x, y)| DVec2::new(x, y));
            let slots = [slot::STEEL, slot::STEEL, slot::STEEL, slot::ROOF, slot::ROOF, slot::STEEL];
            run(&mut b, piece, [a, z], *gap, &section, &slots);
            // Vents and lamps' housings along the ridge.
            let mut k = libm::ceil(a / 11.0);
            while k * 11.0 + 1.2 < z {
                let along = k * 11.0;
                let ground = piece.floor_m(along, *gap);
                let y = gap + w * 0.45 * if k.rem_euclid(2.0) < 0.5 { 1.0 } else { -1.0 };
                let at = DVec2::new(along - piece.middle_m, y);
                b.block(
                    slot::STEEL,
                    slot::DARK,
                    at,
                    DVec2::X,
                    DVec2::new(0.8, 0.45),
                    ground + eaves - 0.2,
                    ground + eaves + 0.5,
                );
                k += 1.0;
            }
        }
        let mut k = libm::ceil(span[0] / 7.5);
        while k * 7.5 < span[1] - 0.3 {
            let along = k * 7.5;
            let ground = piece.floor_m(along, *gap);
            let at = |dx: f64, dy: f64| DVec2::new(along + dx - piece.middle_m, gap + dy);
            if along > a && along < z {
                for dy in [-0.62, 0.62] {
                    b.block(
                        slot::STEEL,
                        slot::STEEL,
                        at(0.0, dy * half),
                        DVec2::X,
                        DVec2::splat(0.14),
                        ground - 0.3,
                        ground + eaves + 0.05,
                    );
                }
            } else {
                let lamp = ground + 6.0;
                b.limb(slot::STEEL, at(0.0, 0.0).extend(ground), at(0.0, 0.0).extend(lamp), [0.09, 0.06], 5);
                b.block(
                    slot::STEEL,
                    slot::STEEL,
                    at(0.0, 0.0),
                    DVec2::X,
                    DVec2::new(0.18, 0.9),
                    lamp - 0.05,
                    lamp + 0.1,
                );
            }
            // Heads of stairs, lifts and shelters.
            if k.rem_euclid(6.0) < 0.5 && along + 6.0 < span[1] {
                let top = ground + PLATFORM_M + 2.7;
                b.block(slot::GLASS, slot::ROOF, at(3.6, 0.0), DVec2::X, DVec2::new(2.2, 1.2), ground, top);
            }
            k += 1.0;
        }
    }
    b.finish()
}

/// Signal bridges over the tracks, and huts beside them.
fn signals(piece: &Piece<'_>) -> Mesh {
    let mut b = MeshBuilder::default();
    let c = piece.corridor;
    let number = libm::round(piece.middle_m / PIECE_M);
    let mut rng = c.key.child("signals").index(number as i64 as u64).rng();
    let (portal, hut, x) = (rng.chance(0.3), rng.chance(0.35), rng.signed() * 18.0);
    let along = piece.middle_m + x;
    let clear = c.crossings.iter().all(|(_, s, _)| (c.line.along(s.crossing(0.0, &c.line, 0.0)) - along).abs() > 30.0);
    let station = c.station_m.is_some_and(|[a, z]| along > a - 12.0 && along < z + 12.0);
    if portal && clear && !station && c.tracks.len() > 3 {
        // From beside the first track to the middle of a gap or beside the last one.
        let right = c.tracks[0].left_m - 2.6;
        let left =
            c.gaps_m.last().copied().filter(|_| rng.chance(0.5)).unwrap_or(c.tracks[c.tracks.len() - 1].left_m + 2.6);
        let ground = |y: f64| piece.floor_m(along, y);
        let top = ground(f64::midpoint(right, left)) + 7.3;
        for y in [right, left] {
            let foot = DVec2::new(x, y);
            for dx in [-0.45, 0.45] {
                b.block(
                    slot::STEEL,
                    slot::STEEL,
                    foot + DVec2::new(dx, 0.0),
                    DVec2::X,
                    DVec2::splat(0.11),
                    ground(y) - 0.8,
                    top,
                );
            }
        }
        let beam = |dx: f64, z: f64| (DVec3::new(x + dx, right - 0.3, z), DVec3::new(x + dx, left + 0.3, z));
        for (dx, z) in [(-0.45, top), (0.45, top), (-0.45, top - 0.9), (0.45, top - 0.9)] {
            let (from, to) = beam(dx, z);
            b.limb(slot::STEEL, from, to, [0.07; 2], 4);
        }
        let mut y = right + 0.6;
        while y + 1.2 < left {
            for dx in [-0.45, 0.45] {
                b.limb(slot::STEEL, DVec3::new(x + dx, y, top), DVec3::new(x + dx, y + 0.6, top - 0.9), [0.035; 2], 3);
                b.limb(
                    slot::STEEL,
                    DVec3::new(x + dx, y + 0.6, top - 0.9),
                    DVec3::new(x + dx, y + 1.2, top),
                    [0.035; 2],
                    3,
                );
            }
            y += 1.2;
        }
        for track in c.tracks.iter().filter(|t| t.left_m > right && t.left_m < left) {
            let at = DVec2::new(x, track.left_m + 0.9);
            b.block(slot::DARK, slot::DARK, at, DVec2::X, DVec2::new(0.2, 0.3), top - 2.3, top - 0.6);
        }
    }
    if hut && !station {
        let [right, left] = c.floor_m();
        let side = if c.tracks[0].left_m - right > left - c.tracks[c.tracks.len() - 1].left_m {
            right + 1.9
        } else {
            left - 1.9
        };
        let along = piece.middle_m + rng.signed() * 20.0;
        let z = piece.floor_m(along, side);
        let half = DVec2::new(rng.range(1.4, 3.4), rng.range(0.8, 1.1));
        let at = DVec2::new(along - piece.middle_m, side);
        b.block(slot::STEEL, slot::ROOF, at, DVec2::X, half, z - 0.5, z + rng.range(2.1, 2.9));
    }
    b.finish()
}
