//! Streets: carriageways with gutters, walks, markings and repairs; lights and traffic along them.

use super::Params;
use super::ground_slot as slot;
use super::land::{Land, Sheet};
use super::layout::{BULB_M, Fillet, LOCAL_ROADWAY_M, Line, Module, Piece, Strip};
use super::lot::{Content, Parked, Plant, Planted};
use super::paving::Layer;
use crate::city::toronto::traffic::draw_body;
use crate::kit::ground::Patch;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// Width of the concrete gutter, m.
pub(super) const GUTTER_M: f64 = 0.5;

/// Radius of a corner's kerb, m.
const CORNER_M: f64 = 7.0;

/// A patch whose texture coordinates are the world's.
pub(super) fn plain(layer: Layer, outline: Vec<DVec2>, slot: u16, lowered: bool) -> (Layer, Patch) {
    (layer, Patch { outline, slot, origin_m: DVec2::ZERO, axis: DVec2::X, lowered })
}

/// The corner between two kerb lines and the arc that rounds it, when both lines are moved by `out` into the land.
fn fillet(f: &Fillet, radius_m: f64, out: f64) -> Vec<DVec2> {
    let corner = f.corner + f.into * (out - 0.3);
    let r = radius_m + 0.3;
    let centre = corner + f.into * r;
    let mut points = vec![corner];
    for k in 0..=6 {
        let (s, c) = libm::sincos(core::f64::consts::FRAC_PI_2 * f64::from(k) / 6.0);
        points.push(centre - f.into * DVec2::new(s, c) * r);
    }
    if polygon::area(&points) < 0.0 {
        points.reverse();
    }
    points
}

pub(super) fn disc(centre: DVec2, radius_m: f64) -> Vec<DVec2> {
    (0..28)
        .map(|k| {
            let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 28.0);
            centre + DVec2::new(c, s) * radius_m
        })
        .collect()
}

fn strip_outline(s: &Strip, half_m: f64) -> Vec<DVec2> {
    let along = (s.to - s.from).normalize();
    let left = along.perp() * half_m;
    vec![s.from - left, s.to - left, s.to + left, s.from + left]
}

/// The local streets of a module.
pub(super) fn local(module: &Module<'_>, params: &Params, detailed: bool) -> Content {
    let mut out = Content::default();
    let mut rng = module.key.child("streets").rng();
    let asphalt = slot::ASPHALT + rng.below(u64::from(slot::ASPHALTS)) as u16;
    // Either a walk at the kerb, or a planted strip between kerb and walk.
    let parkway = rng.chance(0.45);
    let (walk_m, lawn_m) = if parkway { (3.25, 1.8) } else { (1.75, 0.0) };
    let sheet = &module.sheet;
    let mut lay = |layer: Layer, local: &[DVec2], slot: u16, lowered: bool| {
        out.patches.push(plain(layer, sheet.polygon(local), slot, lowered));
    };
    let bands = [
        (Layer::Walk, walk_m, slot::SIDEWALK, false, true),
        (Layer::Parkway, lawn_m, slot::PARKWAY, false, parkway),
        (Layer::Gutter, 0.0, slot::GUTTER, true, true),
        (Layer::Local, -GUTTER_M, asphalt, true, true),
    ];
    for (layer, out_m, slot, lowered, wanted) in bands {
        if !wanted || (!detailed && layer != Layer::Local) {
            continue;
        }
        for s in &module.strips {
            lay(layer, &strip_outline(s, LOCAL_ROADWAY_M + out_m), slot, lowered);
        }
        for b in &module.bulbs {
            lay(layer, &disc(*b, BULB_M + out_m), slot, lowered);
        }
        for f in &module.fillets {
            lay(layer, &fillet(f, CORNER_M, out_m), slot, lowered);
        }
    }
    if !detailed {
        return out;
    }
    for (k, s) in module.strips.iter().enumerate() {
        let key = module.key.child("strip").index(k as u64);
        along_local(sheet, s, params, &key, &mut out);
    }
    out
}

