//! Where samples fall: stratified, keyed by pixel and sample, never drawn in order.

use glam::{DVec2, DVec3};
use satseed_scene::{hash_cell, unit_from_hash};

/// The numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pixel_hash: u32,
    index: u32,
}

impl Sample {
    /// Sample `index` of a pixel. `key` separates views.
    pub(super) fn new(column: i32, row: i32, index: u32, key: u32) -> Self {
        Self { pixel_hash: hash_cell(column, row, 0, key), index }
    }

    /// A point of the unit square for a purpose: over the pixel's samples, a Kronecker sequence on the plastic number
    /// (Roberts 2018), shifted by the pixel's own hash, so that few samples are already spread evenly.
    #[inline]
    pub(super) fn square(self, purpose: u32) -> DVec2 {
        const A: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
        let h = |k: u32| f64::from(unit_from_hash(hash_cell(purpose as i32, k as i32, 7, self.pixel_hash)));
        let p = DVec2::new(h(0), h(1)) + A * f64::from(self.index);
        p - DVec2::new(libm::floor(p.x), libm::floor(p.y))
    }
}

/// A direction about `normal` with density cos / pi (Malley's method: a disc lifted to the hemisphere).
#[inline]
pub(super) fn cosine_direction(normal: DVec3, square: DVec2) -> DVec3 {
    let radius = square.x.sqrt();
    let (s, c) = libm::sincos(square.y * core::f64::consts::TAU);
    let (a, b) = normal.any_orthonormal_pair();
    (a * (radius * c) + b * (radius * s) + normal * (1.0 - square.x).max(0.0).sqrt()).normalize()
}

/// A direction inside a cone of half angle `radius_rad` about `axis`, uniform over the disc.
#[inline]
pub(super) fn disc_direction(axis: DVec3, radius_rad: f64, square: DVec2) -> DVec3 {
    let radius = square.x.sqrt() * radius_rad;
    let (s, c) = libm::sincos(square.y * core::f64::consts::TAU);
    let (a, b) = axis.any_orthonormal_pair();
    (axis + a * (radius * c) + b * (radius * s)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_square_evenly() {
        let n = 256;
        let mut cells = [0; 16];
        let mut mean = DVec2::ZERO;
        for i in 0..n {
            let p = Sample::new(3, 5, i, 1).square(2);
            cells[(p.x * 4.0) as usize * 4 + (p.y * 4.0) as usize] += 1;
            mean += p / f64::from(n);
        }
        assert!(cells.iter().all(|c| (12..=20).contains(c)), "{cells:?}");
        assert!((mean - DVec2::splat(0.5)).length() < 0.02);
    }

    #[test]
    fn cosine_directions_have_the_cosines_mean() {
        let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
        let n = 4096;
        let mean: f64 =
            (0..n).map(|i| cosine_direction(normal, Sample::new(0, 0, i, 0).square(0)).dot(normal)).sum::<f64>()
                / f64::from(n);
        assert!((mean - 2.0 / 3.0).abs() < 0.002, "{mean}");
    }
}
