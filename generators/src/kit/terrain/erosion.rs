//! What water and gravity do to a height field.

use super::flow::Drainage;
use satseed_scene::Raster;

/// One implicit step of stream-power incision, dz/dt = -K A^(1/2) S (Braun and Willett 2013, m = 0.5, n = 1): O(n),
/// stable for any step. `strength(post, z)` is K dt, dimensionless: the distance over which a knickpoint travels in
/// the step is `K dt sqrt(A)`. Outlets (their own receivers) keep their heights, and no post falls below its receiver.
pub fn stream_power(
    z: &mut Raster<f32>,
    drainage: &Drainage,
    area_m2: &[f32],
    mut strength: impl FnMut(usize, f32) -> f32,
) {
    let cell = z.cell_m as f32;
    for &post in &drainage.order {
        let post = post as usize;
        let to = drainage.receiver[post] as usize;
        if to == post {
            continue;
        }
        let apart = post.abs_diff(to);
        let straight = apart == 1 || apart == z.width;
        let run = if straight { cell } else { cell * core::f32::consts::SQRT_2 };
        let factor = strength(post, z.data[post]) * area_m2[post].sqrt() / run;
        z.data[post] = (z.data[post] + factor * z.data[to]) / (1.0 + factor);
    }
}

/// One explicit step of hillslope diffusion where `keep(post)` is false: `amount` is D dt / cell^2, at most 0.25.
/// The border stays.
pub fn diffuse(z: &mut Raster<f32>, amount: f32, keep: impl Fn(usize) -> bool) {
    let (width, height) = (z.width, z.height);
    let old = z.data.clone();
    for j in 1..height - 1 {
        for i in 1..width - 1 {
            let p = j * width + i;
            if !keep(p) {
                let sum = old[p - 1] + old[p + 1] + old[p - width] + old[p + width];
                z.data[p] = old[p] + amount * (sum - 4.0 * old[p]);
            }
        }
    }
}

/// Lets loose material slide until it rests at its angle: `rock` is what cannot move, `loose` its cover's thickness, m.
///
/// Each pass moves, for posts from the lattice's four colours in turn (so that no order of work shows), a part of
/// what stands above the angle to the lowest neighbour. Mass is kept.
pub fn settle(rock: &Raster<f32>, loose: &mut Raster<f32>, repose_tangent: f32, passes: usize) {
    let (width, height, cell) = (rock.width, rock.height, rock.cell_m as f32);
    for _ in 0..passes {
        for colour in 0..9 {
            for j in (1 + colour / 3..height - 1).step_by(3) {
                for i in (1 + colour % 3..width - 1).step_by(3) {
                    let p = j * width + i;
                    if loose.data[p] <= 0.0 {
                        continue;
                    }
                    let top = rock.data[p] + loose.data[p];
                    let (mut most, mut target) = (0.0, p);
                    for (k, q) in
                        [p + 1, p + 1 + width, p + width, p + width - 1, p - 1, p - 1 - width, p - width, p + 1 - width]
                            .into_iter()
                            .enumerate()
                    {
                        let run = if k % 2 == 0 { cell } else { cell * core::f32::consts::SQRT_2 };
                        let excess = top - rock.data[q] - loose.data[q] - repose_tangent * run;
                        if excess > most {
                            most = excess;
                            target = q;
                        }
                    }
                    let moved = (most * 0.5).min(loose.data[p]);
                    loose.data[p] -= moved;
                    loose.data[target] += moved;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::terrain::flow::fill_and_drain;
    use glam::DVec2;

    #[test]
    fn a_line_reaches_the_steady_slope() {
        // Steady state of dz/dt = U - K sqrt(A) S on a line: S = (U / K) / sqrt(A).
        let mut z = Raster::filled(DVec2::ZERO, 10.0, 40, 1, 0.0_f32);
        for (i, v) in z.data.iter_mut().enumerate() {
            *v = i as f32 * 0.01;
        }
        let uplift_per_strength = 4.0;
        for _ in 0..4000 {
            for v in &mut z.data[1..] {
                *v += uplift_per_strength * 0.05;
            }
            let d = fill_and_drain(&mut z, 1, |p| p == 0);
            let area = d.area_m2(10.0);
            stream_power(&mut z, &d, &area, |_, _| 0.05);
        }
        for i in [1, 10, 30] {
            let slope = (z.data[i] - z.data[i - 1]) / 10.0;
            let expected = uplift_per_strength / ((40 - i) as f32 * 100.0).sqrt();
            assert!((slope / expected - 1.0).abs() < 0.01, "{i}: {slope} for {expected}");
        }
    }

    #[test]
    fn loose_material_rests_at_its_angle_and_is_kept() {
        let rock = Raster::filled(DVec2::ZERO, 1.0, 41, 41, 0.0_f32);
        let mut loose = rock.clone();
        loose.set(20, 20, 60.0);
        settle(&rock, &mut loose, 0.7, 400);
        let total: f32 = loose.data.iter().sum();
        assert!((total - 60.0).abs() < 1e-2);
        for j in 1..40 {
            for i in 1..40 {
                let drop = loose.get(i, j) - loose.get(i + 1, j);
                assert!(drop.abs() < 0.72, "{i} {j}: {drop}");
            }
        }
    }
}
