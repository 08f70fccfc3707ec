//! Holds a dataset against its own hashes and against what its labels must be.
//!
//! Every line of the manifest stands three times (sample record, part, manifest) and the root hash over all of them, so
//! that a single fault is always told from what it does not agree with. What the files say is then held against the
//! lines, byte by byte and pixel by pixel, and whatever is there beside is named too.

use super::formats::decode_height_map;
use super::manifest::{MANIFEST, ManifestHash, PART, RECIPE, ROOT_HASH, SAMPLE, parse_lines};
use super::reader::{decode_plane, most_cells, parse_camera, sample_of};
use super::record::{FileRecord, SampleRecord};
use super::sample::{Layer, Statistics};
use super::store::{Store, StoreError};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What is wrong with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// It should be there.
    Missing,
    /// It should not be there.
    Extra,
    /// It is shorter than recorded.
    Truncated,
    /// Its content is not what was recorded.
    Changed,
    /// It holds what another file of the dataset should hold.
    Swapped,
    /// Its content is as recorded, but contradicts itself or another file.
    Contradiction,
    /// It differs from what its seed makes.
    NotReproduced,
}

impl Fault {
    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Extra => "extra",
            Self::Truncated => "truncated",
            Self::Changed => "changed",
            Self::Swapped => "swapped",
            Self::Contradiction => "contradiction",
            Self::NotReproduced => "not-reproduced",
        }
    }
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Finding {
    /// Which file.
    pub path: String,
    /// What is wrong with it.
    pub fault: Fault,
    /// In words.
    pub detail: String,
}

impl Finding {
    pub(super) fn new(path: impl Into<String>, fault: Fault, detail: impl Into<String>) -> Self {
        Self { path: path.into(), fault, detail: detail.into() }
    }
}

/// What `verify` found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// Hash of the manifest that the dataset was held against; none where it has none yet.
    pub root_hash: Option<String>,
    /// Samples that were looked at.
    pub samples: usize,
    /// Samples that the plan has and the dataset has not yet.
    pub samples_to_make: usize,
    /// Files that were read.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Everything that is wrong, by path.
    pub findings: Vec<Finding>,
    /// What should be known but is no fault.
    pub notes: Vec<String>,
}

impl Report {
    /// Whether nothing is wrong.
    pub fn is_fine(&self) -> bool {
        self.findings.is_empty()
    }

    /// Adds what a further check found.
    pub fn add(&mut self, findings: Vec<Finding>) {
        self.findings.extend(findings);
        self.findings.sort();
        self.findings.dedup();
    }
}

/// Checks a dataset. `planned` is the ids of its plan in order, where `recipe.toml` can still be read.
///
/// # Errors
/// Where the store itself fails; what is wrong with the dataset is in the report.
pub fn verify(store: &dyn Store, planned: Option<&[String]>) -> Result<Report, StoreError> {
    let entries: BTreeMap<String, Option<u64>> = store.list("")?.into_iter().map(|e| (e.path, e.bytes)).collect();
    let mut report = Report {
        root_hash: None,
        samples: 0,
        samples_to_make: 0,
        files: 0,
        bytes: entries.values().flatten().sum(),
        findings: Vec::new(),
        notes: Vec::new(),
    };
    report.files = entries.len();
    let mut findings = Vec::new();
    let lines = trusted_lines(store, &entries, planned, &mut report, &mut findings)?;
    let mut records = Vec::new();
    for (id, line) in &lines {
        match SampleRecord::from_line(line) {
            Ok(record) if record.id == *id => records.push(record),
            Ok(record) => findings.push(Finding::new(
                format!("{id}/{SAMPLE}"),
                Fault::Contradiction,
                format!("it is the record of `{}`", record.id),
            )),
            Err(e) => findings.push(Finding::new(format!("{id}/{SAMPLE}"), Fault::Contradiction, e.to_string())),
        }
    }
    report.samples = records.len();

    let mut expected: BTreeSet<String> = [RECIPE, MANIFEST, ROOT_HASH].map(str::to_owned).into();
    let by_hash: BTreeMap<&str, &str> =
        records.iter().flat_map(|r| r.files.values()).map(|f| (f.blake3.as_str(), f.path.as_str())).collect();
    let checker = Checker { store, entries: &entries, by_hash };

    // Files that several records name: the recipe and those of the scenes. All must name them alike.
    let mut shared: BTreeMap<&str, (&str, &FileRecord)> = BTreeMap::new();
    for record in &records {
        let own = format!("{}/", record.id);
        for (name, file) in record.files.iter().filter(|(_, f)| !f.path.starts_with(&own)) {
            let (_, first) = shared.entry(&file.path).or_insert((name, file));
            if *first != file {
                let detail = format!("`{}` records another content of it than other samples do", record.id);
                findings.push(Finding::new(&file.path, Fault::Contradiction, detail));
            }
        }
    }
    for (name, file) in shared.values() {
        expected.insert(file.path.clone());
        findings.extend(checker.shared_file(name, file)?);
    }
    for (scene, part) in parts_of(&lines) {
        let path = format!("{scene}/{PART}");
        let planned_here = |id: &&String| id.split_once('/').is_some_and(|(s, _)| s == scene);
        let complete =
            planned.is_none_or(|ids| ids.iter().filter(planned_here).all(|id| lines.iter().any(|(i, _)| i == id)));
        if complete || entries.contains_key(&path) {
            findings.extend(checker.derived_file(&path, part.as_bytes(), "the records of its samples")?);
        }
        expected.insert(path);
    }
    for record in &records {
        expected.insert(format!("{}/{SAMPLE}", record.id));
        expected.extend(record.files.values().map(|f| f.path.clone()));
    }
    let per_sample: Result<Vec<_>, StoreError> = records
        .par_iter()
        .zip(lines.par_iter().map(|(_, l)| l))
        .map(|(record, line)| checker.sample(record, line))
        .collect();
    findings.extend(per_sample?.into_iter().flatten());

    for (path, bytes) in entries.iter().filter(|(path, _)| !expected.contains(*path)) {
        let unfinished = report.samples_to_make > 0 && planned.is_some_and(|ids| is_part_of_a_plan(path, ids));
        if bytes.is_some() && unfinished {
            report.notes.push(format!("`{path}` belongs to a sample that is not finished"));
            continue;
        }
        let what = if bytes.is_none() { "it is a link or no regular file" } else { "no record names it" };
        findings.push(Finding::new(path, Fault::Extra, what));
    }
    report.add(findings);
    Ok(report)
}

