//! Shops of one or two storeys with their parking, restaurants that one drives through, filling stations, large stores.

use super::fittings::{Fitting, block, canopy, wall};
use super::site::{Draft, GROUNDED, Place, Rect, Work, corners, plain, shrunk};
use super::{Use, ground, part};
use crate::city::california::ground_slot as suburb;
use crate::city::california::house::Extra;
use crate::city::california::lot::Plant;
use crate::city::california::paving::Layer;
use crate::city::toronto::traffic::draw_body;
use crate::kit::buildings::{Facade, Furnishing, Mass, RoofItem, RoofItemKind, slot};
use crate::kit::polygon;
use crate::kit::vehicles::Body;
use glam::DVec2;
use satseed_scene::Rng;

/// What stands on the roof of a low shop.
pub(super) const SHOP_ROOF: Furnishing =
    Furnishing { base_m: 0.0, machines: 0.75, panels: 0.14, beds: 0.0, bulkhead: 0.15 };

/// Skylights in rows on a large roof.
pub(super) fn skylights(draft: &mut Draft, mass: usize, pitch: DVec2, half: DVec2) {
    let (low, high) = polygon::bounds(&draft.masses[mass].outline);
    let base_m = draft.masses[mass].roof_m;
    let mut y = low.y + pitch.y * 0.7;
    while y < high.y - 2.0 {
        let mut x = low.x + pitch.x * 0.6;
        while x < high.x - 2.0 {
            let centre_m = DVec2::new(x, y);
            let free = draft.items.iter().all(|i| (i.centre_m - centre_m).abs().cmpgt(i.half_m + half + 0.5).any());
            let over = |o: &[DVec2]| polygon::contains(&polygon::mitred(o, -0.6 - half.max_element()), centre_m);
            let under = draft.masses.iter().enumerate().any(|(k, m)| k != mass && over(&m.outline));
            if free && !under {
                let kind = RoofItemKind::Skylight;
                draft.items.push(RoofItem { kind, centre_m, axis: DVec2::X, half_m: half, base_m, height_m: 0.55 });
            }
            x += pitch.x;
        }
        y += pitch.y;
    }
}

/// A raised part of a shop's front.
fn false_front(draft: &mut Draft, [x0, x1, y0, _]: Rect, roof_m: f64, rng: &mut Rng) {
    let wide = rng.range(0.2, 0.45) * (x1 - x0);
    if wide < 4.0 {
        return;
    }
    let x = rng.range(x0 + 0.5, x1 - wide - 0.5);
    let top = roof_m + rng.range(1.3, 2.6);
    draft.masses.push(plain(corners([x, x + wide, y0 - 0.35, y0 + 1.5]), GROUNDED, top, 0.25));
}

/// An awning or arcade along the front.
fn arcade(draft: &mut Draft, [x0, x1, y0, _]: Rect, rng: &mut Rng) {
    let (deep, under) = (rng.range(1.6, 2.8), rng.range(2.9, 3.5));
    let posts = libm::floor((x1 - x0) / 6.0).max(1.0) as u32;
    let mut add = |f: Fitting| draft.extras.push(Extra::Fitting(f));
    add(block([x0 + 0.3, x1 - 0.3, y0 - deep, y0 + 0.2], [under, under + 0.35], [slot::COPING, slot::TERRACE]));
    for k in 0..=posts {
        let x = x0 + 0.5 + (x1 - x0 - 1.0) * f64::from(k) / f64::from(posts);
        add(block([x - 0.13, x + 0.13, y0 - deep + 0.1, y0 - deep + 0.36], [-0.8, under + 0.1], [slot::COPING; 2]));
    }
}

/// A sign on a pole.
fn pole_sign(draft: &mut Draft, at: DVec2, rng: &mut Rng) {
    let (high, half) = (rng.range(6.0, 9.5), rng.range(1.2, 2.2));
    let mut add = |f: Fitting| draft.extras.push(Extra::Fitting(f));
    add(block([at.x - 0.16, at.x + 0.16, at.y - 0.16, at.y + 0.16], [-0.9, high - 1.4], [slot::METAL; 2]));
    add(block([at.x - half, at.x + half, at.y - 0.25, at.y + 0.25], [high - 1.6, high], [part::CANOPY; 2]));
}

