//! What is said of a sample: its record, which is also its line in the manifest.

use super::sample::{Identity, Statistics};
use super::store::check_path;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A file as a record names it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Path below the dataset's folder.
    pub path: String,
    /// Size, bytes.
    pub bytes: u64,
    /// BLAKE3 of the file.
    pub blake3: String,
    /// BLAKE3 of the decoded array (row-major, little-endian, no padding); absent where the file is no array.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pixels_blake3: Option<String>,
}

impl FileRecord {
    /// The record of a file's content.
    pub fn of(path: String, content: &[u8], pixels: Option<blake3::Hash>) -> Self {
        Self {
            path,
            bytes: content.len() as u64,
            blake3: blake3::hash(content).to_hex().to_string(),
            pixels_blake3: pixels.map(|h| h.to_hex().to_string()),
        }
    }
}

/// A sample's record: `sample.json`, and the sample's line in `part.jsonl` and `manifest.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleRecord {
    /// Who it is.
    #[serde(flatten)]
    pub identity: Identity,
    /// Share of the left view's pixels seen by both views, 0 to 1.
    pub valid_fraction: f64,
    /// Share in the right frame but behind something, 0 to 1.
    pub occluded_fraction: f64,
    /// Share beyond the right frame, 0 to 1.
    pub out_of_frame_fraction: f64,
    /// Lowest disparity of the left view's hit pixels, px.
    pub disparity_min_px: Option<f32>,
    /// Highest disparity of the left view's hit pixels, px.
    pub disparity_max_px: Option<f32>,
    /// Its files, those of its scene (`scene`, `dsm`, `dtm`, `ndsm`) and the dataset's `recipe`, by name.
    pub files: BTreeMap<String, FileRecord>,
}

/// Why a record is not one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct RecordError(String);

/// A name that a scene or a sample may have: `[a-z0-9][a-z0-9_-]{0,63}`.
pub fn is_name(name: &str) -> bool {
    let plain = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit();
    name.len() <= 64
        && name.bytes().next().is_some_and(plain)
        && name.bytes().all(|b| plain(b) || matches!(b, b'_' | b'-'))
}

impl SampleRecord {
    /// The record of a finished sample.
    pub fn new(identity: Identity, statistics: &Statistics, files: BTreeMap<String, FileRecord>) -> Self {
        Self {
            identity,
            valid_fraction: statistics.valid_fraction,
            occluded_fraction: statistics.occluded_fraction,
            out_of_frame_fraction: statistics.out_of_frame_fraction,
            disparity_min_px: statistics.disparity_range_px.map(|r| r[0]),
            disparity_max_px: statistics.disparity_range_px.map(|r| r[1]),
            files,
        }
    }

    /// The line, with its end.
    pub fn to_line(&self) -> String {
        let mut line = serde_json::to_string(self).expect("a record is plain data with text keys");
        line.push('\n');
        line
    }

    /// Reads a line that may come from a stranger: names and paths are checked before anyone uses them.
    ///
    /// # Errors
    /// What is wrong, in words that follow "line N: ".
    pub fn from_line(line: &str) -> Result<Self, RecordError> {
        let record: Self =
            serde_json::from_str(line).map_err(|e| RecordError(format!("it is no sample record: {e}")))?;
        let bad = |what: String| Err(RecordError(what));
        let Some((scene, sample)) = record.id().split_once('/').filter(|(a, b)| is_name(a) && is_name(b)) else {
            return bad(format!(
                "`{}` is no sample id, which is `<scene>/<sample>` of a-z, 0-9, `_`, `-`",
                shown(record.id())
            ));
        };
        let own = format!("{scene}/{sample}/");
        for (name, file) in &record.files {
            check_path(&file.path).map_err(|e| RecordError(e.to_string()))?;
            let (folder, _) = file.path.rsplit_once('/').unwrap_or(("", &file.path));
            let expected = match name.as_str() {
                "recipe" => "",
                "scene" | "dsm" | "dtm" | "ndsm" => scene,
                _ => own.trim_end_matches('/'),
            };
            if folder != expected {
                return bad(format!(
                    "the file `{}` of `{}` lies in another folder: `{}`",
                    shown(name),
                    record.id(),
                    shown(&file.path)
                ));
            }
            for hash in [Some(&file.blake3), file.pixels_blake3.as_ref()].into_iter().flatten() {
                if hash.len() != 64 || !hash.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f')) {
                    return bad(format!("a hash of `{}` is not 64 hexadecimal digits", shown(&file.path)));
                }
            }
        }
        Ok(record)
    }

    /// `<scene>/<sample>`.
    pub fn id(&self) -> &str {
        &self.identity.id
    }

    /// The scene's name.
    pub fn scene(&self) -> &str {
        self.identity.scene()
    }
}

