//! The lie of the land: a gentle slope with swells, a few metres over a scene.

use glam::DVec2;
use satseed_scene::SeedPath;

/// Greatest height above and below the datum, m.
pub(in crate::city) const AMPLITUDE_M: f64 = 3.7;

/// Three swells; the pivot may lie anywhere on them.
#[derive(Clone, Debug)]
pub(in crate::city) struct Swells {
    waves: [(DVec2, f64, f64); 3],
}

impl Swells {
    /// Of a city.
    pub(in crate::city) fn new(city: &SeedPath) -> Self {
        let mut rng = city.child("relief").rng();
        let waves = [(2.2, 2600.0), (1.0, 1150.0), (0.5, 640.0)].map(|(amplitude_m, wavelength_m)| {
            let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let k = core::f64::consts::TAU / wavelength_m;
            (DVec2::new(s, c) * k, amplitude_m, rng.range(0.0, core::f64::consts::TAU))
        });
        Self { waves }
    }

    /// Height at a place of the world, m.
    pub(in crate::city) fn height_m(&self, p: DVec2) -> f64 {
        self.waves.iter().map(|(k, a, phase)| a * libm::sin(k.dot(p) + phase)).sum()
    }
}
