//! What a plan costs, before any of it is done.

use super::Plan;
use crate::recipe::{DisparityPrecision, Label, Recipe, SensorCoding};

/// What a plan costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// Scenes to build.
    pub scenes: u64,
    /// Pairs to make.
    pub pairs: u64,
    /// Bytes on disk, about.
    pub disk_bytes: u64,
    /// Upper bound of memory while it runs, bytes.
    pub memory_bytes: u64,
    /// Rays to trace for pixels and labels, about; those of light come on top.
    pub rays: u64,
}

/// Bytes that the program takes before it has a scene.
const BASE_BYTES: u64 = 64 << 20;

impl Estimate {
    /// The cost of a whole plan with `samples_in_flight` pairs in memory at once.
    pub fn of(recipe: &Recipe, plan: &Plan, samples_in_flight: u32) -> Self {
        let pairs = plan.pair_count() as u64;
        let pixels = recipe.camera().pixels();
        let scene_bytes = plan.scenes.iter().map(|s| s.region.memory_bound_bytes()).max().unwrap_or(0);
        let sample_bytes = 2 * pixels * memory_bytes_per_pixel();
        let milli_bytes = 2 * pixels * disk_millibytes_per_pixel(recipe);
        // One ray a sample and one to the sun; the label's own, its way to the other camera, and four corners.
        let rays_per_pixel = u64::from(recipe.sensor().samples_per_pixel) * 2 + 6;
        Self {
            scenes: plan.scenes.len() as u64,
            pairs,
            disk_bytes: pairs * (milli_bytes / 1000 + 8192),
            memory_bytes: BASE_BYTES + scene_bytes + u64::from(samples_in_flight.max(1)) * sample_bytes,
            rays: pairs * 2 * pixels * rays_per_pixel,
        }
    }
}

/// Radiance and its blur 2 x 16, image up to 16, hit point 24, disparity 4, validity 1, elevation 4, class 1, instance 4, normal
/// 12, shadow 1, edge 1, and an encoder's copy 8.
fn memory_bytes_per_pixel() -> u64 {
    2 * 16 + 16 + 24 + 4 + 1 + 4 + 1 + 4 + 12 + 1 + 1 + 8
}

/// Compressed sizes per pixel of one view, thousandths of a byte, measured on samples of 2048 x 2048 pixels; the disparity
/// of the right view counts half in each.
fn disk_millibytes_per_pixel(recipe: &Recipe) -> u64 {
    let labels = recipe.labels();
    let disparity = match labels.disparity_precision {
        DisparityPrecision::Full => 1360,
        DisparityPrecision::Px256th => 680,
    };
    let views = if labels.has(Label::DisparityRight) { 2 } else { 1 };
    let sensor = &recipe.sensor().imager;
    let band = match SensorCoding::from(sensor.coding) {
        SensorCoding::Stretched => 470,
        SensorCoding::Counts => 1200,
        SensorCoding::Radiance => 3000,
    };
    let mut sum = band * sensor.bands.count() as u64 + views * (disparity + 40) / 2;
    for (label, size) in [
        (Label::Class, 80),
        (Label::Elevation, 1360),
        (Label::Instance, 150),
        (Label::Normal, 2500),
        (Label::Shadow, 250),
        (Label::Edge, 60),
    ] {
        if labels.has(label) {
            sum += size;
        }
    }
    sum
}