/// A stranger's text, short enough for a message and without control characters.
fn shown(text: &str) -> String {
    text.chars().take(80).flat_map(char::escape_default).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn record() -> SampleRecord {
        let sample = crate::dataset::sample::tests::synthetic("canyon-gorge-7", "b03-a17", 8, 6);
        let mut counted = sample.clone();
        let files = [
            (
                "left".to_owned(),
                FileRecord::of("canyon-gorge-7/b03-a17/left.png".into(), b"x", Some(blake3::hash(b"y"))),
            ),
            ("dsm".to_owned(), FileRecord::of("canyon-gorge-7/dsm.tif".into(), b"z", None)),
            ("recipe".to_owned(), FileRecord::of("recipe.toml".into(), b"r", None)),
        ];
        SampleRecord::new(sample.identity, &counted.count().unwrap(), files.into())
    }

    #[test]
    fn a_line_reads_back() {
        let record = record();
        let line = record.to_line();
        assert!(line.ends_with("}\n") && line.matches('\n').count() == 1);
        assert_eq!(SampleRecord::from_line(&line).unwrap(), record);
        assert_eq!(SampleRecord::from_line(&line).unwrap().to_line(), line);
        let start = r#"{"id":"canyon-gorge-7/b03-a17","region":"canyon","variant":"gorge","scene_seed":7,"split":"train","scene_params_hash":"9f03c1aa","baseline_m":100.0,"#;
        assert!(line.starts_with(start), "{line}");
    }

    /// A reader that is half a unit off in the last place would call every such record a contradiction.
    #[test]
    fn fractions_read_back_to_the_bit() {
        let mut record = record();
        for i in 0..2000 {
            record.valid_fraction = f64::from(i) / 1999.0;
            record.disparity_min_px = Some((f64::from(i) * 0.377 - 300.0) as f32);
            assert_eq!(SampleRecord::from_line(&record.to_line()).unwrap(), record);
        }
    }

    #[test]
    fn strangers_lines_are_refused() {
        let line = record().to_line();
        for (from, to, what) in [
            ("canyon-gorge-7/b03-a17\",", "../b03-a17\",", "no sample id"),
            ("canyon-gorge-7/b03-a17/left.png", "../../etc/passwd", "cannot be a dataset's file"),
            ("canyon-gorge-7/b03-a17/left.png", "/etc/passwd", "cannot be a dataset's file"),
            ("canyon-gorge-7/b03-a17/left.png", "canyon-gorge-7/b03-a18/left.png", "another folder"),
            ("canyon-gorge-7/dsm.tif", "dsm.tif", "another folder"),
            ("\"blake3\":\"", "\"blake3\":\"g", "hexadecimal"),
            ("\"scene_seed\":7", "\"scene_seed\":-7", "no sample record"),
        ] {
            let changed = line.replacen(from, to, 1);
            assert_ne!(changed, line);
            let error = SampleRecord::from_line(&changed).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
    }

    /// Whatever a stranger changes, a line is refused or names only paths within the dataset.
    #[test]
    fn changed_lines_never_lead_out_of_the_dataset() {
        let line = record().to_line();
        let mut draws = blake3::Hasher::new().update(b"lines").finalize_xof();
        let mut read = 0;
        for _ in 0..20_000 {
            let mut bytes = line.clone().into_bytes();
            let mut word = [0; 8];
            for _ in 0..=2 {
                draws.fill(&mut word);
                let at = u32::from_le_bytes([word[0], word[1], word[2], word[3]]) as usize % bytes.len();
                match word[4] % 4 {
                    0 => bytes[at] = b"./\\\"{}-e09\n"[word[5] as usize % 11],
                    1 => drop(bytes.remove(at)),
                    2 => bytes.insert(at, b'.'),
                    _ => bytes[at] = word[5] & 0x7f,
                }
            }
            let Ok(record) = SampleRecord::from_line(&String::from_utf8_lossy(&bytes)) else { continue };
            read += 1;
            assert!(record.id().split('/').all(is_name));
            assert!(record.files.values().all(|f| check_path(&f.path).is_ok()));
        }
        assert!(read > 50, "some changes are legal: {read}");
    }

    #[test]
    fn names() {
        for good in ["a", "7", "canyon-gorge-7", "b03_a17", &"x".repeat(64)] {
            assert!(is_name(good), "{good}");
        }
        for bad in ["", "-a", "_a", "A", "a.b", "a/b", "ä", &"x".repeat(65)] {
            assert!(!is_name(bad), "{bad}");
        }
    }
}
