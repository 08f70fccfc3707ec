//! DSM and DTM of a scene, as a dataset has them.

use super::ModelError;
use crate::dataset::formats::{HeightMap, encode_height_map};
use crate::labels::surface_models;
use satseed_scene::Scene;

/// The bytes of two `GeoTIFF` files of one grid.
#[derive(Clone, Debug)]
pub struct HeightFiles {
    /// First surface from above, `dsm.tif` of a dataset.
    pub dsm: Vec<u8>,
    /// Bare ground, `dtm.tif` of a dataset.
    pub dtm: Vec<u8>,
}

/// Height maps over the square of half side `half_side_m` around the pivot, with cells of `cell_m`.
///
/// # Errors
/// Where the square holds no cell.
pub fn height_files(scene: &Scene, half_side_m: f64, cell_m: f64) -> Result<HeightFiles, ModelError> {
    let models = surface_models(scene, half_side_m, cell_m);
    let dsm = encode_height_map(&HeightMap::from(models.dsm_m))?;
    let dtm = encode_height_map(&HeightMap::from(models.dtm_m))?;
    Ok(HeightFiles { dsm, dtm })
}
