//! What stands on flat roofs and where.

use super::plan::{RoofItem, RoofItemKind};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// What to put on a roof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Furnishing {
    /// Height of the roof, m.
    pub base_m: f64,
    /// Air handlers for each 100 m^2.
    pub handlers: f64,
    /// Probability that solar panels fill part of it.
    pub panels: f64,
    /// Probability of planted beds.
    pub beds: f64,
    /// Probability of a stair head.
    pub bulkhead: f64,
}

struct Placer<'a> {
    roof: &'a [DVec2],
    obstacles: &'a [Vec<DVec2>],
    placed: Vec<Vec<DVec2>>,
    items: Vec<RoofItem>,
    base_m: f64,
}

impl Placer<'_> {
    /// Places an item unless it comes too near to the edge or to anything else.
    fn put(&mut self, kind: RoofItemKind, centre: DVec2, axis: DVec2, half: DVec2, height: f64, clear: f64) -> bool {
        let outline = polygon::oriented_rectangle(centre, axis, half + DVec2::splat(clear));
        let inside = outline.iter().all(|p| polygon::contains(self.roof, *p))
            && (0..4).all(|k| {
                let m = (outline[k] + outline[(k + 1) % 4]) * 0.5;
                polygon::contains(self.roof, m)
            });
        let free = inside
            && !self.obstacles.iter().any(|o| polygon::convex_overlap(o, &outline))
            && !self.placed.iter().any(|o| polygon::convex_overlap(o, &outline));
        if free {
            self.placed.push(outline);
            let item = RoofItem { kind, centre_m: centre, axis, half_m: half, base_m: self.base_m, height_m: height };
            self.items.push(item);
        }
        free
    }
}

/// Furniture of one flat roof. `obstacles` are convex outlines of what stands on it already.
pub fn furnish(roof: &[DVec2], obstacles: &[Vec<DVec2>], what: Furnishing, path: &SeedPath) -> Vec<RoofItem> {
    let mut rng = path.rng();
    let area = polygon::area(roof);
    let (low, high) = polygon::bounds(roof);
    let mut placer = Placer { roof, obstacles, placed: Vec::new(), items: Vec::new(), base_m: what.base_m };
    let axis = (roof[1] - roof[0]).normalize();
    let somewhere = |rng: &mut Rng| DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
    if rng.chance(what.bulkhead) {
        for _ in 0..12 {
            let half = DVec2::new(rng.range(1.4, 2.6), rng.range(1.3, 2.0));
            let (at, height) = (somewhere(&mut rng), rng.range(2.5, 3.6));
            if placer.put(RoofItemKind::Bulkhead, at, axis, half, height, 0.5) {
                break;
            }
        }
    }
    if rng.chance(what.beds) {
        for _ in 0..(4.0 + area / 60.0) as u32 {
            let half = DVec2::new(rng.range(1.0, 6.0), rng.range(0.8, 3.0));
            let (at, height) = (somewhere(&mut rng), rng.range(0.2, 0.5));
            placer.put(RoofItemKind::Bed, at, axis, half, height, 0.5);
        }
    }
    handlers(&mut placer, &mut rng, area * what.handlers / 100.0, axis, [low, high]);
    if rng.chance(what.panels) {
        panels(&mut placer, &mut rng, axis, [low, high]);
    }
    for _ in 0..(area / 400.0) as u32 {
        if rng.chance(0.35) {
            let half = DVec2::new(rng.range(0.6, 2.4), rng.range(0.5, 1.0));
            let at = somewhere(&mut rng);
            placer.put(RoofItemKind::Skylight, at, axis, half, rng.range(0.5, 0.8), 0.4);
        }
    }
    let vents = (2.0 + area / 45.0).min(30.0) as u32;
    for _ in 0..vents {
        let (r, height) = (rng.range(0.12, 0.35), rng.range(0.4, 1.1));
        let at = somewhere(&mut rng);
        placer.put(RoofItemKind::Vent, at, axis, DVec2::splat(r), height, 0.15);
    }
    placer.items
}

/// Air handlers in clusters of one to four, each cluster with a duct.
fn handlers(placer: &mut Placer<'_>, rng: &mut Rng, wanted: f64, axis: DVec2, [low, high]: [DVec2; 2]) {
    let mut left = libm::floor(wanted + rng.unit()) as i64;
    let mut tries = 0;
    while left > 0 && tries < 60 {
        tries += 1;
        let big = rng.chance(0.3);
        let half = if big {
            DVec2::new(rng.range(2.0, 3.2), rng.range(1.1, 1.5))
        } else {
            DVec2::new(rng.range(0.9, 1.6), rng.range(0.7, 1.1))
        };
        let height = if big { rng.range(1.8, 2.4) } else { rng.range(1.1, 1.7) };
        let a = if rng.chance(0.8) { axis } else { axis.perp() };
        let start = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
        let count = 1 + rng.below(4) as i64;
        for k in 0..count.min(left) {
            let at = start + a.perp() * (k as f64 * (2.0 * half.y + 1.1));
            if !placer.put(RoofItemKind::AirHandler, at, a, half, height, 0.45) {
                break;
            }
            left -= 1;
            if k == 0 && rng.chance(0.6) {
                let length = rng.range(1.5, 5.0);
                let centre = at + a * (half.x + length + 0.9);
                placer.put(RoofItemKind::Duct, centre, a, DVec2::new(length, rng.range(0.25, 0.5)), 0.7, 0.2);
            }
        }
    }
}

/// Rows of solar panels over a rectangle of the roof.
fn panels(placer: &mut Placer<'_>, rng: &mut Rng, axis: DVec2, [low, high]: [DVec2; 2]) {
    let centre = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
    let (half, pitch) = (DVec2::new(rng.range(2.5, 6.0), 0.5), rng.range(1.5, 2.0));
    let rise = 0.12 + rng.range(0.09, 0.25);
    for column in -1..=1 {
        for row in -4..=4 {
            let at =
                centre + axis * (f64::from(column) * (2.0 * half.x + 0.9)) + axis.perp() * (f64::from(row) * pitch);
            placer.put(RoofItemKind::Panels, at, axis, half, rise, 0.12);
        }
    }
}
