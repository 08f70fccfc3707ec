//! Sun, sky and ground of a clear day, per band: what does not depend on the camera, worked out once per scene.
//!
//! The sky's shape is the CIE standard clear sky (CIE S 011:2003, type 12), scaled so that its horizontal irradiance is
//! the diffuse share of the air's transmittance. What the ground sends up and the air sends back comes on top, the same
//! from everywhere, and brightens shadows over bright ground.

use super::AmbientMode;
use super::air::Air;
use super::ambient::Ambient;
use super::sampling::Sample;
use super::shading::radiance;
use glam::DVec3;
use rayon::prelude::*;
use satseed_scene::{Bands, Environment, Ray};
use satseed_tracer::Tracer;
use std::sync::Arc;

/// Solar irradiance at the top of the atmosphere, W / (m^2 um); WorldView-3's bands, rounded.
const TOP_IRRADIANCE: [f64; 4] = [2005.0, 1830.0, 1535.0, 1090.0];
/// Lowest cosine of a zenith that the formulas of plane air are used for.
const LEAST_COSINE: f64 = 0.1;

/// Light of one acquisition over one scene.
#[derive(Clone, Debug)]
pub struct Light {
    /// Unit vector to the sun's centre.
    pub sun: DVec3,
    /// Direct irradiance on a surface that faces the sun, at the ground, W / (m^2 um).
    pub sun_irradiance: Bands,
    /// Diffuse irradiance of the open sky on flat ground, W / (m^2 um).
    pub sky_irradiance: Bands,
    /// Mean radiance that the surroundings send up, W / (m^2 sr um).
    pub mean_radiance: Bands,
    /// What of a white Lambert surface on flat ground, in full sun and sky, reaches a sensor straight above, without the
    /// air's own light; W / (m^2 sr um). The unit of a sensor's signal.
    pub white_radiance: Bands,
    /// The clear sky's shape times this is radiance.
    pub(super) sky_scale: Bands,
    /// Radiance of the sky that is the same from everywhere.
    pub(super) sky_uniform: Bands,
    pub(super) air: [Air; 4],
    /// What all views share of the dome's light; none where each sample asks for itself.
    pub(super) ambient: Option<Arc<Ambient>>,
}

/// What the air between ground and sensor does to radiance: `ground * direct + added`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Veil {
    /// Share of the ground's radiance that arrives from where it left.
    pub direct: Bands,
    /// The air's own light, and that of the surroundings scattered into the line of sight, W / (m^2 sr um).
    pub added: Bands,
}

impl Light {
    /// The light over a scene. Its mean reflectance, shadows and gaps included, is what a fixed grid of vertical rays
    /// finds over its full detail, at most 1 km across: the reach of scattering between ground and air.
    pub fn of(tracer: &Tracer, environment: &Environment) -> Self {
        let over_black = Self::over(environment, Bands::ZERO);
        let mean = over_black.mean_over(tracer);
        let white = over_black.flat_irradiance();
        let reflectance = Bands(core::array::from_fn(|b| core::f32::consts::PI * mean[b] / white[b]));
        Self::over(environment, reflectance)
    }

    /// The light over surroundings of a mean reflectance.
    pub fn over(environment: &Environment, mean_reflectance: Bands) -> Self {
        const PI: f64 = core::f64::consts::PI;
        let sun = environment.sun_direction();
        let mu = sun.z.max(LEAST_COSINE);
        let air: [Air; 4] = core::array::from_fn(|b| Air::new(b, environment.aerosol_optical_depth));
        let shape_irradiance = integrate_sky(sun);
        let each = |value: &dyn Fn(usize, &Air) -> f64| Bands(core::array::from_fn(|b| value(b, &air[b]) as f32));
        let top = |b: usize, a: &Air| TOP_IRRADIANCE[b] * a.gas(mu);
        let down = |b: usize, a: &Air| top(b, a) * mu * a.transmittance(mu);
        let diffuse = |b: usize, a: &Air| top(b, a) * mu * (a.transmittance(mu) - a.direct(mu)).max(0.0);
        // Light that went up and came back, over and over.
        let back = |b: usize, a: &Air| {
            let share = a.spherical_albedo() * f64::from(mean_reflectance[b]).clamp(0.0, 1.0);
            down(b, a) * share / (1.0 - share)
        };
        Self {
            sun,
            sun_irradiance: each(&|b, a| top(b, a) * a.direct(mu)),
            sky_irradiance: each(&|b, a| diffuse(b, a) + back(b, a)),
            mean_radiance: each(&|b, a| f64::from(mean_reflectance[b]) * (down(b, a) + back(b, a)) / PI),
            white_radiance: each(&|b, a| down(b, a) * a.transmittance(1.0) * a.gas(1.0) / PI),
            sky_scale: each(&|b, a| diffuse(b, a) / shape_irradiance),
            sky_uniform: each(&|b, a| back(b, a) / PI),
            air,
            ambient: None,
        }
    }

