//! A lot: its house, drive and walks, yards, pool, fences, trees and cars.

use super::Params;
use super::ground_slot as slot;
use super::house::{self, Extra, Room, wall_mass};
use super::layout::{LOCAL_ROADWAY_M, LOCAL_ROW_M, Lot, Rear};
use super::paving::Layer;
use super::urban::Use;
use crate::city::toronto::traffic::draw_body;
use crate::kit::buildings::{BuildingPlan, Roof};
use crate::kit::ground::Patch;
use crate::kit::polygon;
use crate::kit::vehicles::Body;
use glam::DVec2;
use satseed_scene::Rng;

/// What a building is; decides its materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    House,
    Shed,
    Shop,
    School,
    /// Of downtown and of low blocks.
    Urban(Use),
    /// A house under flat roofs.
    Villa,
    /// Flats, two to four storeys.
    Apartments,
}

/// A building of the plan.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Building {
    pub(super) kind: Kind,
    pub(super) plan: BuildingPlan,
    pub(super) extras: Vec<Extra>,
    /// Highest ridge above the ground, m.
    pub(super) ridge_m: f64,
}

/// Plants that are trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plant {
    /// Broad-leaved garden or street tree.
    Broad,
    /// Upright evergreen.
    Upright,
    /// Palm.
    Palm,
    /// Shrub, hedge plant.
    Shrub,
    /// Shrub of dry slopes, wider than high.
    Chaparral,
}

/// A plant in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Planted {
    pub(super) at: DVec2,
    pub(super) plant: Plant,
    /// Factor on its kind's size.
    pub(super) size: f64,
}

/// A vehicle in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parked {
    pub(super) centre: DVec2,
    /// Where it points.
    pub(super) axis: DVec2,
    pub(super) body: Body,
    /// It stands on a carriageway, below the kerb.
    pub(super) lowered: bool,
}

/// A straight wall or fence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fence {
    pub(super) from: DVec2,
    pub(super) to: DVec2,
    pub(super) height_m: f64,
    pub(super) block: bool,
}

/// A piece of a plan: what stands and lies somewhere.
#[derive(Clone, Debug, Default)]
pub(super) struct Content {
    pub(super) buildings: Vec<(String, Building)>,
    pub(super) patches: Vec<(Layer, Patch)>,
    pub(super) plants: Vec<Planted>,
    pub(super) vehicles: Vec<Parked>,
    pub(super) fences: Vec<Fence>,
    pub(super) lights: Vec<(DVec2, DVec2)>,
    /// Vehicles on decks, with the deck's height in the world, m.
    pub(super) raised: Vec<(Parked, f64)>,
    pub(super) pools: u32,
    pub(super) solar: u32,
}

/// A lot's frame: x along its front, y into it, origin in the middle of the front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) centre: DVec2,
    pub(super) axis: DVec2,
}

impl Frame {
    pub(super) fn local(&self, p: DVec2) -> DVec2 {
        let d = p - self.centre;
        DVec2::new(d.dot(self.axis), self.axis.perp_dot(d))
    }

    pub(super) fn world(&self, p: DVec2) -> DVec2 {
        self.centre + self.axis * p.x + self.axis.perp() * p.y
    }

    pub(super) fn outline(&self, local: &[DVec2]) -> Vec<DVec2> {
        local.iter().map(|p| self.world(*p)).collect()
    }

    pub(super) fn patch(&self, layer: Layer, local: &[DVec2], slot: u16) -> (Layer, Patch) {
        let outline = self.outline(local);
        let patch = Patch { origin_m: outline[0], outline, slot, axis: self.axis, lowered: false };
        (layer, patch)
    }
}

/// Left and right border of a convex outline at a height of its frame.
fn interval(outline: &[DVec2], y: f64) -> Option<[f64; 2]> {
    let mut out: Option<[f64; 2]> = None;
    for i in 0..outline.len() {
        let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
        if (a.y > y) != (b.y > y) {
            let x = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
            out = Some(out.map_or([x, x], |[l, r]| [l.min(x), r.max(x)]));
        }
    }
    out
}

