//! The air over a scene: the whole column, worked out once per band, never marched.
//!
//! Scattering after Vermote et al. 1997 (6S): the radiance that a sensor sees over ground of reflectance `r` amid
//! surroundings of mean reflectance `m` is
//!
//! `path + E / pi (direct r + diffuse m)`, `E = E_top mu_s T_down / (1 - S m)`, `direct + diffuse = T_up`.
//!
//! Optical depths after Hansen and Travis (1974) for molecules and Angstrom's law for aerosol; absorption by ozone and
//! water vapour as a small depth of each band. Zeniths are those of the orbit: a proxy camera at 1 km sees a frame under
//! many angles, the satellite that it stands for under one.

use glam::DVec3;

/// Band centres, micrometres: blue, green, red, near infrared.
pub(super) const WAVELENGTH_UM: [f64; 4] = [0.48, 0.545, 0.66, 0.83];
/// Vertical depth of what absorbs: 300 Dobson units of ozone (Chappuis bands), and 2 cm of water vapour in the infrared.
const GAS_DEPTH: [f64; 4] = [0.006, 0.028, 0.019, 0.020];
/// Aerosol: single scattering albedo, asymmetry, Angstrom exponent, and the share of scattering that goes on forward.
const AEROSOL_ALBEDO: f64 = 0.93;
const AEROSOL_ASYMMETRY: f64 = 0.65;
const ANGSTROM: f64 = 1.3;
const AEROSOL_FORWARD: f64 = 0.86;
/// Share of molecular scattering that does not reach the other side.
const RAYLEIGH_BACK: f64 = 0.48;
/// Multiple scattering relative to single scattering in the path radiance.
const MULTIPLE: f64 = 1.2;

/// The column of one band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// Optical depth of molecules.
    pub rayleigh: f64,
    /// Optical depth of aerosol.
    pub aerosol: f64,
    /// Optical depth of what only absorbs.
    pub gas: f64,
}

impl Air {
    /// The air of a band (0..4) for an aerosol optical depth at 550 nm.
    pub(super) fn new(band: usize, aerosol_550: f64) -> Self {
        let um = WAVELENGTH_UM[band];
        let l2 = 1.0 / (um * um);
        Self {
            rayleigh: 0.008_569 * l2 * l2 * (1.0 + 0.0113 * l2 + 0.000_13 * l2 * l2),
            aerosol: aerosol_550 * libm::pow(um / 0.55, -ANGSTROM),
            gas: GAS_DEPTH[band],
        }
    }

    /// Depth of all that scatters.
    fn depth(&self) -> f64 {
        self.rayleigh + self.aerosol
    }

    /// Share of light that passes unscattered along a cosine; without gas.
    pub(super) fn direct(&self, mu: f64) -> f64 {
        libm::exp(-self.depth() / mu)
    }

    /// Direct and diffuse transmittance along a cosine; without gas.
    pub(super) fn transmittance(&self, mu: f64) -> f64 {
        let lost = RAYLEIGH_BACK * self.rayleigh + (1.0 - AEROSOL_ALBEDO * AEROSOL_FORWARD) * self.aerosol;
        libm::exp(-lost / mu)
    }

    /// Transmittance of the gases along a cosine.
    pub(super) fn gas(&self, mu: f64) -> f64 {
        libm::exp(-self.gas / mu)
    }

    /// Reflectance of the air alone by single scattering, for unit vectors to sun and sensor; without gas.
    pub(super) fn single_path_reflectance(&self, to_sun: DVec3, to_sensor: DVec3) -> f64 {
        let (mu_s, mu_v) = (to_sun.z, to_sensor.z);
        let cos_scatter = -to_sun.dot(to_sensor);
        let rayleigh = 0.75 * (1.0 + cos_scatter * cos_scatter);
        let g = AEROSOL_ASYMMETRY;
        let aerosol = (1.0 - g * g) / libm::pow(1.0 + g * g - 2.0 * g * cos_scatter, 1.5);
        let scattered = (self.rayleigh * rayleigh + AEROSOL_ALBEDO * self.aerosol * aerosol) / self.depth();
        let paths = 1.0 - libm::exp(-self.depth() * (1.0 / mu_s + 1.0 / mu_v));
        scattered * paths / (4.0 * (mu_s + mu_v))
    }

    /// Reflectance of the air alone, all orders of scattering.
    pub(super) fn path_reflectance(&self, to_sun: DVec3, to_sensor: DVec3) -> f64 {
        MULTIPLE * self.single_path_reflectance(to_sun, to_sensor)
    }

