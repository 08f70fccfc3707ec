//! A block of downtown: towers, parking structures and lots over the block's whole depth, the rest in two rows of sites.
//!
//! Where towers stand is drawn from points on a lattice of the world, one to each 2.4 hectares and each pushed about in its
//! cell: every frame has about as many, and a block has as many as points fall into it and its half of the streets.

use super::grid::CityBlock;
use super::site::{Place, Work, corners, wide_enough};
use super::{Use, garage, ground, open, tower};
use crate::city::california::Params;
use crate::city::california::lot::Content;
use crate::city::california::paving::Layer;
use crate::city::toronto::ground_slot as slot;
use crate::city::toronto::massing::{self, Relief};
use crate::kit::parcels::{Site, subdivide};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Side of the towers' lattice, m.
const LATTICE_M: f64 = 156.0;

/// Least and greatest height of a tower's roof, m, before its penthouse.
const TOWER_M: [f64; 2] = [82.0, 200.0];

/// The points of the lattice in an outline.
fn points(city: &SeedPath, outline: &[DVec2]) -> Vec<DVec2> {
    let (low, high) = polygon::bounds(outline);
    let start = {
        let mut rng = city.child("towers").rng();
        DVec2::new(rng.unit(), rng.unit())
    };
    let cell = |p: DVec2| (p / LATTICE_M - start).floor();
    let (a, b) = (cell(low), cell(high));
    let mut out = Vec::new();
    for j in b.y.min(a.y) as i64 - 1..=b.y as i64 + 1 {
        for i in a.x as i64 - 1..=b.x as i64 + 1 {
            let mut rng = city.child("tower").index(i as u64).index(j as u64).rng();
            let at = DVec2::new(i as f64 + 0.5 + 0.3 * rng.signed(), j as f64 + 0.5 + 0.3 * rng.signed());
            let p = (at + start) * LATTICE_M;
            if polygon::contains(outline, p) {
                out.push(p);
            }
        }
    }
    out
}

/// Height of a tower: they are highest around a middle that lies near the pivot.
fn height_m(city: &SeedPath, at: DVec2, key: &SeedPath) -> f64 {
    let mut rng = city.child("skyline").rng();
    let middle = DVec2::new(rng.signed(), rng.signed()) * 130.0;
    let near = libm::exp(-(at - middle).length_squared() / (260.0 * 260.0));
    let u = key.child("height").rng().unit();
    TOWER_M[0] + (TOWER_M[1] - TOWER_M[0]) * libm::pow(u, 1.25) * (0.45 + 0.55 * near)
}

/// What takes the whole depth of a block.
#[derive(Clone, Copy, PartialEq)]
enum Deep {
    Tower(DVec2),
    Garage,
    Lot,
    Park,
    Rest,
}

