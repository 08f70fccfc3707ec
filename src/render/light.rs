//! Sun, sky and air of a clear day, per band.
//!
//! Optical depths after Hansen and Travis (1974) for molecules and Angstrom's law for aerosol; total downward and upward
//! transmittance with the backward scattered share lost; path reflectance by single scattering with a factor for
//! multiple scattering (after Vermote et al. 1997, 6S). The sky's shape is the CIE standard clear sky (CIE S 011:2003,
//! type 12), scaled so that its horizontal irradiance is the diffuse share. Air is that of the whole column above the
//! scene, from orbit: nothing is marched through the proxy camera's first kilometre.

use glam::DVec3;
use satseed_scene::{Bands, Environment};

/// Band centres, micrometres: blue, green, red, near infrared.
const WAVELENGTH_UM: [f64; 4] = [0.48, 0.545, 0.66, 0.83];
/// Solar irradiance at the top of the atmosphere, W / (m^2 um); WorldView-3's bands, rounded.
const TOP_IRRADIANCE: [f64; 4] = [2005.0, 1830.0, 1535.0, 1090.0];
/// Aerosol: single scattering albedo, asymmetry, Angstrom exponent, and the share of scattering that goes on forward.
const AEROSOL_ALBEDO: f64 = 0.93;
const AEROSOL_ASYMMETRY: f64 = 0.65;
const ANGSTROM: f64 = 1.3;
const AEROSOL_FORWARD: f64 = 0.86;
/// Share of molecular scattering that does not reach the other side.
const RAYLEIGH_BACK: f64 = 0.48;
/// Multiple scattering relative to single scattering in the path radiance.
const MULTIPLE: f64 = 1.2;

/// Light of one acquisition.
#[derive(Clone, Debug)]
pub struct Light {
    /// Unit vector to the sun's centre.
    pub sun: DVec3,
    /// Direct irradiance on a surface that faces the sun, at the ground, W / (m^2 um).
    pub sun_irradiance: Bands,
    /// Diffuse irradiance of the open sky on flat ground, W / (m^2 um).
    pub sky_irradiance: Bands,
    /// Share of the ground's radiance that reaches the sensor.
    pub upward_transmittance: Bands,
    /// Radiance that the air itself sends to the sensor, W / (m^2 sr um).
    pub path_radiance: Bands,
    /// Radiance of a white Lambert surface in full sun and sky at the top of the atmosphere, W / (m^2 sr um).
    pub white_radiance: Bands,
    sky_scale: Bands,
}

impl Light {
    /// Works out the light of an environment.
    pub fn new(environment: &Environment) -> Self {
        let sun = environment.sun_direction();
        let mu = sun.z.max(0.02);
        let mut l = Self {
            sun,
            sun_irradiance: Bands::ZERO,
            sky_irradiance: Bands::ZERO,
            upward_transmittance: Bands::ZERO,
            path_radiance: Bands::ZERO,
            white_radiance: Bands::ZERO,
            sky_scale: Bands::ZERO,
        };
        let shape_irradiance = integrate_sky(sun);
        for b in 0..4 {
            let air = Air::new(WAVELENGTH_UM[b], environment.aerosol_optical_depth);
            let top = TOP_IRRADIANCE[b];
            let direct = top * libm::exp(-air.total() / mu);
            let down = top * mu * air.transmittance(mu);
            let diffuse = (down - direct * mu).max(0.0);
            l.sun_irradiance.0[b] = direct as f32;
            l.sky_irradiance.0[b] = diffuse as f32;
            l.sky_scale.0[b] = (diffuse / shape_irradiance) as f32;
            let up = air.transmittance(1.0);
            l.upward_transmittance.0[b] = up as f32;
            l.path_radiance.0[b] = (air.path_reflectance(mu) * top * mu / core::f64::consts::PI) as f32;
            l.white_radiance.0[b] = (down * up / core::f64::consts::PI) as f32;
        }
        l
    }

    /// Radiance of the open sky in a direction (unit); below the horizon, the horizon's.
    #[inline]
    pub fn sky_radiance(&self, direction: DVec3) -> Bands {
        self.sky_scale * clear_sky(direction, self.sun) as f32
    }
}

struct Air {
    rayleigh: f64,
    aerosol: f64,
}

impl Air {
    fn new(wavelength_um: f64, aerosol_550: f64) -> Self {
        let l2 = 1.0 / (wavelength_um * wavelength_um);
        Self {
            rayleigh: 0.008_569 * l2 * l2 * (1.0 + 0.0113 * l2 + 0.000_13 * l2 * l2),
            aerosol: aerosol_550 * libm::pow(wavelength_um / 0.55, -ANGSTROM),
        }
    }

    fn total(&self) -> f64 {
        self.rayleigh + self.aerosol
    }

