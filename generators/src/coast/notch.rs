//! The notch that storms wear into the foot of cliffs.

use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::overhang::{Hollow, UNTOLD_M};
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;

/// How far before the cliff's foot the notch is looked at, m.
const BEFORE_M: f64 = 1.5;

/// The notch at a place `behind_m` from the foot of a cliff, whose platform lies at a height; softer rock recedes farther. None
/// where the place is far from it, or where `strength`, 0 to 1, is small.
pub(super) fn notch(p: DVec2, seed: u32, behind_m: f64, platform_m: f64, strength: f64) -> Option<Hollow> {
    if strength <= 0.0 || !(-BEFORE_M..9.0).contains(&behind_m) {
        return None;
    }
    let n = |salt: u32, wavelength_m: f64| fractal(p, seed ^ salt, wavelength_m, 2, 0.4) / 0.29;
    let depth = Hollow::faded((2.6 + 2.4 * n(0, 33.0)).clamp(-1.0, 5.5), strength);
    let cover_m = depth + Hollow::BEARING_M - behind_m;
    if cover_m < -UNTOLD_M {
        return None;
    }
    let vault = Hollow::vault(depth, behind_m);
    let floor_m = platform_m + 0.05 + 0.14 * behind_m.max(0.0) + 0.08 * n(1, 3.0);
    let high_m = 2.2 + 0.8 * smoothstep(-1.0, 1.5, n(2, 50.0)) + 0.1 * n(3, 6.0);
    Some(Hollow { level: 0, floor_m, roof_m: floor_m + (high_m - 0.14 * behind_m) * vault.max(-0.6), cover_m })
}