/// Side setback, m.
const SIDE_M: f64 = 1.35;

/// Decides a lot.
pub(super) fn plan(params: &Params, lot: &Lot, height_m: &dyn Fn(DVec2) -> f64) -> Content {
    let mut out = Content::default();
    let (p, q) = (lot.outline[0], lot.outline[1]);
    let frame = Frame { centre: (p + q) * 0.5, axis: (q - p).normalize() };
    let local: Vec<DVec2> = lot.outline.iter().map(|p| frame.local(*p)).collect();
    let mut rng = lot.key.child("yard").rng();
    let looks = Looks::draw(&mut rng);
    let inner = polygon::inset(&local, 0.06).unwrap_or_else(|| local.clone());
    out.patches.push(frame.patch(Layer::Yard, &inner, looks.rear));
    let Some((room, deep)) = room(&local, lot.bulge_m, &mut lot.key.child("room").rng()) else {
        scatter(&frame, &inner, params, &[], &mut lot.key.child("trees").rng(), 3, &mut out);
        return out;
    };
    let mut rng = lot.key.child("house").rng();
    let built = if rng.unit() < params.density { house::house(&room, &mut rng) } else { None };
    // Nothing of it may leave the lot.
    let keeps = |m: &crate::kit::buildings::Mass| {
        m.outline.iter().all(|p| polygon::contains(&local, *p) && polygon::border_distance(&local, *p) > 0.7)
    };
    let built = built.filter(|h| keeps(&h.masses[0])).map(|mut h| {
        h.masses.retain(keeps);
        h
    });
    let Some(mut h) = built else {
        scatter(&frame, &inner, params, &[], &mut lot.key.child("trees").rng(), 3, &mut out);
        return out;
    };
    let kind = if lot.hillside {
        house::on_slope(&mut h, &room, deep, &mut lot.key.child("slope").rng())
    } else {
        Kind::House
    };
    if lot.key.child("solar").rng().chance(0.19) {
        let extra = house::solar(&h, frame.axis, &mut lot.key.child("panels").rng());
        out.solar = u32::from(extra.is_some());
        h.extras.extend(extra);
    }
    let footprints: Vec<Vec<DVec2>> = h.masses.iter().map(|m| m.outline.clone()).collect();
    front_yard(&frame, &local, &h, &looks, lot, params, &mut out);
    rear_yard(&frame, &local, &h, &looks, deep, lot, &mut out);
    fences(&frame, &local, &h, lot, &mut out);
    gardens(&frame, &inner, &h, &footprints, lot, params, &mut out);
    cars(&frame, &local, &h, lot, params, &mut out);
    let ridge_m = h.ridge_m;
    let plan = house::grounded(frame.centre, frame.axis, h.masses, h.items, &mut h.extras, height_m);
    out.buildings.insert(0, (format!("{}/house", lot.name), Building { kind, plan, extras: h.extras, ridge_m }));
    for (k, (outline, wall_m)) in sheds(&local, h.rear_m, &mut lot.key.child("shed").rng()).into_iter().enumerate() {
        let roof = Roof::Gable { along_first: k % 2 == 0, rise_m: 0.55, eaves_m: 0.12, hip: 0.0 };
        let clear = |p: &Planted| !polygon::contains(&polygon::mitred(&outline, -1.0), frame.local(p.at));
        out.plants.retain(clear);
        let mass = wall_mass(outline, wall_m, roof);
        let plan = house::grounded(frame.centre, frame.axis, vec![mass], Vec::new(), &mut [], height_m);
        let ridge_m = wall_m + 0.55;
        let shed = Building { kind: Kind::Shed, plan, extras: Vec::new(), ridge_m };
        out.buildings.push((format!("{}/shed", lot.name), shed));
    }
    out
}

/// How a lot's ground looks.
struct Looks {
    front: u16,
    rear: u16,
    drive: u16,
    patio: u16,
}

