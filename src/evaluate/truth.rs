//! What a sample's labels say of each pixel: its truth, and the bin of every break-down that it falls into.

use super::boundary::{jumps, squared_distances};
use super::breakdown::{By, DisparityBins, NO_BIN, boundary_bin, height_bin, shadow_bin, slope_bin};
use super::prediction::Size;
use crate::dataset::formats::{HeightMap, Pixels, Plane};
use crate::dataset::texture::contrast_steps;
use crate::dataset::{CameraFile, Dataset, Layer, ReadError, SampleRecord, View, validity};

/// A sample's truth.
pub(super) struct Truth {
    /// Columns and rows.
    pub(super) size: Size,
    /// Disparity, px; NaN where nothing was hit.
    pub(super) disparity_px: Vec<f32>,
    /// Validity map.
    pub(super) validity: Vec<u8>,
    /// On either side of a disparity jump.
    pub(super) jumps: Vec<bool>,
    /// Squared distance to the next such pixel, px^2.
    pub(super) jump_distances: Vec<u32>,
    /// For each break-down, the bin of each pixel; none where the dataset has no such label.
    pub(super) bins: [Option<Vec<u16>>; By::ALL.len()],
    /// `cx_R - cx_L`, px.
    pub(super) doffs_px: f64,
}

impl Truth {
    /// Reads it. `ground` is the bare ground of the sample's scene.
    pub(super) fn read(
        dataset: &Dataset<'_>,
        record: &SampleRecord,
        ground: Option<&HeightMap>,
        disparity_bins: DisparityBins,
    ) -> Result<Self, ReadError> {
        let camera = dataset.camera(record)?;
        let size = Size { width: camera.left.width_px, height: camera.left.height_px };
        let width = size.width as usize;
        let plane = |layer| dataset.plane(record, &camera, layer, View::Left);
        let label = |layer: Layer| {
            let there = record.files.contains_key(&layer.key(View::Left));
            there.then(|| plane(layer)).transpose()
        };
        let disparity_px = plane(Layer::Disparity)?.into_floats();
        let validity = plane(Layer::Validity)?.into_bytes();
        let jumps = jumps(&disparity_px, width);
        let jump_distances = squared_distances(&jumps, width);
        let bins = By::ALL.map(|by| {
            Ok::<_, ReadError>(Some(match by {
                By::Texture => {
                    contrast_steps(&dataset.plane(record, &camera, Layer::Image, View::Left)?.to_rgb8(), width)
                }
                By::Disparity => disparity_px.iter().map(|d| disparity_bins.bin(*d)).collect(),
                By::Height => {
                    let Some(ground) = ground else { return Ok(None) };
                    heights_above_ground(&disparity_px, &camera, ground)
                }
                By::Boundary => jump_distances.iter().map(|d| boundary_bin(*d)).collect(),
                By::Slope => {
                    let Some(Plane { pixels: Pixels::Vector(normals), .. }) = label(Layer::Normal)? else {
                        return Ok(None);
                    };
                    normals.chunks_exact(3).map(|n| slope_bin([n[0], n[1], n[2]])).collect()
                }
                By::Class => {
                    let Some(classes) = label(Layer::Class)? else { return Ok(None) };
                    classes.into_bytes().into_iter().map(u16::from).collect()
                }
                By::Shadow => {
                    let Some(shadow) = label(Layer::Shadow)? else { return Ok(None) };
                    shadow.into_bytes().into_iter().map(shadow_bin).collect()
                }
            }))
        });
        let [a, b, c, d, e, f, g] = bins;
        let bins = [a?, b?, c?, d?, e?, f?, g?];
        Ok(Self { size, disparity_px, validity, jumps, jump_distances, bins, doffs_px: camera.doffs_px })
    }

    /// Whether a pixel counts, and if so whether it is occluded.
    pub(super) fn occluded(&self, pixel: usize) -> Option<bool> {
        match self.validity[pixel] {
            validity::VALID => Some(false),
            validity::OCCLUDED => Some(true),
            _ => None,
        }
        .filter(|_| self.disparity_px[pixel].is_finite())
    }
}

/// The bin of each pixel's height above the bare ground below it.
fn heights_above_ground(disparity_px: &[f32], camera: &CameraFile, ground: &HeightMap) -> Vec<u16> {
    let heights_m = camera.heights_above(ground, disparity_px);
    heights_m.into_iter().map(|h| if h.is_finite() { height_bin(h) } else { NO_BIN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::CameraRecord;

    /// A camera 1000 m over the origin that looks down, north up, over ground at 100 m: a disparity of f B / 888 is a
    /// point 112 m high, 12 m above the ground.
    #[test]
    fn heights_by_hand() {
        let record = CameraRecord {
            width_px: 3,
            height_px: 1,
            fx_px: 1000.0,
            fy_px: 1000.0,
            cx_px: 1.0,
            cy_px: 0.0,
            position_m: [0.0, 0.0, 1000.0],
            world_from_camera: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            projection: [[0.0; 4]; 3],
        };
        let camera = CameraFile {
            left: record.clone(),
            right: record,
            baseline_m: 50.0,
            altitude_m: 1000.0,
            gsd_m: 1.0,
            azimuth_deg: 90.0,
            convergence_deg: 0.0,
            convergence_at_pivot_deg: 0.0,
            doffs_px: 7.0,
            disparity_range_px: None,
        };
        // Cells of 0.8 m: the left pixel's point lies at x = -0.888, in the first cell, over ground of 60 m.
        let heights_m = vec![60.0, 100.0, f32::NAN];
        let ground = HeightMap { west_m: -0.8, south_m: 0.0, cell_m: 0.8, width: 3, height: 1, heights_m };
        let d = (1000.0 * 50.0 / 888.0 - 7.0) as f32;
        let bins = heights_above_ground(&[d, d, d], &camera, &ground);
        assert_eq!(bins, [height_bin(52.0), height_bin(12.0), NO_BIN]);
        assert_eq!(heights_above_ground(&[f32::NAN, -7.0, 0.01], &camera, &ground), [NO_BIN; 3]);
    }
}