/// A shop at the sidewalk over the site's whole width; cars behind it, from the alley.
pub(super) fn shop(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("shop").rng();
    let Some(r) = place.rect(rng.range(0.15, 1.5), 0.12, 0.3) else { return false };
    let deep = r[3] - r[2];
    if r[1] - r[0] < 6.0 || deep < 10.0 {
        return false;
    }
    let floors = if rng.chance(0.36) { 2.0 } else { 1.0 };
    let behind = if deep > 30.0 && rng.chance(0.8) { rng.range(11.8, 0.42 * deep) } else { rng.range(0.3, 6.0) };
    let body: Rect = [r[0], r[1], r[2], r[3] - behind];
    let roof_m = floors * rng.range(3.6, 4.2) + rng.range(0.9, 1.9);
    // The rear is often lower.
    let step = rng.chance(0.4) && body[3] - body[2] > 16.0;
    let front_end = if step { body[2] + (body[3] - body[2]) * rng.range(0.45, 0.7) } else { body[3] };
    let mut draft = Draft::new(
        Use::Store,
        vec![plain(corners([body[0], body[1], body[2], front_end]), GROUNDED, roof_m, rng.range(0.5, 1.2))],
    );
    if step {
        let inner = [body[0] + 0.3, body[1] - rng.range(0.3, 3.0), front_end - 0.3, body[3]];
        draft.masses.push(plain(corners(inner), GROUNDED, roof_m - rng.range(0.8, 2.0), 0.4));
    }
    if rng.chance(0.45) {
        false_front(&mut draft, body, roof_m, &mut rng);
    }
    let count = draft.masses.len();
    for k in 0..count.min(2) {
        if draft.masses[k].roof_m < roof_m + 0.5 {
            draft.furnish(k, SHOP_ROOF, &[], &place.key);
        }
    }
    if rng.chance(0.45) && place.site.on_street[place.site.front] {
        let deep = rng.range(0.7, 1.1);
        let awning =
            block([body[0] + 0.4, body[1] - 0.4, body[2] - deep, body[2] + 0.2], [2.8, 3.05], [part::CANOPY; 2]);
        draft.extras.push(Extra::Fitting(awning));
    }
    work.floor(place, *rng.pick(&ground::YARDS[..3]));
    work.build(place, "shop", draft);
    if behind > 11.5 {
        let occupancy = rng.range(0.3, 0.8);
        // The row along the building; its aisle is towards the alley.
        work.parking(&place.frame, [r[0] + 0.3, r[1] - 0.3, body[3] + 0.6, r[3]], occupancy, &place.key);
    }
    if rng.chance(0.6) {
        let at = DVec2::new(rng.range(r[0], r[1] - 2.0), r[3] - 1.2);
        bins(work, place, at);
    }
    true
}

/// Refuse bins behind low walls.
fn bins(work: &mut Work<'_>, place: &Place<'_>, at: DVec2) {
    let mut rng = place.key.child("bins").rng();
    let b = [at.x - 1.5, at.x + 1.5, at.y - 0.9, at.y + 0.8];
    let bin = [b[0] + 0.5, b[0] + rng.range(1.9, 2.5), b[2] + 0.2, b[3] - 0.3];
    let mut draft = Draft::new(Use::Works, vec![plain(corners(bin), GROUNDED, 1.25, 0.06)]);
    for (p, q) in [((b[0], b[2]), (b[0], b[3])), ((b[0], b[3]), (b[1], b[3])), ((b[1], b[2]), (b[1], b[3]))] {
        let w = wall(DVec2::new(p.0, p.1), DVec2::new(q.0, q.1), 0.2, [-0.8, 1.7], slot::WALL);
        draft.extras.push(Extra::Fitting(w));
    }
    let free = corners(shrunk(b, -0.5)).iter().all(|p| {
        let world = place.frame.world(*p);
        work.taken.iter().all(|o| !polygon::contains(o, world))
    });
    if free {
        work.build(place, "bins", draft);
    }
}

