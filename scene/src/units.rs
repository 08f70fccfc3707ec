//! Units and the lattice that vertices live on.

use glam::DVec3;

/// The lattice of vertex coordinates, m: 1/1024. Exact in f32 up to 16 km, so meshes hash equally everywhere.
pub const QUANTUM_M: f64 = 1.0 / 1024.0;

/// The nearest multiple of [`QUANTUM_M`], as f32 without error for |x| < 16,384 m. Halves go up.
#[inline]
pub fn quantise_m(x_m: f64) -> f32 {
    (libm::floor(x_m * 1024.0 + 0.5) * QUANTUM_M) as f32
}

/// [`quantise_m`] for the three coordinates of a point.
#[inline]
pub fn quantise_point(p: DVec3) -> [f32; 3] {
    [quantise_m(p.x), quantise_m(p.y), quantise_m(p.z)]
}

/// The unit vector that points to an azimuth (clockwise from north) and an elevation above the horizon, radians.
pub fn direction_from_angles(azimuth_rad: f64, elevation_rad: f64) -> DVec3 {
    let (sa, ca) = libm::sincos(azimuth_rad);
    let (se, ce) = libm::sincos(elevation_rad);
    DVec3::new(sa * ce, ca * ce, se)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantised_values_are_exact_multiples() {
        for i in -20_000..20_000_i32 {
            let x = f64::from(i) * 0.7371;
            let q = f64::from(quantise_m(x));
            assert_eq!(q * 1024.0, libm::floor(q * 1024.0));
            assert!((q - x).abs() <= QUANTUM_M / 2.0);
        }
    }

    #[test]
    fn north_and_up() {
        assert_eq!(direction_from_angles(0.0, 0.0), DVec3::Y);
        let east = direction_from_angles(core::f64::consts::FRAC_PI_2, 0.0);
        assert!((east - DVec3::X).length() < 1e-15);
    }
}
