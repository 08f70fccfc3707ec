//! Old farmland: a square cut again and again by its oriented box (Vanegas 2012), first by roads, then by what divides
//! parcels.

use super::Params;
use super::crops::Crop;
use super::plan::{Border, DOMAIN_HALF_M, Edge, Piece};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// What a layout gives.
#[derive(Default)]
pub(super) struct Sheet {
    pub(super) borders: Vec<Border>,
    pub(super) pieces: Vec<Piece>,
    pub(super) pivots: Vec<(DVec2, f64)>,
}

/// A polygon with the border of each edge.
#[derive(Clone)]
pub(super) struct Tagged {
    pub(super) corners: Vec<DVec2>,
    pub(super) borders: Vec<u32>,
}

impl Tagged {
    /// The part of a convex polygon where `(p - on) . inward >= 0`; the cut gets the border `tag`.
    pub(super) fn clipped(&self, on: DVec2, inward: DVec2, tag: u32) -> Option<Self> {
        let side = |p: DVec2| (p - on).dot(inward);
        let n = self.corners.len();
        let mut out = Self { corners: Vec::with_capacity(n + 1), borders: Vec::with_capacity(n + 1) };
        for i in 0..n {
            let (a, b, border) = (self.corners[i], self.corners[(i + 1) % n], self.borders[i]);
            let (sa, sb) = (side(a), side(b));
            if sa >= 0.0 {
                out.corners.push(a);
                out.borders.push(if sa == 0.0 && sb < 0.0 { tag } else { border });
            }
            if (sa > 0.0 && sb < 0.0) || (sa < 0.0 && sb > 0.0) {
                out.corners.push(a + (b - a) * (sa / (sa - sb)));
                out.borders.push(if sa > 0.0 { tag } else { border });
            }
        }
        (out.corners.len() >= 3 && polygon::area(&out.corners) > 100.0).then_some(out)
    }

    /// Both sides of a line, and the border between them.
    pub(super) fn split(&self, on: DVec2, along: DVec2, edge: Edge, borders: &mut Vec<Border>) -> Option<[Self; 2]> {
        let tag = borders.len() as u32;
        let left = self.clipped(on, along.perp(), tag)?;
        let right = self.clipped(on, -along.perp(), tag)?;
        let n = left.corners.len();
        let k = (0..n).find(|k| left.borders[*k] == tag)?;
        borders.push(Border { ends: [left.corners[k], left.corners[(k + 1) % n]], edge });
        Some([left, right])
    }
}

/// The box of least area with a side along one of the polygon's edges: its middle, its longer direction, and both sizes.
pub(super) fn oriented_box(corners: &[DVec2]) -> (DVec2, DVec2, [f64; 2]) {
    let n = corners.len();
    let mut best = (f64::MAX, DVec2::ZERO, DVec2::X, [0.0; 2]);
    for i in 0..n {
        let e = (corners[(i + 1) % n] - corners[i]).normalize();
        let (low, high) = corners.iter().fold((DVec2::MAX, DVec2::MIN), |(low, high), p| {
            let local = DVec2::new(p.dot(e), p.dot(e.perp()));
            (low.min(local), high.max(local))
        });
        let size = high - low;
        if size.x * size.y < best.0 {
            let middle = (low + high) / 2.0;
            let world = e * middle.x + e.perp() * middle.y;
            best = if size.x >= size.y {
                (size.x * size.y, world, e, [size.x, size.y])
            } else {
                (size.x * size.y, world, e.perp(), [size.y, size.x])
            };
        }
    }
    (best.1, best.2, best.3)
}

pub(super) fn lay(params: &Params, path: &SeedPath) -> Sheet {
    let mut sheet = Sheet::default();
    let mut rng = path.child("skeleton").rng();
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let axis = DVec2::new(c, s);
    let corners = polygon::rectangle(DVec2::splat(-DOMAIN_HALF_M), DVec2::splat(DOMAIN_HALF_M));
    let corners: Vec<DVec2> = corners.iter().map(|p| axis.rotate(*p)).collect();
    // The domain's own rim: never seen.
    let rim: Vec<u32> = (0..4)
        .map(|k: usize| {
            sheet.borders.push(Border { ends: [corners[k], corners[(k + 1) % 4]], edge: Edge::Furrow });
            k as u32
        })
        .collect();
    let whole = Tagged { corners, borders: rim };
    // The lane that every frame sees, and a track that leaves it on each side.
    let signed = |rng: &mut Rng, low: f64, high: f64| rng.range(low, high) * if rng.chance(0.5) { 1.0 } else { -1.0 };
    let lane = axis.perp() * signed(&mut rng, 25.0, 150.0);
    let Some(sides) = whole.split(lane, axis, Edge::Lane, &mut sheet.borders) else { return sheet };
    for (k, side) in sides.into_iter().enumerate() {
        let on = axis * signed(&mut rng, 60.0, 260.0);
        let (s, c) = libm::sincos(rng.signed() * 0.22);
        let along = axis.perp().rotate(DVec2::new(c, s));
        let halves = side.split(on, along, Edge::Track, &mut sheet.borders);
        for (h, half) in halves.into_iter().flatten().enumerate() {
            cut(params, half, 4 + 2 * k as u64 + h as u64, true, path, &mut sheet);
        }
    }
    set_yard(&mut sheet, path);
    sheet
}

