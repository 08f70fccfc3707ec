//! Apartments of two and three storeys: boxes on posts over their cars, courts with a pool, walk-ups on the arterials.

use super::fittings::{block, canopy, pool, wall};
use super::site::{Draft, GROUNDED, Place, Rect, Work, corners, plain};
use super::{Use, ground, part};
use crate::city::california::ground_slot as suburb;
use crate::city::california::house::Extra;
use crate::city::california::lot::Plant;
use crate::city::california::paving::Layer;
use crate::city::toronto::traffic::draw_body;
use crate::kit::buildings::{Furnishing, slot};
use glam::DVec2;
use satseed_scene::Rng;

const ROOF: Furnishing = Furnishing { base_m: 0.0, machines: 0.5, panels: 0.22, beds: 0.0, bulkhead: 0.1 };

/// Height of a storey, m.
const STOREY_M: f64 = 2.95;

/// A roof on posts along the alley, cars below it.
fn carport(work: &mut Work<'_>, place: &Place<'_>, r: Rect, rng: &mut Rng) {
    let (x0, x1, y0) = (r[0] + 0.4, r[1] - 0.4, r[3] - 5.6);
    let stalls = libm::floor((x1 - x0) / 2.7).max(1.0) as u32;
    let roof = [x0, x1, y0, r[3] - 0.1];
    let mut draft =
        Draft::new(Use::Apartments, vec![plain(corners([x0, x0 + 1.3, y0 + 2.0, y0 + 5.0]), GROUNDED, 2.1, 0.06)]);
    draft.extras.extend(
        canopy(roof, [2.25, 0.22], stalls.div_ceil(2), [slot::COPING, slot::METAL]).into_iter().map(Extra::Fitting),
    );
    let back = wall(DVec2::new(x0, y0 + 0.2), DVec2::new(x1, y0 + 0.2), 0.18, [-0.8, 2.3], slot::WALL);
    draft.extras.push(Extra::Fitting(back));
    let full = rng.range(0.4, 0.8) * work.params.vehicles;
    // Things are stored at one end.
    for k in 1..stalls {
        if rng.chance(full.min(1.0)) {
            let body = draw_body(rng, false);
            if body.size_m()[2] < 2.1 {
                let x = x0 + (x1 - x0) * (f64::from(k) + 0.5) / f64::from(stalls);
                work.car(&place.frame, DVec2::new(x, y0 + 3.0), DVec2::NEG_Y, body);
            }
        }
    }
    work.build(place, "carport", draft);
}

