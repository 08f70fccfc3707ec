//! Venice: islands between winding canals, houses wall to wall under tiles, calli as dark slits.
//!
//! The plan comes first and is plain data: canals, islands, calli, blocks, lots, houses. It is cut with straight lines,
//! and then the whole plane is bent. Triangles come last. Everything is keyed by its own path: one tree more moves no house.

mod assemble;
mod boats;
mod bridges;
mod canals;
mod church;
mod fabric;
mod house_mesh;
mod houses;
mod lie;
mod materials;
mod moorings;
mod piece;
mod roof;
mod things;

use crate::{ParameterError, check_range};
use satseed_scene::{Scene, SeedPath};
use serde::{Deserialize, Serialize};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 3;

/// Slots of the ground's mesh.
mod ground_slot {
    pub(super) const WATER: u16 = 0;
    pub(super) const QUAY: u16 = 1;
    pub(super) const COPING: u16 = 2;
    pub(super) const PAVING: u16 = 3;
    pub(super) const CAMPO: u16 = 4;
    pub(super) const CAMPO_LINED: u16 = 5;
    pub(super) const COURT: u16 = 6;
    pub(super) const BRICK: u16 = 7;
    pub(super) const GARDEN: u16 = 8;
    pub(super) const COUNT: usize = 9;
}

/// Which part of the city.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Narrow canals alone.
    Dense,
    /// With the Grand Canal.
    Canal,
}

/// Parameters of a Venetian scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Which part of the city.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// How densely blocks are built, 0.5..1.4; 1 is nature, more has fewer courts and gardens.
    pub density: f64,
    /// Factor on the number of trees, 0..3.
    pub trees: f64,
    /// Factor on the share of walls with boats and on those under way, 0..1.5.
    pub boats: f64,
    /// Contrast of texture, 0..2; 1 is nature.
    pub texture_contrast: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { variant: Variant::Dense, radius_m: 700.0, density: 1.0, trees: 1.0, boats: 1.0, texture_contrast: 1.0 }
    }
}

/// Beyond the detailed circle the city goes on without what stands on roofs for this far, m: the shadow of the highest
/// campanile at a sun 17 degrees high.
const RING_M: f64 = 240.0;

/// Things whose centre is nearer to the pivot than the radius and this have full detail, m.
const DETAIL_MARGIN_M: f64 = 25.0;

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Dense => "dense",
            Variant::Canal => "canal",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("density", self.density, 0.5..=1.4)?;
        check_range("trees", self.trees, 0.0..=3.0)?;
        check_range("boats", self.boats, 0.0..=1.5)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)
    }

    // The registry asks every region as a method.
    #[allow(clippy::unused_self)]
    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        [lie::WATER_M - houses::FOOT_M - 0.1, church::HIGHEST_M + lie::SWELL_M]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let km = (self.radius_m + RING_M) / 1000.0;
        let things = self.trees.max(1.0) + self.boats.max(1.0);
        (150.0e6 + (900.0e6 + 50.0e6 * things) * km * km) as u64
    }
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let city = path.child(params.variant());
    assemble::assemble(params, &assemble::plan(params, &city), &city)
}

#[cfg(test)]
mod tests;
