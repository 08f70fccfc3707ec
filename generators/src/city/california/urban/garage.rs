//! Parking structures: two aisles deep, cars on the open deck, a ramp from the deck below it.

use super::fittings::{Fitting, wall};
use super::site::{Draft, GROUNDED, Place, Rect, STALL_M, Work, corners, plain};
use super::{Use, part};
use crate::city::california::house::Extra;
use crate::city::california::lot::Parked;
use crate::city::toronto::traffic::draw_body;
use crate::kit::buildings::{Facade, Mass, Roof, RoofItem, RoofItemKind, slot};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::Rng;

/// Depth of a structure of two aisles and four rows of stalls, m.
const DEPTH_M: f64 = 35.0;

/// Height of a level, m.
const LEVEL_M: f64 = 3.1;

/// The part of the uppermost deck that is open to the deck below: its length, and where it begins across.
const NOTCH_M: [f64; 2] = [32.0, 5.6];

/// Height of the wall around a deck, m.
const GUARD_M: f64 = 1.05;

/// A parking structure if the site has room for one: rows run along the site's longer side.
pub(super) fn garage(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let Some(r) = place.rect(1.2, 0.6, 0.6) else { return false };
    let size = DVec2::new(r[1] - r[0], r[3] - r[2]);
    if size.x >= 46.0 && size.y >= DEPTH_M + 0.2 && (size.x >= size.y || size.x < DEPTH_M + 0.2) {
        return stands(work, place, r);
    }
    if size.y >= 46.0 && size.x >= DEPTH_M + 0.2 {
        let axis = place.frame.axis.perp();
        let frame = crate::city::toronto::massing::Frame { centre: place.frame.centre, axis };
        let turned = Place { site: place.site, frame, name: place.name.clone(), key: place.key };
        return stands(work, &turned, [r[2], r[3], -r[1], -r[0]]);
    }
    false
}

fn deck(outline: Vec<DVec2>, low_m: f64, roof_m: f64, first_floor_m: f64) -> Mass {
    let mut mass = plain(outline, low_m, roof_m, 0.12);
    mass.facade = Facade::Slabs { recess_m: 0.4, slab_m: 1.25, pier_every: 2 };
    mass.first_floor_m = first_floor_m;
    mass.floor_m = LEVEL_M;
    mass.bay_m = 4.6;
    mass.roof = Roof::Flat { parapet_m: 0.12, slot: part::STALLS };
    mass
}