/// Decides a block.
pub(super) fn plan(params: &Params, block: &CityBlock, relief: &Relief<'_>, city: &SeedPath) -> Content {
    let mut work = Work { params, relief, out: Content::default(), taken: Vec::new() };
    let axis = (block.kerb[1] - block.kerb[0]).normalize();
    work.cover(Layer::Yard, polygon::rounded(&block.kerb, 6.0, 5), ground::of(slot::SIDEWALK), axis);
    if let Some(inner) = polygon::inset(&block.property, 0.06) {
        work.cover(Layer::Yard, inner, ground::of(slot::PAVING), axis);
    }
    let towers = points(city, &polygon::mitred(&block.kerb, -7.0));
    if block.property.len() != 4 || (block.irregular && polygon::area(&block.property) < 6500.0) {
        wedge(&mut work, block);
        return work.out;
    }
    let mut q = block.property.clone();
    if q[1].distance(q[2]) > q[0].distance(q[1]) {
        q.rotate_left(1);
    }
    let along = (q[1] - q[0]).normalize();
    let length = q[0].distance(q[1]).min(q[2].distance(q[3]));
    let mut rng = block.key.child("depth").rng();
    let mut pieces: Vec<(Deep, f64)> = Vec::new();
    for p in &towers {
        pieces.push((Deep::Tower(*p), rng.range(50.0, 66.0)));
    }
    if pieces.is_empty() && rng.chance(0.16) {
        pieces.push((Deep::Park, length));
    }
    if rng.chance(0.36) {
        pieces.push((Deep::Garage, rng.range(37.6, 40.0)));
    }
    if rng.chance(0.34) {
        pieces.push((Deep::Lot, rng.range(28.0, 60.0)));
    }
    while pieces.iter().map(|p| p.1).sum::<f64>() > length && pieces.len() > 1 {
        pieces.pop();
    }
    let left = length - pieces.iter().map(|p| p.1).sum::<f64>();
    if left > 24.0 {
        pieces.push((Deep::Rest, left));
    } else if let Some(first) = pieces.first_mut() {
        first.1 += left;
    }
    rng.shuffle(&mut pieces);
    let mut rest = Some(q.clone());
    let mut s = 0.0;
    let mut first_index = 0;
    for (k, (deep, width)) in pieces.iter().enumerate() {
        s += width;
        let Some(whole) = rest.take() else { break };
        let on = q[0] + along * s;
        let piece = if k + 1 == pieces.len() {
            Some(whole)
        } else {
            rest = polygon::clip(&whole, on, along);
            polygon::clip(&whole, on, -along)
        };
        let Some(piece) = piece.filter(|p| p.len() == 4) else { continue };
        if *deep == Deep::Rest {
            rows(&mut work, block, &piece, &mut first_index);
        } else {
            let site = deep_site(piece, &block.property, along, 90 + k as u64);
            deep_use(&mut work, block, &site, *deep, city);
        }
    }
    work.out
}

/// A site over a block's whole depth.
fn deep_site(outline: Vec<DVec2>, block: &[DVec2], along: DVec2, index: u64) -> Site {
    let n = outline.len();
    let middle = |i: usize| (outline[i] + outline[(i + 1) % n]) * 0.5;
    let on_street: Vec<bool> = (0..n).map(|i| polygon::border_distance(block, middle(i)) < 0.05).collect();
    let facing = |i: usize| (outline[(i + 1) % n] - outline[i]).dot(along);
    let front = (0..n).max_by(|a, b| facing(*a).total_cmp(&facing(*b))).unwrap_or(0);
    Site { outline, front, on_street, index }
}

fn deep_use(work: &mut Work<'_>, block: &CityBlock, site: &Site, deep: Deep, city: &SeedPath) {
    let place = Place::new(site, &block.name, &block.key);
    let mut rng = place.key.child("deep").rng();
    let Some(r) = place.rect(1.0, 0.5, 0.5) else {
        work.floor(&place, ground::of(slot::PAVING_DARK));
        return;
    };
    // Density is the share of sites that are built on.
    let built = rng.unit() < work.params.density;
    match deep {
        Deep::Tower(p) if built => {
            let height = height_m(city, p, &place.key);
            let office = rng.chance(0.62);
            // Dwellings reach 45 storeys.
            let stands = (office && tower::office(work, &place, height))
                || tower::residence(work, &place, height.min(158.0))
                || tower::office(work, &place, height);
            if !stands {
                open::lot(work, &place, r);
            }
        }
        Deep::Garage if built => {
            work.floor(&place, ground::of(slot::PAVING_DARK));
            if !garage::garage(work, &place) {
                open::lot(work, &place, r);
            }
        }
        Deep::Park => {
            work.floor(&place, ground::of(slot::PAVING));
            if rng.chance(0.6) {
                open::park(work, &place, r, &mut rng);
            } else {
                open::square(work, &place, r, &mut rng);
            }
        }
        _ => open::lot(work, &place, r),
    }
}