/// Cuts until a block, then until a parcel.
pub(super) fn cut(params: &Params, piece: Tagged, code: u64, roads: bool, path: &SeedPath, sheet: &mut Sheet) {
    let mut rng = path.child("cut").index(code).rng();
    let area_ha = polygon::area(&piece.corners) / 1e4;
    let block_ha = rng.lognormal(24.0, 0.3);
    let roads = roads && area_ha > block_ha;
    let parcel_ha =
        (rng.lognormal(1.5, 0.42) * params.parcel_ha).clamp(0.45 * params.parcel_ha, 3.6 * params.parcel_ha);
    let (middle, long, [length, width]) = oriented_box(&piece.corners);
    let is_done = !roads && (area_ha < parcel_ha && length < 4.2 * width || area_ha < 0.42 * params.parcel_ha);
    if is_done {
        let Tagged { corners, borders } = piece;
        sheet.pieces.push(Piece { whole: corners, borders, code, convex: true, crop: None, pivot: None });
        return;
    }
    let edge = if roads {
        if area_ha > 90.0 && rng.chance(0.45) { Edge::Lane } else { Edge::Track }
    } else {
        let weights =
            if area_ha > 2.6 * params.parcel_ha { [0.74, 0.11, 0.09, 0.06] } else { [0.62, 0.07, 0.16, 0.15] };
        let [hedge, ditch, margin, furrow] = weights;
        let hedge = hedge * params.hedges.min(1.6);
        [Edge::Hedge, Edge::Ditch, Edge::Margin, Edge::Furrow][rng.weighted(&[hedge, ditch, margin, furrow])]
    };
    let irregular = rng.range(0.1, 0.3);
    // Strips: along the box rather than across it, where they stay wide enough.
    let lengthwise = !roads && length < 1.9 * width && width > 130.0 && rng.chance(0.3);
    let (across, extent) = if lengthwise { (long.perp(), width) } else { (long, length) };
    let on = middle + across * (extent * 0.5 * irregular * rng.signed());
    let (s, c) = libm::sincos(rng.signed() * irregular * 0.75);
    let along = across.perp().rotate(DVec2::new(c, s));
    let Some(halves) = piece.split(on, along, edge, &mut sheet.borders) else {
        let Tagged { corners, borders } = piece;
        sheet.pieces.push(Piece { whole: corners, borders, code, convex: true, crop: None, pivot: None });
        return;
    };
    for (h, half) in halves.into_iter().enumerate() {
        cut(params, half, 2 * code + h as u64, roads, path, sheet);
    }
}

/// Cuts a farmyard out of a parcel on a lane not far from the pivot.
fn set_yard(sheet: &mut Sheet, path: &SeedPath) {
    let front = |piece: &Piece| {
        let n = piece.whole.len();
        let on_lane = (0..n).filter(|k| sheet.borders[piece.borders[*k] as usize].edge == Edge::Lane);
        let length = |k: usize| piece.whole[k].distance(piece.whole[(k + 1) % n]);
        on_lane.max_by(|a, b| length(*a).total_cmp(&length(*b))).filter(|k| length(*k) > 105.0)
    };
    let place = |piece: &Piece, k: usize| (piece.whole[k] + piece.whole[(k + 1) % piece.whole.len()]) / 2.0;
    let best = (0..sheet.pieces.len())
        .filter_map(|i| front(&sheet.pieces[i]).map(|k| (i, k)))
        .filter(|(i, _)| polygon::area(&sheet.pieces[*i].whole) > 1.3e4)
        .min_by(|a, b| {
            let off = |&(i, k): &(usize, usize)| (place(&sheet.pieces[i], k).length() - 130.0).abs();
            off(a).total_cmp(&off(b))
        });
    let Some((i, k)) = best else { return };
    let mut rng = path.child("yard").rng();
    let piece = sheet.pieces.swap_remove(i);
    let n = piece.whole.len();
    let (a, b) = (piece.whole[k], piece.whole[(k + 1) % n]);
    let along = (b - a).normalize();
    let wide = rng.range(72.0, 88.0);
    // At the end that is nearer to the pivot.
    let on = if a.length() < b.length() { a + along * wide } else { b - along * wide };
    let outward = if a.length() < b.length() { along } else { -along };
    let whole = Tagged { corners: piece.whole, borders: piece.borders };
    let keep = |t: Tagged, code: u64, crop: Option<Crop>| Piece {
        whole: t.corners,
        borders: t.borders,
        code,
        convex: true,
        crop,
        pivot: None,
    };
    let tag = sheet.borders.len() as u32;
    let parts = whole.clipped(on, -outward, tag).zip(whole.clipped(on, outward, tag));
    let Some((near, rest)) = parts else {
        sheet.pieces.push(keep(whole, piece.code, None));
        return;
    };
    let cut_line = |t: &Tagged, tag: u32| {
        let n = t.corners.len();
        (0..n).find(|k| t.borders[*k] == tag).map(|k| [t.corners[k], t.corners[(k + 1) % n]])
    };
    if let Some(ends) = cut_line(&near, tag) {
        sheet.borders.push(Border { ends, edge: Edge::Hedge });
    }
    sheet.pieces.push(keep(rest, 2 * piece.code, None));
    let back = on + along.perp() * rng.range(66.0, 78.0);
    let tag = sheet.borders.len() as u32;
    match near.clipped(back, -along.perp(), tag).zip(near.clipped(back, along.perp(), tag)) {
        Some((yard, paddock)) => {
            if let Some(ends) = cut_line(&yard, tag) {
                sheet.borders.push(Border { ends, edge: Edge::Margin });
            }
            sheet.pieces.push(keep(yard, 4 * piece.code + 2, Some(Crop::Yard)));
            sheet.pieces.push(keep(paddock, 4 * piece.code + 3, None));
        }
        None => sheet.pieces.push(keep(near, 2 * piece.code + 1, Some(Crop::Yard))),
    }
}
