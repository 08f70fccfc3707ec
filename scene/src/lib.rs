//! The vocabulary of satseed: what a scene is, and nothing of how it is made, traced or seen.
//!
//! A [`Scene`] is a list of [`Mesh`]es placed by [`Instance`]s, dressed in [`Material`]s. A material is data: a closed
//! set of texture primitives ([`Field`]) with one pure evaluator that returns the mean over a pixel's footprint.
//! Everything random comes from a [`SeedPath`], a key, never from an order of drawing.
//!
//! Frames: the world is right-handed east-north-up in metres; z = 0 is the region's ground datum. Angles are radians.

mod bands;
mod environment;
mod field;
mod fractal;
mod material;
mod mesh;
mod noise;
mod raster;
mod scene;
mod seed;
mod texture_noise;
mod units;
mod wide;

pub use bands::Bands;
pub use environment::Environment;
pub use field::{Coordinate, Field, Filtered, Space, SurfacePoint};
pub use fractal::Fractal;
pub use material::{Beds, Brdf, Bump, Class, Layer, Material, Shade};
pub use mesh::{Mesh, MeshError};
pub use noise::{gradient_noise_2d, gradient_noise_2d_x4, hash_cell, unit_from_hash};
pub use raster::{MaterialRaster, Raster};
pub use scene::{Instance, Object, Ray, Scene, SceneError};
pub use seed::{Rng, SeedPath};
pub use units::{QUANTUM_M, direction_from_angles, quantise_m, quantise_point};
