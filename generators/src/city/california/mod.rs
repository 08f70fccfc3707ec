//! California: suburbs of detached houses on bent streets, with lawns, drives, pools and palms.
//!
//! The plan comes first and is plain data: lines, modules, lots, houses, what lies and grows around them. Triangles come
//! last. Everything is keyed by its own path: one tree more moves no house.

mod assemble;
mod freeway;
mod hill;
mod house;
mod junction;
mod land;
mod layout;
mod lot;
mod marina;
mod materials;
mod module;
mod paving;
mod slabs;
mod streets;
mod urban;

use crate::city::toronto::relief;
use crate::{ParameterError, check_range};
use satseed_scene::{Scene, SeedPath};
use serde::{Deserialize, Serialize};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 3;

/// Slots of the ground's mesh.
mod ground_slot {
    pub(super) const LAND: u16 = 0;
    pub(super) const KERB: u16 = 1;
    pub(super) const SIDEWALK: u16 = 2;
    pub(super) const PARKWAY: u16 = 3;
    pub(super) const GUTTER: u16 = 4;
    /// The first of the ages of local asphalt.
    pub(super) const ASPHALT: u16 = 5;
    pub(super) const ASPHALTS: u16 = 4;
    pub(super) const ARTERIAL: u16 = 9;
    pub(super) const COLLECTOR: u16 = 10;
    pub(super) const JUNCTION: u16 = 11;
    pub(super) const CROSSING: u16 = 12;
    pub(super) const STOP: u16 = 13;
    pub(super) const PATCH: u16 = 14;
    pub(super) const TRENCH: u16 = 15;
    pub(super) const MEDIAN: u16 = 16;
    pub(super) const MULCH: u16 = 17;
    pub(super) const COPING: u16 = 18;
    pub(super) const PARKING: u16 = 19;
    pub(super) const PLAZA: u16 = 20;
    pub(super) const TURF: u16 = 21;
    pub(super) const INFIELD: u16 = 22;
    pub(super) const COURT: u16 = 23;
    pub(super) const TRACK: u16 = 24;
    pub(super) const YARD_ASPHALT: u16 = 25;
    /// Kinds of front yards: green, fading, dry, bare, gravel.
    pub(super) const FRONT: [u16; 9] = [26, 27, 28, 29, 30, 31, 32, 33, 34];
    /// Kinds of rear yards.
    pub(super) const REAR: [u16; 8] = [35, 36, 37, 38, 39, 40, 41, 42];
    /// Kinds of concrete and pavers.
    pub(super) const DRIVE: [u16; 6] = [43, 44, 45, 46, 47, 48];
    /// Pools: pale, blue, green-blue, neglected.
    pub(super) const POOL: [u16; 4] = [49, 50, 51, 52];
    pub(super) const COUNT: usize = 53;
    // A harbour's own come after the others.
    pub(super) const WATER: u16 = 53;
    pub(super) const SEAWALL: u16 = 54;
    pub(super) const RIPRAP: u16 = 55;
    pub(super) const SAND: u16 = 56;
}

/// Which part of the city.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Detached houses on bent streets.
    Suburb,
    /// The same around two freeways that cross in a stack of four levels.
    Interchange,
    /// Towers, garages, squares and parking lots on a grid.
    Downtown,
    /// Shops, apartments and workshops of one to three storeys with their parking.
    Lowrise,
    /// A marina: basins full of boats between moles with apartments, a channel, and a bank with beaches.
    Waterfront,
    /// Streets along ridges and spurs, houses on level pads, chaparral in the ravines.
    Hill,
}

/// Parameters of a California scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Which part of the city.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Share of lots that are built on, 0.2..1.
    pub density: f64,
    /// Factor on the number of trees and shrubs, 0..3.
    pub trees: f64,
    /// Factor on the number of vehicles, 0..3.
    pub vehicles: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { variant: Variant::Suburb, radius_m: 700.0, density: 1.0, trees: 1.0, vehicles: 1.0 }
    }
}

/// Beyond the detailed circle streets and plain houses go on for this far, m: what an oblique view sees.
const RING_M: f64 = 260.0;

/// Things whose place is nearer to the pivot than the radius and this have full detail, m: half a lot.
const DETAIL_MARGIN_M: f64 = 30.0;

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Suburb => "suburb",
            Variant::Interchange => "interchange",
            Variant::Downtown => "downtown",
            Variant::Lowrise => "lowrise",
            Variant::Waterfront => "waterfront",
            Variant::Hill => "hill",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("density", self.density, 0.2..=1.0)?;
        check_range("trees", self.trees, 0.0..=3.0)?;
        check_range("vehicles", self.vehicles, 0.0..=3.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        // Relief and kerbs reach down to -3.9 m, feet and piers 1.5 m below the ground; the tallest palm is 27 m high with
        // its crown, the highest ramp 29 m, with a truck on it 33 m.
        if self.variant == Variant::Hill {
            // Ridges lie within 25 m of the datum, ravines up to 90 m below them.
            return [-110.0, 62.0];
        }
        let reach = relief::AMPLITUDE_M;
        let highest_m = match self.variant {
            Variant::Downtown => 220.0,
            Variant::Lowrise => 55.0,
            Variant::Suburb | Variant::Interchange | Variant::Waterfront | Variant::Hill => 36.0,
        };
        [-reach - 2.5, highest_m + reach]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let km = self.radius_m / 1000.0;
        let things = self.trees.max(1.0) + self.vehicles.max(1.0);
        (300.0e6 + (2000.0e6 + 60.0e6 * things) * km * km) as u64
    }
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let city = path.child(params.variant());
    assemble::assemble(params, &assemble::plan(params, &city), &city)
}

#[cfg(test)]
mod tests;