impl Looks {
    fn draw(rng: &mut Rng) -> Self {
        let front = slot::FRONT[rng.weighted(&[0.2, 0.14, 0.14, 0.14, 0.12, 0.1, 0.05, 0.06, 0.05])];
        let rear = slot::REAR[rng.weighted(&[0.13, 0.13, 0.17, 0.13, 0.16, 0.13, 0.07, 0.08])];
        let drive = slot::DRIVE[rng.weighted(&[0.26, 0.28, 0.2, 0.12, 0.08, 0.06])];
        let patio = slot::DRIVE[rng.weighted(&[0.22, 0.22, 0.2, 0.12, 0.14, 0.1])];
        Self { front, rear, drive, patio }
    }
}

/// Where a house may stand, and the depth of the lot behind it.
fn room(local: &[DVec2], bulge_m: f64, rng: &mut Rng) -> Option<(Room, f64)> {
    let deepest = local.iter().map(|p| p.y).fold(0.0, f64::max);
    let mut front = bulge_m * 0.9 + if bulge_m > 0.0 { rng.range(4.0, 5.0) } else { rng.range(4.6, 5.9) };
    for _ in 0..5 {
        let mut rear = deepest - rng.range(4.6, 6.2);
        let mut x = [f64::MIN, f64::MAX];
        for y in [front, front + 6.0, front + 12.0] {
            let [l, r] = interval(local, y)?;
            x = [x[0].max(l + SIDE_M), x[1].min(r - SIDE_M)];
        }
        // The rear corners of a skew lot may cut off the last rooms.
        let holds = |y: f64| interval(local, y).is_some_and(|[l, r]| l + 0.9 < x[0] && r - 0.9 > x[1]);
        while rear > front + 12.0 && !holds(rear) {
            rear -= 0.5;
        }
        if x[1] - x[0] > 9.5 && rear - front > 11.5 {
            return Some((Room { x, y: [front, rear] }, deepest));
        }
        front += 2.5;
    }
    None
}

fn rect(x0: f64, x1: f64, y0: f64, y1: f64) -> Vec<DVec2> {
    polygon::rectangle(DVec2::new(x0, y0), DVec2::new(x1, y1))
}

/// From the kerb to the property line, m.
const MARGIN_M: f64 = LOCAL_ROW_M - LOCAL_ROADWAY_M;

