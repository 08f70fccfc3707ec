//! Holds a dataset against its own hashes and against what its labels must be.
//!
//! Every line of the manifest stands three times (sample record, part, manifest) and the root hash over all of them, so
//! that a single fault is always told from what it does not agree with. What the files say is then held against the
//! lines, byte by byte and pixel by pixel, and whatever is there beside is named too.

mod files;
mod lines;
mod report;

pub use report::{Fault, Finding, Report};

use super::manifest::{CARD, CROISSANT, GALLERY, MANIFEST, PAGES, PART, RECIPE, ROOT_HASH, SAMPLE};
use super::record::{FileRecord, SampleRecord};
use super::seal::Seal;
use super::store::{Store, StoreError};
use files::Checker;
use lines::{parts_of, trusted_lines};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

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
            Ok(record) if record.id() == id => records.push(record),
            Ok(record) => findings.push(Finding::new(
                format!("{id}/{SAMPLE}"),
                Fault::Contradiction,
                format!("it is the record of `{}`", record.id()),
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
        let own = format!("{}/", record.id());
        for (name, file) in record.files.iter().filter(|(_, f)| !f.path.starts_with(&own)) {
            let (_, first) = shared.entry(&file.path).or_insert((name, file));
            if *first != file {
                let detail = format!("`{}` records another content of it than other samples do", record.id());
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
        expected.insert(format!("{}/{SAMPLE}", record.id()));
        expected.extend(record.files.values().map(|f| f.path.clone()));
    }
    let per_sample: Result<Vec<_>, StoreError> = records
        .par_iter()
        .zip(lines.par_iter().map(|(_, l)| l))
        .map(|(record, line)| checker.sample(record, line))
        .collect();
    findings.extend(per_sample?.into_iter().flatten());

    expected.extend(PAGES.iter().filter(|p| entries.get(**p).is_some_and(Option::is_some)).map(|p| (*p).to_owned()));
    findings.extend(pages(store, &entries, report.root_hash.as_deref())?);

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

/// What is wrong with the pages that follow from the dataset. They may be missing.
fn pages(
    store: &dyn Store,
    entries: &BTreeMap<String, Option<u64>>,
    root_hash: Option<&str>,
) -> Result<Vec<Finding>, StoreError> {
    let there = |page: &str| entries.get(page).is_some_and(Option::is_some);
    let mut findings = Vec::new();
    let mut card = None;
    for page in [GALLERY, CARD].into_iter().filter(|page| there(page)) {
        const AGAIN: &str = "remove it, and generate makes it again";
        let content = store.get(page)?;
        match Seal::of(&content) {
            None => {
                let detail = format!("it is not what its last line says: {AGAIN}");
                findings.push(Finding::new(page, Fault::Changed, detail));
            }
            Some(seal) if root_hash.is_some_and(|hash| hash != seal.root_hash) => {
                let detail = format!("it shows another dataset: {AGAIN}");
                findings.push(Finding::new(page, Fault::Contradiction, detail));
            }
            Some(_) if page == CARD => card = Some(content),
            Some(_) => {}
        }
    }
    if there(CROISSANT) {
        let hash = blake3::hash(&store.get(CROISSANT)?).to_hex();
        let named = |card: &Vec<u8>| String::from_utf8_lossy(card).contains(hash.as_str());
        if !card.as_ref().is_some_and(named) {
            let detail =
                format!("`{CARD}` does not hold its BLAKE3 {hash}: remove both, and generate makes them again");
            findings.push(Finding::new(CROISSANT, Fault::Changed, detail));
        }
    }
    Ok(findings)
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
