//! Files against their records, and labels against what labels must be.

use super::{Fault, Finding};
use crate::dataset::formats::decode_height_map;
use crate::dataset::layer::Layer;
use crate::dataset::manifest::SAMPLE;
use crate::dataset::reader::{decode_plane, most_cells, parse_camera, sample_of};
use crate::dataset::record::{FileRecord, SampleRecord};
use crate::dataset::sample::Statistics;
use crate::dataset::store::{Store, StoreError};
use std::collections::BTreeMap;

/// Reads files and holds them against their records.
pub(super) struct Checker<'a> {
    pub(super) store: &'a dyn Store,
    pub(super) entries: &'a BTreeMap<String, Option<u64>>,
    /// Where a content belongs.
    pub(super) by_hash: BTreeMap<&'a str, &'a str>,
}

impl Checker<'_> {
    /// Reads a file and holds it against its record.
    fn content(&self, file: &FileRecord) -> Result<Result<Vec<u8>, Finding>, StoreError> {
        let found = |fault, detail: String| Ok(Err(Finding::new(&file.path, fault, detail)));
        match self.entries.get(&file.path) {
            None => return found(Fault::Missing, "it is recorded, but not there".into()),
            Some(None) => return found(Fault::Changed, "it is a link or no regular file".into()),
            Some(Some(bytes)) if *bytes < file.bytes && *bytes == 0 => {
                return found(Fault::Truncated, format!("it is empty instead of {} bytes", file.bytes));
            }
            Some(Some(_)) => {}
        }
        let content = self.store.get(&file.path)?;
        let hash = blake3::hash(&content).to_hex().to_string();
        if hash == file.blake3 && content.len() as u64 == file.bytes {
            return Ok(Ok(content));
        }
        if let Some(home) = self.by_hash.get(hash.as_str()).filter(|home| **home != file.path) {
            return found(Fault::Swapped, format!("it holds the content of `{home}`"));
        }
        let hashes = format!("BLAKE3 {hash} instead of {}", file.blake3);
        match content.len() as u64 {
            n if n < file.bytes => found(Fault::Truncated, format!("{n} bytes instead of {}, {hashes}", file.bytes)),
            n if n > file.bytes => found(Fault::Changed, format!("{n} bytes instead of {}, {hashes}", file.bytes)),
            _ => found(Fault::Changed, hashes),
        }
    }

    /// A file whose content follows from others.
    pub(super) fn derived_file(&self, path: &str, content: &[u8], from: &str) -> Result<Option<Finding>, StoreError> {
        Ok(self.content(&FileRecord::of(path.to_owned(), content, None))?.err().map(|f| {
            let detail =
                if f.fault == Fault::Missing { format!("{from} are complete, but it is not there") } else { f.detail };
            Finding::new(path, f.fault, detail)
        }))
    }

    /// A file that several records name.
    pub(super) fn shared_file(&self, name: &str, file: &FileRecord) -> Result<Option<Finding>, StoreError> {
        let content = match self.content(file)? {
            Ok(content) => content,
            Err(finding) => return Ok(Some(finding)),
        };
        if !matches!(name, "dsm" | "dtm" | "ndsm") {
            return Ok(None);
        }
        let contradiction = |detail: String| Ok(Some(Finding::new(&file.path, Fault::Contradiction, detail)));
        match decode_height_map(&content, most_cells(content.len())) {
            Err(e) => contradiction(e.to_string()),
            Ok(map) if Some(map.pixel_hash().to_hex().to_string()) != file.pixels_blake3 => {
                contradiction("its pixels have not the recorded hash".into())
            }
            Ok(_) => Ok(None),
        }
    }

    /// A sample's record and files, and whether its labels are what labels must be.
    pub(super) fn sample(&self, record: &SampleRecord, line: &str) -> Result<Vec<Finding>, StoreError> {
        let mut findings = Vec::new();
        let record_path = format!("{}/{SAMPLE}", record.id());
        findings.extend(self.derived_file(&record_path, line.as_bytes(), "the manifest and its files")?);
        let own = format!("{}/", record.id());
        let mut contents = BTreeMap::new();
        for (name, file) in record.files.iter().filter(|(_, f)| f.path.starts_with(&own)) {
            match self.content(file)? {
                Ok(content) => drop(contents.insert(name.as_str(), (file, content))),
                Err(finding) => findings.push(finding),
            }
        }
        if findings.is_empty() {
            findings.extend(labels(record, &contents));
        }
        Ok(findings)
    }
}

/// Decodes a sample whose files are all as recorded, and asks of it what the writer asked before writing.
fn labels(record: &SampleRecord, contents: &BTreeMap<&str, (&FileRecord, Vec<u8>)>) -> Vec<Finding> {
    let contradiction = |path: &str, detail: String| vec![Finding::new(path, Fault::Contradiction, detail)];
    let record_path = format!("{}/{SAMPLE}", record.id());
    let Some((camera_file, text)) = contents.get("camera") else {
        return contradiction(&record_path, "it names no camera file".into());
    };
    let camera = match parse_camera(&camera_file.path, &String::from_utf8_lossy(text)) {
        Ok(camera) => camera,
        Err(e) => return contradiction(&camera_file.path, e.to_string()),
    };
    if camera.baseline_m != record.identity.baseline_m || camera.azimuth_deg != record.identity.azimuth_deg {
        return contradiction(&camera_file.path, "its baseline or azimuth is not that of the record".into());
    }
    let mut planes = Vec::new();
    for (name, (file, content)) in contents.iter().filter(|(name, _)| **name != "camera") {
        let Some((layer, view)) = Layer::from_key(name) else {
            return contradiction(&file.path, format!("`{name}` is no layer of a sample"));
        };
        let plane = match decode_plane(file, content, &camera, layer, view) {
            Ok(plane) => plane,
            Err(e) => return contradiction(&file.path, e.to_string()),
        };
        if Some(plane.pixel_hash().to_hex().to_string()) != file.pixels_blake3 {
            return contradiction(&file.path, "its pixels have not the recorded hash".into());
        }
        planes.push((layer, view, plane));
    }
    let mut sample = sample_of(record, camera, planes);
    if let Err(e) = sample.check() {
        return contradiction(&format!("{}/{}", record.id(), e.file), e.what);
    }
    let statistics = match sample.count() {
        Ok(statistics) => statistics,
        Err(e) => return contradiction(&format!("{}/{}", record.id(), e.file), e.what),
    };
    let recorded = Statistics {
        valid_fraction: record.valid_fraction,
        occluded_fraction: record.occluded_fraction,
        out_of_frame_fraction: record.out_of_frame_fraction,
        disparity_range_px: record.disparity_min_px.zip(record.disparity_max_px).map(|(a, b)| [a, b]),
    };
    if statistics != recorded {
        return contradiction(
            &record_path,
            format!("its statistics are {recorded:?}, but its labels give {statistics:?}"),
        );
    }
    Vec::new()
}
