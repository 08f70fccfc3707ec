//! A block: its character, its sites and what each is used for.
//!
//! Characters and tower heights are drawn from a two-dimensional low-discrepancy sequence over the block's indices
//! (Roberts 2018, the R2 sequence, from a random start): neighbours differ, and every frame of a few hundred metres has
//! about the share of towers that the whole city has.

pub(super) mod open;
pub(super) mod site;

use super::massing::{Building, Relief};
use super::{Params, Variant, estate, ground_slot};
use crate::kit::ground::Patch;
use crate::kit::parcels::subdivide;
use crate::kit::polygon;
use crate::kit::streets::Block;
use glam::DVec2;
use satseed_scene::SeedPath;
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
    /// Slabs in lawns.
    Estate,
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
pub(super) fn spread(start: f64, i: i64, j: i64) -> f64 {
    let x = start + i as f64 * 0.754_877_666_246_692_7 + j as f64 * 0.569_840_290_998_053_2;
    x - libm::floor(x)
}

fn character(params: &Params, block: &Block, city: &SeedPath) -> Character {
    let [i, j] = block.index;
    if i == 0 && j == 0 && params.variant != Variant::Slabs {
        // The pivot always has something tall to look at.
        return Character::Towers;
    }
    let start = city.child("character").rng().unit();
    let u = spread(start, i, j);
    let limits = match params.variant {
        Variant::Core => [0.56, 0.72, 0.93, 0.98],
        Variant::Midtown => [0.06, 0.08, 0.48, 0.95],
        Variant::Rail => [0.38, 0.46, 0.88, 0.95],
        Variant::Slabs => return Character::Estate,
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
        Character::Estate => rng.range(72.0, 108.0),
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
        Character::Park | Character::Estate => 0.0,
        _ => rng.range(4.0, 6.0),
    };
    let cut = subdivide(&block.property, lane_m, &path, |p| site_width_m(character, p));
    let axis = (block.property[1] - block.property[0]).normalize();
    let patch = |outline: Vec<DVec2>, slot: u16| Patch { origin_m: outline[0], outline, slot, axis, lowered: false };
    let open = matches!(character, Character::Park | Character::Estate);
    if let Some(ground) = polygon::inset(&block.property, 0.08) {
        out.patches.push(patch(ground, if open { ground_slot::LAWN } else { ground_slot::PAVING }));
    }
    if character == Character::Park {
        open::park(block, &path, &mut out);
        return out;
    }
    if character == Character::Estate {
        for site in &cut.sites {
            let path = path.child("site").index(site.index);
            estate::site(params, block, site, relief, city, &path, &mut out);
        }
        return out;
    }
    if let Some(lane) = cut.lane.and_then(|l| polygon::inset_edges(&l, |_| 0.12)) {
        let axis = longest(&lane);
        out.patches.push(Patch { origin_m: lane[0], outline: lane, slot: ground_slot::LANE, axis, lowered: false });
    }
    let mut towers: Vec<(Vec<DVec2>, bool)> = Vec::new();
    for site in &cut.sites {
        let path = path.child("site").index(site.index);
        site::one_site(params, block, site, character, relief, city, &path, &mut towers, &mut out);
    }
    out
}

fn longest(p: &[DVec2]) -> DVec2 {
    (0..p.len())
        .map(|i| p[(i + 1) % p.len()] - p[i])
        .max_by(|a, b| a.length().total_cmp(&b.length()))
        .map_or(DVec2::X, |d| d.normalize())
}
