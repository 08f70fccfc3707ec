//! Samples to pixels: a fine grid, the optics' blur, decimation.

use super::Lighting;
use super::sampling::Sample;
use super::shading::radiance;
use crate::camera::Camera;
use rayon::prelude::*;
use satseed_scene::{Bands, Ray};
use satseed_tracer::{TILE_SIDE, Tracer, tile_order};
use std::ops::Range;

/// Radiance at the ground of every pixel after the optics, W / (m^2 sr um), row by row from the top.
#[derive(Clone, Debug)]
pub(super) struct Radiance {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// One value a pixel.
    pub data: Vec<Bands>,
}

/// How samples are laid over the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Grid {
    /// Fine cells along a pixel's side.
    fine: u32,
    /// Samples along a fine cell's side.
    side: u32,
}

impl Grid {
    fn new(samples_per_pixel: u32) -> Self {
        let fine = if samples_per_pixel >= 4 { 2 } else { 1 };
        let mut side = 1;
        while fine * fine * side * side < samples_per_pixel {
            side += 1;
        }
        Self { fine, side }
    }
}

/// Traces all samples of a frame and lets the optics blur them. The blur is a Gaussian of `sigma_px` on top of the
/// pixel's own box. A margin around the frame is traced too, so that borders are blurred as the middle is.
pub(super) fn expose(tracer: &Tracer, camera: &Camera, lighting: &Lighting, samples: u32, sigma_px: f64) -> Radiance {
    let grid = Grid::new(samples);
    let sigma = sigma_px * f64::from(grid.fine);
    let (kernel, margin) = (kernel(sigma, grid.fine), reach(sigma));
    let (width, height) = (camera.width_px, camera.height_px);
    let fine_height = (height * grid.fine) as i32;
    // Each fine row is blurred along itself and decimated at once: what stays is as wide as the image.
    let tops: Vec<i32> = (-margin..fine_height + margin).step_by(TILE_SIDE as usize).collect();
    let bands: Vec<Vec<Vec<Bands>>> = tops
        .into_par_iter()
        .map(|top| {
            let columns = -margin..(width * grid.fine) as i32 + margin;
            let rows = top..(top + TILE_SIDE as i32).min(fine_height + margin);
            let blur = |fine: &[Bands]| {
                (0..width as usize).map(|u| weighted(&kernel, &fine[u * grid.fine as usize..])).collect()
            };
            let length = columns.len();
            cells(tracer, camera, lighting, grid, columns, rows).chunks(length).map(blur).collect()
        })
        .collect();
    let rows: Vec<Vec<Bands>> = bands.into_iter().flatten().collect();
    let data: Vec<Vec<Bands>> = (0..height as usize)
        .into_par_iter()
        .map(|v| {
            let first = v * grid.fine as usize;
            (0..width as usize)
                .map(|u| {
                    let mut sum = Bands::ZERO;
                    for (k, weight) in kernel.iter().enumerate() {
                        sum += rows[first + k][u] * *weight;
                    }
                    sum
                })
                .collect()
        })
        .collect();
    Radiance { width, height, data: data.into_iter().flatten().collect() }
}

fn weighted(kernel: &[f32], values: &[Bands]) -> Bands {
    kernel.iter().zip(values).fold(Bands::ZERO, |sum, (w, v)| sum + *v * *w)
}

/// Cells beyond the pixel's own that a blur of `sigma` cells reaches on each side.
fn reach(sigma: f64) -> i32 {
    if sigma > 0.0 { libm::ceil(3.5 * sigma) as i32 } else { 0 }
}

/// Weights of the fine cells around a pixel, from `reach` cells before its first to `reach` after its last: the pixel's
/// box convolved with a Gaussian of `sigma` cells.
fn kernel(sigma: f64, fine: u32) -> Vec<f32> {
    let reach = reach(sigma);
    let gauss = |x: i32| {
        if sigma > 0.0 { libm::exp(-0.5 * f64::from(x * x) / (sigma * sigma)) } else { f64::from(u8::from(x == 0)) }
    };
    let cells = fine as i32;
    let weights: Vec<f64> = (-reach..cells + reach).map(|i| (0..cells).map(|cell| gauss(i - cell)).sum()).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|w| (w / total) as f32).collect()
}

/// Mean radiance of fine cells, row by row.
fn cells(
    tracer: &Tracer,
    camera: &Camera,
    lighting: &Lighting,
    grid: Grid,
    columns: Range<i32>,
    rows: Range<i32>,
) -> Vec<Bands> {
    let side = f64::from(grid.side);
    let count = grid.side * grid.side;
    // Footprint of one sample per metre of distance.
    let spread = 1.0 / (camera.fx_px * f64::from(grid.fine) * side);
    // Both views of a pair have cameras of their own place: their sampling patterns are unrelated.
    let key = (camera.position_m.x.to_bits() ^ camera.position_m.y.to_bits().rotate_left(17)) as u32
        ^ (camera.position_m.x.to_bits() >> 32) as u32;
    let mut means = vec![Bands::ZERO; columns.len() * rows.len()];
    for left in columns.clone().step_by(TILE_SIDE as usize) {
        let tile_columns = TILE_SIDE.min((columns.end - left) as u32);
        let tile: Vec<(i32, i32)> = tile_order(tile_columns, rows.len() as u32)
            .map(|(x, y)| (left + x as i32, rows.start + y as i32))
            .collect();
        for index in 0..count {
            let samples: Vec<Sample> =
                tile.iter().map(|(column, row)| Sample::new(*column, *row, index, key)).collect();
            let ray = |((column, row), sample): (&(i32, i32), &Sample)| {
                let jitter = sample.square(0);
                let place = |base: i32, step: u32, jitter: f64| {
                    (f64::from(base) + (f64::from(step) + jitter) / side) / f64::from(grid.fine) - 0.5
                };
                camera.ray(place(*column, index % grid.side, jitter.x), place(*row, index / grid.side, jitter.y))
            };
            let rays: Vec<Ray> = tile.iter().zip(&samples).map(ray).collect();
            for ((column, row), value) in tile.iter().zip(radiance(tracer, lighting, &rays, spread, &samples)) {
                means[(row - rows.start) as usize * columns.len() + (column - columns.start) as usize] += value;
            }
        }
    }
    for mean in &mut means {
        *mean = *mean * (1.0 / count as f32);
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_centred_on_the_pixel_and_sum_to_one() {
        for (sigma, fine) in [(0.0, 1), (0.0, 2), (0.6, 1), (1.1, 2)] {
            let k = kernel(sigma, fine);
            assert!((k.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let centroid: f64 = k.iter().enumerate().map(|(i, w)| i as f64 * f64::from(*w)).sum();
            let middle = f64::from(reach(sigma)) + (f64::from(fine) - 1.0) / 2.0;
            assert!((centroid - middle).abs() < 1e-6, "{sigma} {fine}: {centroid} against {middle}");
        }
    }

    #[test]
    fn grids_hold_at_least_the_samples_asked_for() {
        for (asked, held) in [(1, 1), (2, 4), (4, 4), (5, 16), (16, 16), (64, 64)] {
            let g = Grid::new(asked);
            let samples = (g.fine * g.side) * (g.fine * g.side);
            assert!(samples >= asked && samples <= held.max(asked * 4), "{asked}: {samples}");
        }
    }
}
