//! The lie of the land: how the plan's straight lines are bent, and how the paving swells.
//!
//! The plan is drawn with straight cuts, which is safe and quick, and then the whole plane is bent smoothly. Canals wind,
//! streets are crooked and corners are off the square, and nothing that stood apart can overlap.

use crate::kit::terrain::noise::fractal;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Wavelengths and amplitudes of the bends, m: of canals, of streets, of house fronts. The slopes add up to less than one,
/// so no place is taken twice.
const BENDS: [[f64; 2]; 3] = [[430.0, 34.0], [125.0, 10.5], [44.0, 2.6]];

/// Height of the water's surface, m: the paving is the datum.
pub(super) const WATER_M: f64 = -0.8;

/// Greatest height of the paving above and below the datum, m.
pub(super) const SWELL_M: f64 = 0.4;

/// Bends and swells of a city.
#[derive(Clone, Debug)]
pub(super) struct Lie {
    seed: u32,
}

impl Lie {
    /// Of a city.
    pub(super) fn new(city: &SeedPath) -> Self {
        Self { seed: city.child("lie").hash_u32() }
    }

    /// Where a place of the plan lies in the world.
    pub(super) fn world(&self, p: DVec2) -> DVec2 {
        let mut out = p;
        for (k, [wavelength_m, amplitude_m]) in (0_u32..).zip(BENDS) {
            let at = |s: u32| fractal(p, self.seed.wrapping_add(s + 31 * k), wavelength_m, 1, 0.5) * amplitude_m;
            out += DVec2::new(at(1), at(17));
        }
        out
    }

    /// Height of the paving at a place of the world, m.
    pub(super) fn paving_m(&self, p: DVec2) -> f64 {
        let swell =
            fractal(p, self.seed ^ 0x9e1, 85.0, 2, 0.5) * 0.35 + fractal(p, self.seed ^ 0x77, 21.0, 1, 0.5) * 0.08;
        swell.clamp(-SWELL_M, SWELL_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_is_taken_twice() {
        for seed in 0..6 {
            let lie = Lie::new(&SeedPath::root("lie", seed));
            for k in 0..4000 {
                let p = DVec2::new(f64::from(k % 63) * 41.3, f64::from(k / 63) * 37.9) - DVec2::splat(1200.0);
                let e = 0.5;
                let (x, y) = (lie.world(p + DVec2::X * e) - lie.world(p), lie.world(p + DVec2::Y * e) - lie.world(p));
                let stretch = x.perp_dot(y) / (e * e);
                assert!((0.4..2.0).contains(&stretch), "{p}: {stretch}");
            }
        }
    }
}
