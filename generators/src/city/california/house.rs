//! Houses: wings under hipped or gabled roofs that run into each other, a garage towards the street, and what is on them.
//!
//! Everything is drawn in the lot's frame: x along the street, y into the lot.

use super::lot::Kind;
use super::urban::fittings::Fitting;
use crate::kit::buildings::{BuildingPlan, Facade, Mass, Roof, RoofItem, RoofItemKind, slot};
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, Rng};

/// The part of a lot that a house may stand on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// Left and right limit, m.
    pub(super) x: [f64; 2],
    /// Front and rear limit, m.
    pub(super) y: [f64; 2],
}

/// A thing of a house that is neither mass nor roof item.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Extra {
    /// Solar panels on a slope: lower left corner (seen from the eaves), along the eaves, up the slope (plan), height of the
    /// roof at the corner, rise for each metre up in plan, panels along and up.
    Solar { corner: DVec2, along: DVec2, up: DVec2, height_m: f64, slope: f64, count: [u32; 2] },
    /// A door in a wall: its middle, direction along the wall, width, height.
    Door { centre: DVec2, along: DVec2, width_m: f64, height_m: f64 },
    /// A flat cover on posts: outline, height.
    Cover { low: DVec2, high: DVec2, height_m: f64 },
    /// Part of a larger building.
    Fitting(Fitting),
    /// A deck on posts over falling ground: outline. Its floor lies a step above the pad.
    Deck { low: DVec2, high: DVec2 },
}

/// A house in its lot's frame, and the pieces of ground that belong to it.
#[derive(Clone, Debug)]
pub(super) struct House {
    pub(super) masses: Vec<Mass>,
    pub(super) items: Vec<RoofItem>,
    pub(super) extras: Vec<Extra>,
    /// Left and right side of the garage, and its front, m.
    pub(super) garage: [f64; 3],
    /// Where the front door is.
    pub(super) door: DVec2,
    /// Where the rear yard begins.
    pub(super) rear_m: f64,
    /// Left and right wall, m.
    pub(super) sides_m: [f64; 2],
    /// Highest ridge above the ground, m.
    pub(super) ridge_m: f64,
}

/// What all wings of a house share.
struct Style {
    slope: f64,
    eaves_m: f64,
    hip: bool,
}

/// How far below the ground walls begin before the terrain is known, m.
pub(super) const GROUNDED: f64 = -1.0;

pub(super) fn wall_mass(outline: Vec<DVec2>, roof_m: f64, roof: Roof) -> Mass {
    Mass {
        outline,
        low_m: GROUNDED,
        roof_m,
        first_floor_m: 0.3,
        floor_m: 2.75,
        bay_m: 3.4,
        shop: false,
        facade: Facade::Plain,
        roof,
        balconies: Vec::new(),
    }
}

/// A wing over a rectangle, its ridge along the longer side or as told.
fn wing([x0, x1, y0, y1]: [f64; 4], wall_m: f64, along_x: bool, hip: bool, style: &Style) -> Mass {
    let size = DVec2::new(x1 - x0, y1 - y0);
    let (along, across) = if along_x { (size.x, size.y) } else { (size.y, size.x) };
    let e = style.eaves_m;
    let rise_m = (across / 2.0 + e) * style.slope;
    let hip = if hip { ((across + 2.0 * e) / (along + 2.0 * e)).min(0.98) } else { 0.0 };
    let outline = polygon::rectangle(DVec2::new(x0, y0), DVec2::new(x1, y1));
    wall_mass(outline, wall_m, Roof::Gable { along_first: along_x, rise_m, eaves_m: e, hip })
}

fn ridge_m(mass: &Mass) -> f64 {
    match mass.roof {
        Roof::Gable { rise_m, .. } => mass.roof_m + rise_m,
        Roof::Flat { parapet_m, .. } => mass.roof_m + parapet_m,
    }
}

