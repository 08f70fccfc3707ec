//! A block: its character, its sites and what each is used for.
//!
//! Characters and tower heights are drawn from a two-dimensional low-discrepancy sequence over the block's indices
//! (Roberts 2018, the R2 sequence, from a random start): neighbours differ, and every frame of a few hundred metres has
//! about the share of towers that the whole city has.

use super::houses::{self, Yard};
use super::massing::{self, Building, Frame, Relief};
use super::{Params, Variant, ground_slot};
use crate::kit::ground::Patch;
use crate::kit::parcels::{Site, subdivide};
use crate::kit::polygon;
use crate::kit::streets::Block;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};
use serde::{Deserialize, Serialize};

/// What prevails in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Character {
    /// Residential towers.
    Towers,
    /// Office towers.
    Offices,
    /// Mid-rise, shops, some towers.
    Mixed,
    /// Brick rows.
    Rows,
    /// A public garden.
    Park,
}

/// Cars stand here: centre, direction, world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stall {
    /// Centre.
    pub centre: DVec2,
    /// Direction a car points to.
    pub axis: DVec2,
}

/// A block with everything decided.
#[derive(Clone, Debug)]
pub(super) struct BlockPlan {
    /// What prevails.
    pub character: Character,
    /// Buildings with their path within the block.
    pub buildings: Vec<(String, Building)>,
    /// Ground inside the property line, the later on top.
    pub patches: Vec<Patch>,
    /// Where trees may stand, world.
    pub trees: Vec<DVec2>,
    /// Parking spaces.
    pub stalls: Vec<Stall>,
    /// Cleared sites, for a crane: centre.
    pub cleared: Vec<DVec2>,
}

/// The R2 sequence over block indices, 0..1.
fn spread(start: f64, i: i64, j: i64) -> f64 {
    let x = start + i as f64 * 0.754_877_666_246_692_7 + j as f64 * 0.569_840_290_998_053_2;
    x - libm::floor(x)
}

fn character(params: &Params, block: &Block, city: &SeedPath) -> Character {
    let [i, j] = block.index;
    if i == 0 && j == 0 {
        // The pivot always has something tall to look at.
        return Character::Towers;
    }
    let start = city.child("character").rng().unit();
    let u = spread(start, i, j);
    let limits = match params.variant {
        Variant::Core => [0.56, 0.72, 0.93, 0.98],
        Variant::Midtown => [0.06, 0.08, 0.48, 0.95],
    };
    let order = [Character::Towers, Character::Offices, Character::Mixed, Character::Rows, Character::Park];
    order[limits.iter().take_while(|l| u >= **l).count()]
}

/// Width of the next site along a street, m.
fn site_width_m(character: Character, path: &SeedPath) -> f64 {
    let mut rng = path.rng();
    match character {
        Character::Towers => rng.range(32.0, 50.0),
        Character::Offices => rng.range(44.0, 66.0),
        Character::Mixed => {
            let [from, to] = *rng.pick(&[[14.0, 24.0], [22.0, 34.0], [34.0, 48.0]]);
            rng.range(from, to)
        }
        Character::Rows => rng.range(28.0, 60.0),
        Character::Park => 1000.0,
    }
}

/// Plans a block.
pub(super) fn plan(params: &Params, block: &Block, relief: &Relief<'_>, city: &SeedPath) -> BlockPlan {
    let path = city.child("block").index(block.index[0] as u64).index(block.index[1] as u64);
    let character = character(params, block, city);
    let mut out = BlockPlan {
        character,
        buildings: Vec::new(),
        patches: Vec::new(),
        trees: Vec::new(),
        stalls: Vec::new(),
        cleared: Vec::new(),
    };
    let mut rng = path.child("lane").rng();
    let lane_m = match character {
        Character::Park => 0.0,
        _ => rng.range(4.0, 6.0),
    };
    let cut = subdivide(&block.property, lane_m, &path, |p| site_width_m(character, p));
    let axis = (block.property[1] - block.property[0]).normalize();
    let patch = |outline: Vec<DVec2>, slot: u16| Patch { origin_m: outline[0], outline, slot, axis, lowered: false };
    if let Some(ground) = polygon::inset(&block.property, 0.08) {
        out.patches
            .push(patch(ground, if character == Character::Park { ground_slot::LAWN } else { ground_slot::PAVING }));
    }
    if character == Character::Park {
        park(block, &path, &mut out);
        return out;
    }
    if let Some(lane) = cut.lane.and_then(|l| polygon::inset_edges(&l, |_| 0.12)) {
        let axis = longest(&lane);
        out.patches.push(Patch { origin_m: lane[0], outline: lane, slot: ground_slot::LANE, axis, lowered: false });
    }
    let mut towers: Vec<(Vec<DVec2>, bool)> = Vec::new();
    for site in &cut.sites {
        let path = path.child("site").index(site.index);
        one_site(params, block, site, character, relief, city, &path, &mut towers, &mut out);
    }
    out
}

