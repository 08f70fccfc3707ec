//! The blur of optics, detector and motion.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

/// Least modulation transfer at the Nyquist frequency that can be asked for.
pub const MIN_MTF: f64 = 0.02;
/// Largest: beyond it the pixel's own box (0.64) leaves too little for a blur on a grid of half pixels.
pub const MAX_MTF: f64 = 0.40;

/// The point spread on top of the pixel's own box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Modulation transfer across the track at half a cycle a pixel, pixel box and a Gaussian together,
    /// [`MIN_MTF`]..=[`MAX_MTF`]; none for the box alone, which has 2/pi.
    pub mtf_at_nyquist: Option<f64>,
    /// How far the image moves along the track (down the image) while it is exposed, px, 0..=2; needs a blur.
    pub smear_px: f64,
}

impl Optics {
    /// Standard deviation of the Gaussian, px.
    pub fn sigma_px(&self) -> f64 {
        // 2/pi exp(-2 (pi sigma / 2)^2) at half a cycle a pixel.
        self.mtf_at_nyquist.map_or(0.0, |mtf| (-2.0 * libm::log(mtf * PI / 2.0)).sqrt() / PI)
    }

    /// Modulation transfer along the track at half a cycle a pixel.
    pub fn mtf_along_track(&self) -> f64 {
        let half = PI * self.smear_px / 2.0;
        let smear = if half > 0.0 { libm::sin(half) / half } else { 1.0 };
        self.mtf_at_nyquist.unwrap_or(2.0 / PI) * smear
    }

    /// Weights of the cells of a grid of `fine` cells a pixel, along a row: from [`Kernel::reach`] cells before a pixel's
    /// first cell to as many after its last.
    pub(in crate::render) fn across(&self, fine: u32) -> Kernel {
        Kernel::new(self.sigma_px() * f64::from(fine), 0.0, fine)
    }

    /// The same, down a column.
    pub(in crate::render) fn along(&self, fine: u32) -> Kernel {
        Kernel::new(self.sigma_px() * f64::from(fine), self.smear_px * f64::from(fine), fine)
    }
}

/// A pixel's weights over the cells of a finer grid, in one direction.
#[derive(Clone, Debug)]
pub(in crate::render) struct Kernel {
    /// Cells beyond the pixel's own on each side.
    pub reach: i32,
    /// Weights, sum 1.
    pub weights: Vec<f32>,
}

impl Kernel {
    /// A box of `pixel` cells, convolved with a Gaussian of `sigma` and a box of `smear`, in cells. Without a Gaussian no
    /// smear either: a box shorter than a cell cannot be told on its grid.
    pub(super) fn new(sigma: f64, smear: f64, pixel: u32) -> Self {
        let reach = if sigma > 0.0 { libm::ceil(3.5 * sigma + smear / 2.0) as i32 } else { 0 };
        let below = |x: f64| 0.5 * (1.0 + libm::erf(x / sigma * FRAC_1_SQRT_2));
        let spread = |x: i32| {
            let x = f64::from(x);
            if sigma <= 0.0 {
                f64::from(u8::from(x == 0.0))
            } else if smear <= 1e-6 {
                libm::exp(-0.5 * x * x / (sigma * sigma))
            } else {
                below(x + smear / 2.0) - below(x - smear / 2.0)
            }
        };
        let cells = pixel as i32;
        let weights: Vec<f64> =
            (-reach..cells + reach).map(|i| (0..cells).map(|cell| spread(i - cell)).sum()).collect();
        let total: f64 = weights.iter().sum();
        Self { reach, weights: weights.into_iter().map(|w| (w / total) as f32).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_centred_on_the_pixel_and_sum_to_one() {
        for (sigma, smear, pixel) in [(0.0, 0.0, 1), (0.0, 0.0, 2), (0.6, 0.0, 1), (1.1, 0.8, 2), (2.1, 0.0, 4)] {
            let k = Kernel::new(sigma, smear, pixel);
            assert!((k.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let centroid: f64 = k.weights.iter().enumerate().map(|(i, w)| i as f64 * f64::from(*w)).sum();
            let middle = f64::from(k.reach) + (f64::from(pixel) - 1.0) / 2.0;
            assert!((centroid - middle).abs() < 1e-6, "{sigma} {pixel}: {centroid} against {middle}");
        }
    }

    /// The kernel's own transfer on the fine grid, with the box of a fine cell that tracing adds, at half a cycle a pixel.
    #[test]
    fn kernels_have_the_transfer_that_was_asked_for() {
        for mtf in [MIN_MTF, 0.10, 0.15, 0.20, MAX_MTF] {
            for smear_px in [0.0, 0.4, 1.0] {
                let optics = Optics { mtf_at_nyquist: Some(mtf), smear_px };
                for (kernel, expected) in [(optics.across(2), mtf), (optics.along(2), optics.mtf_along_track())] {
                    let transfer = |f: f64| {
                        let centre = (kernel.weights.len() as f64 - 1.0) / 2.0;
                        let wave = |i: usize| libm::cos(2.0 * PI * f * (i as f64 - centre));
                        kernel.weights.iter().enumerate().map(|(i, w)| f64::from(*w) * wave(i)).sum::<f64>()
                    };
                    // A quarter cycle a cell; the cell's own box has sin(pi/4) / (pi/4) there.
                    let found = transfer(0.25) * libm::sin(PI / 4.0) / (PI / 4.0);
                    assert!((found - expected).abs() < 0.012, "{mtf} {smear_px}: {found} against {expected}");
                }
            }
        }
    }
}