    /// Direct plus diffuse transmittance along the cosine `mu`.
    fn transmittance(&self, mu: f64) -> f64 {
        let lost = RAYLEIGH_BACK * self.rayleigh + (1.0 - AEROSOL_ALBEDO * AEROSOL_FORWARD) * self.aerosol;
        libm::exp(-lost / mu)
    }

    /// Reflectance of the air alone, seen from straight above under the sun's cosine `mu`.
    fn path_reflectance(&self, mu: f64) -> f64 {
        let cos_scatter = -mu;
        let rayleigh = 0.75 * (1.0 + cos_scatter * cos_scatter);
        let g = AEROSOL_ASYMMETRY;
        let aerosol = (1.0 - g * g) / libm::pow(1.0 + g * g - 2.0 * g * cos_scatter, 1.5);
        let scattered = (self.rayleigh * rayleigh + AEROSOL_ALBEDO * self.aerosol * aerosol) / self.total();
        let paths = 1.0 - libm::exp(-self.total() * (1.0 / mu + 1.0));
        MULTIPLE * scattered * paths / (4.0 * (mu + 1.0))
    }
}

/// Relative radiance of the CIE standard clear sky, type 12, 1-normalised nowhere: only its shape counts.
fn clear_sky(direction: DVec3, sun: DVec3) -> f64 {
    let cos_zenith = direction.z.max(0.01);
    let cos_sun = direction.dot(sun).clamp(-1.0, 1.0);
    let from_sun = libm::acos(cos_sun);
    let gradation = 1.0 - libm::exp(-0.32 / cos_zenith);
    let indicatrix =
        1.0 + 10.0 * (libm::exp(-3.0 * from_sun) - libm::exp(-1.5 * core::f64::consts::PI)) + 0.45 * cos_sun * cos_sun;
    gradation * indicatrix
}

/// Horizontal irradiance of the sky's shape: the midpoint rule over cos^2 and azimuth, so equal steps weigh equally.
fn integrate_sky(sun: DVec3) -> f64 {
    const STEPS: u32 = 96;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let cos = ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt();
        let sin = (1.0 - cos * cos).sqrt();
        for k in 0..2 * STEPS {
            let (s, c) = libm::sincos((f64::from(k) + 0.5) * core::f64::consts::PI / f64::from(STEPS));
            sum += clear_sky(DVec3::new(sin * c, sin * s, cos), sun);
        }
    }
    core::f64::consts::PI * sum / f64::from(STEPS * 2 * STEPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(zenith_deg: f64, aerosol_optical_depth: f64) -> Environment {
        Environment { sun_elevation_rad: (90.0 - zenith_deg).to_radians(), sun_azimuth_rad: 2.5, aerosol_optical_depth }
    }

    /// Single-scatter values for a sun zenith of 30 deg and an optical depth of 0.15, as tabulated for 6S-like air.
    #[test]
    fn class_values_of_a_clear_day() {
        let light = Light::new(&environment(30.0, 0.15));
        let mu = 30.0_f64.to_radians();
        let mu = libm::cos(mu);
        for (b, (down, up, path, diffuse)) in
            [(0.87, 0.89, 0.050, 0.23), (0.91, 0.93, 0.034, 0.18), (0.95, 0.96, 0.019, 0.13)].into_iter().enumerate()
        {
            let top = TOP_IRRADIANCE[b] * mu;
            let total = f64::from(light.sun_irradiance[b]) * mu + f64::from(light.sky_irradiance[b]);
            assert!((total / top - down).abs() < 0.01, "down {b}: {}", total / top);
            assert!((f64::from(light.upward_transmittance[b]) - up).abs() < 0.01);
            let path_found = f64::from(light.path_radiance[b]) * core::f64::consts::PI / top;
            assert!((path_found / MULTIPLE - path).abs() < 0.004, "path {b}: {}", path_found / MULTIPLE);
            let share = f64::from(light.sky_irradiance[b]) / total;
            assert!((share - diffuse).abs() < 0.015, "diffuse {b}: {share}");
        }
    }

    #[test]
    fn the_dome_integrates_to_the_diffuse_irradiance() {
        let light = Light::new(&environment(48.0, 0.12));
        // A quadrature of its own: uniform in solid angle.
        let mut sum = 0.0;
        let n = 400;
        for i in 0..n {
            let z = (f64::from(i) + 0.5) / f64::from(n);
            let r = (1.0 - z * z).sqrt();
            for k in 0..n {
                let (s, c) = libm::sincos((f64::from(k) + 0.5) / f64::from(n) * core::f64::consts::TAU);
                sum += f64::from(light.sky_radiance(DVec3::new(r * c, r * s, z))[1]) * z;
            }
        }
        let irradiance = sum / f64::from(n * n) * core::f64::consts::TAU;
        let stated = f64::from(light.sky_irradiance[1]);
        assert!((irradiance / stated - 1.0).abs() < 0.005, "{irradiance} against {stated}");
    }
}
