//! The wind's own waves: a tile of sea with the spectrum of a young sea (Tessendorf 2001), read at two incommensurate
//! scales so that no repetition shows.

use glam::DVec2;
use satseed_scene::{Raster, SeedPath};

/// Posts along a side of the tile.
const N: usize = 256;
/// Distance of its posts, m.
const CELL_M: f64 = 0.5;
/// Scale of the second reading.
const SECOND: f64 = 0.737;

/// The wind's waves of one sea, with significant height 1.
pub(super) struct Chop {
    tile: Raster<f32>,
    turn: DVec2,
}

impl Chop {
    /// Waves around a wind's direction, the longest strong ones of length `peak_m`.
    pub(super) fn new(wind: DVec2, peak_m: f64, path: &SeedPath) -> Self {
        let mut rng = path.rng();
        let side_m = N as f64 * CELL_M;
        // Only waves longer than four posts are shaped by the mesh.
        let most = (N / 4) as i32;
        let twiddles: Vec<DVec2> = (0..N)
            .map(|k| {
                let (s, c) = libm::sincos(core::f64::consts::TAU * k as f64 / N as f64);
                DVec2::new(c, s)
            })
            .collect();
        let product = |a: DVec2, b: DVec2| DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
        let (peak, gravity) = (core::f64::consts::TAU / peak_m, 9.81);
        // Rows of the spectrum are summed over x first, then over y: the plain separable transform, exact and short.
        let width = (2 * most + 1) as usize;
        let mut rows = vec![vec![DVec2::ZERO; N]; width];
        for (row, ky) in rows.iter_mut().zip(-most..=most) {
            for kx in -most..=most {
                let k = DVec2::new(f64::from(kx), f64::from(ky)) * (core::f64::consts::TAU / side_m);
                let (re, im) = (rng.normal(), rng.normal());
                let length = k.length();
                let with_wind = k.dot(wind) / length.max(1e-9);
                if length < 1e-9 || with_wind <= 0.0 {
                    continue;
                }
                let amplitude =
                    f64::sqrt(jonswap(f64::sqrt(length / peak)) * gravity / length * spread(with_wind)) / length;
                let a = DVec2::new(re, im) * amplitude;
                for (x, sum) in row.iter_mut().enumerate() {
                    *sum += product(a, twiddles[(x as i32 * kx).rem_euclid(N as i32) as usize]);
                }
            }
        }
        let mut tile = Raster::filled(DVec2::ZERO, CELL_M, N, N, 0.0_f32);
        let mut square = 0.0;
        for y in 0..N {
            for x in 0..N {
                let mut sum = 0.0;
                for (row, ky) in rows.iter().zip(-most..=most) {
                    let w = twiddles[(y as i32 * ky).rem_euclid(N as i32) as usize];
                    sum += row[x].x * w.x - row[x].y * w.y;
                }
                square += sum * sum;
                tile.set(x, y, sum as f32);
            }
        }
        // Significant height is four deviations; the two readings add in variance.
        let scale = 1.0 / (4.0 * f64::sqrt(square / (N * N) as f64) * f64::sqrt(1.0 + SECOND * SECOND));
        for v in &mut tile.data {
            *v = (f64::from(*v) * scale) as f32;
        }
        let (s, c) = libm::sincos(0.35);
        Self { tile, turn: DVec2::new(c, s) }
    }

    /// Height of the sea at a place, in significant heights.
    pub(super) fn at(&self, p: DVec2) -> f64 {
        self.periodic(p) + SECOND * self.periodic(p.rotate(self.turn) / SECOND)
    }

    /// Bicubic between the posts of a tile that repeats.
    fn periodic(&self, p: DVec2) -> f64 {
        let g = p / CELL_M;
        let (fi, fj) = (libm::floor(g.x), libm::floor(g.y));
        let (wx, wy) = (weights(g.x - fi), weights(g.y - fj));
        let wrap = |k: f64, d: i64| ((k as i64 + d).rem_euclid(N as i64)) as usize;
        let columns = [-1, 0, 1, 2].map(|d| wrap(fi, d));
        let mut sum = 0.0;
        for (row, w) in (-1..).zip(wy) {
            let line = &self.tile.data[wrap(fj, row) * N..][..N];
            let mut across = 0.0;
            for (column, v) in columns.iter().zip(wx) {
                across += f64::from(line[*column]) * v;
            }
            sum += across * w;
        }
        sum
    }
}

/// Weights of the uniform cubic B-spline: a little smoother than the posts, with a continuous slope.
fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0,
        (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0,
        (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) / 6.0,
        t3 / 6.0,
    ]
}

/// Spectral density over frequency relative to the peak's (Hasselmann et al. 1973, JONSWAP, gamma 3.3).
fn jonswap(w: f64) -> f64 {
    let sigma = if w <= 1.0 { 0.07 } else { 0.09 };
    let d = (w - 1.0) / sigma;
    let w2 = w * w;
    libm::pow(w, -5.0) * libm::exp(-1.25 / (w2 * w2)) * libm::pow(3.3, libm::exp(-0.5 * d * d))
}

/// Share of directions at a cosine with the wind.
fn spread(with_wind: f64) -> f64 {
    let c2 = with_wind * with_wind;
    c2 * c2
}
