//! What is built beside the water: apartments around courts, restaurants and clubs with their parking, parks at beaches.

use super::super::house::{self, wall_mass};
use super::super::layout::{Line, Slab, SlabUse};
use super::super::lot::{Building, Content, Kind, Plant};
use super::super::paving::Layer;
use super::super::slabs::Site;
use super::super::{Params, ground_slot as slot};
use super::banks::{STUB_M, TURN_M, WALK_M};
use super::harbour::{Cell, Harbour, STONES_M, WALL_M};
use crate::city::california::land::{Land, Sheet};
use crate::kit::buildings::{Furnishing, Mass, Roof, furnish, slot as part};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// From the top of a bank to the parcels: the walk and its planting, m.
const MARGIN_M: f64 = WALK_M + 2.6;
/// Storeys are this high, m.
const STOREY_M: f64 = 3.05;

/// What a parcel is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Apartments,
    Restaurant,
    Club,
    Park,
}

/// A rectangle of the sheet, the axis that its street runs along, and whether that street lies at the far side.
struct Parcel {
    low: DVec2,
    high: DVec2,
    swapped: bool,
    street_far: bool,
    shares: [f64; 4],
}

/// All parcels of a cell whose middle is within reach of the pivot.
pub(super) fn plan(
    params: &Params,
    cell: &Cell,
    harbour: &Harbour,
    land: &Land,
    city: &SeedPath,
    reach: f64,
) -> Vec<(String, Content)> {
    let height = |p: DVec2| land.height_m(p);
    let mut out = Vec::new();
    for (n, parcel) in parcels(cell, harbour).iter().enumerate() {
        let key = city.child("parcel").index(cell.k as u64).index(n as u64);
        let size = parcel.high - parcel.low;
        let length = if parcel.swapped { size.y } else { size.x };
        // Long parcels are divided.
        let count = libm::round(length / key.child("cut").rng().range(66.0, 100.0)).max(1.0);
        for k in 0..count as u64 {
            let at = |share: f64| parcel.low + (parcel.high - parcel.low) * share;
            let (mut low, mut high) = (parcel.low, parcel.high);
            let axis = usize::from(parcel.swapped);
            low[axis] = at(k as f64 / count)[axis] + if k > 0 { 1.0 } else { 0.0 };
            high[axis] = at((k + 1) as f64 / count)[axis];
            if land.world((low + high) * 0.5).length() > reach {
                continue;
            }
            let name = format!("harbour/parcel/{}/{n}/{k}", cell.k);
            let key = key.index(k);
            let size = high - low;
            let slab = Slab {
                name: name.clone(),
                key,
                usage: SlabUse::Park,
                sheet: Sheet {
                    land,
                    origin: low,
                    swapped: parcel.swapped,
                    size: if parcel.swapped { DVec2::new(size.y, size.x) } else { size },
                    bow_m: [0.0; 2],
                },
                street_far: parcel.street_far,
                junction_far: false,
            };
            let mut site = Site::new(&slab, params, &height);
            let mut rng = key.child("use").rng();
            match [Use::Apartments, Use::Restaurant, Use::Club, Use::Park][rng.weighted(&parcel.shares)] {
                Use::Apartments => apartments(&mut site, &mut rng),
                Use::Restaurant => restaurant(&mut site, &mut rng),
                Use::Club => club(&mut site, &mut rng),
                Use::Park => park(&mut site, &mut rng),
            }
            out.push((name, site.out));
        }
    }
    out
}

