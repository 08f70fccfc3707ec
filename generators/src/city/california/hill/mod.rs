//! A hill suburb: streets along ridges and spurs, houses on level pads, chaparral in the ravines between them.

mod lots;
pub(super) mod skeleton;

use super::land::Land;
use super::layout::{BULB_M, Lot};
use super::lot::{self, Content, Plant, Planted};
use super::paving::Layer;
use super::streets::{GUTTER_M, disc, plain};
use super::{DETAIL_MARGIN_M, Params, RING_M, ground_slot as slot};
use crate::kit::polygon;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tiling::normal_of_slope;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Mesh, SeedPath};
use skeleton::{Crest, Hills, ROW_M, Ridge};

/// From the middle of a street to its kerb, m.
const ROADWAY_M: f64 = 4.8;
/// Half width of a fire road, m.
const TRACK_M: f64 = 1.9;
/// Spacing of the ground's posts, m: slopes have gullies.
pub(super) const POST_M: f64 = 6.0;
/// Side of a piece of slope that is planted by its own key, m.
const TILE_M: f64 = 48.0;

/// Shading normals of a ground over hills: the land's own, so that slopes are as round as the land and not as the triangles
/// between posts. Kerbs keep theirs.
pub(super) fn shade(mesh: &mut Mesh, land: &Land) {
    if land.hills().is_none() {
        return;
    }
    let normal = |p: &[f32; 3]| {
        let p = DVec2::new(f64::from(p[0]), f64::from(p[1]));
        let along = |d: DVec2| (land.height_m(p + d) - land.height_m(p - d)) / 2.0;
        normal_of_slope(DVec2::new(along(DVec2::X), along(DVec2::Y)))
    };
    mesh.normals = mesh.positions_m.par_iter().map(normal).collect();
    for t in (0..mesh.triangles.len()).filter(|t| mesh.slots[*t] == slot::KERB) {
        let [a, b, c] = mesh.corners(t);
        let n = (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3().to_array();
        for v in mesh.triangles[t] {
            mesh.normals[v as usize] = n;
        }
    }
}

/// Decides streets, lots and slopes of a land that has hills.
pub(super) fn plan(params: &Params, land: &Land, city: &SeedPath) -> Vec<(String, Content)> {
    let Some(hills) = land.hills() else { return Vec::new() };
    let (reach, detail) = (params.radius_m + RING_M, params.radius_m + DETAIL_MARGIN_M);
    let height = |p: DVec2| land.height_m(p);
    let mut parts = Vec::new();
    for ridge in &hills.ridges {
        let key = ridge.index.iter().fold(city.child("hill street"), |k, i| k.index(*i as u64));
        if let Some(content) = street(ridge, land, reach, detail, params, &key) {
            let [j, i, side] = ridge.index;
            parts.push((format!("hill/street/{j}/{i}/{side}"), content));
        }
    }
    let near: Vec<Lot> = hills
        .lots
        .iter()
        .map(|c| lots::lot(c, land, city))
        .filter(|l| polygon::centroid(&l.outline).length() < reach)
        .collect();
    let contents: Vec<Content> = near.par_iter().map(|l| lot::plan(params, l, &height)).collect();
    for (l, mut content) in near.into_iter().zip(contents) {
        if polygon::centroid(&l.outline).length() > detail + 30.0 {
            content.patches.truncate(1);
        }
        parts.push((l.name, content));
    }
    let n = libm::ceil(detail / TILE_M) as i32;
    let tiles: Vec<(i32, i32)> = (-n..n).flat_map(|j| (-n..n).map(move |i| (i, j))).collect();
    let slopes: Vec<(String, Content)> = tiles
        .into_par_iter()
        .map(|(i, j)| {
            let key = city.child("slope").index(i as u64).index(j as u64);
            (
                format!("hill/slope/{i}/{j}"),
                slope(hills, land, DVec2::new(f64::from(i), f64::from(j)) * TILE_M, params, &key),
            )
        })
        .collect();
    parts.extend(slopes);
    parts
}

/// The strip along some points of a ridge, to a distance on both sides. Strips one after another share their ends.
fn ribbon(points: &[DVec3], range: core::ops::RangeInclusive<usize>, half_m: f64) -> Vec<DVec2> {
    let n = points.len();
    let side = |sign: f64| {
        range.clone().map(move |k| {
            let along = (points[(k + 1).min(n - 1)] - points[k.max(1) - 1]).truncate().normalize();
            points[k].truncate() + along.perp() * (sign * half_m)
        })
    };
    side(-1.0).chain(side(1.0).rev()).collect()
}

/// A street or fire road in pieces, those that come within reach.
fn street(ridge: &Ridge, land: &Land, reach: f64, detail: f64, params: &Params, key: &SeedPath) -> Option<Content> {
    let mut out = Content::default();
    let mut rng = key.rng();
    let world = |flat: &[DVec2]| -> Vec<DVec2> { flat.iter().map(|p| land.world(*p)).collect() };
    let asphalt = slot::ASPHALT + rng.below(u64::from(slot::ASPHALTS)) as u16;
    let bands = [
        (Layer::Walk, ROADWAY_M + 1.6, slot::SIDEWALK, false),
        (Layer::Gutter, ROADWAY_M, slot::GUTTER, true),
        (Layer::Local, ROADWAY_M - GUTTER_M, asphalt, true),
    ];
    let wild = ridge.crest == Crest::Wild;
    let last = ridge.points.len() - 1;
    let lay = |out: &mut Content, (layer, half_m, slot, lowered): (Layer, f64, u16, bool), first: usize| {
        // Bands begin and end at different points: ends on one line would meet in needless corners.
        let starts = core::iter::once(0).chain((first..last).step_by(4)).filter(|k| *k < last);
        let mut starts: Vec<usize> = starts.collect();
        starts.dedup();
        for (n, from) in starts.iter().enumerate() {
            let to = starts.get(n + 1).copied().unwrap_or(last);
            if land.world(ridge.points[(from + to) / 2].truncate()).length() < reach + 60.0 {
                let outline = world(&ribbon(&ridge.points, *from..=to, half_m));
                out.patches.push(plain(layer, outline, slot, lowered));
            }
        }
    };
    if wild {
        // A fire road keeps to its ridge: on a spur it would lead nowhere.
        if ridge.index[2] != 0 {
            return None;
        }
        lay(&mut out, (Layer::Drive, TRACK_M, slot::TRACK, false), 4);
    } else {
        for (band, first) in bands.into_iter().zip([4, 1, 2]) {
            lay(&mut out, band, first);
        }
    }
    for piece in (0..last).step_by(4).filter(|_| !wild) {
        let points = &ridge.points[piece..=(piece + 4).min(last)];
        let middle = land.world(points[points.len() / 2].truncate());
        let mut rng = key.child("piece").index(piece as u64).rng();
        if middle.length() < detail {
            let (a, b) = (points[0].truncate(), points[1].truncate());
            let (wa, wb) = (land.world(a), land.world(b));
            let along = (wb - wa).normalize();
            let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
            out.lights.push((wa + along.perp() * (side * (ROADWAY_M + 0.5)), -along.perp() * side));
            if rng.chance(0.12 * params.vehicles) {
                let body = crate::city::toronto::traffic::draw_body(&mut rng, false);
                let way = if rng.chance(0.5) { 1.0 } else { -1.0 };
                let centre = wa - along.perp() * (1.9 * way);
                out.vehicles.push(lot::Parked { centre, axis: along * way, body, lowered: true });
            }
        }
    }
    if ridge.crest == Crest::Spur && !out.patches.is_empty() {
        let n = ridge.points.len();
        let (from, end) = (ridge.points[0].truncate(), ridge.points[n - 1].truncate());
        let along = (ridge.points[1].truncate() - from).normalize();
        let across = along.perp();
        for ((layer, half_m, slot, lowered), add) in bands.into_iter().zip([1.6, 0.0, -GUTTER_M]) {
            out.patches.push(plain(layer, world(&disc(end, BULB_M + add)), slot, lowered));
            // The mouth widens towards the larger street.
            let (near, far, wide) = (ROADWAY_M - GUTTER_M, ROADWAY_M + 8.0 + add, half_m + 7.0);
            // It ends inside the spur's own strip.
            let narrow = half_m - 0.4;
            let quad = [
                from + along * near - across * wide,
                from + along * far - across * narrow,
                from + along * far + across * narrow,
                from + along * near + across * wide,
            ];
            out.patches.push(plain(layer, world(&quad), slot, lowered));
        }
    }
    (!out.patches.is_empty()).then_some(out)
}

/// What grows on one tile of open slope: chaparral, denser in ravines and where the sun is weaker; oaks in the ravines,
/// eucalyptus in groups.
fn slope(hills: &Hills, land: &Land, corner: DVec2, params: &Params, key: &SeedPath) -> Content {
    let mut out = Content::default();
    let mut rng = key.rng();
    let seed = hills.cover_seed;
    let attempts = libm::floor(TILE_M * TILE_M * 0.24 * params.trees + rng.unit()) as u32;
    for _ in 0..attempts {
        let at = corner + DVec2::new(rng.unit(), rng.unit()) * TILE_M;
        let (draw, size, tall) = (rng.unit(), rng.range(0.75, 1.0), rng.unit());
        let flat = land.turned_back(at);
        if hills.street(flat).0 < ROW_M + 2.5 || hills.near_pad(flat, 2.2) {
            continue;
        }
        let here = land.height_m(at);
        let north = (here - land.height_m(at + DVec2::new(0.0, 6.0))) / 6.0;
        let low = smoothstep(4.0, 32.0, hills.crest_m(flat) - here);
        // Thickets with ragged borders, each of few gaps, and singles far between on dry ground.
        let patch = fractal(flat, seed, 46.0, 3, 0.5) + 0.45 * fractal(flat, seed ^ 0x77, 9.0, 2, 0.5);
        let dense = smoothstep(-0.2, 0.5, 0.08 + 0.35 * low + 0.55 * north + 0.8 * patch);
        if draw > 0.02 + 0.8 * dense {
            continue;
        }
        let grove = fractal(flat, seed ^ 0x51, 90.0, 2, 0.5);
        let plant = if low > 0.8 && tall < 0.03 + 0.05 * low {
            Planted { at, plant: Plant::Broad, size: 0.9 + 0.7 * size }
        } else if grove > 0.3 && tall < 0.045 {
            Planted { at, plant: Plant::Upright, size: 1.1 + 0.6 * size }
        } else {
            // Many low ones, few high ones; higher where they stand close.
            let spread = 0.45 + 0.8 * tall * tall + 0.5 * dense * tall;
            Planted { at, plant: Plant::Chaparral, size: 1.5 * size * spread }
        };
        out.plants.push(plant);
    }
    out
}

#[cfg(test)]
mod tests;
