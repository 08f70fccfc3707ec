//! satseed regenerates a satellite-stereo dataset from seeds: a recipe and a seed go in; stereo pairs with exact labels
//! come out, the same bytes on every machine.
//!
//! The data flows in one direction:
//!
//! ```text
//! recipe (TOML + seed)
//!   -> plan       which scenes, which pairs, which split: pure, cheap, printable
//!   -> scene      meshes, materials, instances of one pivot (crate satseed-generators)
//!   -> tracer     acceleration structure: closest hit, visible? (crate satseed-tracer)
//!   -> view       image and labels of one camera
//!   -> sample     two views and cameras of one pair
//!   -> dataset    files, manifest, verify, resume
//!   -> evaluate   predictions against labels: scores, break-downs, likely mistakes
//!   -> sweep      one recipe with one thing changed, and its curves
//!   -> card       what a dataset tells of itself
//!   -> gallery    one page to look at it
//!   -> export     the layouts that stereo trainers load
//! scene
//!   -> model      a 3-D model, a point cloud, height maps, for other people's viewers
//! ```

pub mod camera;
pub mod card;
pub mod dataset;
pub mod evaluate;
pub mod export;
pub mod gallery;
pub mod labels;
pub mod model;
pub mod pipeline;
pub mod plan;
pub mod recipe;
pub mod render;
pub mod sweep;
