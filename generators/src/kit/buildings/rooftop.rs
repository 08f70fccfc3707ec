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
    /// Machines for each 100 m^2, over many roofs.
    pub machines: f64,
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
    let within = [low, high];
    if rng.chance(what.bulkhead) {
        for _ in 0..12 {
            let half = DVec2::new(rng.range(1.4, 2.6), rng.range(1.3, 2.0));
            let (at, height) = (somewhere(&mut rng, within), rng.range(2.5, 3.6));
            if placer.put(RoofItemKind::Bulkhead, at, axis, half, height, 0.5) {
                break;
            }
        }
    }
    if rng.chance(what.beds) {
        for _ in 0..(4.0 + area / 60.0) as u32 {
            let half = DVec2::new(rng.range(1.0, 6.0), rng.range(0.8, 3.0));
            let (at, height) = (somewhere(&mut rng, within), rng.range(0.2, 0.5));
            placer.put(RoofItemKind::Bed, at, axis, half, height, 0.5);
        }
    }
    machines(&mut placer, &mut rng, area * what.machines / 100.0, axis, within);
    if rng.chance(what.panels) {
        panels(&mut placer, &mut rng, axis, within);
    }
    for _ in 0..(area / 400.0) as u32 {
        if rng.chance(0.35) {
            let half = DVec2::new(rng.range(0.6, 2.4), rng.range(0.5, 1.0));
            let at = somewhere(&mut rng, within);
            placer.put(RoofItemKind::Skylight, at, axis, half, rng.range(0.5, 0.8), 0.4);
        }
    }
    let vents = (2.0 + area / 45.0).min(30.0) as u32;
    for _ in 0..vents {
        let (r, height) = (rng.range(0.12, 0.35), rng.range(0.4, 1.1));
        let at = somewhere(&mut rng, within);
        placer.put(RoofItemKind::Vent, at, axis, DVec2::splat(r), height, 0.15);
    }
    placer.items
}

/// A model of machine: what, half sizes and height, m.
type Model = (RoofItemKind, DVec2, f64);

/// Air handlers and condensers of many makers.
fn model(rng: &mut Rng) -> Model {
    let k = rng.range(0.9, 1.15);
    match rng.below(6) {
        0 => (RoofItemKind::AirHandler, DVec2::new(rng.range(2.0, 3.6), rng.range(0.9, 1.3)) * k, rng.range(1.5, 2.3)),
        1 => (RoofItemKind::AirHandler, DVec2::new(rng.range(1.3, 1.9), rng.range(0.9, 1.2)) * k, rng.range(1.2, 1.7)),
        2 => (RoofItemKind::AirHandler, DVec2::new(0.95, 0.75) * k, rng.range(0.9, 1.2)),
        3 => (RoofItemKind::Condenser, DVec2::new(rng.range(1.5, 2.2), 0.95) * k, rng.range(1.3, 1.9)),
        4 => (RoofItemKind::Condenser, DVec2::new(2.9, 1.05) * k, rng.range(1.6, 2.2)),
        _ => (RoofItemKind::Condenser, DVec2::splat(0.85) * k, rng.range(1.0, 1.5)),
    }
}

/// What cools and airs the house, by its own programme: nearly nothing, packaged machines of one or two models in clusters,
/// small condensers in rows, or a plant behind a screen. `wanted` is the mean number of machines over all of them.
fn machines(placer: &mut Placer<'_>, rng: &mut Rng, wanted: f64, axis: DVec2, within: [DVec2; 2]) {
    if wanted <= 0.0 {
        return;
    }
    let models = [model(rng), model(rng)];
    let axis = if rng.chance(0.8) { axis } else { axis.perp() };
    let (programme, plant) = (rng.unit(), wanted > 2.5 && rng.chance(0.3));
    if plant && screened(placer, rng, axis, within) {
        clusters(placer, rng, wanted * 0.35, models, axis, within);
    } else if programme < 0.27 {
        clusters(placer, rng, (wanted * 0.15).min(2.0), models, axis, within);
    } else if programme < 0.5 {
        condensers(placer, rng, wanted * 1.8, axis, within);
    } else {
        clusters(placer, rng, wanted * 1.5, models, axis, within);
    }
    if rng.chance(0.45) {
        let along = if rng.chance(0.5) { axis } else { axis.perp() };
        let half = DVec2::new(rng.range(2.5, 8.0), rng.range(0.12, 0.3));
        let at = somewhere(rng, within);
        placer.put(RoofItemKind::Duct, at, along, half, rng.range(0.3, 0.5), 0.15);
    }
}

