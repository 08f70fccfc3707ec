//! From radiance to numbers: the imager's blur, noise and coding.

use super::film::Radiance;
use super::light::Light;
use rayon::prelude::*;
use satseed_scene::{SeedPath, hash_cell};

/// An 8-bit colour image, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue of each pixel.
    pub rgb: Vec<u8>,
}

/// An imager, by preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// The pixel's box alone: no optics, no noise.
    Ideal,
    /// `WorldView`-3 as delivered to the eye: 0.3 m, MTF 0.15 at Nyquist, SNR about 120 at reflectance 0.3, haze
    /// subtracted in part, square-root tone curve.
    WorldView3Rgb,
}

/// Share of the air's own light that the delivered product's dark point removes.
const DARK_POINT: f32 = 0.80;
/// Reflectance that becomes full white.
const WHITE_REFLECTANCE: f32 = 0.52;
/// Exponent of the tone curve.
const GAMMA: f32 = 1.0 / 2.0;

impl Sensor {
    /// Gaussian blur on top of the pixel's box, px. With the box's own 2/pi at Nyquist, 0.54 px gives an MTF of 0.15.
    pub fn psf_sigma_px(self) -> f64 {
        match self {
            Self::Ideal => 0.0,
            Self::WorldView3Rgb => 0.54,
        }
    }

    /// Variance of the noise at a signal (in units of reflectance): `a + b * signal`.
    fn noise(self) -> [f32; 2] {
        match self {
            Self::Ideal => [0.0; 2],
            // 0.3 / 120 at 0.3, 0.03 / 30 at 0.03.
            Self::WorldView3Rgb => [4.2e-7, 1.94e-5],
        }
    }

    /// Adds the air, the noise (keyed by `noise` and the pixel) and codes to 8 bits.
    pub(super) fn develop(self, radiance: &Radiance, light: &Light, noise: &SeedPath) -> Image {
        let [a, b] = self.noise();
        let key = noise.hash_u32();
        let width = radiance.width as usize;
        let rows: Vec<Vec<u8>> = radiance
            .data
            .par_chunks(width)
            .enumerate()
            .map(|(v, row)| {
                let mut out = Vec::with_capacity(width * 3);
                for (u, ground) in row.iter().enumerate() {
                    let at_sensor = *ground * light.upward_transmittance + light.path_radiance;
                    for band in [2, 1, 0] {
                        let signal = at_sensor[band] / light.white_radiance[band];
                        let dark = DARK_POINT * light.path_radiance[band] / light.white_radiance[band];
                        let sigma = (a + b * signal.max(0.0)).sqrt();
                        let noisy = signal + sigma * standard_noise(u as i32, v as i32, band as i32, key);
                        out.push(code(noisy - dark));
                    }
                }
                out
            })
            .collect();
        Image { width: radiance.width, height: radiance.height, rgb: rows.into_iter().flatten().collect() }
    }
}

fn code(reflectance: f32) -> u8 {
    let share = (reflectance / WHITE_REFLECTANCE).clamp(0.0, 1.0);
    (libm::powf(share, GAMMA) * 255.0 + 0.5) as u8
}

/// Eight uniforms of 0..65535 have the variance 8 * 65536^2 / 12.
const INVERSE_DEVIATION: f32 = 1.868_8e-5;

/// A number of mean 0, variance 1 and nearly normal: eight 16-bit words of hashes, summed.
fn standard_noise(u: i32, v: i32, band: i32, key: u32) -> f32 {
    let mut sum = 0_u32;
    for k in 0..4 {
        let h = hash_cell(u, v, band * 4 + k, key);
        sum += (h & 0xffff) + (h >> 16);
    }
    (sum as f32 - 262_140.0) * INVERSE_DEVIATION
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_centred_and_of_unit_variance() {
        let (mut sum, mut square) = (0.0_f64, 0.0_f64);
        let n = 100_000;
        for i in 0..n {
            let x = f64::from(standard_noise(i % 317, i / 317, i % 3, 77));
            sum += x;
            square += x * x;
        }
        let (mean, variance) = (sum / f64::from(n), square / f64::from(n));
        assert!(mean.abs() < 0.02, "{mean}");
        assert!((variance - 1.0).abs() < 0.02, "{variance}");
    }
}