/// A house that fills a room, or none where that is too small.
pub(super) fn house(room: &Room, rng: &mut Rng) -> Option<House> {
    let (width, depth) = (room.x[1] - room.x[0], room.y[1] - room.y[0]);
    if width < 8.4 || depth < 11.0 {
        return None;
    }
    let two = rng.chance(if width < 11.0 { 0.7 } else { 0.37 });
    let hip = rng.chance(0.55);
    let mut style = Style { slope: rng.range(0.33, 0.47), eaves_m: rng.range(0.42, 0.6), hip };
    let flip = rng.chance(0.5);
    let width = width.min(rng.range(15.0, 19.0));
    let slack = room.x[1] - room.x[0] - width;
    let shift = slack * rng.range(0.2, 0.8);
    let (x0, x1) = (room.x[0] + shift, room.x[0] + shift + width);
    let front = room.y[0];
    let main_depth = if two { rng.range(11.2, 13.8) } else { rng.range(12.8, 15.6) }.min(depth - 1.5);
    let forward = if rng.chance(0.75) { rng.range(2.0, 5.0) } else { 0.0 }.min(depth - main_depth);
    let (m0, m1) = (front + forward, front + forward + main_depth);
    // One storey is 4.5 to 5.5 m high at its ridge, two are 7 to 8.5 m.
    let low_wall = rng.range(2.5, 2.85);
    let main_wall = if two { rng.range(5.15, 5.55) } else { low_wall };
    let half = main_depth.min(width) / 2.0 + style.eaves_m;
    let limits = if two { [7.05, 8.45] } else { [4.55, 5.5] };
    style.slope = style.slope.clamp((limits[0] - main_wall) / half, (limits[1] - main_wall) / half);
    let mut masses = Vec::new();
    let along_x = width >= main_depth;
    let partial = two && width > 11.5 && rng.chance(0.6);
    if partial {
        // Two storeys over a part, the rest one storey.
        let upper = (width * rng.range(0.55, 0.75)).max(main_depth).min(width);
        let left = rng.chance(0.5);
        let (u0, u1) = if left { (x0, x0 + upper) } else { (x1 - upper, x1) };
        masses.push(wing([u0, u1, m0, m1], main_wall, upper >= main_depth, style.hip, &style));
        let (l0, l1) = if left { (u1 - 1.5, x1) } else { (x0, u0 + 1.5) };
        let inset = rng.range(0.0, 0.8);
        masses.push(wing([l0, l1, m0 + inset, m1 - 0.2], low_wall, true, style.hip, &style));
    } else {
        masses.push(wing([x0, x1, m0, m1], main_wall, along_x, style.hip, &style));
    }
    let middle = f64::midpoint(m0, m1);
    // How far into the main body a wing must reach so that its roof ends under the other.
    let root = |half: f64| if style.hip { (middle + half + style.eaves_m).min(m1 - 1.2) } else { middle };
    let cars = if width > 15.5 && rng.chance(0.3) { rng.range(8.6, 9.4) } else { rng.range(5.9, 6.6) };
    let (g0, g1) = if flip { (x1 - cars, x1) } else { (x0, x0 + cars) };
    let same = |rng: &mut Rng| if rng.chance(0.78) { style.hip } else { !style.hip };
    let mut extras = Vec::new();
    let mut garage_front = m0;
    if forward > 1.0 {
        let hip = same(rng);
        let end = if two { m0 + 1.6 } else { root(cars / 2.0) };
        masses.push(wing([g0, g1, front, end], low_wall - 0.03, false, hip, &style));
        garage_front = front;
    }
    let door_width = if cars > 8.0 { 7.6 } else { 4.9 };
    extras.push(Extra::Door {
        centre: DVec2::new(f64::midpoint(g0, g1), garage_front),
        along: DVec2::X,
        width_m: door_width,
        height_m: 2.15,
    });
    // An entry or a room towards the street beside the garage.
    let (o0, o1) = if flip { (x0, g0 - 0.4) } else { (g1 + 0.4, x1) };
    let mut door = DVec2::new(if flip { g0 - 1.2 } else { g1 + 1.2 }, m0);
    if o1 - o0 > 4.2 && rng.chance(0.8) {
        let w = rng.range(3.8, 6.6).min(o1 - o0);
        let out = rng.range(1.2, 3.4).min(m0 - room.y[0]).max(0.0);
        let left = if flip { o0 } else { o1 - w };
        if out > 0.6 {
            let end = if two { m0 + 1.6 } else { root(w / 2.0) };
            let hip = same(rng);
            masses.push(wing([left, left + w, m0 - out, end], low_wall - 0.05, false, hip, &style));
        }
        door.y = m0;
    }
    // Rooms towards the garden.
    let mut rear = m1;
    let left_over = room.y[1] - m1;
    let wings = if left_over > 1.5 { rng.weighted(&[0.03, 0.65, 0.32]) } else { 0 };
    let first_left = rng.chance(0.5);
    for k in 0..wings {
        let at_left = (k == 0) == first_left;
        let w = if wings == 2 { rng.range(0.3, 0.4) } else { rng.range(0.55, 0.8) } * width;
        let w = w.clamp(3.8, 11.5);
        let out = rng.range(4.2, 9.0).min(left_over);
        let (a, b) = if at_left { (x0, x0 + w) } else { (x1 - w, x1) };
        let start = if two {
            m1 - 1.6
        } else {
            middle.min(m1 - 1.2 - 0.0) - if style.hip { w / 2.0 + style.eaves_m } else { 0.0 }
        };
        let start = start.max(m0 + 1.2);
        let hip = same(rng);
        masses.push(wing([a, b, start, m1 + out], low_wall - 0.04 - 0.03 * k as f64, false, hip, &style));
        rear = rear.max(m1 + out);
    }
    let main = masses[0].clone();
    let mut items = Vec::new();
    furnish(&main, &style, rng, &mut items);
    if rng.chance(0.5) {
        let span = (x1 - x0) * rng.range(0.3, 0.55);
        let at = rng.range(x0 + 0.3, (x1 - span - 0.3).max(x0 + 0.31));
        let far = m1 + rng.range(2.6, 4.0);
        if far < room.y[1] + 1.2 {
            let low = DVec2::new(at, m1 - 0.2);
            extras.push(Extra::Cover { low, high: DVec2::new(at + span, far), height_m: rng.range(2.3, 2.45) });
            rear = rear.max(far);
        }
    }
    let ridge = masses.iter().map(ridge_m).fold(0.0, f64::max);
    Some(House {
        masses,
        items,
        extras,
        garage: [g0, g1, garage_front],
        door,
        rear_m: rear,
        sides_m: [x0, x1],
        ridge_m: ridge,
    })
}