/// Repairs, lights and the few cars on the move of one local street.
fn along_local(sheet: &Sheet<'_>, s: &Strip, params: &Params, key: &SeedPath, out: &mut Content) {
    let along = (s.to - s.from).normalize();
    let length = s.from.distance(s.to);
    let at = |d: f64, left: f64| s.from + along * d + along.perp() * left;
    let mut rng = key.child("repairs").rng();
    let edge = LOCAL_ROADWAY_M - GUTTER_M - 0.3;
    let mut taken: Vec<Vec<DVec2>> = Vec::new();
    for _ in 0..libm::floor(length / 22.0) as u32 {
        let (long, wide, slot) = match rng.weighted(&[0.35, 0.3, 0.35]) {
            0 => (rng.range(10.0, 45.0), rng.range(0.5, 1.1), slot::TRENCH),
            1 => (rng.range(0.7, 1.2), rng.range(3.0, 2.0 * edge), slot::TRENCH),
            _ => (rng.range(1.5, 7.0), rng.range(1.2, 3.4), slot::PATCH),
        };
        let from = rng.range(2.0, (length - long - 2.0).max(2.1));
        let left = rng.range(-edge, (edge - wide).max(-edge + 0.01));
        if from + long + 2.0 > length {
            continue;
        }
        let outline = [at(from, left), at(from + long, left), at(from + long, left + wide), at(from, left + wide)];
        let near = polygon::mitred(&outline, -0.15);
        if taken.iter().any(|t| polygon::convex_overlap(t, &near)) {
            continue;
        }
        taken.push(near);
        out.patches.push(plain(Layer::Mark, sheet.polygon(&outline), slot, true));
    }
    let mut rng = key.child("lights").rng();
    let mut d = rng.range(8.0, 40.0);
    let mut side = 1.0;
    while d < length - 8.0 {
        let p = at(d, side * (LOCAL_ROADWAY_M + 0.6));
        out.lights.push((sheet.world(p), -sheet.direction(p, along.perp() * side)));
        side = -side;
        d += rng.range(45.0, 65.0);
    }
    let mut rng = key.child("traffic").rng();
    for way in [1.0, -1.0] {
        if rng.chance((length / 600.0 * params.vehicles).min(1.0)) {
            let p = at(rng.range(10.0, (length - 10.0).max(10.1)), -way * 1.9);
            let axis = sheet.direction(p, along) * way;
            out.vehicles.push(Parked { centre: sheet.world(p), axis, body: draw_body(&mut rng, false), lowered: true });
        }
    }
}

/// Lanes of a line: to the left of its middle, m, and direction of travel.
fn lanes(line: Line) -> &'static [(f64, f64)] {
    match line {
        Line::Arterial => &[(-10.3, 1.0), (-6.9, 1.0), (-3.5, 1.0), (3.5, -1.0), (6.9, -1.0), (10.3, -1.0)],
        Line::Collector => &[(-3.4, 1.0), (3.4, -1.0)],
        Line::Freeway | Line::End => &[],
    }
}

/// Half width of an arterial's median, m.
const MEDIAN_M: f64 = 1.7;

