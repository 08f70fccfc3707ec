//! Canyon: an incised plateau of hard and soft beds.

use crate::{ParameterError, check_range};
use satseed_scene::{Scene, SeedPath};
use serde::{Deserialize, Serialize};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 1;

/// Parameters of a canyon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Depth from rim to floor, m, 120..220.
    pub relief_m: f64,
    /// Roughness of rock and soil below the scale of erosion, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour, 0..2; 1 is nature.
    pub texture_contrast: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { radius_m: 700.0, relief_m: 170.0, roughness: 1.0, texture_contrast: 1.0 }
    }
}

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        "gorge"
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("relief_m", self.relief_m, 120.0..=220.0)?;
        check_range("roughness", self.roughness, 0.0..=2.0)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        [-self.relief_m - 30.0, 60.0]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        4 << 30
    }
}

pub(crate) fn build(_params: &Params, _path: SeedPath) -> Scene {
    Scene::default()
}