/// Height of a wing's roof over a place of its rectangle, m.
fn roof_height_m(mass: &Mass, style: &Style, p: DVec2) -> f64 {
    let (low, high) = polygon::bounds(&mass.outline);
    let Roof::Gable { along_first, hip, .. } = mass.roof else { return mass.roof_m };
    let (dx, dy) = ((p.x - low.x).min(high.x - p.x), (p.y - low.y).min(high.y - p.y));
    let (across, along) = if along_first { (dy, dx) } else { (dx, dy) };
    let d = if hip > 0.0 { across.min(along) } else { across };
    mass.roof_m + (d + style.eaves_m) * style.slope
}

/// Pipes, vents, a chimney, seldom a cooler.
fn furnish(main: &Mass, style: &Style, rng: &mut Rng, items: &mut Vec<RoofItem>) {
    let (low, high) = polygon::bounds(&main.outline);
    let mut put = |kind: RoofItemKind, p: DVec2, half: DVec2, height: f64| {
        let base_m = roof_height_m(main, style, p) - 0.05;
        items.push(RoofItem { kind, centre_m: p, axis: DVec2::X, half_m: half, base_m, height_m: height });
    };
    for _ in 0..2 + rng.below(5) {
        let p = DVec2::new(rng.range(low.x + 0.8, high.x - 0.8), rng.range(low.y + 0.8, high.y - 0.8));
        let wide = rng.chance(0.3);
        let half = if wide { DVec2::splat(0.24) } else { DVec2::splat(rng.range(0.07, 0.14)) };
        put(RoofItemKind::Vent, p, half, rng.range(0.35, 0.55));
    }
    if rng.chance(0.5) {
        let x = if rng.chance(0.5) { low.x + 0.5 } else { high.x - 0.5 };
        let p = DVec2::new(x, low.y + (high.y - low.y) * rng.range(0.3, 0.7));
        let height = main.roof_m + (high - low).min_element() / 2.0 * style.slope + 0.6 - roof_height_m(main, style, p);
        put(RoofItemKind::Chimney, p, DVec2::new(0.35, rng.range(0.45, 0.8)), height.max(0.9));
    }
    if rng.chance(0.12) {
        let p = DVec2::new(rng.range(low.x + 2.0, high.x - 2.0), rng.range(low.y + 2.0, high.y - 2.0));
        put(RoofItemKind::AirHandler, p, DVec2::new(0.6, 0.5), 0.8);
    }
}

