//! Gradient noise for textures: as cheap as it can be, for it is worked out several times for every ray.
//!
//! After Perlin, "Improving Noise" (SIGGRAPH 2002), with two changes for speed: gradients are drawn from a square or a
//! cube straight from the bits of the hash, so that there is neither a table nor a branch; and the lattice enters the
//! hash as a sum of products, so that the corners of a cell share all of it but the finaliser. All after the cell is f32.

use crate::noise::{fade, lerp};

/// Odd, far from each other's multiples: cells of equal sums are thousands of cells apart.
const PRIME_X: u32 = 0x9e37_79b1;
const PRIME_Y: u32 = 0x85eb_ca77;
const PRIME_Z: u32 = 0xc2b2_ae3d;

/// Makes the deviation of the noise [`NOISE_DEVIATION`]: gradients of 16 and of 10 signed bits.
const SCALE_2D: f32 = 1.645 / 32768.0;
const SCALE_3D: f32 = 1.52 / 512.0;

/// Standard deviation of the noise, measured; filters need it.
pub(crate) const NOISE_DEVIATION: f32 = 0.29;

/// Standard deviation of one component of the slope of [`slope_2d`], measured.
pub(crate) const SLOPE_DEVIATION: f32 = 0.84;

/// Bits of a lattice point: its sum of products, finished with two multiplications (of Wellons' "lowbias32").
#[inline(always)]
fn finish(mut h: u32, seed: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d) ^ seed;
    h ^= h >> 15;
    h.wrapping_mul(0x846c_a68b)
}

/// The four corners of a square cell whose first corner has the sum `base`.
#[inline(always)]
fn corners(base: u32, seed: u32) -> [u32; 4] {
    // Near seeds are spread over all bits.
    let seed = seed.wrapping_mul(0x27d4_eb2f);
    // Four calls by name: `map` over an array is not inlined into the loops that shade, and costs a twentieth of a run.
    let corner = |d: u32| finish(base.wrapping_add(d), seed);
    [corner(0), corner(PRIME_X), corner(PRIME_Y), corner(PRIME_X.wrapping_add(PRIME_Y))]
}

/// Splits a coordinate into its cell and the fraction within; |x| below 2^31. (The cast and a correction are floor, and
/// several times quicker than a call on targets whose baseline has no rounding instruction.)
#[inline(always)]
pub(crate) fn cell(x: f64) -> (i32, f32) {
    let floor = floor(x);
    (floor, (x - f64::from(floor)) as f32)
}

/// The integer below; |x| below 2^31.
#[inline(always)]
pub(crate) fn floor(x: f64) -> i32 {
    let towards_zero = x as i32;
    towards_zero - i32::from(f64::from(towards_zero) > x)
}

/// Gradients of the four corners of a cell, times 2^15.
#[inline(always)]
fn gradients(ix: i32, iy: i32, seed: u32) -> ([f32; 4], [f32; 4]) {
    let base = (ix as u32).wrapping_mul(PRIME_X).wrapping_add((iy as u32).wrapping_mul(PRIME_Y));
    let [h0, h1, h2, h3] = corners(base, seed);
    let x = |h: u32| (h as i32 >> 16) as f32;
    let y = |h: u32| f32::from(h as i16);
    ([x(h0), x(h1), x(h2), x(h3)], [y(h0), y(h1), y(h2), y(h3)])
}

/// Noise over the plane, mean 0, range about -1.2..1.2, wavelength about 1.
#[inline(always)]
pub(crate) fn noise_2d(x: f64, y: f64, seed: u32) -> f32 {
    let ((ix, fx), (iy, fy)) = (cell(x), cell(y));
    let (gx, gy) = gradients(ix, iy, seed);
    let (a, b) = ([fx, fx - 1.0, fx, fx - 1.0], [fy, fy, fy - 1.0, fy - 1.0]);
    let corner = |k: usize| gx[k] * a[k] + gy[k] * b[k];
    let v = [corner(0), corner(1), corner(2), corner(3)];
    let (u, w) = (fade(fx), fade(fy));
    lerp(lerp(v[0], v[1], u), lerp(v[2], v[3], u), w) * SCALE_2D
}

/// The derivatives of [`noise_2d`] over x and y.
#[inline(always)]
pub(crate) fn slope_2d(x: f64, y: f64, seed: u32) -> [f32; 2] {
    let ((ix, fx), (iy, fy)) = (cell(x), cell(y));
    let (gx, gy) = gradients(ix, iy, seed);
    let (a, b) = ([fx, fx - 1.0, fx, fx - 1.0], [fy, fy, fy - 1.0, fy - 1.0]);
    let corner = |k: usize| gx[k] * a[k] + gy[k] * b[k];
    let v = [corner(0), corner(1), corner(2), corner(3)];
    let (u, w) = (fade(fx), fade(fy));
    let fade_slope = |t: f32| 30.0 * t * t * (t - 1.0) * (t - 1.0);
    let mean = |g: [f32; 4]| lerp(lerp(g[0], g[1], u), lerp(g[2], g[3], u), w);
    let across_x = lerp(v[1] - v[0], v[3] - v[2], w) * fade_slope(fx);
    let across_y = lerp(v[2] - v[0], v[3] - v[1], u) * fade_slope(fy);
    [(mean(gx) + across_x) * SCALE_2D, (mean(gy) + across_y) * SCALE_2D]
}

