//! The published dataset's own layout.

use super::super::Place;
use super::super::encode::{float_tiff, gray, rgb};
use super::super::pair::Pair;
use super::Files;
use crate::dataset::CameraRecord;
use serde_json::{Value, json};

/// Focal length that the published cameras name, mm.
const FOCAL_LENGTH_MM: f64 = 20.0;

/// A camera as the published files describe one. It looks straight down; `tilt_deg` is how far from the vertical it sees the
/// target.
fn camera(c: &CameraRecord, target_m: [f64; 3]) -> Value {
    let [dx, dy, dz] = [0, 1, 2].map(|k| target_m[k] - c.position_m[k]);
    let tilt = libm::atan2((dx * dx + dy * dy).sqrt(), -dz);
    // The image's right in the world: its turn about the vertical.
    let yaw = libm::atan2(c.world_from_camera[1][0], c.world_from_camera[0][0]);
    let pixel_mm = FOCAL_LENGTH_MM / c.fx_px;
    json!({
        "world_location_m": c.position_m,
        "world_rotation_deg": [0.0, -90.0, yaw.to_degrees()],
        "height_m": c.position_m[2],
        "tilt_deg": tilt.to_degrees(),
        "fx_px": c.fx_px,
        "fy_px": c.fy_px,
        "cx_px": c.cx_px,
        "cy_px": c.cy_px,
        "sensor_width_mm": pixel_mm * f64::from(c.width_px),
        "sensor_height_mm": pixel_mm * f64::from(c.height_px),
        "focal_length_mm": FOCAL_LENGTH_MM,
    })
}

/// `<region>/{Color,Disparity_raw,Disparity_Normalized,Json}/O<n>*`; 0 where a pixel has no match.
pub(super) fn satunreal(pair: &Pair, place: Place) -> Files {
    let (region, n) = (&pair.identity.region, place.in_region);
    let at = |folder: &str, name: String| format!("{region}/{folder}/{name}");
    let (width, height) = (pair.left.image.width, pair.left.image.height);
    let seen = pair.left.seen_by_both();
    let finite = || seen.iter().copied().filter(|d| d.is_finite());
    let (low, high) = (finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max));
    let scale = if high > low { 255.0 / (high - low) } else { 0.0 };
    let normalized = |d: &f32| if d.is_finite() { ((d - low) * scale + 0.5) as u8 } else { 0 };
    let c = &pair.camera;
    let [l, r] = [&c.left.position_m, &c.right.position_m];
    // The pivot stands at the origin of the world.
    let target = [0.0, 0.0, pair.pivot_height_m];
    let along = [0, 1, 2].map(|k| (target[k] - l[k]) * (r[k] - l[k])).iter().sum::<f64>();
    let cameras = json!({
        "baseline_m": c.baseline_m,
        "lookAtT_Ratio": along / (c.baseline_m * c.baseline_m),
        "convergence_deg": c.convergence_at_pivot_deg,
        "target_pos_m": target,
        "gsd_m": c.gsd_m,
        "image_width_px": width,
        "image_height_px": height,
        "camL": camera(&c.left, target),
        "camR": camera(&c.right, target),
    });
    let mut text = serde_json::to_string_pretty(&cameras).unwrap_or_default();
    text.push('\n');
    Ok(vec![
        (at("Color", format!("O{n}_L.png")), rgb(&pair.left.image)?),
        (at("Color", format!("O{n}_R.png")), rgb(&pair.right.image)?),
        (at("Disparity_Normalized", format!("O{n}.png")), gray(width, height, seen.iter().map(normalized).collect())?),
        (at("Json", format!("O{n}.json")), text.into_bytes()),
        (
            at("Disparity_raw", format!("O{n}.tif")),
            float_tiff(width, height, seen.iter().map(|d| if d.is_finite() { *d } else { 0.0 }).collect())?,
        ),
    ])
}
