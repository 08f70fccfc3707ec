//! Fractal noise: octaves that are worked out once, and summed at a point.

use crate::field::{Filtered, Space, SurfacePoint, position};
use crate::texture_noise::{NOISE_DEVIATION, noise_2d, noise_3d, slope_2d};
use crate::wide::wide;

/// How much shorter each octave is. Not an integer, so that lattices never fall together.
const LACUNARITY: f64 = 1.93;

/// Surfaces whose normal rises more than this are near enough to level for a texture over east and north alone: half
/// the cost of one over space, and on a slope of 45 degrees longer by a factor of 1.4 than it should be.
const LEVEL: f64 = 0.7;

/// Fractal gradient noise: mean 0, range about -1..1. Octaves shorter than two footprints are dropped.
///
/// In [`Space::Uv`] and [`Space::Plan`] it is two-dimensional, in [`Space::Object`] three-dimensional; in
/// [`Space::World`] it is that of the plan on level surfaces and three-dimensional on steep ones.
#[derive(Clone, Debug)]
pub struct Fractal {
    space: Space,
    seed: u32,
    wavelength_m: f32,
    gain: f32,
    /// Inverse of the factors on the wavelengths along the axes.
    squeeze: [f64; 3],
    octaves: Vec<Octave>,
}

#[derive(Clone, Debug)]
struct Octave {
    seed: u32,
    /// Waves per metre.
    frequency: f64,
    /// Half the wavelength, m.
    half_m: f32,
    /// Normalised in variance over all octaves, so that the contrast does not depend on their number.
    amplitude: f32,
    /// Variance of this octave and of all shorter ones.
    variance_from_here: f32,
}

impl Fractal {
    /// Noise with a first octave of `wavelength_m`; each is 1.93 times shorter and half as strong as the one before.
    pub fn new(space: Space, seed: u32, wavelength_m: f32, octaves: u8) -> Self {
        Self { space, seed, wavelength_m, gain: 0.5, squeeze: [1.0; 3], octaves: Vec::new() }.built(octaves)
    }

    /// With another amplitude of an octave relative to the one before.
    #[must_use]
    pub fn gain(mut self, gain: f32) -> Self {
        self.gain = gain;
        let octaves = self.octaves.len() as u8;
        self.built(octaves)
    }

    /// With wavelengths along the axes multiplied by factors: (1, 1, 8) makes vertical streaks.
    #[must_use]
    pub fn stretched(mut self, by: [f32; 3]) -> Self {
        self.squeeze = by.map(|s| 1.0 / f64::from(s));
        self
    }

    fn built(mut self, octaves: u8) -> Self {
        let power = |k: i32| (0..k).fold(1.0_f32, |a, _| a * self.gain);
        let norm: f32 = (0..i32::from(octaves)).map(|k| power(k) * power(k)).sum();
        let mut wavelength = f64::from(self.wavelength_m);
        let mut list = Vec::with_capacity(octaves as usize);
        for k in 0..u32::from(octaves) {
            list.push(Octave {
                seed: self.seed.wrapping_add(k.wrapping_mul(0x9e37_79b9)),
                frequency: 1.0 / wavelength,
                half_m: (wavelength / 2.0) as f32,
                amplitude: power(k as i32) / norm.sqrt(),
                variance_from_here: 0.0,
            });
            wavelength /= LACUNARITY;
        }
        let mut variance = 0.0;
        for octave in list.iter_mut().rev() {
            let deviation = octave.amplitude * NOISE_DEVIATION;
            variance += deviation * deviation;
            octave.variance_from_here = variance;
        }
        self.octaves = list;
        self
    }

    fn is_flat(&self, p: &SurfacePoint) -> bool {
        match self.space {
            Space::Uv | Space::Plan => true,
            Space::Object => false,
            Space::World => p.normal.z.abs() > LEVEL,
        }
    }

