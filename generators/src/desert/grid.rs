//! Means, gradients and limits of slope on the periodic grid of the slab model.

use glam::DVec2;
use rayon::prelude::*;

/// Deviation of the smoothing of windward sides and floors, cells.
const SMOOTH_CELLS: f64 = 2.0;

/// A periodic square of cells.
pub(super) struct Grid {
    /// Cells of a side.
    pub(super) n: usize,
}

impl Grid {
    /// The cell nearest to a place some cells away.
    pub(super) fn moved(&self, p: usize, by: DVec2) -> usize {
        let n = self.n as i64;
        let step = |x: f64| libm::floor(x + 0.5) as i64;
        let (i, j) = ((p % self.n) as i64 + step(by.x), (p / self.n) as i64 + step(by.y));
        (j.rem_euclid(n) * n + i.rem_euclid(n)) as usize
    }

    /// The gradient, per cell.
    pub(super) fn gradient(&self, z: &[f32], p: usize) -> DVec2 {
        let at = |x: f64, y: f64| f64::from(z[self.moved(p, DVec2::new(x, y))]);
        DVec2::new(at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0)) / 2.0
    }

    /// Gaussian mean, `sigma` in cells.
    pub(super) fn blurred(&self, z: &[f32], sigma: f64) -> Vec<f32> {
        let n = self.n;
        let reach = (libm::ceil(3.0 * sigma) as usize).min(n / 2 - 1);
        let raw: Vec<f64> = (0..=2 * reach)
            .map(|k| k as f64 - reach as f64)
            .map(|d| libm::exp(-d * d / (2.0 * sigma * sigma)))
            .collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f32> = raw.iter().map(|w| (w / total) as f32).collect();
        let mut across = vec![0.0_f32; n * n];
        across.par_chunks_mut(n).enumerate().for_each(|(j, row)| {
            let from = &z[j * n..][..n];
            let extended: Vec<f32> = (0..n + 2 * reach).map(|i| from[(i + n - reach) % n]).collect();
            for (i, v) in row.iter_mut().enumerate() {
                *v = extended[i..].iter().zip(&weights).map(|(a, w)| a * w).sum();
            }
        });
        let mut out = vec![0.0_f32; n * n];
        out.par_chunks_mut(n).enumerate().for_each(|(j, row)| {
            for (k, w) in weights.iter().enumerate() {
                let from = &across[(j + k + n - reach) % n * n..][..n];
                for (v, a) in row.iter_mut().zip(from) {
                    *v += a * w;
                }
            }
        });
        out
    }

    /// Lowers what rises by more than `step` a cell from any of the eight neighbours that count.
    pub(super) fn no_steeper(&self, z: &mut [f32], step: f32, counts: impl Fn(usize) -> bool) {
        let n = self.n;
        let diagonal = step * core::f32::consts::SQRT_2;
        // Sweeps in both directions, each with the neighbours that it has just passed; the edges repeat.
        for _ in 0..12 {
            let mut lowered = false;
            for k in 0..2 * n * n {
                let p = if k < n * n { k } else { 2 * n * n - 1 - k };
                let (i, j) = (p % n, p / n);
                let (row, column, beside) = if k < n * n {
                    ((j + n - 1) % n * n, (i + n - 1) % n, (i + 1) % n)
                } else {
                    ((j + 1) % n * n, (i + 1) % n, (i + n - 1) % n)
                };
                let above = |q: usize, rise: f32| if counts(q) { z[q] + rise } else { f32::MAX };
                let most = above(row + i, step)
                    .min(above(j * n + column, step))
                    .min(above(row + column, diagonal))
                    .min(above(row + beside, diagonal));
                if most < z[p] {
                    z[p] = most;
                    lowered = true;
                }
            }
            if !lowered {
                return;
            }
        }
    }

    /// Gaussian mean over the cells of a weight; far from all of them, over more and more of the surroundings.
    pub(super) fn smoothed_where(&self, z: &[f32], weight: &[f32]) -> Vec<f32> {
        let weighted: Vec<f32> = z.iter().zip(weight).map(|(z, w)| z * w).collect();
        let near = (self.blurred(&weighted, SMOOTH_CELLS), self.blurred(weight, SMOOTH_CELLS));
        let far = (self.blurred(&weighted, 3.0 * SMOOTH_CELLS), self.blurred(weight, 3.0 * SMOOTH_CELLS));
        let last = self.blurred(z, 6.0 * SMOOTH_CELLS);
        (0..z.len())
            .map(|p| {
                let sum = near.0[p] + 1e-3 * far.0[p] + 1e-6 * last[p];
                sum / (near.1[p] + 1e-3 * far.1[p] + 1e-6)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_knows_nothing_of_what_has_no_weight() {
        let grid = Grid { n: 64 };
        let z: Vec<f32> = (0..64 * 64).map(|p| if p % 64 < 20 { 9.0 } else { 2.0 }).collect();
        let weight: Vec<f32> = (0..64 * 64).map(|p| if p % 64 < 20 { 0.0 } else { 1.0 }).collect();
        let smooth = grid.smoothed_where(&z, &weight);
        assert!(smooth.iter().all(|v| (v - 2.0).abs() < 0.2), "{:?}", smooth.iter().copied().fold(0.0_f32, f32::max));
        assert!((smooth[40] - 2.0).abs() < 1e-3);
    }
}
