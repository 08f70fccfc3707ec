//! From a scene and a camera to pixels.
//!
//! For each sample: the closest surface, its material over the sample's footprint, the sun's disc, the sky's dome, one
//! bounce. Samples lie on a grid twice as fine as the pixels; the sensor's point spread acts there, then the grid is
//! decimated, as an imager integrates what its optics have blurred. The air is put over the decimated radiance, for it is
//! the same over a frame; then come detectors, colour bands and coding.
//!
//! Light is worked out once per scene, samples are keyed by pixel and view, noise by image: between the two views of a
//! pair nothing changes but the camera and the noise.

mod air;
mod ambient;
mod film;
mod light;
mod sampling;
pub mod sensor;
mod shading;

pub use light::{Light, Veil};
pub use sensor::{Exposure, Image, Sensor};

use crate::camera::Camera;
use glam::DVec3;
use satseed_scene::SeedPath;
use satseed_tracer::Tracer;

/// How the light of the dome and of the surfaces around is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AmbientMode {
    /// Once per scene, on a lattice in the world that all views share; docs/images.md states its error.
    PerScene,
    /// One direction for each sample: the reference, with noise in the shade.
    PerSample,
}

/// How a view is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Samples per pixel, 1..=4096; rounded up to a square number, and to a multiple of 4 above 1.
    pub samples_per_pixel: u32,
    /// The imager.
    pub sensor: Sensor,
}

/// Renders one view by itself: [`expose`] and [`develop`].
pub fn render(tracer: &Tracer, camera: &Camera, light: &Light, settings: Settings, noise: &SeedPath) -> Image {
    let exposure = expose(tracer, camera, light, settings, noise);
    develop(vec![exposure], settings.sensor).remove(0)
}

/// What the sensor's detectors record of one view. `noise` keys their noise: a path of its own for each image. Rows run
/// in parallel on the current rayon pool; the result does not depend on it.
pub fn expose(tracer: &Tracer, camera: &Camera, light: &Light, settings: Settings, noise: &SeedPath) -> Exposure {
    let ground = film::expose(tracer, camera, light, settings.samples_per_pixel, &settings.sensor.optics);
    // The direction in which the orbit stands that this camera is a stand-in for: as the pivot sees it.
    let pivot_m = DVec3::new(0.0, 0.0, tracer.scene().pivot_height_m);
    let veil = light.veil((camera.position_m - pivot_m).try_normalize().unwrap_or(DVec3::Z));
    settings.sensor.record(&ground, light, veil, noise)
}

/// Codes what was recorded: the views of a pair together, so that one stretch serves both.
pub fn develop(exposures: Vec<Exposure>, sensor: Sensor) -> Vec<Image> {
    sensor::code(exposures, sensor.coding)
}