/// Two rows of sites back to back, with an alley between them or none.
fn rows(work: &mut Work<'_>, block: &CityBlock, piece: &[DVec2], first_index: &mut u64) {
    let mut rng = block.key.child("alley").rng();
    let alley_m = if rng.chance(0.6) { 6.0 } else { 0.0 };
    let widths = *rng.pick(&[[14.0, 30.0], [20.0, 42.0], [28.0, 50.0]]);
    let cut = subdivide(piece, alley_m, &block.key.child("rows"), |p| p.rng().range(widths[0], widths[1]));
    if let Some(lane) = cut.lane.and_then(|l| polygon::inset(&l, 0.12)) {
        let axis = (piece[1] - piece[0]).normalize();
        work.cover(Layer::Front, lane, ground::of(slot::LANE), axis);
    }
    for mut site in cut.sites {
        // Only the block's own borders are streets.
        let n = site.outline.len();
        for i in 0..n {
            let middle = (site.outline[i] + site.outline[(i + 1) % n]) * 0.5;
            site.on_street[i] = polygon::border_distance(&block.property, middle) < 0.05;
        }
        site.index = *first_index;
        *first_index += 1;
        small(work, &Place::new(&site, &block.name, &block.key));
    }
}

/// A site of a row.
fn small(work: &mut Work<'_>, place: &Place<'_>) {
    let mut rng = place.key.child("use").rng();
    let relief = work.relief;
    let d = work.params.density;
    let usage = rng.weighted(&[0.46 * d, 0.27 * d, 0.17, 0.05, 0.05]);
    let building = match usage {
        0 => massing::mid_rise(place.site, relief, &place.key),
        1 => massing::shop(place.site, relief, &place.key),
        _ => None,
    };
    if let Some(plan) = building.and_then(wide_enough) {
        work.floor(
            place,
            *rng.pick(&[ground::of(slot::PAVING_DARK), ground::YARDS[0], ground::YARDS[2], ground::of(slot::PAVING)]),
        );
        let usage = if usage == 0 { Use::Block } else { Use::Store };
        work.adopt(place, usage, plan);
        if let Some(r) = place.rect(0.5, 1.5, 1.0) {
            work.strew(&place.frame, r, 0.5, [0.5, 0.2, 0.3], &mut rng);
        }
        return;
    }
    let Some(r) = place.rect(0.8, 0.5, 0.5) else {
        work.floor(place, ground::of(slot::PAVING_DARK));
        return;
    };
    match usage {
        3 => {
            work.floor(place, ground::of(slot::PAVING));
            open::square(work, place, r, &mut rng);
        }
        4 => open::cleared(work, place, r),
        _ => open::lot(work, place, r),
    }
}

/// A block that a diagonal cut: one building over its larger part, a square in what is left.
fn wedge(work: &mut Work<'_>, block: &CityBlock) {
    let mut rng = block.key.child("wedge").rng();
    let n = block.property.len();
    let front = (0..n)
        .max_by(|a, b| {
            let side = |i: usize| block.property[i].distance(block.property[(i + 1) % n]);
            side(*a).total_cmp(&side(*b))
        })
        .unwrap_or(0);
    let site = Site { outline: block.property.clone(), front, on_street: vec![true; n], index: 80 };
    let place = Place::new(&site, &block.name, &block.key);
    work.floor(&place, *rng.pick(&ground::SQUARES));
    super::store::flatiron(work, &place, &mut rng);
    let local: Vec<DVec2> = polygon::inset(&block.property, 1.0)
        .unwrap_or_else(|| block.property.clone())
        .iter()
        .map(|p| place.frame.local(*p))
        .collect();
    if let Some(r) = super::site::inscribed(&local) {
        work.strew(&place.frame, r, 0.8, [0.4, 0.4, 0.2], &mut rng);
        debug_assert!(polygon::area(&corners(r)) > 0.0);
    }
}