/// A small mall: shops along the rear and one side, cars before them.
pub(super) fn mall(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("mall").rng();
    let Some(r) = place.rect(1.2, 0.3, rng.range(0.3, 3.0)) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 16.0 || deep < 28.0 {
        return false;
    }
    let rear = rng.range(12.0, 16.0).min(deep * 0.42);
    let roof_m = rng.range(4.8, 6.4);
    let back: Rect = [r[0], r[1], r[3] - rear, r[3]];
    let mut draft = Draft::new(Use::Store, vec![plain(corners(back), GROUNDED, roof_m, rng.range(0.6, 1.3))]);
    let side = wide > 34.0 && rng.chance(0.7);
    let left = rng.chance(0.5);
    let arm_m = rng.range(11.0, 14.5);
    if side {
        let x = if left { [r[0] + 0.05, r[0] + arm_m] } else { [r[1] - arm_m, r[1] - 0.05] };
        let second = if rng.chance(0.3) { roof_m + 3.2 } else { roof_m - rng.range(0.4, 0.9) };
        draft.masses.push(plain(
            corners([x[0], x[1], r[2] + rng.range(1.0, 6.0), r[3] - rear + 0.4]),
            GROUNDED,
            second,
            0.7,
        ));
    }
    let front = if side {
        if left { [r[0] + arm_m, r[1], back[2], back[3]] } else { [r[0], r[1] - arm_m, back[2], back[3]] }
    } else {
        back
    };
    arcade(&mut draft, front, &mut rng);
    false_front(&mut draft, [front[0], front[1], back[2], back[3]], roof_m, &mut rng);
    pole_sign(&mut draft, DVec2::new(if left { r[1] - 3.0 } else { r[0] + 3.0 }, r[2] + 1.4), &mut rng);
    for k in 0..if side { 2 } else { 1 } {
        draft.furnish(k, SHOP_ROOF, &[], &place.key);
    }
    work.floor(place, ground::YARDS[rng.below(2) as usize]);
    work.build(place, "mall", draft);
    work.lay(Layer::Walk, &place.frame, &corners([front[0], front[1], back[2] - 3.2, back[2] + 0.3]), suburb::PLAZA);
    verge(work, place, r, &mut rng);
    let span = [front[0] + 0.6, front[1] - 0.6, r[2] + 3.0, back[2] - 3.4];
    let occupancy = rng.range(0.35, 0.85);
    if span[3] - span[2] > 11.4 {
        work.parking(&place.frame, span, occupancy, &place.key);
    }
    true
}

/// A planted strip along the street.
fn verge(work: &mut Work<'_>, place: &Place<'_>, r: Rect, rng: &mut Rng) {
    let slot = *rng.pick(&[suburb::PARKWAY, suburb::MULCH, suburb::FRONT[2], suburb::FRONT[7]]);
    let gate = rng.range(r[0] + 3.0, r[1] - 9.0);
    for [a, b] in [[r[0], gate], [gate + 7.0, r[1]]] {
        if b - a < 2.0 {
            continue;
        }
        work.lay(Layer::Bed, &place.frame, &corners([a, b, r[2], r[2] + 1.9]), slot);
        let mut x = a + 1.5;
        while x < b - 1.0 {
            let (plant, size) = match rng.weighted(&[0.3, 0.25, 0.45]) {
                0 => (Plant::Palm, rng.range(0.7, 1.05)),
                1 => (Plant::Broad, rng.range(0.4, 0.75)),
                _ => (Plant::Shrub, rng.range(0.6, 1.2)),
            };
            if rng.chance((0.7 * work.params.trees).min(1.0)) {
                work.plant(place.frame.world(DVec2::new(x, r[2] + 0.95)), plant, size);
            }
            x += rng.range(3.0, 7.0);
        }
    }
}