    /// Spherical albedo: the share of diffuse light from below that the air sends back. Molecules after Chandrasekhar (as
    /// in 6S, `CSALBR`), aerosol by its backward share along the mean diffuse path.
    pub(super) fn spherical_albedo(&self) -> f64 {
        // Mean slant of diffuse light, and the backward share of a scattering for such light (Wiscombe and Grams 1976).
        const DIFFUSE_PATH: f64 = 1.66;
        let t = self.rayleigh;
        let e3 = 0.5 * (libm::exp(-t) * (1.0 - t) + t * t * exponential_integral(t));
        let molecules = (3.0 * t - e3 * (4.0 + 2.0 * t) + 2.0 * libm::exp(-t)) / (4.0 + 3.0 * t);
        let backward = 0.5 * (1.0 - 0.875 * AEROSOL_ASYMMETRY);
        molecules + 1.0 - libm::exp(-DIFFUSE_PATH * backward * AEROSOL_ALBEDO * self.aerosol)
    }
}

/// `E1(t)` for 0 < t <= 1 (Abramowitz and Stegun 5.1.53).
fn exponential_integral(t: f64) -> f64 {
    const A: [f64; 6] = [-0.577_215_66, 0.999_991_93, -0.249_910_55, 0.055_199_68, -0.009_760_04, 0.001_078_57];
    A.iter().rev().fold(0.0, |sum, a| sum * t + a) - libm::log(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ZENITH_30: f64 = 0.523_598_775_598_298_8;

    /// Class values for a sun zenith of 30 deg, seen from straight above: depths, single-scatter path reflectance,
    /// transmittances at an aerosol depth of 0.15.
    #[test]
    fn class_values_of_a_clear_day() {
        let (sin, mu) = libm::sincos(ZENITH_30);
        let to_sun = DVec3::new(sin, 0.0, mu);
        let table = [(0.170, 0.050, 0.87, 0.89), (0.101, 0.034, 0.91, 0.93), (0.046, 0.019, 0.95, 0.96)];
        for (band, (depth, path, down, up)) in table.into_iter().enumerate() {
            let air = Air::new(band, 0.15);
            assert!((air.rayleigh - depth).abs() < 0.001, "tau_R {band}: {}", air.rayleigh);
            let found = air.single_path_reflectance(to_sun, DVec3::Z);
            assert!((found - path).abs() < 0.003, "path {band}: {found}");
            assert!((1.15..=1.25).contains(&(air.path_reflectance(to_sun, DVec3::Z) / found)));
            assert!((air.transmittance(mu) - down).abs() < 0.01, "down {band}: {}", air.transmittance(mu));
            assert!((air.transmittance(1.0) - up).abs() < 0.01, "up {band}: {}", air.transmittance(1.0));
        }
    }

    /// Diffuse shares of the irradiance on flat ground at three aerosol depths, sun zenith 30 deg.
    #[test]
    fn diffuse_shares() {
        let mu = libm::cos(ZENITH_30);
        for (aerosol, shares) in [(0.05, [0.14, 0.10, 0.06]), (0.15, [0.23, 0.18, 0.13]), (0.30, [0.36, 0.29, 0.22])] {
            for (band, share) in shares.into_iter().enumerate() {
                let air = Air::new(band, aerosol);
                let found = 1.0 - air.direct(mu) / air.transmittance(mu);
                assert!((found - share).abs() < 0.015, "aerosol {aerosol}, band {band}: {found} against {share}");
            }
        }
    }

    /// Chandrasekhar's values for a conservative molecular air, and the order of magnitude of 6S for a hazy one.
    #[test]
    fn spherical_albedo_of_thin_air() {
        assert!((exponential_integral(0.5) - 0.559_773_6).abs() < 1e-6);
        let molecules = Air { rayleigh: 0.1, aerosol: 0.0, gas: 0.0 }.spherical_albedo();
        // A thin layer sends back half of what it scatters out of diffuse light, whose mean path is 2.
        assert!(molecules < 0.1 && molecules > 0.07, "{molecules}");
        let hazy = Air::new(0, 0.3).spherical_albedo();
        assert!((0.17..0.27).contains(&hazy), "{hazy}");
    }

    #[test]
    fn air_creates_no_light() {
        for band in 0..4 {
            for aerosol in [0.0, 0.12, 1.0] {
                let air = Air::new(band, aerosol);
                for mu in [0.17_f64, 0.5, 1.0] {
                    let to_sun = DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
                    let path = air.path_reflectance(to_sun, DVec3::Z);
                    assert!(air.direct(mu) <= air.transmittance(mu), "band {band}, aerosol {aerosol}, mu {mu}");
                    // Not a flux balance: the path is seen from above only. But white ground stays below white.
                    let up = air.transmittance(1.0);
                    let white = path + air.transmittance(mu) * up / (1.0 - air.spherical_albedo());
                    assert!(white < 1.05, "band {band}, aerosol {aerosol}, mu {mu}: {white}");
                }
            }
        }
    }
}