/// Noise over space, mean 0, range about -1.2..1.2, wavelength about 1.
#[inline(always)]
pub(crate) fn noise_3d(x: f64, y: f64, z: f64, seed: u32) -> f32 {
    let ((ix, fx), (iy, fy), (iz, fz)) = (cell(x), cell(y), cell(z));
    let base = (ix as u32)
        .wrapping_mul(PRIME_X)
        .wrapping_add((iy as u32).wrapping_mul(PRIME_Y))
        .wrapping_add((iz as u32).wrapping_mul(PRIME_Z));
    let (a, b) = ([fx, fx - 1.0, fx, fx - 1.0], [fy, fy, fy - 1.0, fy - 1.0]);
    let layer = |base: u32, c: f32| -> [f32; 4] {
        let h = corners(base, seed);
        // Ten bits for each component, from the top.
        let part = |h: u32, up: u32| ((h << up) as i32 >> 22) as f32;
        let corner = |k: usize| part(h[k], 0) * a[k] + part(h[k], 10) * b[k] + part(h[k], 20) * c;
        [corner(0), corner(1), corner(2), corner(3)]
    };
    let (low, high) = (layer(base, fz), layer(base.wrapping_add(PRIME_Z), fz - 1.0));
    let (u, v, w) = (fade(fx), fade(fy), fade(fz));
    let s = [lerp(low[0], high[0], w), lerp(low[1], high[1], w), lerp(low[2], high[2], w), lerp(low[3], high[3], w)];
    lerp(lerp(s[0], s[1], u), lerp(s[2], s[3], u), v) * SCALE_3D
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_centred_bounded_and_of_the_stated_deviation() {
        type Case<'a> = (&'a str, f64, f64, &'a dyn Fn(i32) -> f32);
        let n = 200_000;
        let at = |i: i32| (f64::from(i) * 0.1371, f64::from(i % 977) * 0.713, f64::from(i % 313) * 0.377);
        let slope = f64::from(SLOPE_DEVIATION);
        let cases: [Case<'_>; 4] = [
            ("2d", f64::from(NOISE_DEVIATION), 1.45, &|i| noise_2d(at(i).0, at(i).1, 9)),
            ("3d", f64::from(NOISE_DEVIATION), 1.45, &|i| noise_3d(at(i).0, at(i).1, at(i).2, 9)),
            ("slope over x", slope, 5.0, &|i| slope_2d(at(i).0, at(i).1, 9)[0]),
            ("slope over y", slope, 5.0, &|i| slope_2d(at(i).0, at(i).1, 9)[1]),
        ];
        for (name, expected, bound, value) in cases {
            let (mut sum, mut square, mut peak) = (0.0, 0.0, 0.0_f64);
            for i in 0..n {
                let v = f64::from(value(i));
                sum += v;
                square += v * v;
                peak = peak.max(v.abs());
            }
            let deviation = (square / f64::from(n)).sqrt();
            assert!((sum / f64::from(n)).abs() < 0.07 * expected, "{name}: mean {}", sum / f64::from(n));
            assert!(peak <= bound, "{name}: peak {peak}");
            assert!((deviation / expected - 1.0).abs() < 0.05, "{name}: {deviation}");
        }
    }

    #[test]
    fn noise_vanishes_on_its_lattice_and_is_continuous() {
        assert_eq!(noise_2d(5.0, -3.0, 1), 0.0);
        assert_eq!(noise_3d(5.0, -3.0, 2.0, 1), 0.0);
        for x in [2.0, -7.0] {
            assert!((noise_3d(x - 1e-6, 0.3, 0.4, 1) - noise_3d(x + 1e-6, 0.3, 0.4, 1)).abs() < 1e-4);
            assert!((noise_2d(0.3, x - 1e-6, 1) - noise_2d(0.3, x + 1e-6, 1)).abs() < 1e-4);
        }
    }

    #[test]
    fn slopes_are_the_differences_of_the_noise() {
        let e = 1e-3;
        for (x, y) in [(1.3, 2.7), (-5.51, 0.12), (200.9, -77.6)] {
            let slope = slope_2d(x, y, 4);
            let over_x = (noise_2d(x + e, y, 4) - noise_2d(x - e, y, 4)) / (2.0 * e as f32);
            let over_y = (noise_2d(x, y + e, 4) - noise_2d(x, y - e, 4)) / (2.0 * e as f32);
            assert!(
                (slope[0] - over_x).abs() < 5e-3 && (slope[1] - over_y).abs() < 5e-3,
                "{slope:?} {over_x} {over_y}"
            );
        }
    }

    /// Neighbouring lattice points, and the same one under other seeds, draw independent gradients.
    #[test]
    fn corners_are_independent() {
        let n = 200_i32;
        let draw = |i: i32, j: i32, seed: u32| {
            let (gx, gy) = gradients(i, j, seed);
            [f64::from(gx[0]) / 32768.0, f64::from(gy[0]) / 32768.0]
        };
        for (di, dj, seed) in
            [(1, 0, 7), (0, 1, 7), (1, 1, 7), (1, -1, 7), (2, 0, 7), (0, 0, 8), (1, 0, 8), (0, 0, 7 ^ 0x51)]
        {
            let mut sums = [0.0; 3];
            for j in 0..n {
                for i in 0..n {
                    let (a, b) = (draw(i, j, 7), draw(i + di, j + dj, seed));
                    sums[0] += a[0] * b[0];
                    sums[1] += a[1] * b[1];
                    sums[2] += a[0] * b[1];
                }
            }
            // Variance of a component is 1/3: five deviations of the mean of n * n products.
            let bound = 5.0 / 3.0 / f64::from(n);
            for s in sums.map(|s| s / f64::from(n * n)) {
                assert!(s.abs() < bound, "({di}, {dj}) seed {seed}: {s} beyond {bound}");
            }
        }
    }
}