fn parcels(c: &Cell, h: &Harbour) -> Vec<Parcel> {
    let p = DVec2::new;
    let row = Line::Collector.half_row_m();
    let north = h.streets[1] - Line::Arterial.half_row_m() - 0.2;
    let (west, east) = (c.x[0] + c.mole_m[0] - WALL_M - MARGIN_M, c.x[1] - c.mole_m[1] + WALL_M + MARGIN_M);
    let mole = [0.52, 0.12, 0.24, 0.12];
    let tip = |k: usize| c.tip[k] + STONES_M + MARGIN_M;
    let turn = |k: usize| c.tip[k] + TURN_M + 18.0;
    let sand = if c.sandy_head { 8.0 } else { 0.0 };
    let head = c.head + WALL_M + MARGIN_M + sand;
    let south = h.streets[0] + row + 0.2;
    let bank = h.channel[0] - STONES_M - MARGIN_M - if c.sandy_bank { 37.0 } else { 0.0 };
    let stub = if h.streets[0] + STUB_M + 16.0 < bank { row } else { 16.0 };
    vec![
        Parcel { low: p(c.x[0] + row, turn(0)), high: p(west, north), swapped: true, street_far: false, shares: mole },
        Parcel { low: p(east, turn(1)), high: p(c.x[1] - row, north), swapped: true, street_far: true, shares: mole },
        // The tips of moles are small parks.
        Parcel {
            low: p(c.x[0] + 0.1, tip(0)),
            high: p(west - 8.0, turn(0)),
            swapped: true,
            street_far: false,
            shares: [0.0, 0.0, 0.0, 1.0],
        },
        Parcel {
            low: p(east + 8.0, tip(1)),
            high: p(c.x[1] - 0.1, turn(1)),
            swapped: true,
            street_far: true,
            shares: [0.0, 0.0, 0.0, 1.0],
        },
        Parcel {
            low: p(west + 1.0, head),
            high: p(east - 1.0, north),
            swapped: false,
            street_far: true,
            shares: if c.sandy_head { [0.0, 0.2, 0.1, 0.7] } else { [0.42, 0.34, 0.24, 0.0] },
        },
        Parcel {
            low: p(c.x[0] + stub, south),
            high: p(c.x[1] - stub, bank),
            swapped: false,
            street_far: false,
            shares: if c.sandy_bank { [0.2, 0.2, 0.0, 0.6] } else { [0.55, 0.3, 0.15, 0.0] },
        },
    ]
}

/// A bar of a building under a flat roof, in the building's frame.
fn bar(low: DVec2, high: DVec2, roof_m: f64, parapet_m: f64) -> Mass {
    let mut mass = wall_mass(polygon::rectangle(low, high), roof_m, Roof::Flat { parapet_m, slot: part::ROOF });
    mass.bay_m = 3.6;
    mass.floor_m = STOREY_M;
    mass
}

/// Blocks of flats, each a ring or a bar around a court with a pool, on lawns.
fn apartments(site: &mut Site<'_>, rng: &mut Rng) {
    let size = site.size();
    let lawn = slot::FRONT[rng.weighted(&[0.5, 0.3, 0.2])];
    site.lay(Layer::Yard, &Site::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1), lawn);
    let storeys = [2.0, 3.0, 4.0][rng.weighted(&[0.3, 0.42, 0.28])];
    let mut u = rng.range(3.0, 6.0);
    let mut k = 0;
    while u + 22.0 < size.x {
        let w = rng.range(30.0, 52.0).min(size.x - u - 3.0);
        let (front, deep) = (rng.range(4.0, 6.5), size.y - rng.range(3.0, 5.0));
        let depth = (deep - front).min(54.0);
        block(site, &format!("flats/{k}"), [u, u + w, front, front + depth], storeys, rng);
        // A way in from the street between two blocks.
        let gap = rng.range(7.0, 10.0);
        if u + w + gap < size.x {
            site.lay(Layer::Drive, &Site::rect(u + w + 1.2, u + w + gap - 1.2, -0.3, depth * 0.7), slot::YARD_ASPHALT);
        }
        u += w + gap;
        k += 1;
    }
    site.woods((size.x * size.y / 150.0) as u32, rng, [1.5, size.x - 1.5, 1.5, size.y - 1.5]);
    let mut u = 2.0;
    while u < size.x - 1.0 {
        let (plant, size, v) =
            (if rng.chance(0.5) { Plant::Palm } else { Plant::Shrub }, rng.range(0.7, 1.1), rng.range(1.0, 3.0));
        if rng.unit() < site.params.trees {
            site.tree(u, v, plant, size);
        }
        u += rng.range(3.0, 8.0);
    }
}