/// A restaurant that one drives through: a lane around it with a queue, stalls on both sides.
pub(super) fn drive_through(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("drive").rng();
    let Some(r) = place.rect(1.0, 0.4, 0.4) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 25.0 || deep < 30.0 {
        return false;
    }
    let half = DVec2::new(rng.range(4.5, 6.0), rng.range(8.0, 10.5).min(deep / 2.0 - 6.5));
    let c = DVec2::new(f64::midpoint(r[0], r[1]) + rng.range(0.0, 2.0), f64::midpoint(r[2], r[3]));
    let b = [c.x - half.x, c.x + half.x, c.y - half.y, c.y + half.y];
    let roof_m = rng.range(4.4, 5.4);
    let mut draft = Draft::new(Use::Store, vec![plain(corners(b), GROUNDED, roof_m, rng.range(0.8, 1.4))]);
    let tower = [c.x - 2.2, c.x + 2.2, b[2] - 0.5, b[2] + 3.0];
    draft.masses.push(plain(corners(tower), GROUNDED, roof_m + rng.range(1.6, 2.8), 0.3));
    draft.furnish(0, Furnishing { machines: 2.2, ..SHOP_ROOF }, &[], &place.key);
    // The window's roof reaches over the lane.
    let cover = block([b[1] - 0.2, b[1] + 3.6, c.y + 1.0, c.y + 5.5], [3.3, 3.7], [part::CANOPY; 2]);
    draft.extras.push(Extra::Fitting(cover));
    let post = block([b[1] + 3.2, b[1] + 3.5, c.y + 1.3, c.y + 1.6], [-0.8, 3.4], [slot::COPING; 2]);
    draft.extras.push(Extra::Fitting(post));
    pole_sign(&mut draft, DVec2::new(r[0] + 3.0, r[2] + 1.2), &mut rng);
    work.floor(place, ground::YARDS[rng.below(2) as usize]);
    work.lay(Layer::Walk, &place.frame, &corners([b[0] - 1.6, b[1] + 0.4, b[2] - 2.4, b[3] + 0.6]), suburb::PLAZA);
    // The lane: behind the building and along its right.
    let lane = [
        (b[0] - 2.0, b[3] + 1.2),
        (b[1] + 0.5, b[3] + 1.2),
        (b[1] + 0.5, b[2] + 1.0),
        (b[1] + 3.7, b[2] + 1.0),
        (b[1] + 3.7, b[3] + 4.6),
        (b[0] - 2.0, b[3] + 4.6),
    ]
    .map(|(x, y)| DVec2::new(x, y));
    work.lay(Layer::Drive, &place.frame, &lane, suburb::DRIVE[1]);
    work.build(place, "restaurant", draft);
    verge(work, place, r, &mut rng);
    let queue = libm::floor(f64::from(rng.below(6) as u32) * work.params.vehicles) as u32;
    for k in 0..queue.min(5) {
        let body = draw_body(&mut rng, false);
        let y = c.y + 3.0 - 6.2 + 6.2 * f64::from(k);
        if y < b[3] - 1.0 {
            work.car(&place.frame, DVec2::new(b[1] + 2.1, y), DVec2::NEG_Y, body);
        }
    }
    let turned = crate::city::toronto::massing::Frame { centre: place.frame.centre, axis: place.frame.axis.perp() };
    // Stalls along the left border look at it, those on the right too.
    for (k, span) in [[r[2] + 3.0, r[3] - 1.0, -(b[0] - 2.2), -r[0]], [r[2] + 3.0, r[3] - 6.0, -r[1], -(b[1] + 4.0)]]
        .into_iter()
        .enumerate()
    {
        if span[3] - span[2] > 11.5 {
            let occupancy = rng.range(0.3, 0.8);
            work.parking(&turned, span, occupancy, &place.key.index(k as u64));
        }
    }
    true
}

