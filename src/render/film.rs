//! Samples to pixels: a fine grid, the optics' blur, decimation.

use super::light::Light;
use super::sampling::Sample;
use super::sensor::Optics;
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

/// Samples along a side of the squares that share what they can, by the samples along a cell's side: squares that stay few
/// samples wide, so that more samples err less. Of very many, which are a reference, each has its own.
const TOGETHER: [u32; 5] = [1, 1, 2, 3, 2];

/// Side of the squares of cells that are traced together: the more rays to the sun there are, the closer some of them lie.
const TRACED_SIDE: u32 = 2 * TILE_SIDE;

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

/// Traces all samples of a frame and lets the optics blur them. A margin around the frame is traced too, so that borders
/// are blurred as the middle is.
pub(super) fn expose(tracer: &Tracer, camera: &Camera, light: &Light, samples: u32, optics: &Optics) -> Radiance {
    let grid = Grid::new(samples);
    let (across, along) = (optics.across(grid.fine), optics.along(grid.fine));
    let (width, height) = (camera.width_px, camera.height_px);
    let fine_height = (height * grid.fine) as i32;
    // Each fine row is blurred along itself and decimated at once: what stays is as wide as the image.
    let tops: Vec<i32> = (-along.reach..fine_height + along.reach).step_by(TRACED_SIDE as usize).collect();
    let bands: Vec<Vec<Vec<Bands>>> = tops
        .into_par_iter()
        .map(|top| {
            let columns = -across.reach..(width * grid.fine) as i32 + across.reach;
            let rows = top..(top + TRACED_SIDE as i32).min(fine_height + along.reach);
            let blur = |fine: &[Bands]| {
                (0..width as usize).map(|u| weighted(&across.weights, &fine[u * grid.fine as usize..])).collect()
            };
            let length = columns.len();
            cells(tracer, camera, light, grid, columns, rows).chunks(length).map(blur).collect()
        })
        .collect();
    let rows: Vec<Vec<Bands>> = bands.into_iter().flatten().collect();
    let mut data = vec![Bands::ZERO; width as usize * height as usize];
    data.par_chunks_mut(width as usize).enumerate().for_each(|(v, sums)| {
        let first = v * grid.fine as usize;
        for (row, weight) in rows[first..].iter().zip(&along.weights) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += *value * *weight;
            }
        }
    });
    Radiance { width, height, data }
}

fn weighted(kernel: &[f32], values: &[Bands]) -> Bands {
    kernel.iter().zip(values).fold(Bands::ZERO, |sum, (w, v)| sum + *v * *w)
}

/// Mean radiance of fine cells, row by row.
fn cells(
    tracer: &Tracer,
    camera: &Camera,
    light: &Light,
    grid: Grid,
    columns: Range<i32>,
    rows: Range<i32>,
) -> Vec<Bands> {
    let side = f64::from(grid.side);
    let count = grid.side * grid.side;
    // What a square of samples has in common is worked out once.
    let square = TOGETHER.get(grid.side as usize).copied().unwrap_or(1);
    let together = square * square;
    // Footprint of those samples per metre of distance.
    let spread = f64::from(square) / (camera.fx_px * f64::from(grid.fine) * side);
    // Both views of a pair have cameras of their own place: their sampling patterns are unrelated.
    let key = (camera.position_m.x.to_bits() ^ camera.position_m.y.to_bits().rotate_left(17)) as u32
        ^ (camera.position_m.x.to_bits() >> 32) as u32;
    let mut means = vec![Bands::ZERO; columns.len() * rows.len()];
    for left in columns.clone().step_by(TRACED_SIDE as usize) {
        let tile_columns = TRACED_SIDE.min((columns.end - left) as u32);
        let tile: Vec<(i32, i32)> = tile_order(tile_columns, rows.len() as u32)
            .map(|(x, y)| (left + x as i32, rows.start + y as i32))
            .collect();
        let corners = || (0..grid.side).step_by(square as usize);
        for (y0, x0) in corners().flat_map(|y0| corners().map(move |x0| (y0, x0))) {
            let indices = (y0..y0 + square).flat_map(|y| (x0..x0 + square).map(move |x| y * grid.side + x));
            let samples: Vec<(i32, i32, u32)> =
                tile.iter().flat_map(|(column, row)| indices.clone().map(|index| (*column, *row, index))).collect();
            let keyed: Vec<Sample> =
                samples.iter().map(|(column, row, index)| Sample::new(*column, *row, *index, key)).collect();
            let ray = |((column, row, index), sample): (&(i32, i32, u32), &Sample)| {
                let jitter = sample.square(0);
                let place = |base: i32, step: u32, jitter: f64| {
                    (f64::from(base) + (f64::from(step) + jitter) / side) / f64::from(grid.fine) - 0.5
                };
                camera.ray(place(*column, index % grid.side, jitter.x), place(*row, index / grid.side, jitter.y))
            };
            let rays: Vec<Ray> = samples.iter().zip(&keyed).map(ray).collect();
            let values = radiance(tracer, light, &rays, spread, &keyed, together as usize);
            for ((column, row), value) in tile.iter().zip(values) {
                means[(row - rows.start) as usize * columns.len() + (column - columns.start) as usize] += value;
            }
        }
    }
    for mean in &mut means {
        *mean = *mean * (together as f32 / count as f32);
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_hold_at_least_the_samples_asked_for() {
        for (asked, held) in [(1, 1), (2, 4), (4, 4), (5, 16), (16, 16), (64, 64)] {
            let g = Grid::new(asked);
            let samples = (g.fine * g.side) * (g.fine * g.side);
            assert!(samples >= asked && samples <= held.max(asked * 4), "{asked}: {samples}");
        }
    }
}