    /// The octaves that a footprint leaves something of, with their remaining amplitudes; and the variance it hides.
    #[inline(always)]
    fn visible(&self, p: &SurfacePoint, mut add: impl FnMut(&Octave, f32)) -> f32 {
        let per_footprint = (1.0 / p.footprint_m) as f32;
        let mut hidden = 0.0;
        for octave in &self.octaves {
            // Full weight above four footprints, none below two.
            let keep = octave.half_m * per_footprint - 1.0;
            if keep <= 0.0 {
                return hidden + octave.variance_from_here;
            }
            if keep < 1.0 {
                let lost = octave.amplitude * (1.0 - keep) * NOISE_DEVIATION;
                hidden += lost * lost;
                add(octave, octave.amplitude * keep);
            } else {
                add(octave, octave.amplitude);
            }
        }
        hidden
    }

    /// Whether another is the same noise.
    #[inline]
    pub(crate) fn is(&self, other: &Self) -> bool {
        core::ptr::eq(self, other)
            || self.seed == other.seed
                && self.wavelength_m == other.wavelength_m
                && self.octaves.len() == other.octaves.len()
                && self.space == other.space
                && self.gain == other.gain
                && self.squeeze == other.squeeze
    }

    pub(crate) fn evaluate(&self, p: &SurfacePoint) -> Filtered {
        wide(|| self.filtered(p))
    }

    #[inline(always)]
    fn filtered(&self, p: &SurfacePoint) -> Filtered {
        let q = position(p, self.space);
        let (x, y) = (q.x * self.squeeze[0], q.y * self.squeeze[1]);
        let mut mean = 0.0;
        let variance = if self.is_flat(p) {
            self.visible(p, |o, amplitude| mean += amplitude * noise_2d(x * o.frequency, y * o.frequency, o.seed))
        } else {
            let z = q.z * self.squeeze[2];
            self.visible(p, |o, amplitude| {
                mean += amplitude * noise_3d(x * o.frequency, y * o.frequency, z * o.frequency, o.seed);
            })
        };
        Filtered { mean, variance }
    }

    /// Derivatives over the first two axes, 1/m, where the noise is two-dimensional.
    pub(crate) fn slope(&self, p: &SurfacePoint) -> Option<[f64; 2]> {
        self.is_flat(p).then(|| wide(|| self.slope_over_plan(p)))
    }

    #[inline(always)]
    fn slope_over_plan(&self, p: &SurfacePoint) -> [f64; 2] {
        let q = position(p, self.space);
        let [kx, ky, _] = self.squeeze;
        let mut sum = [0.0; 2];
        self.visible(p, |o, amplitude| {
            let slope = slope_2d(q.x * kx * o.frequency, q.y * ky * o.frequency, o.seed);
            let strength = f64::from(amplitude) * o.frequency;
            sum[0] += f64::from(slope[0]) * strength * kx;
            sum[1] += f64::from(slope[1]) * strength * ky;
        });
        sum
    }

    /// Whether a footprint hides all of it.
    pub(crate) fn is_hidden(&self, footprint_m: f64) -> bool {
        f64::from(self.wavelength_m) <= 2.0 * footprint_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    /// Wide registers change no bit.
    #[test]
    fn wide_registers_give_the_same_bits() {
        let mut rng = crate::SeedPath::root("wide", 1).rng();
        for (space, steep) in [(Space::World, 0.2), (Space::World, 1.0), (Space::Object, 1.0), (Space::Uv, 1.0)] {
            let noise = Fractal::new(space, 77, 6.0, 5).gain(0.6).stretched([1.0, 3.0, 0.5]);
            for _ in 0..5_000 {
                let place = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 900.0;
                let point = SurfacePoint {
                    world_m: place,
                    object_m: place * 0.1,
                    uv_m: DVec2::new(place.y, place.x),
                    normal: DVec3::new((1.0_f64 - steep * steep).sqrt(), 0.0, steep),
                    footprint_m: 0.05 + rng.unit(),
                    variation: [0.0; 4],
                };
                let (found, plain) = (noise.evaluate(&point), noise.filtered(&point));
                assert_eq!(found.mean.to_bits(), plain.mean.to_bits());
                assert_eq!(found.variance.to_bits(), plain.variance.to_bits());
                if let Some(slope) = noise.slope(&point) {
                    assert_eq!(slope.map(f64::to_bits), noise.slope_over_plan(&point).map(f64::to_bits));
                }
            }
        }
    }
}
