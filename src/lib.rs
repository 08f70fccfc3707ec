//! satseed regenerates a satellite-stereo dataset from seeds.

pub mod camera;
pub mod dataset;
pub mod labels;
pub mod render;
