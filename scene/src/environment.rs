//! Sun and air of one acquisition: frozen for all pairs of a pivot.

use crate::units::direction_from_angles;
use glam::DVec3;

/// Sun and air. Part of the recipe, not of a scene's key: the same geometry serves every light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Sun's elevation above the horizon, radians, in (0, pi/2].
    pub sun_elevation_rad: f64,
    /// Sun's azimuth, clockwise from north, radians.
    pub sun_azimuth_rad: f64,
    /// Aerosol optical depth at 550 nm, 0..1; clear air is 0.05, haze 0.3.
    pub aerosol_optical_depth: f64,
}

impl Environment {
    /// Angular radius of the solar disc, radians (0.53 deg across).
    pub const SUN_ANGULAR_RADIUS_RAD: f64 = 0.004_625;

    /// Unit vector towards the centre of the sun, world frame.
    pub fn sun_direction(&self) -> DVec3 {
        direction_from_angles(self.sun_azimuth_rad, self.sun_elevation_rad)
    }
}