/// Solar panels on the slope of the main roof that looks most to the south; `axis` is the lot's x in the world.
pub(super) fn solar(house: &House, axis: DVec2, rng: &mut Rng) -> Option<Extra> {
    let main = &house.masses[0];
    let Roof::Gable { along_first, rise_m, eaves_m, hip } = main.roof else { return None };
    let (low, high) = polygon::bounds(&main.outline);
    let along = if along_first { DVec2::X } else { DVec2::Y };
    // The two long slopes look along +-`along.perp()`; the one whose outward side is most southern.
    let out = [along.perp(), -along.perp()];
    let southness = |d: DVec2| -(axis * d.x + axis.perp() * d.y).y;
    let outward = if southness(out[0]) >= southness(out[1]) { out[0] } else { out[1] };
    let size = high - low;
    let (run, across) = if along_first { (size.x, size.y) } else { (size.y, size.x) };
    let half = across / 2.0 + eaves_m;
    let slope = rise_m / half;
    let tilt = (1.0 + slope * slope).sqrt();
    let up_rows = (libm::floor((half - 1.1) * tilt / 1.68) as u32).min(1 + rng.below(3) as u32);
    if up_rows == 0 {
        return None;
    }
    let top = 0.7 + f64::from(up_rows) * 1.68 / tilt;
    let free = if hip > 0.0 { run + 2.0 * eaves_m - 2.0 * (top + 0.3) } else { run - 0.8 };
    let most = libm::floor(free / 1.02);
    if most < 3.0 {
        return None;
    }
    let count = (3 + rng.below(9) as u32).min(most as u32);
    let length = f64::from(count) * 1.02;
    let spare = free - length;
    let start = -length / 2.0 + spare * 0.5 * rng.signed();
    let centre = (low + high) * 0.5;
    // Seen from the eaves, left to right and up.
    let up = -outward;
    let right = -up.perp();
    let corner = centre + outward * (half - 0.7) + right * start;
    let height_m = main.roof_m + 0.7 * slope + 0.12;
    Some(Extra::Solar { corner, along: right, up, height_m, slope, count: [count, up_rows] })
}

/// Adds extras to a building's mesh; they are in the building's frame.
pub(super) fn add_extras(mesh: &mut Mesh, extras: &[Extra]) {
    let mut b = MeshBuilder::default();
    for extra in extras {
        match extra {
            Extra::Door { centre, along, width_m, height_m } => {
                b.block(slot::GUARD, slot::GUARD, *centre, *along, DVec2::new(width_m / 2.0, 0.05), -0.2, *height_m);
            }
            Extra::Cover { low, high, height_m } => {
                let slab = polygon::rectangle(*low, *high);
                b.prism(slot::TERRACE, slot::TERRACE, &slab, *height_m, height_m + 0.16, Wall::PLAIN);
                let posts = 2 + u32::from(high.x - low.x > 6.0);
                for k in 0..posts {
                    let share = f64::from(k) / f64::from(posts - 1);
                    let x = low.x + 0.2 + (high.x - low.x - 0.4) * share;
                    let foot = DVec2::new(x, high.y - 0.2);
                    b.block(slot::COPING, slot::COPING, foot, DVec2::X, DVec2::splat(0.07), -0.5, height_m + 0.05);
                }
            }
            Extra::Fitting(f) => f.add(&mut b),
            Extra::Deck { low, high } => deck(&mut b, *low, *high),
            Extra::Solar { corner, along, up, height_m, slope, count } => {
                solar_slab(&mut b, *corner, *along, *up, *height_m, *slope, *count);
            }
        }
    }
    mesh.append(b.finish());
}

/// How deep the posts of a deck reach below the pad, m: deeper than a bank falls below its outer edge.
const POSTS_M: f64 = 4.5;

fn deck(b: &mut MeshBuilder, low: DVec2, high: DVec2) {
    b.prism(slot::TERRACE, slot::TERRACE, &polygon::rectangle(low, high), -0.1, 0.18, Wall::PLAIN);
    let posts = libm::ceil((high.x - low.x) / 3.2).max(2.0) as u32;
    for k in 0..=posts {
        let x = low.x + 0.15 + (high.x - low.x - 0.3) * f64::from(k) / f64::from(posts);
        b.block(slot::COPING, slot::COPING, DVec2::new(x, high.y - 0.3), DVec2::X, DVec2::splat(0.1), -POSTS_M, 0.05);
    }
    // A rail on the three free sides.
    let rail = [(low.x + 0.05, true), (high.x - 0.05, true), (high.y - 0.05, false)];
    for (at, side) in rail {
        let (centre, half) = if side {
            (DVec2::new(at, f64::midpoint(low.y, high.y)), DVec2::new(0.04, (high.y - low.y) / 2.0 - 0.1))
        } else {
            (DVec2::new(f64::midpoint(low.x, high.x), at), DVec2::new((high.x - low.x) / 2.0 - 0.1, 0.04))
        };
        b.block(slot::COPING, slot::COPING, centre, DVec2::X, half, 0.1, 1.1);
    }
}