/// A file of a sample or scene that the plan has but no record names yet.
fn is_part_of_a_plan(path: &str, ids: &[String]) -> bool {
    if path.contains("/.") {
        return false;
    }
    ids.iter().any(|id| {
        let scene = id.split_once('/').map_or("", |(s, _)| s);
        path.strip_prefix(id.as_str()).is_some_and(|rest| rest.starts_with('/'))
            || ["scene.json", "dsm.tif", "dtm.tif", "ndsm.tif"].iter().any(|f| path == format!("{scene}/{f}"))
    })
}

type Lines = Vec<(String, String)>;

/// The lines that everything else is held against, by id: the manifest's own where it has its hash, otherwise what the
/// parts or records say, whichever has the hash.
fn trusted_lines(
    store: &dyn Store,
    entries: &BTreeMap<String, Option<u64>>,
    planned: Option<&[String]>,
    report: &mut Report,
    findings: &mut Vec<Finding>,
) -> Result<Lines, StoreError> {
    let read = |path: &str| -> Result<Option<String>, StoreError> {
        match entries.get(path) {
            Some(Some(_)) => Ok(Some(String::from_utf8_lossy(&store.get(path)?).into_owned())),
            _ => Ok(None),
        }
    };
    let manifest = read(MANIFEST)?;
    let root = read(ROOT_HASH)?;
    let is_root = |text: &str| root.as_deref() == Some(&ManifestHash::of(text.as_bytes()).to_file());

    // The order of samples: the plan's, or the manifest's own, or that of the folders.
    let listed = manifest.as_deref().and_then(|m| parse_lines(m).ok()).map(|r| r.into_iter().map(|r| r.id).collect());
    let ids: Vec<String> = match (planned, listed) {
        (Some(ids), _) => ids.to_vec(),
        (None, Some(ids)) => ids,
        (None, None) => {
            entries.keys().filter_map(|p| p.strip_suffix(&format!("/{SAMPLE}"))).map(str::to_owned).collect()
        }
    };
    let mut from_records = Vec::new();
    for id in &ids {
        if let Some(line) = read(&format!("{id}/{SAMPLE}"))? {
            from_records.push((id.clone(), line));
        }
    }
    let mut from_parts = String::new();
    let mut scenes: Vec<&str> = ids.iter().filter_map(|id| id.split_once('/')).map(|(s, _)| s).collect();
    scenes.dedup();
    for scene in scenes {
        from_parts.push_str(&read(&format!("{scene}/{PART}"))?.unwrap_or_default());
    }
    let joined: String = from_records.iter().map(|(_, line)| line.as_str()).collect();

    if manifest.is_none() && root.is_none() && (planned.is_none() || from_records.len() < ids.len()) {
        report.samples_to_make = planned.map_or(0, |ids| ids.len() - from_records.len());
        let missing = match planned {
            Some(ids) => {
                format!("{} of {} samples are made: run generate again to finish", from_records.len(), ids.len())
            }
            None => "this is no finished dataset".to_owned(),
        };
        findings.push(Finding::new(MANIFEST, Fault::Missing, missing));
        return Ok(from_records);
    }
    let candidates = [manifest.as_deref(), Some(joined.as_str()), Some(from_parts.as_str())];
    let trusted = candidates.into_iter().flatten().find(|text| is_root(text));
    match &manifest {
        None => {
            findings.push(Finding::new(
                MANIFEST,
                Fault::Missing,
                "all samples are recorded, but it is not there: run generate again to write it",
            ));
        }
        Some(m) if Some(m.as_str()) == trusted => {}
        Some(m) if trusted.is_none() && (*m == joined || *m == from_parts) => {}
        Some(m) => {
            let shorter = m.len() < joined.len() && joined.starts_with(m.as_str());
            let fault = if shorter { Fault::Truncated } else { Fault::Changed };
            findings.push(Finding::new(MANIFEST, fault, format!("it has not the hash that `{ROOT_HASH}` says")));
        }
    }
    match &root {
        None => findings.push(Finding::new(
            ROOT_HASH,
            Fault::Missing,
            "the manifest's hash is not there: run generate again to write it",
        )),
        Some(_) if trusted.is_some() => {}
        Some(_) => findings.push(Finding::new(
            ROOT_HASH,
            Fault::Changed,
            "it is not the hash of the manifest, parts or records",
        )),
    }
    let text = trusted.map_or_else(|| manifest.clone().unwrap_or_else(|| joined.clone()), str::to_owned);
    report.root_hash = Some(ManifestHash::of(text.as_bytes()).hex());
    let lines = match parse_lines(&text) {
        Ok(records) => records.into_iter().map(|r| r.id).zip(text.lines().map(|l| format!("{l}\n"))).collect(),
        Err(e) => {
            findings.push(Finding::new(MANIFEST, Fault::Contradiction, e.to_string()));
            from_records
        }
    };
    hold_against_plan(&lines, planned, findings);
    Ok(lines)
}

