//! `camera.json`. A format of its own, which stays as it is when the program's cameras change.

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
