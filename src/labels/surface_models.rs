//! DSM, DTM and nDSM of a scene, and where several surfaces lie above each other.

use super::columns::{BAND_ROWS, Columns, Crossing, Grid};
use crate::labels::view::MISS_NAN;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Raster, Scene};

/// Heights over a square around the pivot.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceModels {
    /// First surface from above at each cell's centre, m; NaN where there is none.
    pub dsm_m: Raster<f32>,
    /// Bare ground (object 0) at each cell's centre, m: the uppermost where ground overhangs ground; NaN where there is
    /// none.
    pub dtm_m: Raster<f32>,
    /// Height of the first surface above the ground, m: the difference of the other two, as f32 gives it.
    pub ndsm_m: Raster<f32>,
    /// For each cell, how many upward surfaces with open space over them a vertical line meets, those more than 1 m below
    /// the one before. A house on its plot is one; a crown over a lawn, a deck over a street, a balcony over a balcony or
    /// a ledge over its alcove are two and more.
    pub layers: Raster<u8>,
}

/// Upward surfaces closer together than this are one layer, m.
const LAYER_M: f32 = 1.0;

/// What [`surface_models`] takes for a square of `side` by `side` cells, bytes: three heights and a count a cell, and on up to
/// 16 threads the crossings of a band of lines.
pub fn surface_model_bytes(side: u64) -> u64 {
    const THREADS: u64 = 16;
    // The densest band of a core has 25 a line; a growing list may hold twice what it needs.
    const CROSSINGS: u64 = 50;
    side * side * 13 + THREADS * side * BAND_ROWS as u64 * CROSSINGS * size_of::<Crossing>() as u64
}

/// Looks down vertical lines through the centres of cells of `cell_m` over the square of half side `half_side_m`.
pub fn surface_models(scene: &Scene, half_side_m: f64, cell_m: f64) -> SurfaceModels {
    let side = (2.0 * half_side_m / cell_m).ceil() as usize;
    let grid = Grid { first: DVec2::splat((0.5 - side as f64 / 2.0) * cell_m), cell_m, side };
    let columns = Columns::new(scene, grid);
    let raster = |data| Raster { origin_m: grid.first, cell_m, width: side, height: side, data };
    let (mut dsm, mut dtm) = (vec![MISS_NAN; side * side], vec![MISS_NAN; side * side]);
    let mut layers = vec![0_u8; side * side];
    let band = (side * BAND_ROWS).max(1);
    dsm.par_chunks_mut(band).zip(dtm.par_chunks_mut(band)).zip(layers.par_chunks_mut(band)).enumerate().for_each(
        |(k, ((dsm, dtm), layers))| {
            for line in columns.band(k).chunk_by(|a, b| a.cell() == b.cell()) {
                let cell = line[0].cell();
                dsm[cell] = line[0].z_m();
                dtm[cell] = line.iter().find(|c| c.is_terrain()).map_or(MISS_NAN, |c| c.z_m());
                layers[cell] = layer_count(line);
            }
        },
    );
    let ndsm =
        dsm.par_iter().zip(&dtm).map(|(dsm, dtm)| if dsm.is_nan() || dtm.is_nan() { MISS_NAN } else { dsm - dtm });
    let ndsm = ndsm.collect();
    let layers = Raster { origin_m: grid.first, cell_m, width: side, height: side, data: layers };
    SurfaceModels { dsm_m: raster(dsm), dtm_m: raster(dtm), ndsm_m: raster(ndsm), layers }
}

/// Surfaces that a line comes upon from the open, going down. Solids may run into each other, so it counts in how many
/// of them it is.
fn layer_count(line: &[Crossing]) -> u8 {
    let (mut inside, mut layers, mut last_m) = (0_u32, 0_u8, f32::INFINITY);
    for crossing in line {
        if !crossing.enters() {
            inside = inside.saturating_sub(1);
            continue;
        }
        if inside == 0 && last_m - crossing.z_m() > LAYER_M {
            layers = layers.saturating_add(1);
            last_m = crossing.z_m();
        }
        inside += 1;
    }
    layers
}
