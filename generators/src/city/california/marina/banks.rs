//! The water, its banks, the walks along them, and the streets that run out onto moles.

use super::super::layout::{BULB_M, Grid, Line, Piece};
use super::super::lot::{Content, Plant, Planted};
use super::super::paving::{HALF_M, Layer};
use super::super::streets::{self, GUTTER_M, disc, plain};
use super::super::{DETAIL_MARGIN_M, Params, ground_slot as slot};
use super::harbour::{Cell, Harbour, Reach, Shore};
use crate::city::california::land::Land;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Width of the walks along the water, and of the strip between them and the bank, m.
pub(super) const WALK_M: f64 = 4.2;
const EDGE_M: f64 = 0.5;
/// From a mole's tip to the middle of the turning place of its street, m.
pub(super) const TURN_M: f64 = 27.0;
/// Length of the streets that come to the southern bank, from the middle of the street that they leave, m.
pub(super) const STUB_M: f64 = 58.0;

fn world(land: &Land, flat: &[DVec2]) -> Vec<DVec2> {
    flat.iter().map(|p| land.world(*p)).collect()
}

/// The water of a cell and its banks; none where it leaves the ground.
pub(super) fn water(cell: &Cell, land: &Land) -> Option<Content> {
    let mut out = Content::default();
    for reach in cell.north.iter().chain(&cell.south) {
        let slot = match reach.shore {
            Shore::Wall => slot::SEAWALL,
            Shore::Stones => slot::RIPRAP,
            Shore::Beach => slot::SAND,
        };
        out.patches.push(plain(Layer::Coping, world(land, &strip(reach, 0.0, 0.0, 0.0)), slot, false));
    }
    out.patches.push(plain(Layer::Water, world(land, &cell.water), slot::WATER, false));
    let within = |p: &DVec2| p.abs().max_element() < HALF_M - 40.0;
    out.patches.iter().all(|(_, p)| p.outline.iter().all(within)).then_some(out)
}

/// The land between a shore's line, moved inland by a share of the bank and some metres, and the bank's top moved by others.
fn strip(reach: &Reach, share: f64, from_m: f64, to_m: f64) -> Vec<DVec2> {
    let mut out = if share == 0.0 { reach.line.clone() } else { reach.inland(share, from_m) };
    out.extend(reach.inland(1.0, to_m).into_iter().rev());
    out
}

/// Walks, palms and lights along a cell's shores, and its streets.
pub(super) fn plan(
    params: &Params,
    cell: &Cell,
    harbour: &Harbour,
    grid: &Grid,
    land: &Land,
    city: &SeedPath,
) -> Vec<(String, Content)> {
    let mut walks = Content::default();
    // Lawn lies below all that is built; where nothing is, it is seen.
    let p = DVec2::new;
    let (south, north) = (harbour.streets[0] + 10.0, harbour.streets[1] - 16.0);
    let (west, east) = (cell.x[0] + cell.mole_m[0] - 1.0, cell.x[1] - cell.mole_m[1] + 1.0);
    for (low, high) in [
        (p(cell.x[0], south), p(cell.x[1], harbour.channel[0] - 20.0)),
        (p(cell.x[0], cell.tip[0] + 3.0), p(west, north)),
        (p(east, cell.tip[1] + 3.0), p(cell.x[1], north)),
        (p(west - 3.0, cell.head + 3.0), p(east + 3.0, north)),
    ] {
        let outline = world(land, &polygon::rectangle(low, high));
        walks.patches.push(plain(Layer::Yard, outline, slot::TURF, false));
    }
    for (r, reach) in cell.north.iter().chain(&cell.south).enumerate() {
        let outline = strip(reach, 1.0, EDGE_M, EDGE_M + WALK_M);
        walks.patches.push(plain(Layer::Deck, world(land, &outline), slot::PLAZA, false));
        let key = city.child("walk").index(cell.k as u64).index(r as u64);
        along_walk(params, reach, land, &key, &mut walks);
    }
    let mut parts = vec![(format!("harbour/walk/{}", cell.k), walks)];
    parts.extend(mole(params, cell, harbour, grid, land, city));
    parts
}

