//! Rays against a scene: the closest surface, and whether a point sees another.
//!
//! Two levels: a tree over instances, and one tree for each mesh. Boxes are tested in f32 with a conservative bound, so
//! they propose; triangles are decided in f64 in the world frame, so every answer is that of exact geometry up to f64's
//! own rounding and does not depend on the tree.
//!
//! - [`Tracer::closest`] gives the first hit; hits within [`tie_tolerance_m`] of it are one place, and the lowest
//!   (instance, triangle) of them answers.
//! - [`Tracer::occluder`] and [`Tracer::blocked`] start on a surface; [`Origin`] owns the rule that says which triangles
//!   a ray that starts there cannot meet.
//!
//! Surfaces are two-sided, and a ray cannot slip between triangles that share an edge (Woop, Benthin, Wald 2013).

mod block;
mod bundle;
mod bvh8;
mod query;
mod simd;
mod single;
mod slab;
mod surface;
mod traverse;
mod tree;
mod triangle;

pub use bundle::{TILE_SIDE, tile_order};
pub use simd::InstructionSet;
pub use surface::{Hit, Origin, tie_tolerance_m};
pub use traverse::{RayCounts, Tracer};
pub use tree::{BYTES_PER_INSTANCE, BYTES_PER_TRIANGLE, BYTES_PER_WIDE_TRIANGLE};
