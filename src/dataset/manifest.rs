//! Names of a dataset's own files, and the hash that stands for all of it.

use super::record::{RecordError, SampleRecord};

/// The resolved recipe.
pub const RECIPE: &str = "recipe.toml";
/// One line a sample, in plan order.
pub const MANIFEST: &str = "manifest.jsonl";
/// The manifest's hash.
pub const ROOT_HASH: &str = "manifest.blake3";
/// The dataset to look at, a page that follows from the rest: no record names it, and nobody needs it.
pub const GALLERY: &str = "gallery.html";
/// The dataset's card: a page that follows from the rest.
pub const CARD: &str = "README.md";
/// What programs read of the card; the card holds its hash.
pub const CROISSANT: &str = "croissant.json";
/// Pages that follow from the dataset. No record names them, and nobody needs them.
pub const PAGES: [&str; 3] = [GALLERY, CARD, CROISSANT];
/// A scene's lines of the manifest.
pub const PART: &str = "part.jsonl";
/// A sample's record.
pub const SAMPLE: &str = "sample.json";

/// BLAKE3 of the manifest: the root hash, which stands for every byte of the dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ManifestHash(blake3::Hash);

impl ManifestHash {
    /// The hash of a manifest's text.
    pub fn of(manifest: &[u8]) -> Self {
        Self(blake3::hash(manifest))
    }

    /// A manifest's hash that was worked out piece by piece.
    pub(super) fn from_hash(hash: blake3::Hash) -> Self {
        Self(hash)
    }

    /// 64 hexadecimal digits.
    pub fn hex(&self) -> String {
        self.0.to_hex().to_string()
    }

    /// The 32 bytes.
    pub fn bytes(&self) -> &[u8; 32] {
        self.0.as_bytes()
    }

    /// The content of `manifest.blake3`, as `b3sum --check` reads it.
    pub fn to_file(&self) -> String {
        format!("{}  {MANIFEST}\n", self.hex())
    }
}

/// The records of a manifest or part, in its order.
///
/// # Errors
/// The first bad line, by its number.
pub fn parse_lines(text: &str) -> Result<Vec<SampleRecord>, LineError> {
    let mut records = Vec::new();
    for (i, line) in text.lines().enumerate() {
        records.push(SampleRecord::from_line(line).map_err(|reason| LineError { line: i + 1, reason })?);
    }
    Ok(records)
}

/// A bad line of a manifest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct LineError {
    /// From 1.
    pub line: usize,
    /// What is wrong.
    pub reason: RecordError,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_hash_is_what_b3sum_prints() {
        // BLAKE3 of nothing, from the reference test vectors.
        let hash = ManifestHash::of(b"");
        assert_eq!(hash.hex(), "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262");
        assert_eq!(hash.to_file(), format!("{}  manifest.jsonl\n", hash.hex()));
    }

    #[test]
    fn a_bad_line_is_named() {
        assert_eq!(parse_lines("").unwrap(), []);
        let error = parse_lines("{\"id\":3}\n").unwrap_err().to_string();
        assert!(error.starts_with("line 1: it is no sample record"), "{error}");
    }
}
