//! Open ground of a block: courts, parking lots, gardens.

use super::{BlockPlan, Stall};
use crate::city::toronto::ground_slot;
use crate::city::toronto::massing::Frame;
use crate::kit::ground::Patch;
use crate::kit::parcels::Site;
use crate::kit::polygon;
use crate::kit::streets::Block;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Covers a site.
pub(super) fn ground(site: &Site, slot: u16, out: &mut BlockPlan) {
    if let Some(outline) = polygon::inset(&site.outline, 0.12).filter(|o| polygon::area(o) > 4.0) {
        // Corners closer than quantising tolerates would cross.
        let short = (0..outline.len()).any(|i| outline[i].distance(outline[(i + 1) % outline.len()]) < 0.05);
        if !short {
            out.patches.push(Patch { origin_m: outline[0], outline, slot, axis: site.axis(), lowered: false });
        }
    }
}

/// Trees in what a building leaves of its site.
pub(super) fn court(site: &Site, path: &SeedPath, out: &mut BlockPlan) {
    let mut rng = path.child("court").rng();
    let (low, high) = polygon::bounds(&site.outline);
    for _ in 0..22 {
        let p = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
        if polygon::contains(&site.outline, p) && polygon::border_distance(&site.outline, p) > 1.5 && rng.chance(0.5) {
            out.trees.push(p);
        }
    }
}

/// Trees strewn over a site, about one to a square of `spacing` metres.
pub(in crate::city::toronto) fn scatter(site: &Site, spacing: f64, path: &SeedPath, out: &mut BlockPlan) {
    let mut rng = path.child("scatter").rng();
    let (low, high) = polygon::bounds(&site.outline);
    let n = (polygon::area(&site.outline) / (spacing * spacing)) as u32;
    for _ in 0..n {
        let p = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
        if polygon::contains(&site.outline, p) && polygon::border_distance(&site.outline, p) > 2.0 {
            out.trees.push(p);
        }
    }
}

/// A parking lot: stalls 2.6 x 5.5 m in double rows with aisles of 6.5 m, tree islands at the ends.
pub(in crate::city::toronto) fn parking(site: &Site, frame: &Frame, path: &SeedPath, out: &mut BlockPlan) {
    let Some(outline) = polygon::inset(&site.outline, 0.9).filter(|o| polygon::area(o) > 60.0) else {
        ground(site, ground_slot::PAVING_DARK, out);
        return;
    };
    ground(site, ground_slot::YARD, out);
    let local: Vec<DVec2> = outline.iter().map(|p| frame.local(*p)).collect();
    let (low, high) = polygon::bounds(&local);
    let origin = DVec2::new(low.x, low.y + 5.5);
    out.patches.push(Patch {
        origin_m: frame.world(origin),
        outline,
        slot: ground_slot::PARKING,
        axis: frame.axis,
        lowered: false,
    });
    let mut rng = path.child("stalls").rng();
    let occupancy = rng.range(0.3, 0.8);
    let mut y = origin.y - 2.75;
    let mut row = 0;
    while y < high.y - 2.5 {
        let mut x = low.x + 1.3;
        while x < high.x - 1.0 {
            let p = DVec2::new(x + rng.signed() * 0.15, y + rng.signed() * 0.3);
            let corners = polygon::oriented_rectangle(p, DVec2::X, DVec2::new(1.4, 2.9));
            if corners.iter().all(|c| polygon::contains(&local, *c)) && rng.chance(occupancy) {
                let way = if rng.chance(0.7) { 1.0 } else { -1.0 } * if row % 2 == 0 { 1.0 } else { -1.0 };
                out.stalls.push(Stall { centre: frame.world(p), axis: frame.axis.perp() * way });
            }
            x += 2.6;
        }
        y += if row % 2 == 0 { 5.5 } else { 12.0 };
        // Rows come in pairs back to back, the first pair's first row lies along the street.
        row += 1;
    }
}

/// A public garden: lawn, crossing paths, trees.
pub(super) fn park(block: &Block, path: &SeedPath, out: &mut BlockPlan) {
    let mut rng = path.child("park").rng();
    let q = &block.property;
    let c = polygon::centroid(q);
    let Some(inner) = polygon::inset(q, 3.0) else { return };
    // A diagonal path and a round place in the middle.
    let (a, b) = (inner[0], inner[2]);
    let along = (b - a).normalize();
    let place: Vec<DVec2> = (0..14)
        .map(|k| {
            let (s, co) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 14.0);
            c + DVec2::new(co, s) * rng.range(9.0, 9.4)
        })
        .collect();
    for side in [-1.0, 1.0] {
        let from = c + along * (side * 10.5);
        let to = c + along * (side * (a.distance(b) / 2.0 - 8.0));
        let mid = (from + to) * 0.5;
        let outline = polygon::oriented_rectangle(mid, along, DVec2::new(from.distance(to) / 2.0, 1.6));
        if outline.iter().all(|p| polygon::contains(&inner, *p)) {
            out.patches.push(Patch { origin_m: mid, outline, slot: ground_slot::PATH, axis: along, lowered: false });
        }
    }
    out.patches.push(Patch {
        origin_m: c,
        outline: place.clone(),
        slot: ground_slot::PLAZA,
        axis: along,
        lowered: false,
    });
    let (low, high) = polygon::bounds(&inner);
    let mut trees: Vec<DVec2> = Vec::new();
    for _ in 0..(polygon::area(q) / 70.0) as u32 {
        let p = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
        let clear_of_path = along.perp_dot(p - c).abs() > 3.0 && p.distance(c) > 11.0;
        if polygon::contains(&inner, p) && clear_of_path && trees.iter().all(|t| t.distance(p) > 5.0) {
            trees.push(p);
        }
    }
    out.trees.append(&mut trees);
}
