//! Terrain: noise, flow, erosion, weighted distances, contour lines, overhangs, and error-bounded triangulation.
//!
//! Everything works on [`Raster`](satseed_scene::Raster)s of `f32` posts, from coarse to fine, and on one thread unless
//! a function says otherwise; what is parallel is parallel by rows or tiles and collected in order.

pub mod contour;
pub mod erosion;
pub mod flow;
pub mod front;
pub mod noise;
pub mod overhang;
pub mod sampling;
pub mod tiling;
pub mod tin;