fn somewhere(rng: &mut Rng, [low, high]: [DVec2; 2]) -> DVec2 {
    DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y))
}

/// Machines in clusters of one to five of one model, many with a duct.
fn clusters(placer: &mut Placer<'_>, rng: &mut Rng, wanted: f64, models: [Model; 2], axis: DVec2, within: [DVec2; 2]) {
    let mut left = libm::floor(wanted + rng.unit()) as i64;
    let mut tries = 0;
    while left > 0 && tries < 60 {
        tries += 1;
        let (kind, half, height) = models[usize::from(rng.chance(0.3))];
        let start = somewhere(rng, within);
        let (count, gap_m) = (1 + rng.below(5) as i64, rng.range(0.8, 2.2));
        for k in 0..count.min(left) {
            let at = start + axis.perp() * (k as f64 * (2.0 * half.y + gap_m));
            if !placer.put(kind, at, axis, half, height, 0.45) {
                break;
            }
            left -= 1;
            if rng.chance(if k == 0 { 0.5 } else { 0.12 }) {
                let length = rng.range(1.2, 4.0);
                let centre = at + axis * (half.x + length + 0.9);
                placer.put(RoofItemKind::Duct, centre, axis, DVec2::new(length, rng.range(0.25, 0.5)), 0.7, 0.2);
            }
        }
    }
}

/// One or two rows of small condensers, one for each flat or shop.
fn condensers(placer: &mut Placer<'_>, rng: &mut Rng, wanted: f64, axis: DVec2, within: [DVec2; 2]) {
    let (half, height, pitch_m) = (rng.range(0.38, 0.55), rng.range(0.7, 1.1), rng.range(1.5, 2.4));
    let mut left = libm::floor(wanted + rng.unit()).max(2.0) as i64;
    for _ in 0..40 {
        let start = somewhere(rng, within);
        let count = left.min(3 + rng.below(8) as i64);
        for k in 0..count {
            let at = start + axis * (k as f64 * pitch_m);
            if !placer.put(RoofItemKind::Condenser, at, axis, DVec2::splat(half), height, 0.2) {
                break;
            }
            left -= 1;
        }
        if left <= 0 {
            break;
        }
    }
}

/// A plant behind a screen: cooling towers in a row, air handlers beside them. Whether there was room for it.
fn screened(placer: &mut Placer<'_>, rng: &mut Rng, axis: DVec2, within: [DVec2; 2]) -> bool {
    let tower = DVec2::splat(rng.range(1.3, 2.1));
    let (count, handlers) = (1 + rng.below(4) as i32, rng.below(3) as i32);
    let handler = DVec2::new(tower.y, rng.range(0.8, 1.1));
    let tall_m = rng.range(2.6, 3.8);
    // Along the screen: towers, then handlers, with a way around each.
    let pitch_m = 2.0 * tower.x + 0.7;
    let handler_pitch_m = 2.0 * handler.y + 1.0;
    let long_m = f64::from(count) * pitch_m + f64::from(handlers) * handler_pitch_m + 1.6;
    let half = DVec2::new(long_m / 2.0, tower.y + rng.range(1.3, 2.4));
    for _ in 0..24 {
        let at = somewhere(rng, within);
        if !placer.put(RoofItemKind::Screen, at, axis, half, tall_m * rng.range(0.75, 1.0), 0.8) {
            continue;
        }
        let base_m = placer.base_m;
        let mut inside = |x: f64, kind: RoofItemKind, turned: DVec2, half_m: DVec2, height_m: f64| {
            let centre_m = at + axis * x;
            placer.items.push(RoofItem { kind, centre_m, axis: turned, half_m, base_m, height_m });
        };
        let mut x = 0.8 - half.x;
        for _ in 0..count {
            inside(x + pitch_m / 2.0, RoofItemKind::CoolingTower, axis, tower, tall_m);
            x += pitch_m;
        }
        for _ in 0..handlers {
            inside(x + handler_pitch_m / 2.0, RoofItemKind::AirHandler, axis.perp(), handler, 0.5 * tall_m);
            x += handler_pitch_m;
        }
        return true;
    }
    false
}

/// Rows of solar panels over a rectangle of the roof.
fn panels(placer: &mut Placer<'_>, rng: &mut Rng, axis: DVec2, within: [DVec2; 2]) {
    let centre = somewhere(rng, within);
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
