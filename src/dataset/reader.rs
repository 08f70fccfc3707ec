//! Reads a dataset that anyone may have written.

use super::camera_file::CameraFile;
use super::formats::{FormatError, HeightMap, Plane, decode_height_map, decoded_bytes_at_most};
use super::layer::{Layer, View};
use super::manifest::{LineError, MANIFEST, ManifestHash, parse_lines};
use super::record::{FileRecord, SampleRecord};
use super::sample::Sample;
use super::store::{Store, StoreError};

/// Largest frame of a dataset, px in each direction; the recipe allows no larger one.
const MAX_SIDE_PX: u32 = 16384;
/// Most cells of a surface model: 2 x 900 m at 0.05 m.
const MAX_CELLS: usize = 36_000 * 36_000;

/// Why something cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The store could not.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The manifest is no manifest.
    #[error("`{MANIFEST}`, {0}")]
    Manifest(#[from] LineError),
    /// The dataset is not complete, or it is none.
    #[error("the folder has no `{MANIFEST}`: it is no finished dataset; run generate again to finish it")]
    Unfinished,
    /// A file is not what its record says.
    #[error("`{path}`: {reason}")]
    File {
        /// Which file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// There is no such sample.
    #[error("the dataset has no sample `{0}`; its manifest lists what there is")]
    NoSample(String),
}

/// A finished dataset, open for reading. Only what is asked for is read.
pub struct Dataset<'a> {
    store: &'a dyn Store,
    records: Vec<SampleRecord>,
    root_hash: ManifestHash,
}

impl<'a> Dataset<'a> {
    /// Reads the manifest. It does not check any file; `verify` does.
    ///
    /// # Errors
    /// Where there is no manifest or it is none.
    pub fn open(store: &'a dyn Store) -> Result<Self, ReadError> {
        let manifest = match store.get(MANIFEST) {
            Err(StoreError::NotFound { .. }) => return Err(ReadError::Unfinished),
            other => other?,
        };
        let text = String::from_utf8_lossy(&manifest);
        Ok(Self { store, records: parse_lines(&text)?, root_hash: ManifestHash::of(&manifest) })
    }

    /// Its samples in plan order.
    pub fn records(&self) -> &[SampleRecord] {
        &self.records
    }

    /// The hash of its manifest.
    pub fn root_hash(&self) -> ManifestHash {
        self.root_hash
    }

    /// Its store.
    pub fn store(&self) -> &'a dyn Store {
        self.store
    }

    /// The record of a sample.
    ///
    /// # Errors
    /// Where there is no such sample.
    pub fn record(&self, id: &str) -> Result<&SampleRecord, ReadError> {
        self.records.iter().find(|r| r.id() == id).ok_or_else(|| ReadError::NoSample(id.chars().take(140).collect()))
    }

    /// The text of one of a sample's text files: `recipe`, `scene` or `camera`.
    ///
    /// # Errors
    /// Where it is missing or no text.
    pub fn text(&self, record: &SampleRecord, name: &str) -> Result<String, ReadError> {
        let file = file_of(record, name)?;
        let bytes = self.store.get(&file.path)?;
        String::from_utf8(bytes).map_err(|_| fault(&file.path, "it is no text"))
    }

    /// A sample's cameras.
    ///
    /// # Errors
    /// Where the file is missing or says what no camera can be.
    pub fn camera(&self, record: &SampleRecord) -> Result<CameraFile, ReadError> {
        parse_camera(&file_of(record, "camera")?.path, &self.text(record, "camera")?)
    }

    /// One of a sample's arrays, of the size that its camera says.
    ///
    /// # Errors
    /// Where it is missing, damaged, or of another kind or size.
    pub fn plane(
        &self,
        record: &SampleRecord,
        camera: &CameraFile,
        layer: Layer,
        view: View,
    ) -> Result<Plane, ReadError> {
        let file = file_of(record, &layer.key(view))?;
        decode_plane(file, &self.store.get(&file.path)?, camera, layer, view)
    }

    /// A surface model of a sample's scene, `dsm`, `dtm` or `ndsm`.
    ///
    /// # Errors
    /// Where it is missing or damaged.
    pub fn height_map(&self, record: &SampleRecord, name: &str) -> Result<HeightMap, ReadError> {
        let file = file_of(record, name)?;
        let bytes = self.store.get(&file.path)?;
        decode_height_map(&bytes, most_cells(bytes.len())).map_err(|e| fault(&file.path, &e.to_string()))
    }
}

/// Most cells that a surface model of a file's length can have.
pub(super) fn most_cells(file_bytes: usize) -> usize {
    MAX_CELLS.min((decoded_bytes_at_most(file_bytes) / 4) as usize)
}

pub(super) fn parse_camera(path: &str, text: &str) -> Result<CameraFile, ReadError> {
    let camera: CameraFile =
        serde_json::from_str(text).map_err(|e| fault(path, &format!("it is no camera file: {e}")))?;
    for c in [&camera.left, &camera.right] {
        if ![c.width_px, c.height_px].iter().all(|n| (1..=MAX_SIDE_PX).contains(n)) {
            return Err(fault(path, &format!("a frame has 1 to {MAX_SIDE_PX} px on each side")));
        }
    }
    Ok(camera)
}

pub(super) fn decode_plane(
    file: &FileRecord,
    bytes: &[u8],
    camera: &CameraFile,
    layer: Layer,
    view: View,
) -> Result<Plane, ReadError> {
    let camera = if view == View::Left { &camera.left } else { &camera.right };
    Plane::decode_one_of(bytes, layer.kinds(), camera.width_px, camera.height_px)
        .map_err(|e: FormatError| fault(&file.path, &e.to_string()))
}

/// A sample as its record and decoded files say.
pub(super) fn sample_of(record: &SampleRecord, camera: CameraFile, planes: Vec<(Layer, View, Plane)>) -> Sample {
    Sample { identity: record.identity.clone(), camera, planes }
}

fn file_of<'r>(record: &'r SampleRecord, name: &str) -> Result<&'r FileRecord, ReadError> {
    record
        .files
        .get(name)
        .ok_or_else(|| fault(record.id(), &format!("the sample has no `{name}`: its recipe does not ask for it")))
}

fn fault(path: &str, reason: &str) -> ReadError {
    ReadError::File { path: path.to_owned(), reason: reason.to_owned() }
}
