//! satseed regenerates a satellite-stereo dataset from seeds.

pub mod camera;
pub mod labels;
pub mod render;
