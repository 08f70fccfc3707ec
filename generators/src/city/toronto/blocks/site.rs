//! What one site of a block is used for, and what is built on it.

use super::open::{court, ground, parking, scatter};
use super::{BlockPlan, Character, spread};
use crate::city::toronto::houses::{self, Yard};
use crate::city::toronto::massing::{self, Building, Frame, Relief};
use crate::city::toronto::{Params, Variant, ground_slot};
use crate::kit::ground::Patch;
use crate::kit::parcels::Site;
use crate::kit::polygon;
use crate::kit::streets::Block;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

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

/// Decides a site and adds what stands and lies on it; `towers` are the feet of those that stand already.
#[allow(clippy::too_many_arguments)]
pub(super) fn one_site(
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
        Use::Rows => rows(site, &name("house"), relief, path, out),
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

/// Fills a site with a row of houses, called `name` and a number, and their yards.
pub(in crate::city::toronto) fn rows(
    site: &Site,
    name: &str,
    relief: &Relief<'_>,
    path: &SeedPath,
    out: &mut BlockPlan,
) {
    ground(site, ground_slot::YARD, out);
    let axis = site.axis();
    let row = houses::row(site, relief, path);
    for (k, b) in row.buildings.into_iter().enumerate() {
        out.buildings.push((format!("{name}/{k}"), b));
    }
    let mut rng = path.child("yards").rng();
    for (outline, kind) in row.yards {
        let paved = [ground_slot::PAVING, ground_slot::PAVING_DARK, ground_slot::PLAZA];
        let slot = match kind {
            Yard::Patio => *rng.pick(&paved),
            Yard::Front => [ground_slot::LAWN, ground_slot::YARD, ground_slot::PAVING][rng.weighted(&[0.5, 0.2, 0.3])],
            Yard::Rear => {
                [ground_slot::LAWN, ground_slot::YARD, ground_slot::PAVING_DARK][rng.weighted(&[0.5, 0.38, 0.12])]
            }
        };
        let (low, high) = polygon::bounds(&outline);
        let tries = if kind == Yard::Rear { 7 } else { 1 };
        for _ in 0..tries {
            let at = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
            if polygon::contains(&outline, at) && rng.chance(0.5) {
                out.trees.push(at);
            }
        }
        out.patches.push(Patch { origin_m: outline[0], outline, slot, axis, lowered: false });
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