fn block(site: &mut Site<'_>, name: &str, [u0, u1, v0, v1]: [f64; 4], storeys: f64, rng: &mut Rng) {
    let (w, d) = (u1 - u0, v1 - v0);
    let half = DVec2::new(w, d) / 2.0;
    let t = rng.range(9.2, 11.4);
    let roof = |rng: &mut Rng| storeys * STOREY_M + 0.3 + rng.range(0.0, 0.4);
    let p = DVec2::new;
    let parapet = rng.range(0.4, 0.9);
    let mut masses = Vec::new();
    let court = w > 2.0 * t + 9.0 && d > 2.0 * t + 8.0;
    if court {
        masses.push(bar(p(-half.x, -half.y), p(half.x, -half.y + t), roof(rng), parapet));
        masses.push(bar(p(-half.x + 0.2, half.y - t), p(half.x - 0.2, half.y), roof(rng) - 0.41, parapet));
        // One wing may be lower, or missing: the court opens to the side.
        let open = rng.weighted(&[0.5, 0.25, 0.25]);
        for (k, sign) in [(1, -1.0), (2, 1.0)] {
            if open != k {
                let (a, b) = (sign * (half.x - 0.5), sign * (half.x - t));
                let less = if storeys > 2.0 && rng.chance(0.35) { STOREY_M } else { 0.0 };
                let top = roof(rng) - 0.83 - less;
                masses.push(bar(p(a.min(b), -half.y + t - 1.2), p(a.max(b), half.y - t + 1.2), top, parapet));
            }
        }
    } else {
        // A bar along the street, stepped where it is long, with a wing towards the water.
        let depth = d.min(rng.range(13.0, 16.5));
        let cut = rng.range(0.35, 0.65) * w - half.x;
        masses.push(bar(p(-half.x, -half.y), p(cut, -half.y + depth), roof(rng), parapet));
        masses.push(bar(
            p(cut - 0.6, -half.y + 1.4),
            p(half.x, (-half.y + depth + 1.2).min(half.y)),
            roof(rng) - 0.41,
            parapet,
        ));
        if d > depth + 6.0 {
            let (a, b) = if rng.chance(0.5) { (-half.x + 0.6, -half.x + 11.0) } else { (half.x - 11.0, half.x - 0.6) };
            masses.push(bar(p(a, -half.y + depth - 2.0), p(b, half.y), roof(rng) - 0.83, parapet));
        }
    }
    let key = site.slab.key.child(name);
    let mut items = Vec::new();
    let over: Vec<Vec<DVec2>> = masses.iter().map(|m| m.outline.clone()).collect();
    for (k, m) in masses.iter().enumerate() {
        let others: Vec<Vec<DVec2>> =
            over.iter().enumerate().filter(|(n, _)| *n != k).map(|(_, o)| polygon::mitred(o, -0.3)).collect();
        let what = Furnishing { base_m: m.roof_m, machines: 0.9, panels: 0.2, beds: 0.0, bulkhead: 0.3 };
        items.extend(furnish(&polygon::mitred(&m.outline, 0.9), &others, what, &key.child("roof").index(k as u64)));
    }
    let middle = (f64::midpoint(u0, u1), f64::midpoint(v0, v1));
    // The frame of the building goes on to the left of the street's way; seen from the land's other side it is turned.
    let axis = site.along(middle.0, middle.1);
    let into = site.at(middle.0, middle.1 + 0.5) - site.at(middle.0, middle.1 - 0.5);
    let axis = if axis.perp().dot(into) > 0.0 { axis } else { -axis };
    let at = site.at(middle.0, middle.1);
    if court {
        let q = |a: f64, b: f64, c: f64, d: f64| Site::rect(u0 + a, u1 - b, v0 + c, v1 - d);
        site.lay(
            Layer::Front,
            &q(t - 1.0, t - 1.0, t - 1.0, t - 1.0),
            *rng.pick(&[slot::PLAZA, slot::DRIVE[5], slot::FRONT[0]]),
        );
        let inner = DVec2::new(w, d) - DVec2::splat(2.0 * t);
        let pool =
            DVec2::new(rng.range(3.0, 5.0).min(inner.x / 2.0 - 2.5), rng.range(2.2, 3.4).min(inner.y / 2.0 - 2.5));
        if pool.min_element() > 1.5 {
            let centre = DVec2::new(middle.0, middle.1) + DVec2::new(rng.signed(), rng.signed()) * 1.2;
            pool_at(site, centre, pool, rng);
        }
    }
    for outline in &over {
        site.taken.push(outline.iter().map(|q| at + axis * q.x + axis.perp() * q.y).collect());
    }
    let ridge_m = masses.iter().map(|m| m.roof_m).fold(0.0, f64::max) + parapet;
    // `grounded` moves the frame to the first mass's middle.
    let plan = house::grounded(at, axis, masses, items, &mut [], site.height_m);
    let name = format!("{}/{name}", site.slab.name);
    site.out.buildings.push((name, Building { kind: Kind::Apartments, plan, extras: Vec::new(), ridge_m }));
}

