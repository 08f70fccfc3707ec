//! Hashed gradient noise: a pure function of place and seed, the same bits everywhere.
//!
//! After Perlin, "Improving Noise" (SIGGRAPH 2002): quintic fade, gradients at lattice points. Gradients are drawn by an
//! integer hash with full 32-bit seeds (the `noise` crate's permutation table repeats after 256 cells: a visible lattice
//! on a frame that spans thousands of them).

use crate::texture_noise::cell;
use crate::wide::wide;

/// Mixes a lattice cell and a seed to 32 uniform bits (Murmur3: a round for each coordinate, then its finaliser).
#[inline]
pub fn hash_cell(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    finish(round(round(round(start(seed), x), y), z))
}

#[inline]
fn start(seed: u32) -> u32 {
    seed ^ 0x9e37_79b9
}

#[inline]
fn round(h: u32, word: i32) -> u32 {
    let h = h ^ (word as u32).wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    h.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
}

#[inline]
fn finish(mut h: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// The upper 24 bits of a hash as a float in [0, 1).
#[inline]
pub fn unit_from_hash(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[inline(always)]
pub(crate) fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
pub(crate) fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Sixteen unit directions, cos and sin of k * 22.5 deg.
const DIRECTIONS: [[f32; 16]; 2] = {
    const A: f32 = 0.923_879_5;
    const B: f32 = core::f32::consts::FRAC_1_SQRT_2;
    const C: f32 = 0.382_683_43;
    [
        [1.0, A, B, C, 0.0, -C, -B, -A, -1.0, -A, -B, -C, 0.0, C, B, A],
        [0.0, C, B, A, 1.0, A, B, C, 0.0, -C, -B, -A, -1.0, -A, -B, -C],
    ]
};

/// Gradient noise over the plane, mean 0, range about -1..1, wavelength about 1.
#[inline]
pub fn gradient_noise_2d(x: f64, y: f64, seed: u32) -> f32 {
    gradient_noise([x], [y], [seed])[0]
}

/// [`gradient_noise_2d`] at four places, each with a seed of its own: the same bits in less time, since most of it goes
/// side by side.
#[inline]
pub fn gradient_noise_2d_x4(x: [f64; 4], y: [f64; 4], seed: [u32; 4]) -> [f32; 4] {
    wide(|| gradient_noise(x, y, seed))
}

#[inline(always)]
fn gradient_noise<const N: usize>(x: [f64; N], y: [f64; N], seed: [u32; N]) -> [f32; N] {
    const CORNERS: [(i32, i32); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];
    let (mut ix, mut iy, mut fx, mut fy) = ([0; N], [0; N], [0.0; N], [0.0; N]);
    for k in 0..N {
        (ix[k], fx[k]) = cell(x[k]);
        (iy[k], fy[k]) = cell(y[k]);
    }
    let mut hashes = [[0; N]; 4];
    for (c, (dx, dy)) in CORNERS.into_iter().enumerate() {
        for k in 0..N {
            hashes[c][k] = hash_cell(ix[k].wrapping_add(dx), iy[k].wrapping_add(dy), 0, seed[k]) >> 28;
        }
    }
    let mut corners = [[0.0; N]; 4];
    for (c, (dx, dy)) in CORNERS.into_iter().enumerate() {
        let (mut gx, mut gy) = ([0.0; N], [0.0; N]);
        for k in 0..N {
            let direction = hashes[c][k] as usize;
            (gx[k], gy[k]) = (DIRECTIONS[0][direction], DIRECTIONS[1][direction]);
        }
        for k in 0..N {
            corners[c][k] = gx[k] * (fx[k] - dx as f32) + gy[k] * (fy[k] - dy as f32);
        }
    }
    let mut out = [0.0; N];
    for k in 0..N {
        let (u, v) = (fade(fx[k]), fade(fy[k]));
        let value = lerp(lerp(corners[0][k], corners[1][k], u), lerp(corners[2][k], corners[3][k], u), v);
        out[k] = value * core::f32::consts::SQRT_2;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_centred_bounded_and_of_the_stated_deviation() {
        let (mut sum, mut square, mut peak) = (0.0, 0.0, 0.0_f64);
        let n = 200_000;
        for i in 0..n {
            let v = f64::from(gradient_noise_2d(i as f64 * 0.1371, (i % 977) as f64 * 0.713, 9));
            sum += v;
            square += v * v;
            peak = peak.max(v.abs());
        }
        let deviation = (square / f64::from(n)).sqrt();
        assert!((sum / f64::from(n)).abs() < 0.02, "mean {}", sum / f64::from(n));
        assert!(peak <= 1.2, "peak {peak}");
        assert!((deviation - 0.30).abs() < 0.025, "{deviation}");
    }

    #[test]
    fn four_at_once_are_the_four() {
        for i in 0..20_000 {
            let x = core::array::from_fn(|k| f64::from(i * 4 + k as i32) * 0.737 - 9_000.0);
            let y = core::array::from_fn(|k| f64::from(i % 711 + k as i32) * -1.313 + 300.0);
            let seed = core::array::from_fn(|k| (i as u32).wrapping_mul(0x9e37_79b9) ^ k as u32);
            let once = gradient_noise_2d_x4(x, y, seed);
            for k in 0..4 {
                assert_eq!(once[k].to_bits(), gradient_noise_2d(x[k], y[k], seed[k]).to_bits());
            }
        }
    }

    #[test]
    fn noise_vanishes_on_its_lattice_and_is_continuous() {
        assert_eq!(gradient_noise_2d(5.0, -3.0, 1), 0.0);
        let a = gradient_noise_2d(1.999_999, 0.3, 1);
        let b = gradient_noise_2d(2.000_001, 0.3, 1);
        assert!((a - b).abs() < 1e-4);
    }
}