/// A manifest that agrees with its hash may still not be that of its recipe.
fn hold_against_plan(lines: &Lines, planned: Option<&[String]>, findings: &mut Vec<Finding>) {
    let Some(planned) = planned else { return };
    let has: BTreeSet<&str> = lines.iter().map(|(id, _)| id.as_str()).collect();
    let should: BTreeSet<&str> = planned.iter().map(String::as_str).collect();
    for id in should.difference(&has) {
        findings.push(Finding::new(
            format!("{id}/{SAMPLE}"),
            Fault::Missing,
            "the plan of `recipe.toml` has this sample",
        ));
    }
    for id in has.difference(&should) {
        findings.push(Finding::new(
            format!("{id}/{SAMPLE}"),
            Fault::Extra,
            "the plan of `recipe.toml` has no such sample",
        ));
    }
}

/// The text of every scene's part, in the manifest's order.
fn parts_of(lines: &Lines) -> Vec<(&str, String)> {
    let mut parts: Vec<(&str, String)> = Vec::new();
    for (id, line) in lines {
        let scene = id.split_once('/').map_or("", |(s, _)| s);
        match parts.last_mut() {
            Some((last, text)) if *last == scene => text.push_str(line),
            _ => parts.push((scene, line.clone())),
        }
    }
    parts
}

struct Checker<'a> {
    store: &'a dyn Store,
    entries: &'a BTreeMap<String, Option<u64>>,
    /// Where a content belongs.
    by_hash: BTreeMap<&'a str, &'a str>,
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
    fn derived_file(&self, path: &str, content: &[u8], from: &str) -> Result<Option<Finding>, StoreError> {
        Ok(self.content(&FileRecord::of(path.to_owned(), content, None))?.err().map(|f| {
            let detail =
                if f.fault == Fault::Missing { format!("{from} are complete, but it is not there") } else { f.detail };
            Finding::new(path, f.fault, detail)
        }))
    }

    fn shared_file(&self, name: &str, file: &FileRecord) -> Result<Option<Finding>, StoreError> {
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
    fn sample(&self, record: &SampleRecord, line: &str) -> Result<Vec<Finding>, StoreError> {
        let mut findings = Vec::new();
        let record_path = format!("{}/{SAMPLE}", record.id);
        findings.extend(self.derived_file(&record_path, line.as_bytes(), "the manifest and its files")?);
        let own = format!("{}/", record.id);
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
    let record_path = format!("{}/{SAMPLE}", record.id);
    let Some((camera_file, text)) = contents.get("camera") else {
        return contradiction(&record_path, "it names no camera file".into());
    };
    let camera = match parse_camera(&camera_file.path, &String::from_utf8_lossy(text)) {
        Ok(camera) => camera,
        Err(e) => return contradiction(&camera_file.path, e.to_string()),
    };
    if camera.baseline_m != record.baseline_m || camera.azimuth_deg != record.azimuth_deg {
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
        return contradiction(&format!("{}/{}", record.id, e.file), e.what);
    }
    let statistics = match sample.count() {
        Ok(statistics) => statistics,
        Err(e) => return contradiction(&format!("{}/{}", record.id, e.file), e.what),
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
