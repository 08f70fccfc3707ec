//! DSM and DTM of a scene.

use crate::labels::view::MISS_NAN;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Raster, Ray};
use satseed_tracer::{Origin, Tracer};

/// Heights over a square around the pivot.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceModels {
    /// First surface from above at each cell's centre, m; NaN where there is none.
    pub dsm_m: Raster<f32>,
    /// Bare ground (object 0) at each cell's centre, m; NaN where there is none.
    pub dtm_m: Raster<f32>,
    /// For each cell, how many upward surfaces more than 1 m apart a vertical line meets.
    pub layers: Raster<u8>,
}

/// Surfaces of one vertical line that are looked at; deeper ones are not told apart.
const MOST_LAYERS: usize = 64;

/// Traces vertical lines through the centres of cells of `cell_m` over the square of half side `half_side_m`.
pub fn surface_models(tracer: &Tracer, half_side_m: f64, cell_m: f64) -> SurfaceModels {
    let n = (2.0 * half_side_m / cell_m).ceil() as usize;
    let first = DVec2::splat((0.5 - n as f64 / 2.0) * cell_m);
    let [low, high] = tracer.bounds_m();
    let (top, depth) = (high.z + 1.0, high.z - low.z + 2.0);
    let rows: Vec<Vec<(f32, f32, u8)>> = (0..n)
        .into_par_iter()
        .map(|j| {
            (0..n)
                .map(|i| {
                    let at = first + DVec2::new(i as f64, j as f64) * cell_m;
                    column(tracer, at.extend(top), depth)
                })
                .collect()
        })
        .collect();
    let cells: Vec<(f32, f32, u8)> = rows.into_iter().flatten().collect();
    SurfaceModels {
        dsm_m: raster(first, cell_m, n, cells.iter().map(|c| c.0).collect()),
        dtm_m: raster(first, cell_m, n, cells.iter().map(|c| c.1).collect()),
        layers: raster(first, cell_m, n, cells.iter().map(|c| c.2).collect()),
    }
}

fn raster<T>(origin_m: DVec2, cell_m: f64, n: usize, data: Vec<T>) -> Raster<T> {
    Raster { origin_m, cell_m, width: n, height: n, data }
}

/// First surface, bare ground, and the number of upward surfaces more than 1 m apart below a point.
fn column(tracer: &Tracer, from: DVec3, depth: f64) -> (f32, f32, u8) {
    let scene = tracer.scene();
    let ray = Ray { origin: from, direction: DVec3::NEG_Z };
    let mut next = tracer.closest(&ray, depth);
    let (mut dsm, mut dtm, mut layers, mut last) = (MISS_NAN, MISS_NAN, 0, f64::INFINITY);
    for _ in 0..MOST_LAYERS {
        let Some(hit) = next else { break };
        let z = hit.point.z;
        if dsm.is_nan() {
            dsm = z as f32;
        }
        let [a, b, c] = hit.corners;
        if (b - a).cross(c - a).z > 0.0 && last - z > 1.0 {
            layers += 1;
            last = z;
        }
        if scene.instances[hit.instance as usize].object == 0 {
            dtm = z as f32;
            break;
        }
        next = tracer.closest_from(&Origin::on(&hit), DVec3::NEG_Z, depth);
    }
    (dsm, dtm, layers)
}