fn pool_at(site: &mut Site<'_>, centre: DVec2, half: DVec2, rng: &mut Rng) {
    let shape = polygon::rounded(&polygon::rectangle(centre - half, centre + half), rng.range(0.4, 2.0), 3);
    site.lay(Layer::Coping, &polygon::mitred(&shape, -0.35), slot::COPING);
    site.lay(Layer::Water, &shape, slot::POOL[rng.below(3) as usize]);
    if let Some((_, patch)) = site.out.patches.last_mut() {
        patch.lowered = true;
    }
    site.out.pools += 1;
    let outline = polygon::mitred(&shape, -1.0).iter().map(|p| site.at(p.x, p.y)).collect();
    site.taken.push(outline);
}

/// A restaurant or two with a terrace towards the water, parking towards the street.
fn restaurant(site: &mut Site<'_>, rng: &mut Rng) {
    let size = site.size();
    site.lay(Layer::Yard, &Site::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1), slot::FRONT[1]);
    let deep = rng.range(11.0, 17.0).min(size.y - 22.0).max(9.0);
    let count = if size.x > 62.0 { 2 } else { 1 };
    for k in 0..count {
        let (from, to) = (size.x * k as f64 / count as f64 + 4.0, size.x * (k + 1) as f64 / count as f64 - 4.0);
        let w = rng.range(15.0, 24.0).min(to - from);
        let u = rng.range(from, to - w + 0.01);
        let v1 = size.y - rng.range(4.5, 6.5);
        site.lay(
            Layer::Front,
            &Site::rect((u - 5.0).max(0.2), (u + w + 5.0).min(size.x - 0.2), v1 - deep - 2.0, size.y - 0.2),
            slot::PLAZA,
        );
        let key = site.slab.key.child("restaurant").index(k);
        site.flat(&format!("restaurant/{k}"), Kind::Shop, [u, u + w, v1 - deep, v1], rng.range(4.6, 6.6), &key);
    }
    let near = size.y - deep - 10.0;
    site.lay(Layer::Bed, &Site::rect(0.5, size.x - 0.5, 0.4, 3.0), slot::MULCH);
    if near > 21.0 {
        site.parking([1.0, size.x - 1.0, 3.0, near], rng.range(0.5, 0.85), &site.slab.key.child("parking"));
    } else {
        site.lay(Layer::Drive, &Site::rect(1.0, size.x - 1.0, 3.0, near.max(8.0)), slot::YARD_ASPHALT);
    }
    site.woods(10, rng, [1.0, size.x - 1.0, size.y - deep - 8.0, size.y - 0.5]);
}

