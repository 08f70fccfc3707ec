//! Labels against closed forms: plane, boxes, ramp, street canyon, bridge, overhang, sphere.
//!
//! Every prediction is written from the geometry of the scene and the definition of the rig alone. Disparity is held to
//! 1e-9 px in f64, the file's value is the nearest f32, and validity maps must be equal pixel by pixel, in both views.

mod analytic {
    pub(crate) mod bodies;
    pub(crate) mod boxes;
    pub(crate) mod closed_form;
    mod maps;
    mod ramp;
    mod sphere;
    mod strips;
}
mod support;
