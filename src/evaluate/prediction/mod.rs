//! Predicted disparity maps: where they lie, and what a stranger's file holds.
//!
//! A prediction for `<scene>/<sample>` is the file of that name below the folder, or with `__` for the slash, as PFM, TIFF,
//! NPY or 16-bit PNG. Files come from anyone: sizes are held against the sample's before anything is allocated, and
//! whatever is wrong is told in a sentence.

mod npy;
mod pfm;
mod png;
mod tiff;

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Extensions that predictions have, in the order in which they are looked for.
const EXTENSIONS: [&str; 5] = ["pfm", "tif", "tiff", "npy", "png"];

/// Longest side of a frame, px.
pub(super) const MAX_SIDE_PX: u32 = 16384;
/// Most bytes a pixel takes in any file that is read: no codec in use makes more of eight bytes.
const MAX_BYTES_PER_PIXEL: u64 = 16;
/// Bytes for headers and metadata beyond the pixels.
const HEADER_ROOM: u64 = 1 << 22;

/// What is wrong with a prediction's file, as the end of a sentence that names it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(super) struct PredictionError(String);

impl PredictionError {
    /// With this reason.
    pub(super) fn new(reason: impl Into<String>) -> Self {
        Self(reason.into())
    }

    /// What a decoder says, which may quote the file: one line of it, not too long.
    pub(super) fn decoding(reason: &impl std::fmt::Display) -> Self {
        let reason: String = reason.to_string().chars().take(160).flat_map(char::escape_debug).collect();
        Self(format!("it cannot be decoded: {reason}"))
    }
}

/// Columns and rows that a prediction must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    /// Columns.
    pub(super) width: u32,
    /// Rows.
    pub(super) height: u32,
}

impl Size {
    /// How many pixels there are.
    pub(super) fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Refuses another size, and says what it looks like.
    fn expect(self, width: u64, height: u64) -> Result<(), PredictionError> {
        let (own_width, own_height) = (u64::from(self.width), u64::from(self.height));
        if (width, height) == (own_width, own_height) {
            return Ok(());
        }
        let factor =
            (2..=16).find(|k| width.checked_mul(*k) == Some(own_width) && height.checked_mul(*k) == Some(own_height));
        let hint = if let Some(k) = factor {
            format!(": it has 1/{k} of the resolution, enlarge it and multiply its disparities by {k}")
        } else if (width, height) == (own_height, own_width) {
            ": rows and columns look exchanged".to_owned()
        } else if width >= own_width && height >= own_height && width - own_width < 128 && height - own_height < 128 {
            ": crop the padding that the network needed".to_owned()
        } else {
            String::new()
        };
        Err(PredictionError::new(format!(
            "it is {width} x {height} pixels, but the sample has {own_width} x {own_height}{hint}"
        )))
    }
}

/// Where a sample's prediction lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// Here.
    At(PathBuf),
    /// Nowhere.
    Missing,
    /// More than one file claims to be it.
    Several(Vec<PathBuf>),
}

/// Looks for a sample's prediction. Paths are relative to `folder`.
pub(super) fn find(folder: &Path, id: &str) -> Found {
    let mut found: Vec<PathBuf> = Vec::new();
    for stem in [id.to_owned(), id.replace('/', "__")] {
        for extension in EXTENSIONS {
            let path = PathBuf::from(format!("{stem}.{extension}"));
            if folder.join(&path).exists() && !found.contains(&path) {
                found.push(path);
            }
        }
    }
    match found.len() {
        0 => Found::Missing,
        1 => Found::At(found.remove(0)),
        _ => Found::Several(found),
    }
}

/// Files below the folder, two levels deep, that could be predictions but belong to no sample: sorted, relative.
pub(super) fn strangers(folder: &Path, known: &BTreeSet<PathBuf>) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let entries = |path: &Path| -> Vec<PathBuf> {
        fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
    };
    let mut look = |path: &Path| {
        let could_be = path.extension().and_then(|e| e.to_str()).is_some_and(|e| EXTENSIONS.contains(&e));
        if let Ok(relative) = path.strip_prefix(folder)
            && could_be
            && !known.contains(relative)
        {
            out.push(relative.to_owned());
        }
    };
    for path in entries(folder) {
        if path.is_dir() {
            for inner in entries(&path) {
                look(&inner);
            }
        } else {
            look(&path);
        }
    }
    out.sort();
    out
}

/// Reads a prediction: `size` pixels of disparity, row by row from the top, px. What is not finite is no prediction.
///
/// `png_scale` is what a 16-bit PNG's numbers are divided by.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn read(path: &Path, size: Size, png_scale: f64) -> Result<Vec<f64>, PredictionError> {
    let bytes = content_at_most(path, HEADER_ROOM + MAX_BYTES_PER_PIXEL * size.pixels() as u64)?;
    match path.extension().and_then(|e| e.to_str()) {
        Some("pfm") => pfm::decode(&bytes, size),
        Some("npy") => npy::decode(&bytes, size),
        Some("png") => png::decode(&bytes, size, png_scale),
        _ => tiff::decode(&bytes, size),
    }
}

/// The content of a file that is one, and no larger than it may be.
pub(super) fn content_at_most(path: &Path, most: u64) -> Result<Vec<u8>, PredictionError> {
    let failed = |e: std::io::Error| PredictionError::new(format!("it cannot be read: {e}"));
    // Asked before opening: to open a named pipe would wait for its writer.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(PredictionError::new("it is no file"));
    }
    let mut bytes = Vec::new();
    File::open(path).map_err(failed)?.take(most + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > most {
        return Err(PredictionError::new("it is larger than any map of its size can be"));
    }
    Ok(bytes)
}

/// Refuses content that is shorter or longer than its pixels.
fn expect_length(found: usize, needed: usize) -> Result<(), PredictionError> {
    if found == needed {
        return Ok(());
    }
    Err(PredictionError::new(format!("its header is followed by {found} bytes, but its pixels take {needed}")))
}

#[cfg(test)]
mod tests;
