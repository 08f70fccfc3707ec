//! `camera.json`. A format of its own, which stays as it is when the program's cameras change.

use super::formats::HeightMap;
use super::layer::View;
use serde::{Deserialize, Serialize};

/// One camera of `camera.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraRecord {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Focal length along u, px.
    pub fx_px: f64,
    /// Focal length along v, px.
    pub fy_px: f64,
    /// Principal point, u, px; pixel centres stand at integers.
    pub cx_px: f64,
    /// Principal point, v, px.
    pub cy_px: f64,
    /// Optical centre, world frame, m.
    pub position_m: [f64; 3],
    /// Rotation from the camera's frame (u, v, forward) to the world's, by rows.
    pub world_from_camera: [[f64; 3]; 3],
    /// Homogeneous pixel from homogeneous world point, by rows.
    pub projection: [[f64; 4]; 3],
}

/// `camera.json`: the two cameras of a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraFile {
    /// The left camera.
    pub left: CameraRecord,
    /// The right camera.
    pub right: CameraRecord,
    /// Distance of the optical centres, m.
    pub baseline_m: f64,
    /// Height of the optical centres above z = 0, m.
    pub altitude_m: f64,
    /// Ground sampling distance at z = 0, m.
    pub gsd_m: f64,
    /// Direction of the baseline, clockwise from north, degrees.
    pub azimuth_deg: f64,
    /// Angle under which the baseline is seen from z = 0, degrees.
    pub convergence_deg: f64,
    /// The same from the pivot's height, degrees.
    pub convergence_at_pivot_deg: f64,
    /// `cx_R - cx_L`, px, as Middlebury has it.
    pub doffs_px: f64,
    /// Lowest and highest disparity of the left view's hit pixels, occluded and out-of-frame ones included, px.
    pub disparity_range_px: Option<[f32; 2]>,
}

impl CameraFile {
    /// The world point (m) that a pixel of one view sees, from its disparity (px) and the cameras alone: depth is
    /// f B / (d + doffs). NaN where the disparity is.
    pub fn point_m(&self, view: View, pixel: usize, disparity_px: f32) -> [f64; 3] {
        let camera = if view == View::Left { &self.left } else { &self.right };
        let depth = camera.fx_px * self.baseline_m / (f64::from(disparity_px) + self.doffs_px);
        let (u, v) = (pixel % camera.width_px as usize, pixel / camera.width_px as usize);
        let ray = [(u as f64 - camera.cx_px) / camera.fx_px, (v as f64 - camera.cy_px) / camera.fy_px, 1.0];
        let along = |row: &[f64; 3]| depth * (row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2]);
        core::array::from_fn(|k| camera.position_m[k] + along(&camera.world_from_camera[k]))
    }

    /// Height (m) of each of the left view's points over a surface model below it; NaN where the pixel has no disparity (px)
    /// or the model no height.
    pub fn heights_above(&self, ground: &HeightMap, disparity_px: &[f32]) -> Vec<f64> {
        let cell = |at: f64, first: f64, count: u32| {
            let i = ((at - first) / ground.cell_m).round();
            (i >= 0.0 && i < f64::from(count)).then_some(i as usize)
        };
        let height_m = |i: usize| {
            let [x, y, z] = self.point_m(View::Left, i, disparity_px[i]);
            let column = cell(x, ground.west_m, ground.width)?;
            let row = cell(y, ground.south_m, ground.height)?;
            Some(z - f64::from(ground.heights_m[row * ground.width as usize + column]))
        };
        (0..disparity_px.len()).map(|i| height_m(i).unwrap_or(f64::NAN)).collect()
    }
}