fn along_walk(params: &Params, reach: &Reach, land: &Land, key: &SeedPath, out: &mut Content) {
    let mut rng = key.rng();
    let palms = rng.chance(0.75);
    let line = reach.inland(1.0, EDGE_M + WALK_M + 1.2);
    let lamps = reach.inland(1.0, EDGE_M + WALK_M - 0.3);
    let mut next = 4.0;
    let mut lamp = 12.0;
    let mut done = 0.0;
    for k in 1..line.len() {
        let (a, b) = (line[k - 1], line[k]);
        let length = a.distance(b);
        while next < done + length {
            let p = a.lerp(b, (next - done) / length);
            if rng.chance((0.8 * params.trees).min(1.0)) {
                let plant = if palms || rng.chance(0.4) { Plant::Palm } else { Plant::Broad };
                out.plants.push(Planted { at: land.world(p), plant, size: rng.range(0.75, 1.05) });
            }
            next += rng.range(7.5, 11.0);
        }
        while lamp < done + length {
            let t = (lamp - done) / length;
            let p = lamps[k - 1].lerp(lamps[k], t);
            let out_of = line[k - 1].lerp(line[k], t) - p;
            out.lights.push((land.world(p), (land.world(p - out_of) - land.world(p)).normalize()));
            lamp += 34.0;
        }
        done += length;
    }
}

/// The street of the mole at a cell's begin, with the place where cars turn, and the short street of the other bank.
fn mole(
    params: &Params,
    cell: &Cell,
    harbour: &Harbour,
    grid: &Grid,
    land: &Land,
    city: &SeedPath,
) -> Vec<(String, Content)> {
    let x = cell.x[0];
    let p = DVec2::new;
    let turn = p(x, cell.tip[0] + TURN_M);
    let end = p(x, harbour.streets[0] + STUB_M);
    let pieces = [
        (
            turn,
            Piece {
                // No axis of the grid's: this piece has no crossing at its begin.
                index: [2, cell.k, -1],
                kind: Line::Collector,
                ends: [turn, p(x, harbour.streets[1])],
                meets: [Line::End, grid.kind(1, 0)],
            },
        ),
        (
            end,
            Piece {
                index: [0, cell.k, -1],
                kind: Line::Collector,
                ends: [p(x, harbour.streets[0]), end],
                meets: [grid.kind(1, -1), Line::End],
            },
        ),
    ];
    let names = ["mole", "stub"];
    let mut out = Vec::new();
    for ((bulb, piece), name) in pieces.into_iter().zip(names) {
        let middle = land.world((piece.ends[0] + piece.ends[1]) * 0.5);
        let half = piece.ends[0].distance(piece.ends[1]) / 2.0;
        let near = middle.length() < params.radius_m + DETAIL_MARGIN_M + half + 60.0;
        let mut content = streets::piece(&piece, land, params, city, near);
        let bands = [
            (Layer::Walk, BULB_M + 1.75, slot::SIDEWALK, false),
            (Layer::Gutter, BULB_M, slot::GUTTER, true),
            (Layer::Mark, BULB_M - GUTTER_M, slot::JUNCTION, true),
        ];
        for (layer, radius_m, slot, lowered) in bands {
            content.patches.push(plain(layer, world(land, &disc(bulb, radius_m)), slot, lowered));
        }
        let clear = |at: &DVec2| land.turned_back(*at).distance(bulb) > BULB_M + 0.4;
        content.plants.retain(|q| clear(&q.at));
        content.lights.retain(|q| clear(&q.0));
        out.push((format!("harbour/{name}/{}", cell.k), content));
    }
    out
}

/// A timber pier from the southern bank, at some cells.
pub(super) fn pier(
    cell: &Cell,
    harbour: &Harbour,
    land: &Land,
    city: &SeedPath,
) -> Option<(String, DVec2, DVec2, [f64; 2])> {
    let mut rng = city.child("pier").index(cell.k as u64).rng();
    if !rng.chance(0.55) {
        return None;
    }
    let reach = cell.south.iter().find(|r| r.shore == if cell.sandy_bank { Shore::Beach } else { Shore::Stones })?;
    let n = reach.line.len();
    let foot = reach.inland(1.0, 0.5)[n / 2];
    let shore = reach.line[n / 2];
    let length_m = shore.distance(foot) + rng.range(30.0, 38.0).min(0.36 * (harbour.channel[1] - harbour.channel[0]));
    let at = land.world(foot);
    let axis = (land.world(foot + DVec2::Y) - at).normalize();
    Some((format!("harbour/pier/{}", cell.k), at, axis, [length_m, rng.range(2.2, 3.4)]))
}