/// A box whose front stands on posts over a row of cars.
pub(super) fn dingbat(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("dingbat").rng();
    let Some(r) = place.rect(rng.range(2.6, 5.0), rng.range(0.9, 1.4), 0.3) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 10.0 || deep < 24.0 {
        return false;
    }
    let alley = rng.chance(0.4);
    let rear = r[3] - if alley { rng.range(12.4, 14.0) } else { rng.range(1.5, 4.0) };
    let walk = rng.range(1.5, 2.4);
    let body = if rng.chance(0.5) { [r[0], r[1] - walk, r[2], rear] } else { [r[0] + walk, r[1], r[2], rear] };
    let floors = if rng.chance(0.6) { 2.0 } else { 3.0 };
    let roof_m = floors * STOREY_M + rng.range(0.2, 0.5);
    let overhang = if rng.chance(0.7) { 5.8 } else { 0.0 };
    let parapet = rng.range(0.3, 0.8);
    let mut draft = Draft::new(
        Use::Apartments,
        vec![plain(corners([body[0], body[1], body[2] + overhang, body[3]]), GROUNDED, roof_m, parapet)],
    );
    if overhang > 0.0 {
        draft.masses.push(plain(
            corners([body[0] + 0.02, body[1] - 0.02, body[2], body[2] + overhang + 0.4]),
            2.5,
            roof_m - 0.03,
            parapet,
        ));
        let posts = libm::round((body[1] - body[0]) / 5.4).max(1.0) as u32;
        for k in 0..=posts {
            let x = body[0] + 0.3 + (body[1] - body[0] - 0.6) * f64::from(k) / f64::from(posts);
            draft.extras.push(Extra::Fitting(block(
                [x - 0.1, x + 0.1, body[2] + 0.2, body[2] + 0.4],
                [-0.8, 2.6],
                [slot::METAL; 2],
            )));
        }
    }
    // An outer walk along the side on the upper floors.
    let side = if body[0] > r[0] { [body[0] - 1.3, body[0] + 0.1] } else { [body[1] - 0.1, body[1] + 1.3] };
    for f in 1..floors as u32 {
        let z = f64::from(f) * STOREY_M;
        let gallery = block(
            [side[0], side[1], body[2] + overhang + 1.0, body[3] - 1.0],
            [z - 0.15, z + 0.12],
            [part::CONCRETE; 2],
        );
        draft.extras.push(Extra::Fitting(gallery));
    }
    draft.furnish(0, ROOF, &[], &place.key);
    work.floor(place, *rng.pick(&[ground::YARDS[2], suburb::REAR[3], suburb::REAR[4], suburb::REAR[7]]));
    work.lay(
        Layer::Walk,
        &place.frame,
        &corners([body[0], body[1], r[2] - 2.4, body[2] + overhang]),
        suburb::DRIVE[rng.below(4) as usize],
    );
    if overhang > 0.0 {
        let n = libm::floor((body[1] - body[0]) / 2.75) as u32;
        let full = rng.range(0.4, 0.85) * work.params.vehicles;
        for k in 0..n {
            let body_kind = draw_body(&mut rng, false);
            if rng.chance(full.min(1.0)) && body_kind.size_m()[2] < 2.2 {
                let x = body[0] + (body[1] - body[0]) * (f64::from(k) + 0.5) / f64::from(n);
                let y = body[2] + 2.7 + rng.signed() * 0.5;
                work.car(&place.frame, DVec2::new(x, y), DVec2::Y, body_kind);
            }
        }
    } else {
        work.lay(
            Layer::Bed,
            &place.frame,
            &corners([body[0] + 0.5, body[1] - 3.0, r[2] - 2.4, body[2] - 0.2]),
            suburb::FRONT[rng.below(9) as usize],
        );
    }
    if alley {
        work.lay(
            Layer::Walk,
            &place.frame,
            &corners([r[0], r[1], r[3] - 6.2, r[3]]),
            ground::YARDS[rng.below(3) as usize],
        );
        carport(work, place, r, &mut rng);
        if rear + 2.0 < r[3] - 7.0 {
            work.strew(&place.frame, [r[0], r[1], rear + 1.0, r[3] - 6.8], 3.0, [0.4, 0.25, 0.35], &mut rng);
        }
    }
    work.build(place, "apartments", draft);
    work.strew(&place.frame, [r[0] - 0.8, r[1] + 0.8, body[2] + 6.5, rear + 1.2], 0.45, [0.3, 0.2, 0.5], &mut rng);
    if !alley {
        work.strew(&place.frame, [r[0], r[1], rear + 0.6, r[3]], 4.0, [0.55, 0.2, 0.25], &mut rng);
    }
    let x = rng.range(r[0], r[1]);
    let plant = if rng.chance(0.5) { Plant::Palm } else { Plant::Broad };
    let size = rng.range(0.5, 0.9);
    work.plant(place.frame.world(DVec2::new(x, r[2] - 1.6)), plant, size);
    true
}

/// Bars around a court that opens to the street, often with a pool.
pub(super) fn court(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("court").rng();
    let Some(r) = place.rect(rng.range(3.0, 6.0), rng.range(1.0, 2.0), 0.3) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 27.0 || deep < 32.0 {
        return false;
    }
    let arm = rng.range(8.0, 10.5);
    let rear = r[3] - rng.range(12.4, 14.0);
    let floors = if rng.chance(0.7) { 2.0 } else { 3.0 };
    let roof_m = floors * STOREY_M + rng.range(0.2, 0.6);
    let parapet = rng.range(0.3, 0.7);
    let bars = [
        [r[0], r[0] + arm, r[2], rear],
        [r[1] - arm, r[1], r[2] + rng.range(0.0, 4.0), rear],
        [r[0] + arm - 0.3, r[1] - arm + 0.3, rear - arm, rear - 0.04],
    ];
    let heights = [roof_m, roof_m + 0.05, roof_m - if rng.chance(0.3) { STOREY_M } else { 0.08 }];
    let masses = bars.iter().zip(heights).map(|(b, h)| plain(corners(*b), GROUNDED, h, parapet)).collect();
    let mut draft = Draft::new(Use::Apartments, masses);
    for k in 0..3 {
        draft.furnish(k, ROOF, &[], &place.key);
    }
    for f in 1..floors as u32 {
        let z = f64::from(f) * STOREY_M;
        for x in [[r[0] + arm - 0.1, r[0] + arm + 1.3], [r[1] - arm - 1.3, r[1] - arm + 0.1]] {
            let walk = block([x[0], x[1], r[2] + 5.0, rear - arm + 0.1], [z - 0.15, z + 0.12], [part::CONCRETE; 2]);
            draft.extras.push(Extra::Fitting(walk));
        }
    }
    let inner = [r[0] + arm + 1.6, r[1] - arm - 1.6, r[2] + 3.0, rear - arm - 1.5];
    work.floor(place, *rng.pick(&[ground::YARDS[2], suburb::REAR[2], suburb::REAR[3]]));
    work.lay(
        Layer::Walk,
        &place.frame,
        &corners(inner),
        *rng.pick(&[suburb::DRIVE[3], suburb::DRIVE[4], suburb::FRONT[1], suburb::FRONT[2], suburb::PLAZA]),
    );
    let (room_x, room_y) = (inner[1] - inner[0], inner[3] - inner[2]);
    if room_x > 7.5 && room_y > 11.0 && rng.chance(0.65) {
        let (w, d) = (rng.range(4.0, (room_x - 2.5).min(7.0)), rng.range(7.0, (room_y - 3.0).min(13.0)));
        let x = inner[0] + (room_x - w) / 2.0;
        let y = inner[2] + rng.range(1.2, room_y - d - 1.2);
        draft.extras.extend(pool([x, x + w, y, y + d], 0.05).into_iter().map(Extra::Fitting));
        work.taken.push(
            corners([x - 1.0, x + w + 1.0, y - 1.0, y + d + 1.0]).iter().map(|p| place.frame.world(*p)).collect(),
        );
    }
    work.lay(Layer::Walk, &place.frame, &corners([r[0], r[1], r[3] - 6.4, r[3]]), ground::YARDS[rng.below(3) as usize]);
    work.build(place, "apartments", draft);
    carport(work, place, r, &mut rng);
    work.strew(&place.frame, inner, 2.6, [0.25, 0.45, 0.3], &mut rng);
    work.strew(&place.frame, [r[0], r[1], r[2] - 2.6, r[2] - 0.6], 5.0, [0.25, 0.25, 0.5], &mut rng);
    true
}