/// A filling station: a roof over the pumps, a small shop behind.
pub(super) fn station(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("station").rng();
    let Some(r) = place.rect(1.0, 0.5, 0.6) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 26.0 || deep < 30.0 {
        return false;
    }
    let store_m = rng.range(8.0, 10.5);
    let store = [r[0] + rng.range(1.0, 4.0), r[1] - rng.range(4.0, 8.0), r[3] - store_m, r[3]];
    let mut draft = Draft::new(Use::Store, vec![plain(corners(store), GROUNDED, rng.range(4.2, 5.0), 0.9)]);
    draft.furnish(0, SHOP_ROOF, &[], &place.key);
    let c = DVec2::new(f64::midpoint(r[0], r[1]), f64::midpoint(r[2] + 4.0, store[2] - 2.0));
    let half = DVec2::new((wide / 2.0 - 3.0).min(rng.range(10.0, 14.0)), rng.range(4.5, 7.0));
    let roof = [c.x - half.x, c.x + half.x, c.y - half.y, c.y + half.y];
    let posts = libm::floor(half.x / 4.5).max(2.0) as u32;
    draft.extras.extend(
        canopy(roof, [rng.range(4.8, 5.4), 0.95], posts, [part::CANOPY, slot::COPING]).into_iter().map(Extra::Fitting),
    );
    let mut pumps = Vec::new();
    for k in 0..posts {
        let x = roof[0] + (roof[1] - roof[0]) * (f64::from(k) + 0.5) / f64::from(posts);
        pumps.push(x);
        draft.extras.push(Extra::Fitting(block(
            [x - 0.5, x + 0.5, c.y - 3.0, c.y + 3.0],
            [-0.3, 0.17],
            [slot::COPING; 2],
        )));
        for y in [-1.6, 1.6] {
            let pump = [x - 0.3, x + 0.3, c.y + y - 0.45, c.y + y + 0.45];
            draft.extras.push(Extra::Fitting(block(pump, [0.05, 1.9], [part::CANOPY; 2])));
        }
    }
    pole_sign(&mut draft, DVec2::new(r[1] - 2.6, r[2] + 1.2), &mut rng);
    work.floor(place, ground::YARDS[0]);
    work.lay(Layer::Walk, &place.frame, &corners(shrunk(roof, -2.5)), suburb::DRIVE[0]);
    work.lay(Layer::Bed, &place.frame, &corners([store[0], store[1], store[2] - 1.8, store[2] + 0.2]), suburb::PLAZA);
    work.build(place, "station", draft);
    verge(work, place, r, &mut rng);
    for x in pumps {
        for side in [-1.75, 1.75] {
            if rng.chance((0.4 * work.params.vehicles).min(1.0)) {
                let body = draw_body(&mut rng, false);
                let way = if rng.chance(0.5) { DVec2::Y } else { DVec2::NEG_Y };
                let y = c.y + rng.range(-1.5, 1.5);
                work.car(&place.frame, DVec2::new(x + side, y), way, body);
            }
        }
    }
    true
}