/// A yacht club or a harbour office with a wide parking lot for those who have a boat here.
fn club(site: &mut Site<'_>, rng: &mut Rng) {
    let size = site.size();
    site.lay(
        Layer::Yard,
        &Site::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1),
        slot::FRONT[rng.weighted(&[0.4, 0.4, 0.2])],
    );
    let w = rng.range(14.0, 30.0).min(0.4 * size.x);
    let deep = rng.range(11.0, 16.0).min(size.y - 8.0);
    let left = rng.chance(0.5);
    let u = if left { 4.0 } else { size.x - w - 4.0 };
    let v1 = size.y - rng.range(3.0, 6.0);
    site.lay(
        Layer::Front,
        &Site::rect((u - 3.0).max(0.2), (u + w + 3.0).min(size.x - 0.2), v1 - deep - 3.0, size.y - 0.2),
        slot::PLAZA,
    );
    let key = site.slab.key.child("club");
    site.flat("club", Kind::Shop, [u, u + w, v1 - deep, v1], rng.range(4.8, 7.8), &key);
    let [a, b] = if left { [u + w + 4.0, size.x - 1.0] } else { [1.0, u - 4.0] };
    let key = site.slab.key.child("parking");
    if b - a > 18.0 {
        site.parking([a, b, 3.0, (size.y - 3.0).min(3.0 + 36.0)], rng.range(0.3, 0.75), &key);
    }
    site.woods(16, rng, [1.0, size.x - 1.0, 0.5, size.y - 0.5]);
}

/// Lawn with palms and paths, parking along the street where there is room.
fn park(site: &mut Site<'_>, rng: &mut Rng) {
    let size = site.size();
    site.lay(Layer::Yard, &Site::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1), slot::TURF);
    let mut lawn = 1.5;
    if size.y > 34.0 && size.x > 34.0 {
        site.parking([4.0, size.x - 4.0, 3.0, 22.0], rng.range(0.4, 0.85), &site.slab.key.child("parking"));
        lawn = 24.0;
    }
    // A path across, crooked.
    let mut v = rng.range(lawn + 2.0, (size.y - 2.0).max(lawn + 2.1));
    let mut u = 0.2;
    while u < size.x - 10.0 {
        let (du, dv) = (rng.range(8.0, 14.0).min(size.x - 0.2 - u), rng.signed() * 3.0);
        let next = (v + dv).clamp(lawn + 1.5, (size.y - 1.5).max(lawn + 1.6));
        let quad = [
            DVec2::new(u, v - 0.9),
            DVec2::new(u + du, next - 0.9),
            DVec2::new(u + du, next + 0.9),
            DVec2::new(u, v + 0.9),
        ];
        site.lay(Layer::Drive, &quad, slot::PLAZA);
        (u, v) = (u + du, next);
    }
    if size.x > 30.0 && size.y > 20.0 && rng.chance(0.6) {
        let u = rng.range(6.0, size.x - 16.0);
        let key = site.slab.key.child("house");
        site.flat("house", Kind::School, [u, u + rng.range(7.0, 11.0), size.y - 11.0, size.y - 5.0], 3.8, &key);
    }
    let count = libm::floor(size.x * (size.y - lawn) / 75.0 * site.params.trees) as u32;
    for _ in 0..count {
        let (u, v) = (rng.range(1.0, size.x - 1.0), rng.range(lawn, size.y - 0.6));
        let plant = [Plant::Palm, Plant::Broad, Plant::Shrub][rng.weighted(&[0.5, 0.3, 0.2])];
        let size = rng.range(0.7, 1.25);
        site.tree(u, v, plant, size);
    }
}