/// Three or four storeys over a half-sunk garage, close to the street.
pub(super) fn walk_up(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let mut rng = place.key.child("walk-up").rng();
    let Some(r) = place.rect(rng.range(2.5, 5.0), rng.range(1.2, 2.0), rng.range(1.0, 4.0)) else { return false };
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 16.0 || deep < 20.0 {
        return false;
    }
    let first = 1.3;
    let floors = 2.0 + rng.below(2) as f64;
    let roof_m = first + floors * STOREY_M + 0.4;
    let (a, b) = (rng.range(0.3, 0.42) * wide, rng.range(0.3, 0.62) * deep);
    let left = rng.chance(0.5);
    let outline: Vec<DVec2> = if wide > 26.0 && deep > 26.0 {
        // A light court in the rear or at the front.
        let (c0, c1) = (r[0] + a, r[1] - a);
        if rng.chance(0.5) {
            [
                (r[0], r[2]),
                (r[1], r[2]),
                (r[1], r[3]),
                (c1, r[3]),
                (c1, r[3] - b),
                (c0, r[3] - b),
                (c0, r[3]),
                (r[0], r[3]),
            ]
        } else {
            [
                (r[0], r[2]),
                (c0, r[2]),
                (c0, r[2] + b),
                (c1, r[2] + b),
                (c1, r[2]),
                (r[1], r[2]),
                (r[1], r[3]),
                (r[0], r[3]),
            ]
        }
        .map(|(x, y)| DVec2::new(x, y))
        .to_vec()
    } else if left {
        [(r[0], r[2]), (r[1], r[2]), (r[1], r[3]), (r[0] + a, r[3]), (r[0] + a, r[3] - b), (r[0], r[3] - b)]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
    } else {
        [(r[0], r[2]), (r[1], r[2]), (r[1], r[3] - b), (r[1] - a, r[3] - b), (r[1] - a, r[3]), (r[0], r[3])]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
    };
    let mut mass = plain(outline, GROUNDED, roof_m, rng.range(0.5, 1.0));
    mass.first_floor_m = first;
    mass.floor_m = STOREY_M;
    mass.bay_m = 3.4;
    let mut draft = Draft::new(Use::Apartments, vec![mass]);
    draft.furnish(0, Furnishing { machines: 0.9, bulkhead: 0.8, ..ROOF }, &[], &place.key);
    work.floor(place, *rng.pick(&[ground::YARDS[2], suburb::REAR[1], suburb::REAR[3]]));
    work.lay(
        Layer::Walk,
        &place.frame,
        &corners([r[0], r[1], r[2] - 2.2, r[2] + 0.2]),
        suburb::FRONT[rng.below(9) as usize],
    );
    work.build(place, "apartments", draft);
    work.strew(&place.frame, [r[0], r[1], r[2] - 2.2, r[2]], 4.0, [0.3, 0.3, 0.4], &mut rng);
    work.strew(&place.frame, [r[0], r[1], r[2] + 2.0, r[3] + 0.6], 0.9, [0.5, 0.25, 0.25], &mut rng);
    true
}
