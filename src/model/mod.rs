//! A scene as files for other people's viewers: a 3-D model, a point cloud of a pair, height maps.
//!
//! All three stand in one frame, the world's: the origin is the pivot's foot at the region's datum, metres. A GLB's axes are
//! turned by its root node, since glTF has y up; point cloud and height maps are east, north, up. The same scene gives
//! the same bytes everywhere.

mod glb;
mod heights;
mod points;

pub use glb::glb;
pub use heights::{HeightFiles, height_files};
pub use points::{Point, PointCloud};

use crate::dataset::formats::FormatError;
use serde::Serialize;

/// Which scene a file shows; it stands in the file.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// The scene's name, as a dataset has it.
    pub scene: String,
    /// Region.
    pub region: String,
    /// The region's variant.
    pub variant: String,
    /// The scene's seed.
    pub seed: u64,
    /// The generator's version.
    pub generator_version: u32,
    /// BLAKE3 of the parameters.
    pub params_hash: String,
}

/// Why a scene has no such file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A GLB counts its bytes with 32 bits.
    #[error(
        "the model would have {bytes} bytes, but a GLB holds at most {}: a smaller radius_m of the scene helps",
        u32::MAX
    )]
    TooLarge {
        /// What it would have.
        bytes: u64,
    },
    /// A scene without a triangle.
    #[error("the scene holds no triangle, so there is no model of it")]
    Empty,
    /// A sample lacks what a point cloud is made of.
    #[error("sample `{id}` has no {what} of its left view, and a point cloud is made of image and disparity")]
    Missing {
        /// The sample.
        id: String,
        /// What it lacks.
        what: &'static str,
    },
    /// A height map cannot be encoded.
    #[error("a height map cannot be written: {0}")]
    Heights(#[from] FormatError),
}
