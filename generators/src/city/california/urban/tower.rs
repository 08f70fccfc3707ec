//! Office and residential towers.
//!
//! Offices have plates of 1,500 to 2,500 m^2 and stand beside a low wing or a square; dwellings have plates below 950 m^2
//! and stand on a podium of shops and parking with a pool on its roof. Until 2014 Los Angeles asked every high-rise for a
//! place where a helicopter can land; most have it.

use super::fittings::{helipad, pool, round};
use super::site::{Draft, GROUNDED, Place, Rect, Work, corners, plain, shrunk};
use super::{Use, ground, open, part};
use crate::city::california::house::Extra;
use crate::city::toronto::massing::{balconies, flat, penthouse};
use crate::kit::buildings::{Facade, Furnishing, Mass, Roof, RoofItem, RoofItemKind, slot};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::Rng;

/// Height of an office's floor, m.
const OFFICE_FLOOR_M: [f64; 2] = [3.9, 4.15];

/// Forms of an office tower's plate.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Slab,
    Square,
    Chamfered,
    Notched,
    Octagon,
    Round,
    Twin,
}

/// A plate within half sizes, about the origin.
fn plate(form: Form, half: DVec2, rng: &mut Rng) -> Vec<DVec2> {
    let r = half.min_element();
    match form {
        Form::Slab | Form::Square => polygon::rectangle(-half, half),
        Form::Chamfered => polygon::rounded(&polygon::rectangle(-half, half), rng.range(5.0, 9.0), 1),
        Form::Octagon => polygon::rounded(&polygon::rectangle(-half, half), 0.586 * r, 1),
        Form::Round => round(DVec2::ZERO, r, 28),
        Form::Notched => {
            let n = DVec2::new(rng.range(3.0, 7.0), rng.range(3.0, 7.0));
            let m = half - n;
            [
                (-m.x, -half.y),
                (m.x, -half.y),
                (m.x, -m.y),
                (half.x, -m.y),
                (half.x, m.y),
                (m.x, m.y),
                (m.x, half.y),
                (-m.x, half.y),
                (-m.x, m.y),
                (-half.x, m.y),
                (-half.x, -m.y),
                (-m.x, -m.y),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        }
        Form::Twin => {
            // Two slabs side by side, one pushed on.
            let d = rng.range(0.14, 0.3) * half.y;
            [
                (-half.x, -half.y),
                (0.0, -half.y),
                (0.0, -half.y + d),
                (half.x, -half.y + d),
                (half.x, half.y),
                (0.0, half.y),
                (0.0, half.y - d),
                (-half.x, half.y - d),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        }
    }
}

fn draw_form(rng: &mut Rng) -> (Form, DVec2) {
    let form = [Form::Slab, Form::Square, Form::Chamfered, Form::Notched, Form::Octagon, Form::Round, Form::Twin]
        [rng.weighted(&[0.2, 0.16, 0.17, 0.15, 0.1, 0.1, 0.12])];
    let half = match form {
        Form::Slab => DVec2::new(rng.range(15.0, 17.5), rng.range(26.0, 33.0)),
        Form::Round => DVec2::splat(rng.range(22.5, 27.0)),
        Form::Octagon => DVec2::splat(rng.range(21.5, 26.0)),
        _ => DVec2::new(rng.range(19.5, 23.5), rng.range(20.0, 26.0)),
    };
    (form, half)
}

fn office_facade(rng: &mut Rng) -> (Facade, f64) {
    match rng.weighted(&[0.42, 0.33, 0.25]) {
        0 => {
            let fin_m = if rng.chance(0.5) { rng.range(0.1, 0.3) } else { 0.0 };
            (Facade::Curtain { fin_m }, *rng.pick(&[1.5, 1.5, 3.0]))
        }
        // Granite and precast: upright piers before the windows, or deep windows.
        1 => {
            let proud_m = if rng.chance(0.6) { rng.range(0.15, 0.45) } else { 0.0 };
            let (band_m, pier_m) = (rng.range(1.0, 1.7), rng.range(0.5, 1.2));
            (Facade::Punched { recess_m: rng.range(0.2, 0.35), band_m, pier_m, proud_m }, rng.range(1.6, 3.2))
        }
        // Bands of windows right round.
        _ => (Facade::Slabs { recess_m: rng.range(0.15, 0.3), slab_m: rng.range(1.2, 1.9), pier_every: 0 }, 3.0),
    }
}

/// A stage of a tower.
#[allow(clippy::too_many_arguments)]
fn stage(
    outline: Vec<DVec2>,
    [low, top]: [f64; 2],
    first_m: f64,
    floor_m: f64,
    look: (Facade, f64),
    parapet: f64,
) -> Mass {
    let floors = libm::round((top - first_m) / floor_m).max(1.0);
    Mass {
        outline,
        low_m: low,
        roof_m: first_m + floors * floor_m,
        first_floor_m: first_m,
        floor_m,
        bay_m: look.1,
        shop: low < 0.0,
        facade: look.0,
        roof: flat(parapet),
        balconies: Vec::new(),
    }
}

fn shifted(outline: &[DVec2], by: DVec2) -> Vec<DVec2> {
    outline.iter().map(|p| *p + by).collect()
}

/// The top of a tower: machines behind a screen, and a landing pad on it or beside it.
fn top(draft: &mut Draft, centre: DVec2, half: DVec2, roof_m: f64, rng: &mut Rng) {
    let pad = rng.chance(0.8);
    let mut room = penthouse(centre, half, roof_m, rng);
    let (low, high) = polygon::bounds(&room.outline);
    let size = (high - low) / 2.0;
    let at = (low + high) / 2.0;
    let radius = rng.range(7.0, 9.5).min(half.min_element() - 1.0);
    room.roof_m = roof_m + rng.range(5.0, 8.0);
    let room_top = room.roof_m;
    let mut over = Vec::new();
    if pad && size.min_element() > radius * 0.6 && radius > 5.0 {
        let pad = helipad(at, DVec2::X, radius, room_top, rng.chance(0.6));
        draft.extras.extend(pad.into_iter().map(Extra::Fitting));
        over.push(round(at, radius * 1.1, 12));
    }
    draft.masses.push(room);
    let n = draft.masses.len() - 1;
    // Cooling towers in a row.
    let mut x = at.x - size.x + 3.0;
    while over.is_empty() && x < at.x + size.x - 2.5 {
        draft.items.push(RoofItem {
            kind: RoofItemKind::Tank,
            centre_m: DVec2::new(x, at.y),
            axis: DVec2::X,
            half_m: DVec2::splat(1.8),
            base_m: room_top,
            height_m: 2.6,
        });
        x += 4.6;
    }
    if rng.chance(0.4) {
        draft.items.push(RoofItem {
            kind: RoofItemKind::Mast,
            centre_m: at + size * 0.85,
            axis: DVec2::X,
            half_m: DVec2::splat(0.22),
            base_m: room_top,
            height_m: rng.range(2.5, 4.5),
        });
    }
    draft.masses[n].roof = Roof::Flat { parapet_m: rng.range(0.5, 1.3), slot: slot::ROOF };
}

const ROOFTOP: Furnishing = Furnishing { base_m: 0.0, machines: 0.7, panels: 0.0, beds: 0.0, bulkhead: 0.6 };

/// An office tower on its site. Tells whether it found room.
pub(super) fn office(work: &mut Work<'_>, place: &Place<'_>, height_m: f64) -> bool {
    let mut rng = place.key.child("office").rng();
    let Some(r) = place.rect(rng.range(3.5, 6.5), 3.0, 3.0) else { return false };
    let (form, mut half) = draw_form(&mut rng);
    let room = DVec2::new(r[1] - r[0], r[3] - r[2]) / 2.0;
    if room.x > room.y && form == Form::Slab {
        half = DVec2::new(half.y, half.x);
    }
    half = half.min(room - DVec2::splat(0.5));
    if half.min_element() < 13.5 || 4.0 * half.x * half.y < 1300.0 {
        return false;
    }
    let slack = room - half;
    let middle = DVec2::new(f64::midpoint(r[0], r[1]), f64::midpoint(r[2], r[3]));
    // To one end, so that the rest is one piece.
    let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let centre = middle + DVec2::new(rng.signed() * slack.x * 0.8, side * slack.y * rng.range(0.75, 0.98));
    let floor_m = rng.range(OFFICE_FLOOR_M[0], OFFICE_FLOOR_M[1]);
    let look = office_facade(&mut rng);
    let lobby_m = rng.range(6.5, 9.5);
    let parapet_m = rng.range(1.0, 2.4);
    let steps = match form {
        Form::Round | Form::Octagon => rng.weighted(&[0.45, 0.4, 0.15]),
        _ => rng.weighted(&[0.5, 0.3, 0.2]),
    };
    let mut masses = Vec::new();
    let (mut low, mut first, mut h) = (GROUNDED, lobby_m, half);
    let mut shape = plate(form, half, &mut rng);
    for k in 0..=steps {
        let share = if k == steps { 1.0 } else { [0.62, 0.82][k.min(1)] + 0.1 * rng.signed() };
        let m = stage(shifted(&shape, centre), [low, height_m * share], first, floor_m, look, parapet_m);
        (low, first) = (m.roof_m - 0.5, m.roof_m + 0.3);
        masses.push(m);
        if k < steps {
            let by = rng.range(0.74, 0.88);
            h *= by;
            // A round or octagonal crown on any shaft, now and then.
            shape = match rng.weighted(&[0.6, 0.2, 0.2]) {
                1 => plate(Form::Octagon, DVec2::splat(h.min_element()), &mut rng),
                2 => plate(Form::Round, DVec2::splat(h.min_element()), &mut rng),
                _ => shape.iter().map(|p| *p * by).collect(),
            };
        }
    }
    let roof_m = low + 0.5;
    let mut draft = Draft::new(Use::Office, masses);
    let inner = if form == Form::Twin { DVec2::new(h.x, h.y * 0.68) } else { h };
    top(&mut draft, centre, inner * 0.92 - DVec2::splat(1.2), roof_m, &mut rng);
    let count = draft.masses.len();
    for k in 0..count - 1 {
        draft.furnish(k, ROOFTOP, &[], &place.key);
    }
    let free = free_end(r, centre, half, side);
    work.floor(place, *rng.pick(&ground::SQUARES));
    work.build(place, "tower", draft);
    let Some(free) = free else { return true };
    if free[3] - free[2] > 17.0 && rng.chance(0.45) {
        wing(work, place, shrunk(free, 1.0), &mut rng);
    } else {
        open::square(work, place, free, &mut rng);
    }
    true
}

/// What a tower leaves of a rectangle at its other end.
fn free_end(r: Rect, centre: DVec2, half: DVec2, side: f64) -> Option<Rect> {
    let free = if side > 0.0 {
        [r[0], r[1], r[2], centre.y - half.y - 3.0]
    } else {
        [r[0], r[1], centre.y + half.y + 3.0, r[3]]
    };
    (free[3] - free[2] > 6.0).then_some(free)
}

/// A low wing of a tower: shops and halls.
fn wing(work: &mut Work<'_>, place: &Place<'_>, r: Rect, rng: &mut Rng) {
    let roof_m = rng.range(6.5, 15.0);
    let cut = rng.range(0.55, 0.8);
    let (x, y) = (r[0] + (r[1] - r[0]) * cut, r[2] + (r[3] - r[2]) * rng.range(0.45, 0.7));
    let outline = [(r[0], r[2]), (r[1], r[2]), (r[1], y), (x, y), (x, r[3]), (r[0], r[3])]
        .map(|(x, y)| DVec2::new(x, y))
        .to_vec();
    let first_floor_m = 5.0;
    let mut mass = plain(outline, GROUNDED, roof_m.max(first_floor_m + 3.5), 1.0);
    mass.facade = Facade::Slabs { recess_m: 0.25, slab_m: rng.range(0.6, 1.3), pier_every: 2 };
    mass.shop = true;
    mass.first_floor_m = first_floor_m;
    mass.floor_m = (mass.roof_m - first_floor_m) / libm::round((mass.roof_m - first_floor_m) / 4.0).max(1.0);
    let mut draft = Draft::new(Use::Office, vec![mass]);
    let what = Furnishing { base_m: 0.0, machines: 0.4, panels: 0.15, beds: 0.25, bulkhead: 0.3 };
    draft.furnish(0, what, &[], &place.key.child("wing"));
    work.build(place, "wing", draft);
}

/// A residential tower on its podium.
pub(super) fn residence(work: &mut Work<'_>, place: &Place<'_>, height_m: f64) -> bool {
    let mut rng = place.key.child("residence").rng();
    let Some(r) = place.rect(rng.range(1.0, 3.0), rng.range(0.5, 2.0), rng.range(0.5, 2.0)) else { return false };
    // The tower stands at one end; a podium of a deep site leaves the other for something low.
    let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let (r, rest) = split_end(r, side, &mut rng);
    let room = DVec2::new(r[1] - r[0], r[3] - r[2]) / 2.0;
    let half = DVec2::new(rng.range(11.0, 14.0), rng.range(14.0, 17.5)).min(room - DVec2::splat(3.0));
    if half.min_element() < 9.0 {
        return false;
    }
    let shop_m = rng.range(4.8, 6.0);
    let levels = 2.0 + rng.below(5) as f64;
    let podium_m = shop_m + 3.1 * levels;
    let mut podium = plain(corners(r), GROUNDED, podium_m, 1.1);
    podium.shop = true;
    podium.first_floor_m = shop_m;
    podium.floor_m = 3.1;
    podium.bay_m = rng.range(4.0, 6.0);
    podium.facade = if rng.chance(0.5) {
        Facade::Slabs { recess_m: 0.3, slab_m: 1.15, pier_every: 2 }
    } else {
        Facade::Punched { recess_m: 0.22, band_m: rng.range(1.2, 1.7), pier_m: rng.range(0.8, 1.6), proud_m: 0.03 }
    };
    podium.roof = Roof::Flat { parapet_m: 1.1, slot: slot::TERRACE };
    let slack = room - half - DVec2::splat(2.5);
    let middle = DVec2::new(f64::midpoint(r[0], r[1]), f64::midpoint(r[2], r[3]));
    let centre = middle + DVec2::new(rng.signed() * slack.x, side * slack.y.max(0.0) * rng.range(0.85, 1.0));
    let floor_m = rng.range(3.0, 3.15);
    let form = [Form::Square, Form::Notched, Form::Chamfered, Form::Twin][rng.weighted(&[0.4, 0.25, 0.15, 0.2])];
    let shape = shifted(&plate(form, half, &mut rng), centre);
    let bay_m = rng.range(2.8, 3.6);
    let facade = if rng.chance(0.7) {
        let pier_every = [0, 2, 3, 4][rng.below(4) as usize];
        Facade::Slabs { recess_m: rng.range(0.15, 0.3), slab_m: rng.range(0.25, 0.6), pier_every }
    } else {
        Facade::Punched {
            recess_m: rng.range(0.18, 0.3),
            band_m: rng.range(0.9, 1.3),
            pier_m: rng.range(0.6, 1.3),
            proud_m: 0.0,
        }
    };
    let mut shaft = stage(
        shape.clone(),
        [podium_m - 0.4, height_m],
        podium_m + 0.25,
        floor_m,
        (facade, bay_m),
        rng.range(0.9, 1.4),
    );
    shaft.balconies = balconies(&shape, bay_m, &mut rng);
    let roof_m = shaft.roof_m;
    let mut draft = Draft::new(Use::Residence, vec![podium, shaft]);
    let inner = if form == Form::Twin { half * DVec2::new(1.0, 0.66) } else { half };
    top(&mut draft, centre, inner - DVec2::splat(1.8), roof_m, &mut rng);
    let mut over = Vec::new();
    if let Some(deck) = free_end(shrunk(r, 1.5), centre, half, side).filter(|d| d[3] - d[2] > 9.0 && d[1] - d[0] > 14.0)
    {
        over.push(corners(pool_deck(&mut draft, deck, podium_m, &mut rng)));
    }
    let calm = Furnishing { base_m: 0.0, machines: 0.15, panels: 0.06, beds: 0.85, bulkhead: 0.3 };
    draft.furnish(0, calm, &over, &place.key);
    draft.furnish(1, ROOFTOP, &[], &place.key);
    work.floor(place, ground::SQUARES[rng.below(3) as usize]);
    work.build(place, "tower", draft);
    match rest {
        Some(rest) if rng.chance(0.5) => wing(work, place, rest, &mut rng),
        Some(rest) => open::square(work, place, rest, &mut rng),
        None => {}
    }
    true
}

/// The part of a deep rectangle at one end, and what is left at the other.
fn split_end(r: Rect, side: f64, rng: &mut Rng) -> (Rect, Option<Rect>) {
    let deep = r[3] - r[2];
    if deep < 58.0 || rng.chance(0.2) {
        return (r, None);
    }
    let keep = deep * rng.range(0.58, 0.76);
    if side > 0.0 {
        let y = r[3] - keep;
        ([r[0], r[1], y, r[3]], Some([r[0], r[1], r[2], y - 2.5]))
    } else {
        let y = r[2] + keep;
        ([r[0], r[1], r[2], y], Some([r[0], r[1], y + 2.5, r[3]]))
    }
}

/// A pool with its deck, cabins and a strip of planting on a podium. Returns what it takes.
pub(super) fn pool_deck(draft: &mut Draft, room: Rect, deck_m: f64, rng: &mut Rng) -> Rect {
    let (wide, deep) =
        (rng.range(9.0, 17.0).min(room[1] - room[0] - 5.0), rng.range(4.5, 7.0).min(room[3] - room[2] - 4.0));
    let x0 = rng.range(room[0] + 2.0, (room[1] - wide - 2.0).max(room[0] + 2.01));
    let y0 = rng.range(room[2] + 1.5, (room[3] - deep - 2.0).max(room[2] + 1.51));
    let water = [x0, x0 + wide, y0, y0 + deep];
    let mut add = |f| draft.extras.push(Extra::Fitting(f));
    pool(water, deck_m).into_iter().for_each(&mut add);
    // Cabins along one side, couches along the other.
    let mut x = x0;
    while x + 2.6 < x0 + wide && y0 + deep + 4.2 < room[3] {
        let cabin = [x, x + 2.4, y0 + deep + 1.6, y0 + deep + 3.8];
        add(super::fittings::block(cabin, [deck_m - 0.1, deck_m + 2.5], [slot::COPING, part::CANOPY]));
        x += rng.range(3.0, 4.4);
    }
    let mut x = x0 + 0.4;
    while x + 0.7 < x0 + wide && y0 - 3.0 > room[2] {
        add(super::fittings::block([x, x + 0.7, y0 - 2.9, y0 - 1.0], [deck_m - 0.1, deck_m + 0.35], [slot::COPING; 2]));
        x += 1.5;
    }
    [x0 - 1.0, x0 + wide + 1.0, y0 - 3.2, y0 + deep + 4.0]
}
