//! A dataset on disk or in memory: written once, sample by sample, and checked against itself.
//!
//! It knows the plan's names and plain arrays, not scenes, cameras or rays.

mod camera_file;
mod compare;
pub mod formats;
mod join;
mod layer;
mod lock;
mod manifest;
mod ownership;
mod reader;
mod record;
mod sample;
mod seal;
mod store;
mod summary;
mod terrain;
pub(crate) mod texture;
mod verify;
#[cfg(test)]
mod verify_tests;
mod writer;
#[cfg(test)]
mod writer_tests;

pub use camera_file::{CameraFile, CameraRecord};
pub use compare::{compare_sample, compare_scene};
pub use join::{JoinError, Joined, bring, join, put_same};
pub use layer::{LAST_CLASS, Layer, View, validity};
pub use lock::{FolderLock, LockError};
pub use manifest::{
    CARD, CROISSANT, GALLERY, LineError, MANIFEST, ManifestHash, PAGES, PART, RECIPE, ROOT_HASH, SAMPLE, parse_lines,
};
pub use reader::{Dataset, ReadError};
pub use record::{FileRecord, RecordError, SampleRecord, is_name};
pub use sample::{ContentError, Identity, Sample, Statistics};
pub use seal::Seal;
#[cfg(feature = "cloud")]
pub use store::ObjectStore;
pub use store::{Chunks, DiskStore, Entry, MemoryStore, Store, StoreError, check_path};
pub use summary::{BaselineSummary, CLASS_NAMES, Histogram, RegionSummary, SceneSummary, Summary, summarise};
pub use terrain::SceneFigures;
pub use verify::{Fault, Finding, Report, verify};
pub use writer::{Contents, SceneContents, SceneFiles, WriteError, Writer, same_recipe, to_json};
