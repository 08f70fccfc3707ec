//! From a scene and a camera to pixels.
//!
//! For each sample: the closest surface, its material over the sample's footprint, the sun's disc, the sky's dome, one
//! bounce. Samples lie on a grid twice as fine as the pixels; the sensor's point spread acts there, then the grid is
//! decimated, as an imager integrates what its optics have blurred.

mod film;
mod light;
mod sampling;
pub mod sensor;
mod shading;

pub use light::Light;
pub use sensor::{Image, Sensor};

use crate::camera::Camera;
use satseed_scene::{Environment, SeedPath};
use satseed_tracer::Tracer;

/// How a view is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Samples per pixel, 1..=4096; rounded up to a square number, and to a multiple of 4 above 1.
    pub samples_per_pixel: u32,
    /// The imager.
    pub sensor: Sensor,
}

/// Renders one view. `noise` keys the sensor's noise: a path of its own for each image. Rows run in parallel on the
/// current rayon pool; the result does not depend on it.
pub fn render(
    tracer: &Tracer,
    camera: &Camera,
    environment: &Environment,
    settings: Settings,
    noise: &SeedPath,
) -> Image {
    let light = Light::new(environment);
    let radiance = film::expose(tracer, camera, &light, settings.samples_per_pixel, settings.sensor.psf_sigma_px());
    settings.sensor.develop(&radiance, &light, noise)
}
