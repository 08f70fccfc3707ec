//! Toronto: a rotated grid of towers on podiums, slabs, brick rows and laneways.

use crate::{ParameterError, check_range};
use satseed_scene::{Scene, SeedPath};
use serde::{Deserialize, Serialize};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 1;

/// Which part of the city.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// High-rise core.
    Core,
    /// Mid-rise and brick rows with some towers.
    Midtown,
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

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Core => "core",
            Variant::Midtown => "midtown",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("density", self.density, 0.2..=1.5)?;
        check_range("trees", self.trees, 0.0..=3.0)?;
        check_range("vehicles", self.vehicles, 0.0..=3.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        [-10.0, 320.0]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        4 << 30
    }
}

pub(crate) fn build(_params: &Params, _path: SeedPath) -> Scene {
    Scene::default()
}