fn front_yard(
    frame: &Frame,
    local: &[DVec2],
    h: &house::House,
    looks: &Looks,
    lot: &Lot,
    params: &Params,
    out: &mut Content,
) {
    let mut rng = lot.key.child("front").rng();
    let line = f64::midpoint(h.garage[2], h.door.y) + 3.0;
    let inner = polygon::inset(local, 0.1).unwrap_or_else(|| local.to_vec());
    if let Some(front) = polygon::clip(&inner, DVec2::new(0.0, line), -DVec2::Y) {
        out.patches.push(frame.patch(Layer::Front, &front, looks.front));
    }
    let kerb = -MARGIN_M - 0.6;
    let [g0, g1, gy] = h.garage;
    let wide = g1 - g0 > 8.0;
    let trim = if wide { 0.3 } else { rng.range(0.2, 0.7) };
    let (mut d0, mut d1) = (g0 + trim, g1 - trim);
    // Some pave a strip for one car more.
    if rng.chance(0.2) {
        let more = rng.range(1.6, 2.8);
        if f64::midpoint(g0, g1) < 0.0 { d0 -= more } else { d1 += more }
    }
    out.patches.push(frame.patch(Layer::Drive, &rect(d0, d1, kerb, gy + 0.6), looks.drive));
    // A walk from the drive to the door.
    let side = if h.door.x > f64::midpoint(d0, d1) { d1 - 0.1 } else { d0 + 0.1 };
    let walk = rng.range(1.0, 1.6);
    let (w0, w1) = (side.min(h.door.x - 0.7), side.max(h.door.x + 0.7));
    out.patches.push(frame.patch(Layer::Drive, &rect(w0, w1, h.door.y - walk, h.door.y + 0.5), looks.drive));
    if rng.chance(0.25) {
        let x = h.door.x;
        out.patches.push(frame.patch(
            Layer::Drive,
            &rect(x - 0.55, x + 0.55, kerb + 1.6, h.door.y - walk + 0.1),
            looks.drive,
        ));
    }
    // A planted bed along the front.
    if rng.chance(0.6) {
        let far = if h.door.x > f64::midpoint(g0, g1) { h.sides_m[1] } else { h.sides_m[0] };
        let (b0, b1) = if far > h.door.x { (h.door.x + 0.9, far) } else { (far, h.door.x - 0.9) };
        if b1 - b0 > 2.0 {
            let deep = rng.range(0.9, 2.0);
            out.patches.push(frame.patch(Layer::Bed, &rect(b0, b1, h.door.y - deep, h.door.y + 0.2), slot::MULCH));
            let mut x = b0 + 0.5;
            while x < b1 - 0.3 {
                if rng.chance(0.85) {
                    let at = frame.world(DVec2::new(x, h.door.y - rng.range(0.55, 0.9) * deep.min(1.4)));
                    out.plants.push(Planted { at, plant: Plant::Shrub, size: rng.range(0.7, 1.3) });
                }
                x += rng.range(0.9, 1.6);
            }
        }
    }
    if rng.chance(0.58 * params.trees.min(1.6)) {
        // A street tree between kerb and walk.
        let free =
            if f64::midpoint(d0, d1) < 0.0 { [d1 + 1.5, -local[0].x - 1.0] } else { [local[0].x + 1.0, d0 - 1.5] };
        if free[1] > free[0] && lot.bulge_m == 0.0 {
            let at = frame.world(DVec2::new(rng.range(free[0], free[1]), -MARGIN_M + 1.1));
            let plant = if rng.chance(0.16) { Plant::Palm } else { Plant::Broad };
            out.plants.push(Planted { at, plant, size: rng.range(0.75, 1.25) });
        }
    }
}

fn rear_yard(frame: &Frame, local: &[DVec2], h: &house::House, looks: &Looks, deep: f64, lot: &Lot, out: &mut Content) {
    let mut rng = lot.key.child("rear").rng();
    let inside = |q: &[DVec2], by: f64| {
        q.iter().all(|p| polygon::contains(local, *p) && polygon::border_distance(local, *p) > by)
    };
    let [x0, x1] = h.sides_m;
    let main_rear = polygon::bounds(&h.masses[0].outline).1.y;
    // A patio behind the house.
    let width = (x1 - x0) * rng.range(0.35, 0.8);
    let left = rng.range(x0, x1 - width);
    let reach = (h.rear_m - main_rear + rng.range(1.5, 4.0)).min(deep - main_rear - 2.0);
    let patio = rect(left, left + width, main_rear - 0.5, main_rear + reach);
    if reach > 1.5 && inside(&patio, 0.3) {
        out.patches.push(frame.patch(Layer::Drive, &patio, looks.patio));
    }
    // A side yard paved or gravelled.
    if rng.chance(0.5) {
        let strip = if rng.chance(0.5) {
            rect(x0 - 1.3, x0 + 0.3, h.door.y + 3.4, main_rear)
        } else {
            rect(x1 - 0.3, x1 + 1.3, h.door.y + 3.4, main_rear)
        };
        if inside(&strip, 0.12) {
            let slot = *rng.pick(&slot::DRIVE);
            out.patches.push(frame.patch(Layer::Drive, &strip, slot));
        }
    }
    let mut rng = lot.key.child("pool").rng();
    let wanted = rng.chance(0.45);
    if wanted {
        for _ in 0..40 {
            let half = DVec2::new(rng.range(3.5, 4.8), rng.range(1.8, 2.4));
            let turned = rng.chance(0.3);
            let axis = if turned { DVec2::Y } else { DVec2::X };
            let reach = if turned { DVec2::new(half.y, half.x) } else { half };
            let Some([l, r]) = interval(local, (h.rear_m + reach.y + 2.0).min(deep - 0.5)) else { continue };
            let centre = DVec2::new(
                rng.range(l + reach.x + 1.2, (r - reach.x - 1.2).max(l + reach.x + 1.21)),
                rng.range(main_rear + reach.y + 1.6, (deep - reach.y - 1.0).max(main_rear + reach.y + 1.61)),
            );
            let clear = polygon::oriented_rectangle(centre, axis, half + DVec2::splat(1.0));
            let free = inside(&clear, 0.1)
                && !h.masses.iter().any(|m| polygon::convex_overlap(&m.outline, &clear))
                && !h.extras.iter().any(|e| match e {
                    Extra::Cover { low, high, .. } => polygon::convex_overlap(&polygon::rectangle(*low, *high), &clear),
                    _ => false,
                });
            if free {
                pool(frame, centre, axis, half, looks, inside, &mut rng, out);
                break;
            }
        }
    }
}

