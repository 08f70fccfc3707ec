//! Toronto: a rotated grid of towers on podiums, slabs, brick rows and laneways.
//!
//! The plan comes first and is plain data: streets, blocks, sites, buildings, what stands on the ground. Triangles come
//! last. Everything is keyed by its own path: one tree more moves no house.

mod assemble;
mod blocks;
mod estate;
mod houses;
pub(super) mod massing;
pub(super) mod materials;
mod rail;
pub(super) mod relief;
pub(super) mod traffic;

use crate::kit::streets::{CrossSection, Family, StreetPlan, family};
use crate::{ParameterError, check_range};
use glam::DVec2;
use satseed_scene::{Scene, SeedPath};
use serde::{Deserialize, Serialize};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 4;

/// Slots of the ground's mesh.
pub(super) mod ground_slot {
    pub(in crate::city) const CARRIAGEWAY: u16 = 0;
    pub(in crate::city) const KERB: u16 = 1;
    pub(in crate::city) const SIDEWALK: u16 = 2;
    pub(in crate::city) const PAVING: u16 = 3;
    pub(in crate::city) const PAVING_DARK: u16 = 4;
    pub(in crate::city) const PLAZA: u16 = 5;
    pub(in crate::city) const LAWN: u16 = 6;
    pub(in crate::city) const YARD: u16 = 7;
    pub(in crate::city) const LANE: u16 = 8;
    pub(in crate::city) const PATH: u16 = 9;
    pub(in crate::city) const SOIL: u16 = 10;
    pub(in crate::city) const PARKING: u16 = 11;
    pub(in crate::city) const CROSSING: u16 = 12;
    pub(in crate::city) const STOP: u16 = 13;
    pub(in crate::city) const PATCH_NEW: u16 = 14;
    pub(in crate::city) const PATCH_OLD: u16 = 15;
    pub(in crate::city) const MANHOLE: u16 = 16;
    /// The first of `STREET_KINDS * ROAD_AGES` carriageways.
    pub(in crate::city) const ROAD: u16 = 17;
    pub(in crate::city) const COUNT: usize =
        (ROAD + super::materials::STREET_KINDS * super::materials::ROAD_AGES) as usize;
    // What only some variants have comes after the others.
    pub(super) const COURT_EDGE: u16 = COUNT as u16;
    pub(super) const COURT: u16 = COURT_EDGE + 1;
    pub(super) const POOL: u16 = COURT_EDGE + 2;
    pub(super) const PLAY: u16 = COURT_EDGE + 3;
    pub(super) const BALLAST: u16 = COUNT as u16;
    pub(super) const TRACK: u16 = BALLAST + 1;
    pub(super) const GRAVEL: u16 = BALLAST + 2;
    pub(super) const VERGE: u16 = BALLAST + 3;
}

/// Which part of the city.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// High-rise core.
    Core,
    /// Mid-rise and brick rows with some towers.
    Midtown,
    /// Long blocks of flats of 10 to 20 storeys in lawns, with their parking.
    Slabs,
    /// A railway in a cutting through the city: tracks, platforms, trains, bridges.
    Rail,
}

/// Parameters of a Toronto scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Which part of the city.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Share of built-up lots relative to nature's, 0.2..1.5.
    pub density: f64,
    /// Factor on the number of trees, 0..3.
    pub trees: f64,
    /// Factor on the number of vehicles, 0..3.
    pub vehicles: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { variant: Variant::Core, radius_m: 700.0, density: 1.0, trees: 1.0, vehicles: 1.0 }
    }
}

/// The grid's turn against north, radians: streets run about 17 degrees west of north.
const GRID_TURN_RAD: f64 = -0.297;

/// Beyond the detailed circle the city goes on as plain blocks for this far, m: the shadow of the tallest tower at a sun
/// 27 degrees high, and more than any planned frame sees.
const RING_M: f64 = 600.0;

/// Buildings whose centre is nearer to the pivot than the radius and this have full detail, m: half a large site.
const DETAIL_MARGIN_M: f64 = 40.0;

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Core => "core",
            Variant::Midtown => "midtown",
            Variant::Slabs => "slabs",
            Variant::Rail => "rail",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("density", self.density, 0.2..=1.5)?;
        check_range("trees", self.trees, 0.0..=3.0)?;
        check_range("vehicles", self.vehicles, 0.0..=3.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        // Relief and kerbs reach down to -3.9 m and feet 1 m below the lowest ground; towers are at most 298 m with their
        // penthouse, and rounding to whole floors (2 m), a penthouse higher than the mean (1.5 m), its parapet and
        // furniture (4 m) and the relief come on top.
        let reach = relief::AMPLITUDE_M;
        let highest_m = match self.variant {
            // Twenty storeys of 2.85 m with their machine rooms, or a crane of 110 m.
            Variant::Slabs => 130.0,
            Variant::Core | Variant::Midtown | Variant::Rail => 298.0 + 12.0,
        };
        // Walls and piers of the cutting reach 1 m below its floor.
        let cutting_m = if self.variant == Variant::Rail { rail::DEPTH_M } else { 0.0 };
        [-reach - 2.0 - cutting_m, highest_m + reach]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        // Peak of a process that builds the core and its trees of boxes: 40, 49, 145, 323 and 490 MB at 60, 170, 400, 700
        // and 900 m. The bound has a third and more above that, and a place for each further tree and vehicle.
        let km = self.radius_m / 1000.0;
        let things = self.trees.max(1.0) + self.vehicles.max(1.0);
        (120.0e6 + (800.0e6 + 50.0e6 * things) * km * km) as u64
    }
}

/// The streets out to a distance.
fn streets(variant: Variant, path: &SeedPath, reach_m: f64) -> StreetPlan {
    let (s, c) = libm::sincos(GRID_TURN_RAD);
    let north = DVec2::new(s, c);
    let section = |kind, roadway_m, sidewalk_m| CrossSection { kind, roadway_m, sidewalk_m };
    let narrow = section(0, 10.4, 4.8);
    let local = section(1, 10.6, 4.8);
    let wide = section(2, 16.6, 5.2);
    let avenue = section(3, 22.6, 6.4);
    // Estates are made of large blocks, with fewer and wider streets.
    let (blocks_m, shares) = match variant {
        Variant::Slabs => ([[176.0, 232.0], [196.0, 260.0]], [[0.0, 0.5, 0.36, 0.14]; 2]),
        _ => ([[100.0, 140.0], [110.0, 200.0]], [[0.4, 0.28, 0.22, 0.1], [0.3, 0.3, 0.28, 0.12]]),
    };
    let of = |k: usize, direction: DVec2| Family {
        direction,
        block_m: blocks_m[k],
        turn_rad: 0.008,
        sections: shares[k].into_iter().zip([narrow, local, wide, avenue]).collect(),
    };
    let (a, northward) = family(&of(0, north), &path.child("northward"), reach_m);
    let (b, eastward) = family(&of(1, DVec2::new(north.y, -north.x)), &path.child("eastward"), reach_m);
    StreetPlan { first: [a, b], streets: [northward, eastward] }
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let city = path.child(params.variant());
    assemble::assemble(params, &assemble::plan(params, &city), &city)
}

#[cfg(test)]
mod tests;