/// An arterial or collector between two crossings, with the crossing at its begin.
pub(super) fn piece(piece: &Piece, land: &Land, params: &Params, city: &SeedPath, detailed: bool) -> Content {
    let mut out = Content::default();
    let key = piece.index.iter().fold(city.child("line"), |k, i| k.index(*i as u64));
    let [from, to] = piece.ends;
    let along = (to - from).normalize();
    let length = from.distance(to);
    let sheet = Sheet { land, origin: DVec2::ZERO, swapped: false, size: DVec2::ONE, bow_m: [0.0; 2] };
    let at = |d: f64, left: f64| from + along * d + along.perp() * left;
    let rect = |d0: f64, d1: f64, l0: f64, l1: f64| vec![at(d0, l0), at(d1, l0), at(d1, l1), at(d0, l1)];
    let half = piece.kind.half_roadway_m();
    let clear = piece.meets.map(Line::half_roadway_m);
    let band = |out: &mut Content, layer, l: f64, slot, lowered| {
        out.patches.push(plain(layer, sheet.polygon(&rect(0.0, length, -l, l)), slot, lowered));
    };
    if detailed {
        band(&mut out, Layer::Walk, half + 3.4, slot::SIDEWALK, false);
        band(&mut out, Layer::Parkway, half + 1.7, slot::PARKWAY, false);
        band(&mut out, Layer::Gutter, half, slot::GUTTER, true);
    }
    // The crossing at the begin: a plain square and its rounded corners, given by one of the two lines.
    let below = piece.meets.map(|m| m == Line::Freeway);
    if piece.index[0] == 0 && !below[0] && piece.meets[0] != Line::End {
        let other = clear[0];
        let square = [
            from + DVec2::new(-half, -other),
            from + DVec2::new(half, -other),
            from + DVec2::new(half, other),
            from + DVec2::new(-half, other),
        ];
        out.patches.push(plain(Layer::Mark, sheet.polygon(&square), slot::JUNCTION, true));
        if detailed {
            for (layer, out_m, slot, lowered) in [
                (Layer::Walk, 3.4, slot::SIDEWALK, false),
                (Layer::Parkway, 1.7, slot::SIDEWALK, false),
                (Layer::Gutter, 0.0, slot::GUTTER, true),
                (Layer::Local, -GUTTER_M, slot::JUNCTION, true),
            ] {
                for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    let f = Fillet { corner: from + DVec2::new(sx * half, sy * other), into: DVec2::new(sx, sy) };
                    out.patches.push(plain(layer, sheet.polygon(&fillet(&f, 9.5, out_m)), slot, lowered));
                }
            }
        }
    }
    // Carriageway in chords, so that its markings follow the bend.
    let surface = if piece.kind == Line::Arterial { slot::ARTERIAL } else { slot::COLLECTOR };
    let (d0, d1) = (clear[0] + 6.5, length - clear[1] - 6.5);
    let chords = libm::ceil((d1 - d0) / 15.0).max(1.0);
    let edge = half - GUTTER_M;
    for (a, b) in [(clear[0], d0), (d1, length - clear[1])] {
        out.patches.push(plain(Layer::Major, sheet.polygon(&rect(a, b, -edge, edge)), slot::JUNCTION, true));
    }
    for k in 0..chords as u32 {
        let (a, b) = (d0 + (d1 - d0) * f64::from(k) / chords, d0 + (d1 - d0) * f64::from(k + 1) / chords);
        let (p, q) = (sheet.world(at(a, 0.0)), sheet.world(at(b, 0.0)));
        let axis = (q - p).normalize();
        let outline = sheet.corners(&rect(a, b, -edge, edge));
        let patch = Patch { outline, slot: surface, origin_m: p - axis * a, axis, lowered: true };
        out.patches.push((Layer::Major, patch));
    }
    if !detailed {
        return out;
    }
    markings(piece, &sheet, &at, length, clear, edge, &mut out);
    let ends = [d0, d1];
    // Nothing tall stands below a freeway.
    let (d0, d1) = (if below[0] { 56.0 } else { d0 }, if below[1] { length - 56.0 } else { d1 });
    if piece.kind == Line::Arterial {
        median(&sheet, &at, [d0 + 16.0, d1 - 16.0], params, &key, &mut out);
    }
    verge(piece, &sheet, &at, [d0, d1], params, &key, &mut out);
    traffic(piece, &sheet, &at, ends, params, &key, &mut out);
    out
}

/// Crossings and stop bars before the crossing streets.
fn markings(
    piece: &Piece,
    sheet: &Sheet<'_>,
    at: &impl Fn(f64, f64) -> DVec2,
    length: f64,
    clear: [f64; 2],
    edge: f64,
    out: &mut Content,
) {
    if piece.meets.iter().all(|m| *m == Line::Collector) && piece.kind == Line::Collector {
        return;
    }
    for (start, way, begin) in [(clear[0], 1.0, true), (length - clear[1], -1.0, false)] {
        if matches!(piece.meets[usize::from(!begin)], Line::Freeway | Line::End) {
            continue;
        }
        let mut mark = |a: f64, b: f64, l0: f64, l1: f64, slot: u16| {
            let (a, b) = (start + way * a, start + way * b);
            let (a, b) = (a.min(b), a.max(b));
            let local = [at(a, l0), at(b, l0), at(b, l1), at(a, l1)];
            let outline = sheet.corners(&local);
            let axis = sheet.direction(at(a, 0.0), at(1.0, 0.0) - at(0.0, 0.0));
            let patch = Patch { origin_m: outline[0], outline, slot, axis, lowered: true };
            out.patches.push((Layer::Mark, patch));
        };
        mark(1.0, 4.0, -edge + 0.1, edge - 0.1, slot::CROSSING);
        // Those who come to this end keep to their right.
        let (l0, l1) = if begin { (0.3, edge - 0.2) } else { (-edge + 0.2, -0.3) };
        mark(5.2, 5.7, l0, l1, slot::STOP);
    }
}