fn longest(p: &[DVec2]) -> DVec2 {
    (0..p.len())
        .map(|i| p[(i + 1) % p.len()] - p[i])
        .max_by(|a, b| a.length().total_cmp(&b.length()))
        .map_or(DVec2::X, |d| d.normalize())
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    Condo,
    Office,
    MidRise,
    Rows,
    Shop,
    Parking,
    Cleared,
    Square,
}

fn draw_use(params: &Params, character: Character, site: &Site, rng: &mut Rng) -> Use {
    let wide = site.front_m() > 29.0;
    let options =
        [Use::Condo, Use::Office, Use::MidRise, Use::Rows, Use::Shop, Use::Parking, Use::Cleared, Use::Square];
    let mut weights = match (character, wide) {
        (Character::Towers, true) => [0.78, 0.02, 0.11, 0.01, 0.03, 0.02, 0.02, 0.01],
        (Character::Offices, true) => [0.06, 0.72, 0.12, 0.0, 0.02, 0.02, 0.02, 0.04],
        (Character::Rows, _) => [0.0, 0.0, 0.08, 0.78, 0.07, 0.05, 0.01, 0.01],
        (_, true) => [0.36, 0.05, 0.32, 0.08, 0.1, 0.05, 0.02, 0.02],
        (_, false) => [0.0, 0.0, 0.46, 0.16, 0.32, 0.04, 0.01, 0.01],
    };
    if params.variant == Variant::Midtown {
        weights[0] *= 0.45;
        weights[1] *= 0.3;
        weights[3] *= 1.6;
    }
    for w in &mut weights[..5] {
        *w *= params.density;
    }
    options[rng.weighted(&weights)]
}

#[allow(clippy::too_many_arguments)]
fn one_site(
    params: &Params,
    block: &Block,
    site: &Site,
    character: Character,
    relief: &Relief<'_>,
    city: &SeedPath,
    path: &SeedPath,
    towers: &mut Vec<(Vec<DVec2>, bool)>,
    out: &mut BlockPlan,
) {
    let mut rng = path.child("use").rng();
    let mut usage = draw_use(params, character, site, &mut rng);
    let frame = Frame::of(site);
    let name = |what: &str| format!("block/{}/{}/site/{}/{what}", block.index[0], block.index[1], site.index);
    if usage == Use::Condo || usage == Use::Office {
        if let Some((building, foot)) = tower(site, usage == Use::Office, block, relief, city, path, towers) {
            towers.push((foot, usage == Use::Office));
            out.buildings.push((name("tower"), building));
            ground(site, ground_slot::PLAZA, out);
            court(site, path, out);
            return;
        }
        usage = if rng.chance(0.85) { Use::MidRise } else { Use::Shop };
    }
    let building = match usage {
        Use::MidRise => massing::mid_rise(site, relief, path),
        Use::Shop => massing::shop(site, relief, path),
        _ => None,
    };
    if let Some(building) = building {
        ground(site, if rng.chance(0.5) { ground_slot::PAVING_DARK } else { ground_slot::YARD }, out);
        out.buildings.push((name("building"), building));
        court(site, path, out);
        return;
    }
    match usage {
        Use::Rows => {
            ground(site, ground_slot::YARD, out);
            let row = houses::row(site, relief, path);
            for (k, b) in row.buildings.into_iter().enumerate() {
                out.buildings.push((name(&format!("house/{k}")), b));
            }
            let mut rng = path.child("yards").rng();
            for (outline, kind) in row.yards {
                let paved = [ground_slot::PAVING, ground_slot::PAVING_DARK, ground_slot::PLAZA];
                let slot = match kind {
                    Yard::Patio => *rng.pick(&paved),
                    Yard::Front => {
                        [ground_slot::LAWN, ground_slot::YARD, ground_slot::PAVING][rng.weighted(&[0.5, 0.2, 0.3])]
                    }
                    Yard::Rear => [ground_slot::LAWN, ground_slot::YARD, ground_slot::PAVING_DARK]
                        [rng.weighted(&[0.5, 0.38, 0.12])],
                };
                let (low, high) = polygon::bounds(&outline);
                let tries = if kind == Yard::Rear { 7 } else { 1 };
                for _ in 0..tries {
                    let at = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
                    if polygon::contains(&outline, at) && rng.chance(0.5) {
                        out.trees.push(at);
                    }
                }
                out.patches.push(Patch { origin_m: outline[0], outline, slot, axis: frame.axis, lowered: false });
            }
        }
        Use::Cleared => {
            ground(site, ground_slot::SOIL, out);
            out.cleared.push(frame.centre);
        }
        Use::Square => {
            ground(site, ground_slot::PLAZA, out);
            if let Some(outline) = polygon::inset(&site.outline, rng.range(5.0, 9.0)) {
                let axis = frame.axis;
                out.patches.push(Patch {
                    origin_m: outline[0],
                    outline,
                    slot: ground_slot::LAWN,
                    axis,
                    lowered: false,
                });
            }
            scatter(site, 8.0, path, out);
        }
        _ => parking(site, &frame, path, out),
    }
}

