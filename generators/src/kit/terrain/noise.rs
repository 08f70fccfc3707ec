//! Fractal noise for shapes (materials have their own, filtered, in the scene crate).

use glam::DVec2;
use satseed_scene::{gradient_noise_2d_x4, hash_cell, unit_from_hash};

/// Not an integer, so that the lattices of the octaves never fall together.
const LACUNARITY: f64 = 1.97;
/// Each octave's lattice is turned by 37 degrees against the one before: cosine and sine.
const TURN: DVec2 = DVec2::new(0.798_635_510_047_293, 0.601_815_023_152_048);

/// Fractal gradient noise: mean 0, standard deviation about 0.29, range about -1..1. `gain` is an octave's amplitude
/// relative to the one before; the sum is normalised in variance.
pub fn fractal(p_m: DVec2, seed: u32, wavelength_m: f64, octaves: u32, gain: f64) -> f64 {
    octave_sum(p_m, seed, wavelength_m, octaves, gain, |v| v)
}

/// As [`fractal`], of ridges: near 1 on sharp crests, falling to about -1 between them.
pub fn ridged(p_m: DVec2, seed: u32, wavelength_m: f64, octaves: u32, gain: f64) -> f64 {
    octave_sum(p_m, seed, wavelength_m, octaves, gain, |v| 1.0 - 4.0 * v.abs().min(0.5))
}

fn octave_sum(p_m: DVec2, seed: u32, wavelength_m: f64, octaves: u32, gain: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let mut q = p_m / wavelength_m;
    let (mut sum, mut norm, mut amplitude) = (0.0, 0.0, 1.0);
    let mut octave = 0;
    while octave < octaves {
        // Four at a time, since they cost as much as one and a half.
        let (mut x, mut y, mut seeds) = ([0.0; 4], [0.0; 4], [0; 4]);
        let count = (octaves - octave).min(4) as usize;
        for k in 0..count {
            (x[k], y[k]) = (q.x, q.y);
            seeds[k] = seed.wrapping_add((octave + k as u32).wrapping_mul(0x9e37_79b9));
            q = q.rotate(TURN) * LACUNARITY;
        }
        for value in &gradient_noise_2d_x4(x, y, seeds)[..count] {
            sum += amplitude * shape(f64::from(*value));
            norm += amplitude * amplitude;
            amplitude *= gain;
        }
        octave += 4;
    }
    sum / f64::sqrt(norm)
}

/// A shift of the plane by noise of one wavelength, at most about `amplitude_m` in each direction.
pub fn warp(p_m: DVec2, seed: u32, wavelength_m: f64, amplitude_m: f64) -> DVec2 {
    let at = |s: u32| fractal(p_m, seed.wrapping_add(s), wavelength_m, 2, 0.5) * amplitude_m;
    p_m + DVec2::new(at(0), at(0x51ed))
}

/// A cellular block pattern: one value in -1..1 for each irregular cell, as joints cut rock into blocks, and the
/// distance from the cell's border in cells (0 on a joint).
pub fn blocks(p_m: DVec2, seed: u32, cell_m: f64) -> (f64, f64) {
    let q = p_m / cell_m;
    let (ci, cj) = (libm::floor(q.x), libm::floor(q.y));
    let (mut nearest, mut second, mut value) = (f64::MAX, f64::MAX, 0);
    for dj in -1..=1 {
        for di in -1..=1 {
            let (i, j) = (ci as i32 + di, cj as i32 + dj);
            let h = hash_cell(i, j, 0, seed);
            let jitter = DVec2::new(f64::from(h & 0xffff), f64::from(h >> 16)) / 65_536.0;
            let d = (DVec2::new(f64::from(i), f64::from(j)) + jitter - q).length();
            if d < nearest {
                second = nearest;
                nearest = d;
                value = hash_cell(i, j, 1, seed);
            } else if d < second {
                second = d;
            }
        }
    }
    (f64::from(unit_from_hash(value)) * 2.0 - 1.0, second - nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_centred_and_of_the_stated_deviation() {
        let (mut sum, mut square) = (0.0, 0.0);
        for i in 0..40_000 {
            let p = DVec2::new(f64::from(i % 200) * 7.3, f64::from(i / 200) * 9.1);
            let v = fractal(p, 5, 40.0, 5, 0.5);
            sum += v;
            square += v * v;
        }
        assert!((sum / 4e4).abs() < 0.02);
        assert!(((square / 4e4_f64).sqrt() - 0.29).abs() < 0.03);
    }

    #[test]
    fn a_block_has_one_value() {
        let (a, border) = blocks(DVec2::new(3.0, 4.0), 1, 5.0);
        let (b, _) = blocks(DVec2::new(3.0 + border * 0.2, 4.0), 1, 5.0);
        assert_eq!(a, b);
    }
}