/// What a slope makes of a house: many have flat roofs on several levels, some a deck beyond the pad's rear edge.
pub(super) fn on_slope(house: &mut House, room: &Room, deep_m: f64, rng: &mut Rng) -> Kind {
    if rng.chance(0.45) {
        let (low, high) = (house.sides_m[0].max(room.x[0] + 0.5), house.sides_m[1].min(room.x[1] - 0.5));
        let width = (high - low) * rng.range(0.45, 0.9);
        let x = rng.range(low, high - width + 0.01);
        let out = rng.range(2.4, 3.8);
        house.extras.push(Extra::Deck {
            low: DVec2::new(x, deep_m - rng.range(1.0, 2.2)),
            high: DVec2::new(x + width, deep_m + out),
        });
    }
    if !rng.chance(0.48) {
        return Kind::House;
    }
    let parapet_m = rng.range(0.2, 0.6);
    for (k, mass) in house.masses.iter_mut().enumerate() {
        // Each level a little lower than the one before: none shares a plane with another.
        mass.roof_m += 0.5 - 0.17 * k as f64;
        mass.roof = Roof::Flat { parapet_m, slot: slot::ROOF };
    }
    let main = &house.masses[0];
    for item in &mut house.items {
        item.base_m = main.roof_m;
        item.height_m = item.height_m.min(0.9);
    }
    house.ridge_m = house.masses.iter().map(ridge_m).fold(0.0, f64::max);
    Kind::Villa
}

fn solar_slab(b: &mut MeshBuilder, corner: DVec2, along: DVec2, up: DVec2, height_m: f64, slope: f64, count: [u32; 2]) {
    let tilt = (1.0 + slope * slope).sqrt();
    let (length, rise) = (f64::from(count[0]) * 1.02, f64::from(count[1]) * 1.68);
    let run = rise / tilt;
    let p = |u: f64, v: f64, lift: f64| -> DVec3 { (corner + along * u + up * v).extend(height_m + v * slope + lift) };
    let (low, high) = (-0.05, 0.14);
    let ring = |lift: f64| [p(0.0, 0.0, lift), p(length, 0.0, lift), p(length, run, lift), p(0.0, run, lift)];
    let (bottom, top) = (ring(low), ring(high));
    let uv = [DVec2::ZERO, DVec2::new(length, 0.0), DVec2::new(length, rise), DVec2::new(0.0, rise)];
    b.fan(slot::PANEL, &[(top[0], uv[0]), (top[1], uv[1]), (top[2], uv[2]), (top[3], uv[3])]);
    b.fan(slot::METAL, &[(bottom[3], uv[3]), (bottom[2], uv[2]), (bottom[1], uv[1]), (bottom[0], uv[0])]);
    for k in 0..4 {
        let n = (k + 1) % 4;
        b.fan(slot::METAL, &[(bottom[k], uv[k]), (bottom[n], uv[n]), (top[n], uv[n]), (top[k], uv[k])]);
    }
}

/// A building plan out of masses drawn in a lot's frame: moved to its own middle, its feet in the ground.
pub(super) fn grounded(
    centre: DVec2,
    axis: DVec2,
    mut masses: Vec<Mass>,
    mut items: Vec<RoofItem>,
    extras: &mut [Extra],
    height_m: &dyn Fn(DVec2) -> f64,
) -> BuildingPlan {
    let middle = polygon::centroid(&masses[0].outline);
    for p in masses.iter_mut().flat_map(|m| m.outline.iter_mut()) {
        *p -= middle;
    }
    for i in &mut items {
        i.centre_m -= middle;
    }
    for e in extras {
        match e {
            Extra::Fitting(f) => f.shift(-middle),
            Extra::Solar { corner, .. } => *corner -= middle,
            Extra::Door { centre, .. } => *centre -= middle,
            Extra::Cover { low, high, .. } | Extra::Deck { low, high } => {
                *low -= middle;
                *high -= middle;
            }
        }
    }
    let world = centre + axis * middle.x + axis.perp() * middle.y;
    let ground_m = height_m(world);
    let mut plan = BuildingPlan { centre_m: world, axis, ground_m, drop_m: 0.0, masses, items };
    let feet = plan.masses.iter().flat_map(|m| m.outline.iter());
    let lowest = feet.map(|p| height_m(plan.to_world(*p))).fold(ground_m, f64::min);
    plan.drop_m = ground_m - lowest;
    for m in plan.masses.iter_mut().filter(|m| m.low_m < 0.0) {
        m.low_m = -plan.drop_m - 1.0;
    }
    plan
}
