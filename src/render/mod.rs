//! From a scene and a camera to pixels.
//!
//! For each sample: the closest surface, its material over the sample's footprint, the sun's disc, the sky's dome, one
//! bounce. Samples lie on a grid twice as fine as the pixels; the sensor's point spread acts there, then the grid is
//! decimated, as an imager integrates what its optics have blurred.

mod ambient;
mod film;
mod light;
mod sampling;
pub mod sensor;
mod shading;

pub use light::Light;
pub use sensor::{Image, Sensor};

use crate::camera::Camera;
use ambient::Ambient;
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

/// How the light of the dome and the bounce is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AmbientMode {
    /// Once per scene, on a lattice in the world; all views share it. See docs/rendering.md for its error.
    PerScene,
    /// One direction for each sample: without that error, with noise in the shade.
    PerSample,
}

/// The light of a scene, for all its views.
#[derive(Debug)]
pub struct Lighting {
    light: Light,
    ambient: Option<Ambient>,
}

impl Lighting {
    /// The light of an environment over a scene that stands in full detail within `radius_m` of its pivot.
    pub fn new(environment: &Environment, mode: AmbientMode, radius_m: f64) -> Self {
        let light = Light::new(environment);
        let most_bytes = Self::most_bytes(mode, radius_m) as usize;
        let ambient = (mode == AmbientMode::PerScene).then(|| Ambient::new(&light, most_bytes));
        Self { light, ambient }
    }

    /// Bytes that it may come to hold.
    pub fn most_bytes(mode: AmbientMode, radius_m: f64) -> u64 {
        match mode {
            AmbientMode::PerScene => Ambient::most_bytes(radius_m),
            AmbientMode::PerSample => 0,
        }
    }
}

/// Renders one view. `noise` keys the sensor's noise: a path of its own for each image. Rows run in parallel on the
/// current rayon pool; the result does not depend on it.
pub fn render(tracer: &Tracer, camera: &Camera, lighting: &Lighting, settings: Settings, noise: &SeedPath) -> Image {
    let radiance = film::expose(tracer, camera, lighting, settings.samples_per_pixel, settings.sensor.psf_sigma_px());
    settings.sensor.develop(&radiance, &lighting.light, noise)
}
