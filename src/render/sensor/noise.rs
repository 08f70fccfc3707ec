//! What detectors add: shot noise, read noise, and columns of unequal gain.

use satseed_scene::{SeedPath, hash_cell};

/// Reflectance at which a signal-to-noise ratio is stated.
const SNR_REFLECTANCE: f64 = 0.3;

/// Noise of variance `a + b L` at a signal `L`, and the spread of the columns' gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Ratio of signal to noise at a signal of 0.3, 5..=100,000; none for no shot noise.
    pub snr: Option<f64>,
    /// Standard deviation at a signal of 0, in the signal's unit, 0..=0.05. Not more than the whole noise at 0.3.
    pub read: f64,
    /// Standard deviation of the columns' gains about 1, 0..=0.05.
    pub column_gain: f64,
}

impl Noise {
    /// None at all.
    pub const NONE: Self = Self { snr: None, read: 0.0, column_gain: 0.0 };

    /// `a` and `b` of the variance.
    pub fn variance(&self) -> [f64; 2] {
        let a = self.read * self.read;
        let whole = self.snr.map_or(0.0, |snr| (SNR_REFLECTANCE / snr) * (SNR_REFLECTANCE / snr));
        [a, ((whole - a) / SNR_REFLECTANCE).max(0.0)]
    }

    /// Largest [`Noise::read`] that a ratio leaves room for.
    pub fn most_read(snr: f64) -> f64 {
        SNR_REFLECTANCE / snr
    }

    /// The line of detectors of one band (0..4 the scene's, 4 pan) of one image.
    pub(super) fn detector(&self, image: &SeedPath, band: usize, width: usize) -> Detector {
        let key = image.index(band as u64).hash_u32();
        let [a, b] = self.variance().map(|x| x as f32);
        let spread = self.column_gain as f32;
        let gains = (0..width).map(|u| 1.0 + spread * standard_noise(u as i32, -1, key)).collect();
        Detector { key, a, b, gains }
    }
}

/// The detectors of one band of one image.
#[derive(Clone, Debug)]
pub(super) struct Detector {
    key: u32,
    a: f32,
    b: f32,
    /// Gain of each column.
    gains: Vec<f32>,
}

impl Detector {
    /// What the detector of a column reads of a signal.
    #[inline]
    pub(super) fn read(&self, u: usize, v: usize, signal: f32) -> f32 {
        let even = signal * self.gains[u];
        let variance = self.a + self.b * signal.max(0.0);
        if variance > 0.0 { even + variance.sqrt() * standard_noise(u as i32, v as i32, self.key) } else { even }
    }
}

/// Eight uniforms of 0..65535 have the variance 8 * 65536^2 / 12.
const INVERSE_DEVIATION: f32 = 1.868_8e-5;

/// A number of mean 0, variance 1 and nearly normal: eight 16-bit words of hashes, summed.
#[inline]
fn standard_noise(u: i32, v: i32, key: u32) -> f32 {
    let mut sum = 0_u32;
    for k in 0..4 {
        let h = hash_cell(u, v, k, key);
        sum += (h & 0xffff) + (h >> 16);
    }
    (sum as f32 - 262_140.0) * INVERSE_DEVIATION
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_centred_of_unit_variance_and_nearly_normal() {
        let n = 200_000;
        let (mut sum, mut square, mut fourth) = (0.0_f64, 0.0_f64, 0.0_f64);
        for i in 0..n {
            let x = f64::from(standard_noise(i % 317, i / 317, 77));
            sum += x;
            square += x * x;
            fourth += x * x * x * x;
        }
        let (mean, variance, kurtosis) = (sum / f64::from(n), square / f64::from(n), fourth / f64::from(n));
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((variance - 1.0).abs() < 0.01, "{variance}");
        // Eight uniforms: 3 - 6/5/8.
        assert!((kurtosis - 2.85).abs() < 0.05, "{kurtosis}");
    }

    #[test]
    fn the_stated_ratio_is_met_where_it_is_stated() {
        let noise = Noise { snr: Some(120.0), read: 0.000_65, column_gain: 0.0 };
        let [a, b] = noise.variance();
        let snr = |signal: f64| signal / (a + b * signal).sqrt();
        assert!((snr(0.3) - 120.0).abs() < 1e-9);
        // In shadow, at a tenth of that, about 30.
        assert!((snr(0.03) - 30.0).abs() < 1.5, "{}", snr(0.03));
        assert_eq!(Noise::NONE.variance(), [0.0, 0.0]);
    }
}