fn median(
    sheet: &Sheet<'_>,
    at: &impl Fn(f64, f64) -> DVec2,
    [d0, d1]: [f64; 2],
    params: &Params,
    key: &SeedPath,
    out: &mut Content,
) {
    let mut rng = key.child("median").rng();
    let mut d = d0;
    while d < d1 - 30.0 {
        let end = (d + rng.range(70.0, 150.0)).min(d1);
        let local = [at(d, -MEDIAN_M), at(end, -MEDIAN_M), at(end, MEDIAN_M), at(d, MEDIAN_M)];
        let slot = if rng.chance(0.7) { slot::MEDIAN } else { slot::PLAZA };
        out.patches.push(plain(Layer::Island, sheet.polygon(&local), slot, false));
        let palms = rng.chance(0.5);
        let mut s = d + 5.0;
        while s < end - 4.0 {
            if rng.chance(0.8 * params.trees.min(1.2)) {
                let plant = if palms { Plant::Palm } else { Plant::Broad };
                out.plants.push(Planted { at: sheet.world(at(s, 0.0)), plant, size: rng.range(0.7, 1.1) });
            }
            for _ in 0..3 {
                if rng.chance(0.5 * params.trees.min(2.0)) {
                    let p = at(s + rng.range(1.5, 8.0), rng.signed() * 0.9);
                    out.plants.push(Planted { at: sheet.world(p), plant: Plant::Shrub, size: rng.range(0.5, 1.0) });
                }
            }
            s += rng.range(9.0, 13.0);
        }
        // A gap for turning.
        d = end + rng.range(14.0, 22.0);
    }
}

fn verge(
    piece: &Piece,
    sheet: &Sheet<'_>,
    at: &impl Fn(f64, f64) -> DVec2,
    [d0, d1]: [f64; 2],
    params: &Params,
    key: &SeedPath,
    out: &mut Content,
) {
    let half = piece.kind.half_roadway_m();
    let across = at(0.0, 1.0) - at(0.0, 0.0);
    for (k, side) in [1.0, -1.0].into_iter().enumerate() {
        let mut rng = key.child("verge").index(k as u64).rng();
        let palms = rng.chance(0.4);
        let kept = rng.range(0.4, 0.95) * params.trees;
        let mut d = d0 + rng.range(3.0, 12.0);
        while d < d1 - 4.0 {
            if rng.chance(kept.min(1.0)) {
                let plant = if palms { Plant::Palm } else { Plant::Broad };
                let p = at(d, side * (half + 0.85));
                out.plants.push(Planted { at: sheet.world(p), plant, size: rng.range(0.7, 1.2) });
            }
            d += rng.range(9.0, 14.0);
        }
        let mut d = d0 + if k == 0 { 6.0 } else { 24.0 };
        while d < d1 {
            let p = at(d, side * (half + 0.5));
            out.lights.push((sheet.world(p), -sheet.direction(p, across * side)));
            d += rng.range(36.0, 44.0);
        }
    }
}

fn traffic(
    piece: &Piece,
    sheet: &Sheet<'_>,
    at: &impl Fn(f64, f64) -> DVec2,
    [d0, d1]: [f64; 2],
    params: &Params,
    key: &SeedPath,
    out: &mut Content,
) {
    let along = at(1.0, 0.0) - at(0.0, 0.0);
    let busy = if piece.kind == Line::Arterial { [15.0, 35.0] } else { [6.0, 16.0] };
    for (l, (left, way)) in lanes(piece.kind).iter().enumerate() {
        let mut rng = key.child("lane").index(l as u64).rng();
        let per_m = rng.range(busy[0], busy[1]) / 1000.0 * params.vehicles;
        if per_m <= 0.0 {
            continue;
        }
        let gap = |rng: &mut Rng| 4.0 - libm::log(1.0 - rng.unit()) / per_m;
        let mut back = rng.range(0.0, 60.0);
        while back < d1 - d0 - 12.0 {
            let body = draw_body(&mut rng, piece.kind == Line::Arterial);
            let length = body.size_m()[0];
            let d = if *way > 0.0 { d1 - back - length / 2.0 } else { d0 + back + length / 2.0 };
            let p = at(d, left + rng.signed() * 0.25);
            let axis = sheet.direction(p, along) * *way;
            out.vehicles.push(Parked { centre: sheet.world(p), axis, body, lowered: true });
            back += length + gap(&mut rng);
        }
    }
}