/// A pool with its coping and deck.
#[allow(clippy::too_many_arguments)]
fn pool(
    frame: &Frame,
    centre: DVec2,
    axis: DVec2,
    half: DVec2,
    looks: &Looks,
    inside: impl Fn(&[DVec2], f64) -> bool,
    rng: &mut Rng,
    out: &mut Content,
) {
    let deck = polygon::oriented_rectangle(centre, axis, half + DVec2::new(rng.range(1.0, 2.6), rng.range(0.9, 2.0)));
    if inside(&deck, 0.3) {
        out.patches.push(frame.patch(Layer::Deck, &polygon::rounded(&deck, 0.8, 2), looks.patio));
    }
    let shape = match rng.below(3) {
        0 => polygon::rounded(&polygon::oriented_rectangle(centre, axis, half), 0.5, 2),
        1 => polygon::rounded(&polygon::oriented_rectangle(centre, axis, half), half.y, 5),
        _ => {
            // A kidney: an oval pressed in on one side.
            let bend = rng.range(0.35, 0.6) * if rng.chance(0.5) { 1.0 } else { -1.0 };
            (0..22)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 22.0);
                    let x = c * half.x;
                    let y = s * half.y * (0.85 - 0.15 * c) + bend * (1.0 - c * c * 1.6) * 0.55;
                    centre + axis * x + axis.perp() * y
                })
                .collect()
        }
    };
    let coping = polygon::mitred(&shape, -0.32);
    out.patches.push(frame.patch(Layer::Coping, &coping, slot::COPING));
    let water = slot::POOL[rng.below(slot::POOL.len() as u64) as usize];
    let (layer, mut patch) = frame.patch(Layer::Water, &shape, water);
    patch.lowered = true;
    out.patches.push((layer, patch));
    out.pools = 1;
}

fn fences(frame: &Frame, local: &[DVec2], h: &house::House, lot: &Lot, out: &mut Content) {
    let mut rng = lot.key.child("fence").rng();
    if rng.chance(0.04) {
        return;
    }
    let block = rng.chance(0.3);
    let height_m = rng.range(1.6, 1.95);
    let start = h.door.y.max(h.garage[2]) + rng.range(2.0, 6.0);
    let n = local.len();
    let inner = polygon::inset(local, 0.03).unwrap_or_else(|| local.to_vec());
    if inner.len() != n {
        return;
    }
    // Edge 0 is the front, the last one the left side; others are rear or right side.
    for i in 1..n {
        let (mut a, mut b) = (inner[i], inner[(i + 1) % n]);
        let side = (b - a).normalize();
        let right = i == 1;
        let left = i == n - 1;
        if right && n == 4 {
            // The neighbour's fence stands on this border.
            continue;
        }
        let is_rear = !left && !right;
        if is_rear && n == 4 && lot.rear == Rear::Shared {
            continue;
        }
        if left && b.y < start {
            let t = (a.y - start) / (a.y - b.y);
            b = a.lerp(b, t.clamp(0.0, 1.0));
        }
        if right && a.y < start {
            let t = (start - a.y) / (b.y - a.y);
            a = a.lerp(b, t.clamp(0.0, 1.0));
        }
        let wall = is_rear && lot.rear == Rear::Wall;
        if a.distance(b) > 1.0 && side.length_squared() > 0.0 {
            let (height_m, block) = if wall { (2.05, true) } else { (height_m, block) };
            out.fences.push(Fence { from: frame.world(a), to: frame.world(b), height_m, block });
        }
    }
    // Across to the house.
    if let Some([l, r]) = interval(&inner, start) {
        for (a, b) in [(l + 0.1, h.sides_m[0] - 0.02), (h.sides_m[1] + 0.02, r - 0.1)] {
            if b - a > 0.6 && b - a < 8.0 {
                let at = |x: f64| frame.world(DVec2::new(x, start));
                out.fences.push(Fence { from: at(a), to: at(b), height_m, block: false });
            }
        }
    }
}