    /// The same light, with the dome's part worked out in a way.
    #[must_use]
    pub fn with_ambient(self, mode: AmbientMode, radius_m: f64) -> Self {
        let most_bytes = Self::most_bytes(mode, radius_m) as usize;
        let shared = (mode == AmbientMode::PerScene).then(|| Arc::new(Ambient::new(&self, most_bytes)));
        Self { ambient: shared, ..self }
    }

    /// Bytes that it may come to hold for a scene that stands in full detail within `radius_m` of its pivot.
    pub fn most_bytes(mode: AmbientMode, radius_m: f64) -> u64 {
        match mode {
            AmbientMode::PerScene => Ambient::most_bytes(radius_m),
            AmbientMode::PerSample => 0,
        }
    }

    /// Sun and sky on flat open ground, W / (m^2 um).
    pub fn flat_irradiance(&self) -> Bands {
        self.sun_irradiance * self.sun.z.max(0.0) as f32 + self.sky_irradiance
    }

    /// The air towards a sensor in a direction (unit, from the ground): one for a whole frame, since an orbit sees a frame
    /// under one angle.
    pub fn veil(&self, to_sensor: DVec3) -> Veil {
        let clamped = |d: DVec3| d.with_z(d.z.max(LEAST_COSINE));
        let (to_sun, to_sensor) = (clamped(self.sun), clamped(to_sensor));
        let mut veil = Veil { direct: Bands::ZERO, added: Bands::ZERO };
        for (b, air) in self.air.iter().enumerate() {
            let gas = air.gas(to_sensor.z);
            let (direct, all) = (air.direct(to_sensor.z), air.transmittance(to_sensor.z));
            let top = TOP_IRRADIANCE[b] * to_sun.z * air.gas(to_sun.z) / core::f64::consts::PI;
            let path = air.path_reflectance(to_sun, to_sensor) * top;
            let around = (all - direct).max(0.0) * f64::from(self.mean_radiance[b]);
            veil.direct.0[b] = (direct * gas) as f32;
            veil.added.0[b] = ((path + around) * gas) as f32;
        }
        veil
    }

    /// Radiance of the open sky in a direction (unit); below the horizon, the horizon's.
    #[inline]
    pub fn sky_radiance(&self, direction: DVec3) -> Bands {
        self.sky_scale * clear_sky(direction, self.sun) as f32 + self.sky_uniform
    }