fn ground(site: &Site, slot: u16, out: &mut BlockPlan) {
    if let Some(outline) = polygon::inset(&site.outline, 0.12).filter(|o| polygon::area(o) > 4.0) {
        // Corners closer than quantising tolerates would cross.
        let short = (0..outline.len()).any(|i| outline[i].distance(outline[(i + 1) % outline.len()]) < 0.05);
        if !short {
            out.patches.push(Patch { origin_m: outline[0], outline, slot, axis: site.axis(), lowered: false });
        }
    }
}

/// Trees in what a building leaves of its site.
fn court(site: &Site, path: &SeedPath, out: &mut BlockPlan) {
    let mut rng = path.child("court").rng();
    let (low, high) = polygon::bounds(&site.outline);
    for _ in 0..22 {
        let p = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
        if polygon::contains(&site.outline, p) && polygon::border_distance(&site.outline, p) > 1.5 && rng.chance(0.5) {
            out.trees.push(p);
        }
    }
}

fn scatter(site: &Site, spacing: f64, path: &SeedPath, out: &mut BlockPlan) {
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

/// A tower, if it fits and keeps its distance from those that stand.
fn tower(
    site: &Site,
    office: bool,
    block: &Block,
    relief: &Relief<'_>,
    city: &SeedPath,
    path: &SeedPath,
    towers: &[(Vec<DVec2>, bool)],
) -> Option<(Building, Vec<DVec2>)> {
    let place = massing::tower_place(site, office, path)?;
    let frame = Frame::of(site);
    let foot = |grow: f64| polygon::oriented_rectangle(frame.world(place.0), frame.axis, place.1 + DVec2::splat(grow));
    // Offices stand closer than dwellings may.
    let crowded = towers.iter().any(|(other, other_office)| {
        let gap = if office && *other_office { 14.0 } else { 25.0 };
        polygon::convex_overlap(&foot(gap), other)
    });
    if crowded {
        return None;
    }
    let [i, j] = block.index;
    let start = city.child("height").rng().unit();
    let u = spread(start + 0.618_033_988_749_895 * towers.len() as f64, i, j);
    let jitter = path.child("height").rng().signed() * 0.03;
    // The quantile is of the whole height; the mechanical floor on top takes its share.
    let height_m = massing::tower_height_m((u + jitter).clamp(0.002, 0.998)) - massing::PENTHOUSE_M;
    let building = if office {
        massing::office(site, place, height_m, relief, path)
    } else {
        massing::condo(site, place, height_m, relief, path)
    }?;
    Some((building, foot(0.0)))
}

/// A parking lot: stalls 2.6 x 5.5 m in double rows with aisles of 6.5 m, tree islands at the ends.
fn parking(site: &Site, frame: &Frame, path: &SeedPath, out: &mut BlockPlan) {
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
fn park(block: &Block, path: &SeedPath, out: &mut BlockPlan) {
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