/// Trees and shrubs of the yards, clear of the house and the water.
fn gardens(
    frame: &Frame,
    inner: &[DVec2],
    h: &house::House,
    footprints: &[Vec<DVec2>],
    lot: &Lot,
    params: &Params,
    out: &mut Content,
) {
    let mut rng = lot.key.child("trees").rng();
    let (low, high) = polygon::bounds(inner);
    let mut blocked: Vec<Vec<DVec2>> = footprints.to_vec();
    blocked.push(rect(h.garage[0] - 0.3, h.garage[1] + 0.3, -6.0, h.garage[2] + 1.0));
    let waters: Vec<Vec<DVec2>> = out
        .patches
        .iter()
        .filter(|(layer, _)| *layer == Layer::Coping)
        .map(|(_, p)| p.outline.iter().map(|q| frame.local(*q)).collect())
        .collect();
    blocked.extend(waters);
    let free = |p: DVec2, clear: f64| {
        polygon::contains(inner, p)
            && blocked.iter().all(|o| !polygon::contains(o, p) && polygon::border_distance(o, p) > clear)
    };
    let (front, rear) = (h.door.y, h.rear_m);
    // A tree or two before the house, more behind it and in its corners.
    let lush = rng.range(0.45, 1.6) * params.trees;
    let mut put = |rng: &mut Rng, y: [f64; 2], plant: Plant, size: f64, clear: f64, border: f64| {
        for _ in 0..10 {
            let p = DVec2::new(rng.range(low.x, high.x), rng.range(y[0], y[1].max(y[0] + 0.5)));
            if free(p, clear) && polygon::border_distance(inner, p) > border {
                out.plants.push(Planted { at: frame.world(p), plant, size });
                return;
            }
        }
    };
    let kind = |rng: &mut Rng| match rng.weighted(&[0.72, 0.13, 0.15]) {
        0 => Plant::Broad,
        1 => Plant::Upright,
        _ => Plant::Palm,
    };
    let count = |rng: &mut Rng, mean: f64| libm::floor(mean * lush + rng.unit()) as u32;
    for _ in 0..count(&mut rng, 1.6) {
        let plant = kind(&mut rng);
        put(&mut rng, [0.5, front], plant, 0.5 + 0.7 * lush.sqrt().min(1.4) * 0.8, 1.3, 0.8);
    }
    for _ in 0..count(&mut rng, 6.2) {
        let plant = kind(&mut rng);
        let size = rng.range(0.65, 1.45);
        put(&mut rng, [f64::midpoint(front, rear), high.y], plant, size, 1.2, 0.7);
    }
    for _ in 0..count(&mut rng, 5.0) {
        let size = rng.range(0.6, 1.5);
        put(&mut rng, [front, high.y], Plant::Shrub, size, 0.6, 0.5);
    }
    for _ in 0..count(&mut rng, 2.5) {
        let size = rng.range(0.5, 1.2);
        put(&mut rng, [0.3, front], Plant::Shrub, size, 0.6, 0.5);
    }
    // A hedge along a border.
    if rng.chance(0.24) {
        let i = if rng.chance(0.6) { 2 % inner.len() } else { inner.len() - 1 };
        let (a, b) = (inner[i], inner[(i + 1) % inner.len()]);
        let inward = (b - a).normalize().perp();
        let length = a.distance(b);
        let size = rng.range(1.0, 1.6);
        let mut s = 0.8;
        while s < length - 0.8 {
            let p = a.lerp(b, s / length) + inward * 0.7;
            if p.y > front && free(p, 0.7) {
                out.plants.push(Planted { at: frame.world(p), plant: Plant::Shrub, size: size * rng.range(0.9, 1.15) });
            }
            s += rng.range(0.7, 1.0);
        }
    }
}

