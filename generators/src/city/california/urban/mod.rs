//! Downtown and low blocks: a grid of straight streets, blocks cut into sites, and what each site is used for.

mod apartments;
mod downtown;
pub(super) mod fittings;
mod garage;
mod grid;
mod lowrise;
mod open;
mod site;
mod store;
mod streets;
mod tower;
mod yard;

use super::land::Land;
use super::lot::Content;
use super::{DETAIL_MARGIN_M, Params, Variant};
use crate::kit::polygon;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::SeedPath;

/// What a building is; decides its materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Use {
    /// Office tower.
    Office,
    /// Residential tower.
    Residence,
    /// Mid-rise block.
    Block,
    /// Parking structure.
    Garage,
    /// Shops, restaurants, filling stations.
    Store,
    /// Workshops and warehouses.
    Works,
    /// Apartments of two or three storeys.
    Apartments,
    /// A bridge for pedestrians between two buildings.
    Footbridge,
}

/// Slots of building meshes beyond those of all buildings.
pub(super) mod part {
    use crate::kit::buildings::slot;

    /// A deck with stalls.
    pub(in crate::city::california) const STALLS: u16 = slot::COUNT as u16;
    /// Water of pools and fountains.
    pub(in crate::city::california) const WATER: u16 = STALLS + 1;
    /// White paint.
    pub(in crate::city::california) const PAINT: u16 = STALLS + 2;
    /// Landing pads.
    pub(in crate::city::california) const PAD: u16 = STALLS + 3;
    /// Canopies and signs.
    pub(in crate::city::california) const CANOPY: u16 = STALLS + 4;
    /// Concrete of ramps and spandrels.
    pub(in crate::city::california) const CONCRETE: u16 = STALLS + 5;
    /// Painted sheet metal of containers.
    pub(in crate::city::california) const STEEL: u16 = STALLS + 6;
    /// Number of slots.
    pub(in crate::city::california) const COUNT: usize = STALLS as usize + 7;
}

/// Slots of the ground beyond the suburb's: those of Toronto's streets with other looks, and parking lots.
pub(super) mod ground {
    use crate::city::california::ground_slot;
    use crate::city::toronto::ground_slot as toronto;

    const FIRST: u16 = ground_slot::COUNT as u16;

    /// The slot that stands for one of Toronto's.
    pub(in crate::city::california) const fn of(slot: u16) -> u16 {
        FIRST + slot
    }

    /// Kinds of parking lots: by age.
    pub(in crate::city::california) const LOTS: [u16; 3] =
        [of(toronto::COUNT as u16), of(toronto::COUNT as u16 + 1), of(toronto::COUNT as u16 + 2)];
    /// Kinds of yards: asphalt sealed and bleached, concrete, dirt.
    pub(in crate::city::california) const YARDS: [u16; 4] = [
        of(toronto::COUNT as u16 + 3),
        of(toronto::COUNT as u16 + 4),
        of(toronto::COUNT as u16 + 5),
        of(toronto::COUNT as u16 + 6),
    ];
    /// Kinds of pavers on squares.
    pub(in crate::city::california) const SQUARES: [u16; 3] =
        [of(toronto::COUNT as u16 + 7), of(toronto::COUNT as u16 + 8), of(toronto::COUNT as u16 + 9)];
    /// Number of slots with the suburb's.
    pub(in crate::city::california) const COUNT: usize = ground_slot::COUNT + toronto::COUNT + 10;
}

/// Beyond the detailed circle the city goes on for this far, m: about the shadow of a tower at a sun 25 degrees high.
const RING_M: f64 = 420.0;

/// Whether a variant is one of these.
pub(super) fn is(variant: Variant) -> bool {
    matches!(variant, Variant::Downtown | Variant::Lowrise)
}

fn style(variant: Variant) -> grid::Style {
    match variant {
        Variant::Downtown => {
            grid::Style { turn_rad: 0.7, block_m: [[65.0, 100.0], [100.0, 180.0]], weights: [0.36, 0.34, 0.3] }
        }
        _ => grid::Style { turn_rad: 0.25, block_m: [[84.0, 108.0], [140.0, 200.0]], weights: [0.0, 0.8, 0.2] },
    }
}

/// All parts of a plan, named.
pub(super) fn plan(params: &Params, land: &Land, city: &SeedPath) -> Vec<(String, Content)> {
    let reach = params.radius_m + RING_M;
    let detail_m = params.radius_m + DETAIL_MARGIN_M + 100.0;
    let height = |p: DVec2| land.height_m(p);
    let grid = grid::grid(&style(params.variant), city, reach);
    let mut parts = vec![("carriageways".to_owned(), streets::carriageways(&grid))];
    let blocks: Vec<Content> = grid
        .blocks
        .par_iter()
        .map(|b| {
            let mut content = match params.variant {
                Variant::Downtown => downtown::plan(params, b, &height, city),
                _ => lowrise::plan(params, b, &height, city),
            };
            if polygon::centroid(&b.kerb).length() > detail_m {
                content.patches.truncate(2);
            }
            content
        })
        .collect();
    parts.extend(grid.blocks.iter().map(|b| b.name.clone()).zip(blocks));
    let along: Vec<(String, Content)> =
        grid.segments.par_iter().map(|s| streets::segment(params, s, city, detail_m)).collect();
    if params.variant == Variant::Downtown {
        let bridge = streets::footbridge(&grid, &parts, &height, city);
        parts.extend(bridge);
    }
    parts.extend(along);
    parts
}

#[cfg(test)]
mod tests;