/// A large store over most of a block: cars before it, docks behind.
pub(super) fn large(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("large").rng();
    let Some(r) = place.rect(2.0, 2.0, 2.0) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 60.0 || deep < 60.0 {
        return false;
    }
    let back = r[3] - rng.range(8.0, 11.0);
    let store_m = rng.range(34.0, 46.0).min(deep - 36.0);
    let mut x = r[0] + 3.0;
    let main = rng.range(0.42, 0.66) * wide;
    let mut draft = Draft::new(Use::Store, Vec::new());
    let roof_m = rng.range(7.5, 10.0);
    let store = [x, x + main, back - store_m, back];
    draft.masses.push(plain(corners(store), GROUNDED, roof_m, rng.range(0.9, 1.4)));
    let entry = x + main * rng.range(0.3, 0.7);
    draft.masses.push(plain(
        corners([entry - 7.0, entry + 7.0, store[2] - 3.0, store[2] + 4.0]),
        GROUNDED,
        roof_m + 2.4,
        0.4,
    ));
    x += main + 0.3;
    // Smaller shops beside it.
    while x + 14.0 < r[1] - 3.0 {
        let w = rng.range(14.0, 30.0).min(r[1] - 3.0 - x);
        let shop = [x, x + w, back - rng.range(18.0, 26.0), back];
        draft.masses.push(plain(corners(shop), GROUNDED, rng.range(5.2, 6.8), rng.range(0.5, 1.1)));
        x += w + 0.3;
    }
    skylights(&mut draft, 0, DVec2::new(rng.range(9.0, 13.0), rng.range(8.0, 12.0)), DVec2::new(1.3, 0.65));
    let before = draft.items.clone();
    let lights: Vec<Vec<DVec2>> =
        before.iter().map(|i| polygon::oriented_rectangle(i.centre_m, i.axis, i.half_m + DVec2::splat(0.4))).collect();
    for k in 0..draft.masses.len() {
        if k != 1 {
            let over: &[Vec<DVec2>] = if k == 0 { &lights } else { &[] };
            draft.furnish(k, Furnishing { machines: 0.4, panels: 0.0, ..SHOP_ROOF }, over, &place.key);
        }
    }
    for k in 0..3 {
        let x = store[0] + 6.0 + 5.0 * f64::from(k);
        draft.extras.push(Extra::Door { centre: DVec2::new(x, back), along: DVec2::X, width_m: 3.0, height_m: 3.6 });
    }
    work.floor(place, ground::YARDS[rng.below(2) as usize]);
    work.build(place, "store", draft);
    work.lay(
        Layer::Walk,
        &place.frame,
        &corners([store[0], r[1] - 3.0, store[2] - 6.0, store[2] + 0.3]),
        suburb::PLAZA,
    );
    for k in 0..3 {
        if rng.chance((0.5 * work.params.vehicles).min(1.0)) {
            let at = DVec2::new(store[0] + 6.0 + 5.0 * f64::from(k), back + 5.6);
            work.car(&place.frame, at, DVec2::NEG_Y, Body::Truck);
        }
    }
    verge(work, place, r, &mut rng);
    let occupancy = rng.range(0.3, 0.75);
    let end = work.parking(&place.frame, [r[0] + 3.0, r[1] - 3.0, r[2] + 4.0, store[2] - 9.0], occupancy, &place.key);
    debug_assert!(end <= store[2]);
    true
}

/// A building over a site of any convex shape: its corners cut, its roof in two heights.
pub(super) fn flatiron(work: &mut Work<'_>, place: &Place<'_>, rng: &mut Rng) {
    let local: Vec<DVec2> = place.site.outline.iter().map(|p| place.frame.local(*p)).collect();
    let Some(inner) = polygon::inset(&local, rng.range(1.5, 4.0)).filter(|o| polygon::area(o) > 150.0) else { return };
    let low = work.params.variant == crate::city::california::Variant::Lowrise;
    let outline = polygon::rounded(&inner, rng.range(3.0, 6.0), 2);
    let floors = if low { 1.0 + rng.below(2) as f64 } else { 4.0 + rng.below(7) as f64 };
    let mut mass = plain(outline, GROUNDED, 5.0 + 3.6 * floors, 1.0);
    mass.shop = true;
    mass.first_floor_m = 5.0;
    mass.floor_m = 3.6;
    mass.bay_m = rng.range(2.6, 4.0);
    mass.facade =
        Facade::Punched { recess_m: 0.22, band_m: rng.range(1.2, 1.7), pier_m: rng.range(0.7, 1.4), proud_m: 0.03 };
    let upper = polygon::inset(&inner, rng.range(4.5, 8.0)).filter(|o| polygon::area(o) > 250.0);
    let mut draft = Draft::new(if low { Use::Store } else { Use::Block }, vec![mass]);
    if let Some(outline) = upper.filter(|_| !low && rng.chance(0.7)) {
        let under = draft.masses[0].clone();
        let roof_m = under.roof_m + 3.6 * (1.0 + rng.below(3) as f64);
        let (low_m, first_floor_m) = (under.roof_m - 0.35, under.roof_m);
        let outline = polygon::rounded(&outline, 2.5, 2);
        draft.masses.push(Mass { outline, low_m, roof_m, first_floor_m, shop: false, ..under });
        draft.furnish(1, SHOP_ROOF, &[], &place.key);
    }
    draft.furnish(0, SHOP_ROOF, &[], &place.key);
    work.build(place, "flatiron", draft);
}