/// Trees and shrubs on open land.
fn scatter(
    frame: &Frame,
    inner: &[DVec2],
    params: &Params,
    blocked: &[Vec<DVec2>],
    rng: &mut Rng,
    trees: u32,
    out: &mut Content,
) {
    let (low, high) = polygon::bounds(inner);
    for _ in 0..libm::floor(f64::from(trees) * params.trees + rng.unit()) as u32 {
        let p = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
        if polygon::contains(inner, p) && blocked.iter().all(|o| !polygon::contains(o, p)) {
            let plant = if rng.chance(0.6) { Plant::Broad } else { Plant::Shrub };
            out.plants.push(Planted { at: frame.world(p), plant, size: rng.range(0.6, 1.3) });
        }
    }
}

/// Cars on the drive and at the kerb.
fn cars(frame: &Frame, local: &[DVec2], h: &house::House, lot: &Lot, params: &Params, out: &mut Content) {
    let mut rng = lot.key.child("cars").rng();
    let [g0, g1, gy] = h.garage;
    let places = if g1 - g0 > 8.0 { 3 } else { 2 };
    for k in 0..places {
        let x = g0 + (g1 - g0) * (f64::from(k) + 0.5) / f64::from(places);
        if rng.chance(0.36 * params.vehicles.min(2.0)) {
            let body = draw_body(&mut rng, false);
            let length = body.size_m()[0];
            let axis = frame.axis.perp() * if rng.chance(0.75) { 1.0 } else { -1.0 };
            let y = gy - length / 2.0 - rng.range(0.5, 1.6);
            if y - length / 2.0 > -0.6 {
                out.vehicles.push(Parked { centre: frame.world(DVec2::new(x, y)), axis, body, lowered: false });
            }
        }
    }
    // The kerb beside the drive.
    let (d0, d1) = (g0 - 0.6, g1 + 0.6);
    let (l, r) = (local[0].x, local[1].x);
    let free = if d0 - l > r - d1 { [l, d0] } else { [d1, r] };
    if lot.bulge_m == 0.0 && free[1] - free[0] > 6.2 && rng.chance(0.42 * params.vehicles.min(2.0)) {
        let body = draw_body(&mut rng, false);
        let x = f64::midpoint(free[0], free[1]) + rng.signed() * 0.8;
        let at = frame.world(DVec2::new(x, -MARGIN_M - 1.2 - rng.range(0.0, 0.2)));
        out.vehicles.push(Parked { centre: at, axis: -frame.axis, body, lowered: true });
    }
}

/// Sheds in a rear corner: outline and height of the wall.
fn sheds(local: &[DVec2], rear_m: f64, rng: &mut Rng) -> Vec<(Vec<DVec2>, f64)> {
    if !rng.chance(0.26) || local.len() != 4 {
        return Vec::new();
    }
    let half = DVec2::new(rng.range(1.1, 2.0), rng.range(0.9, 1.5));
    let corner = if rng.chance(0.5) {
        local[2] + DVec2::new(-half.x - 0.7, -half.y - 0.7)
    } else {
        local[3] + DVec2::new(half.x + 0.7, -half.y - 0.7)
    };
    let outline = polygon::oriented_rectangle(corner, DVec2::X, half);
    let sound = outline
        .iter()
        .all(|p| polygon::contains(local, *p) && polygon::border_distance(local, *p) > 0.3 && p.y > rear_m + 0.8);
    if sound { vec![(outline, rng.range(1.9, 2.3))] } else { Vec::new() }
}
