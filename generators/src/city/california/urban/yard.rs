//! Workshops and warehouses with their yards: trucks, containers, fences.

use super::fittings::block;
use super::site::{Draft, GROUNDED, Place, Rect, Work, corners, plain};
use super::store::skylights;
use super::{Use, ground, part};
use crate::city::california::house::Extra;
use crate::city::california::lot::Fence;
use crate::kit::buildings::{Furnishing, slot};
use crate::kit::polygon;
use crate::kit::vehicles::Body;
use glam::DVec2;
use satseed_scene::Rng;

/// A hall of tilted-up concrete or sheet metal, and its yard.
pub(super) fn works(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("works").rng();
    let Some(r) = place.rect(rng.range(0.6, 3.0), 0.25, 0.4) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 11.0 || deep < 16.0 {
        return false;
    }
    let along = wide > 24.0 && rng.chance(0.45);
    let share = rng.range(0.52, 0.84);
    // The yard lies behind the hall, or beside it.
    let (hall, open): (Rect, Rect) = if along {
        let x = r[0] + wide * share;
        ([r[0], x, r[2], r[3]], [x + 0.5, r[1], r[2], r[3]])
    } else {
        let y = r[2] + deep * share;
        ([r[0], r[1], r[2], y], [r[0], r[1], y + 0.5, r[3]])
    };
    let roof_m = rng.range(5.2, 9.5);
    let mut draft = Draft::new(Use::Works, vec![plain(corners(hall), GROUNDED, roof_m, rng.range(0.3, 0.9))]);
    if rng.chance(0.4) {
        // An office at the front corner.
        let w = rng.range(6.0, 9.0).min(wide * 0.5);
        let office = [hall[0] - 0.04, hall[0] + w, hall[2] - 0.3, hall[2] + rng.range(5.0, 8.0)];
        draft.masses.push(plain(corners(office), GROUNDED, (roof_m - rng.range(0.8, 2.2)).max(3.6), 0.5));
    }
    if rng.chance(0.6) {
        skylights(&mut draft, 0, DVec2::new(rng.range(5.5, 9.0), rng.range(5.0, 8.0)), DVec2::new(1.3, 0.5));
    }
    let over: Vec<Vec<DVec2>> = draft
        .items
        .iter()
        .map(|i| polygon::oriented_rectangle(i.centre_m, i.axis, i.half_m + DVec2::splat(0.4)))
        .collect();
    let what = Furnishing { base_m: 0.0, machines: 0.22, panels: 0.12, beds: 0.0, bulkhead: 0.0 };
    draft.furnish(0, what, &over, &place.key);
    let doors = libm::floor((hall[1] - hall[0]) / 7.0).max(1.0) as u32;
    for k in 0..doors {
        let x = hall[0] + (hall[1] - hall[0]) * (f64::from(k) + 0.5) / f64::from(doors);
        if !along {
            let centre = DVec2::new(x, hall[3]);
            draft.extras.push(Extra::Door { centre, along: DVec2::X, width_m: 3.4, height_m: 3.8 });
        }
    }
    work.floor(place, ground::YARDS[rng.weighted(&[0.3, 0.25, 0.25, 0.2])]);
    containers(&mut draft, open, &mut rng);
    work.build(place, "hall", draft);
    trucks(work, place, open, &mut rng);
    // A fence closes the yard towards the street.
    if along && place.site.on_street[place.site.front] {
        let p = |x: f64, y: f64| place.frame.world(DVec2::new(x, y));
        let gate = open[0] + (open[1] - open[0]) * 0.5;
        for [a, b] in [[open[0], gate - 3.0], [gate + 3.0, open[1]]] {
            if b - a > 1.0 {
                let (from, to) = (p(a, open[2] + 0.1), p(b, open[2] + 0.1));
                work.out.fences.push(Fence { from, to, height_m: 2.1, block: rng.chance(0.5) });
            }
        }
    }
    true
}

/// Containers and stacks along one border of a yard.
fn containers(draft: &mut Draft, open: Rect, rng: &mut Rng) {
    if !rng.chance(0.5) {
        return;
    }
    let mut x = open[0] + 0.4;
    let long = open[3] - open[2] > 15.0 && rng.chance(0.5);
    let length = if long { 12.2 } else { 6.1 };
    while x + 2.5 < open[1] - 0.4 && open[3] - open[2] > length + 1.0 {
        if rng.chance(0.55) {
            let y = open[3] - length - rng.range(0.2, 0.9);
            let high = if rng.chance(0.2) { 5.2 } else { 2.6 };
            let paint = *rng.pick(&[part::STEEL, part::STEEL, slot::METAL, part::CANOPY]);
            draft.extras.push(Extra::Fitting(block([x, x + 2.44, y, y + length], [-0.6, high], [paint; 2])));
        }
        x += 2.44 + rng.range(0.2, 2.2);
    }
    if rng.chance(0.4) {
        // Something stacked under the wall.
        let (w, d) = (rng.range(1.5, 4.0), rng.range(1.0, 2.0));
        let at = [open[0] + 0.3, open[0] + 0.3 + d, open[2] + 1.0, open[2] + 1.0 + w];
        draft.extras.push(Extra::Fitting(block(at, [-0.6, rng.range(0.8, 1.8)], [slot::METAL; 2])));
    }
}

fn trucks(work: &mut Work<'_>, place: &Place<'_>, open: Rect, rng: &mut Rng) {
    let area = (open[1] - open[0]) * (open[3] - open[2]);
    let wanted = libm::floor(area / 75.0 * rng.range(0.3, 1.1) * work.params.vehicles) as u32;
    let mut feet: Vec<Vec<DVec2>> = Vec::new();
    for _ in 0..wanted.min(24) {
        let body = *rng.pick(&[Body::Truck, Body::Truck, Body::Van, Body::Pickup, Body::Suv, Body::Sedan]);
        let size = body.size_m();
        let turned = rng.chance(0.75);
        let half = if turned { DVec2::new(size[1], size[0]) } else { DVec2::new(size[0], size[1]) } / 2.0 + 0.35;
        let room = [open[0] + half.x, open[1] - half.x, open[2] + half.y, open[3] - half.y];
        if room[0] >= room[1] || room[2] >= room[3] {
            continue;
        }
        let at = DVec2::new(rng.range(room[0], room[1]), rng.range(room[2], room[3]));
        let foot = polygon::rectangle(at - half, at + half);
        if feet.iter().any(|f| polygon::convex_overlap(f, &foot)) {
            continue;
        }
        feet.push(foot);
        let way = if rng.chance(0.5) { 1.0 } else { -1.0 };
        work.car(&place.frame, at, if turned { DVec2::Y * way } else { DVec2::X * way }, body);
    }
}