fn stands(work: &mut Work<'_>, place: &Place<'_>, r: Rect) -> bool {
    let mut rng = place.key.child("garage").rng();
    let half = DVec2::new(((r[1] - r[0]) / 2.0).min(42.0), DEPTH_M / 2.0);
    let slack = DVec2::new((r[1] - r[0]) / 2.0, (r[3] - r[2]) / 2.0) - half;
    let c = DVec2::new(
        f64::midpoint(r[0], r[1]) + slack.x * rng.signed(),
        f64::midpoint(r[2], r[3]) + slack.y * rng.signed(),
    );
    let levels = 3.0 + rng.below(5) as f64;
    let (high, below) = (levels * LEVEL_M, (levels - 1.0) * LEVEL_M);
    // The ramp may begin at either end.
    let flip = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let at = |x: f64, y: f64| c + DVec2::new(x * flip, y);
    let ring = |mut o: Vec<DVec2>| {
        if polygon::area(&o) < 0.0 {
            o.reverse();
        }
        o
    };
    let [x0, x1, y0, y1] = [-half.x, half.x, -half.y, half.y];
    let (nx, ny) = (x1 - NOTCH_M[0], NOTCH_M[1]);
    let whole = deck(corners([c.x - half.x, c.x + half.x, c.y - half.y, c.y + half.y]), GROUNDED, below, LEVEL_M);
    let upper = ring(vec![at(x0, y0), at(x1, y0), at(x1, ny), at(nx, ny), at(nx, y1), at(x0, y1)]);
    let upper = deck(polygon::mitred(&upper, 0.04), below - 0.4, high, below);
    let mut draft = Draft::new(Use::Garage, vec![whole, upper]);
    let mut add = |f: Fitting| draft.extras.push(Extra::Fitting(f));
    let mut guard = |p: (f64, f64), q: (f64, f64), deck_m: f64| {
        add(wall(at(p.0, p.1), at(q.0, q.1), 0.2, [deck_m - 0.2, deck_m + GUARD_M], part::CONCRETE));
    };
    let e = 0.24;
    for (p, q) in [
        ((x0, y0 + e), (x1, y0 + e)),
        ((x1 - e, y0), (x1 - e, ny)),
        ((x0, y1 - e), (nx, y1 - e)),
        ((x0 + e, y0), (x0 + e, y1)),
    ] {
        guard(p, q, high);
    }
    // Along the notch, but for the head of the ramp.
    guard((nx, ny - e), (x1, ny - e), high);
    guard((nx - e, ny + 6.6), (nx - e, y1), high);
    guard((x1 - e, ny), (x1 - e, y1), below);
    guard((nx, y1 - e), (x1, y1 - e), below);
    let lip = high + 0.14;
    let ramp =
        ring(vec![at(nx - 0.5, ny + 0.4), at(x1 - 4.5, ny + 0.4), at(x1 - 4.5, ny + 6.2), at(nx - 0.5, ny + 6.2)]);
    let top = [0, 1, 2, 3].map(|k: usize| {
        let p = ramp[k];
        let share = ((p.x - c.x) * flip - (nx - 0.5)) / (x1 - 4.0 - nx);
        p.extend(if share > 0.5 { below + 0.02 } else { lip })
    });
    add(Fitting::Slope { top: top.map(|p: DVec3| p), low_m: below - 0.3, slots: [part::CONCRETE; 2] });
    for (x, y) in [(x0 + 2.6, y0 + 3.0), (x1 - 2.6, y0 + 3.0), (x0 + 2.6, y1 - 3.0)] {
        if draft.masses.len() < 4 && rng.chance(0.75) {
            let room = [at(x, y) - DVec2::new(2.8, 3.2), at(x, y) + DVec2::new(2.8, 3.2)];
            draft.masses.push(plain(polygon::rectangle(room[0], room[1]), GROUNDED, high + rng.range(2.6, 3.6), 0.3));
        }
    }
    lamps_or_panels(&mut draft, c, half, high, flip, &mut rng);
    let stairs: Vec<Vec<DVec2>> = draft.masses[2..].iter().map(|m| polygon::mitred(&m.outline, -2.6)).collect();
    let panels = draft
        .extras
        .iter()
        .any(|e| matches!(e, Extra::Fitting(Fitting::Slope { slots, .. }) if slots[1] == slot::PANEL));
    let plan = work.build(place, "garage", draft);
    let share = rng.range(0.25, 0.75) * work.params.vehicles;
    let n = libm::floor(half.x / STALL_M) as i64;
    for (row, way) in [(y0 + 2.75, -1.0), (-2.75, 1.0), (2.75, -1.0), (y1 - 2.75, 1.0)] {
        for k in -n..n {
            let x = (k as f64 + 0.5) * STALL_M;
            let notch = row > ny && x > nx - 1.0;
            let inner = row.abs() < 5.0;
            if x.abs() > half.x - if inner { 8.0 } else { 1.6 } || (notch && (x - nx).abs() < 1.5) {
                continue;
            }
            let p = at(x, row + rng.signed() * 0.25);
            let full = rng.chance(share.min(1.0));
            let body = draw_body(&mut rng, false);
            let way = if rng.chance(0.75) { way } else { -way };
            // Nothing tall below panels.
            let low = body.size_m()[2] < 2.0 || !panels;
            if full && low && stairs.iter().all(|s| !polygon::contains(s, p)) {
                let deck_m = plan.ground_m + if notch { below } else { high };
                let axis = place.frame.axis.perp() * way;
                work.out.raised.push((Parked { centre: place.frame.world(p), axis, body, lowered: false }, deck_m));
            }
        }
    }
    true
}

/// Lamps in the middle of the deck, or rows of solar panels on posts over its stalls.
fn lamps_or_panels(draft: &mut Draft, c: DVec2, half: DVec2, deck_m: f64, flip: f64, rng: &mut Rng) {
    let panels = rng.chance(0.25);
    let mut x = -half.x + 10.0;
    while x < half.x - 10.0 {
        if panels {
            // They lean to one side, 10 m deep over the double row.
            let end = (x + 18.0).min(half.x - 9.0);
            let (low, rise) = (deck_m + 2.7, 0.9);
            let p = |x: f64, y: f64, z: f64| (c + DVec2::new(x, y)).extend(z);
            let top =
                [p(x, -5.0, low + 0.15), p(end, -5.0, low + 0.15), p(end, 5.0, low + rise), p(x, 5.0, low + rise)];
            draft.extras.push(Extra::Fitting(Fitting::Slope { top, low_m: low, slots: [slot::METAL, slot::PANEL] }));
            for post in [x + 3.0, end - 3.0] {
                let at = c + DVec2::new(post, 0.0);
                let foot = super::fittings::block(
                    [at.x - 0.2, at.x + 0.2, at.y - 0.2, at.y + 0.2],
                    [deck_m - 0.1, low + 0.1],
                    [slot::METAL; 2],
                );
                draft.extras.push(Extra::Fitting(foot));
            }
            x = end + 0.8;
        } else {
            draft.items.push(RoofItem {
                kind: RoofItemKind::Mast,
                centre_m: c + DVec2::new(x * flip, 0.0),
                axis: DVec2::X,
                half_m: DVec2::splat(0.16),
                base_m: deck_m,
                height_m: 4.2,
            });
            x += 15.6;
        }
    }
}