    /// Mean radiance of a scene seen from straight above.
    fn mean_over(&self, tracer: &Tracer) -> Bands {
        /// Rays along a side.
        const SIDE: i32 = 64;
        const REACH_M: f64 = 500.0;
        const ABOVE_M: f64 = 5000.0;
        /// Footprint of a ray, m: its colour stands for its surroundings.
        const FOOTPRINT_M: f64 = 2.0;
        let scene = tracer.scene();
        let reach_m = scene.full_detail_radius_m.min(REACH_M);
        let row = |j: i32| {
            let samples: Vec<Sample> = (0..SIDE).map(|i| Sample::new(i, j, 0, 0x6772_6f75)).collect();
            let place = |i: i32, jitter: f64| ((f64::from(i) + jitter) / f64::from(SIDE) * 2.0 - 1.0) * reach_m;
            let ray = |(i, sample): (i32, &Sample)| {
                let jitter = sample.square(0);
                let foot = DVec3::new(place(i, jitter.x), place(j, jitter.y), scene.pivot_height_m + ABOVE_M);
                Ray { origin: foot, direction: DVec3::NEG_Z }
            };
            let rays: Vec<Ray> = (0..).zip(&samples).map(ray).collect();
            radiance(tracer, self, &rays, FOOTPRINT_M / ABOVE_M, &samples, 1)
                .into_iter()
                .fold(Bands::ZERO, |a, b| a + b)
        };
        let rows: Vec<Bands> = (0..SIDE).into_par_iter().map(row).collect();
        rows.into_iter().fold(Bands::ZERO, |a, b| a + b) * (1.0 / (SIDE * SIDE) as f32)
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

    /// Irradiance on flat ground by a quadrature of its own: uniform in solid angle.
    fn dome_irradiance(light: &Light) -> Bands {
        let mut sum = Bands::ZERO;
        let n = 400;
        for i in 0..n {
            let z = (f64::from(i) + 0.5) / f64::from(n);
            let r = (1.0 - z * z).sqrt();
            for k in 0..n {
                let (s, c) = libm::sincos((f64::from(k) + 0.5) / f64::from(n) * core::f64::consts::TAU);
                sum += light.sky_radiance(DVec3::new(r * c, r * s, z)) * z as f32;
            }
        }
        sum * (core::f32::consts::TAU / (n * n) as f32)
    }

    #[test]
    fn the_dome_integrates_to_the_diffuse_irradiance() {
        for (zenith_deg, mean) in [(48.0, 0.0), (30.0, 0.2), (70.0, 0.6)] {
            let light = Light::over(&environment(zenith_deg, 0.12), Bands::grey(mean));
            let found = dome_irradiance(&light);
            for b in 0..4 {
                let stated = light.sky_irradiance[b];
                assert!((found[b] / stated - 1.0).abs() < 0.005, "{zenith_deg} {b}: {} against {stated}", found[b]);
            }
        }
    }

    /// Ground and air send light to and fro: the irradiance over grey ground is that over black ground times
    /// `1 / (1 - S m)`, and the sensor above endless ground of reflectance m sees `path + T_up m E / pi`.
    #[test]
    fn endless_ground_has_its_closed_form() {
        let environment = environment(40.0, 0.2);
        let black = Light::over(&environment, Bands::ZERO);
        let mean = 0.3;
        let grey = Light::over(&environment, Bands::grey(mean));
        let (above_black, above_grey) = (black.veil(DVec3::Z), grey.veil(DVec3::Z));
        for b in 0..4 {
            let air = Air::new(b, 0.2);
            let irradiance = grey.flat_irradiance()[b];
            let times = 1.0 / (1.0 - air.spherical_albedo() * f64::from(mean));
            assert!((f64::from(irradiance / black.flat_irradiance()[b]) / times - 1.0).abs() < 1e-5);
            let ground = mean * irradiance * core::f32::consts::FRAC_1_PI;
            let up = (air.transmittance(1.0) * air.gas(1.0)) as f32;
            let expected = above_black.added[b] + ground * up;
            let found = ground * above_grey.direct[b] + above_grey.added[b];
            assert!((found / expected - 1.0).abs() < 1e-5, "{b}: {found} against {expected}");
        }
    }

    /// Haze veils: less of the ground, more of the air; and a slanted sight is veiled more.
    #[test]
    fn veils_follow_depth_and_slant() {
        let clear = Light::over(&environment(48.0, 0.05), Bands::grey(0.15));
        let hazy = Light::over(&environment(48.0, 0.30), Bands::grey(0.15));
        let slanted = hazy.veil(DVec3::new(0.5, 0.0, 0.75_f64.sqrt()));
        let (clear, hazy) = (clear.veil(DVec3::Z), hazy.veil(DVec3::Z));
        for b in 0..4 {
            assert!(hazy.direct[b] < clear.direct[b] && hazy.added[b] > clear.added[b], "{b}");
            assert!(slanted.direct[b] < hazy.direct[b], "{b}");
        }
        // Blue is veiled most.
        assert!(clear.direct[0] < clear.direct[1] && clear.direct[1] < clear.direct[2]);
    }
}
