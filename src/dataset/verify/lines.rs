//! Which lines a dataset is held against: the manifest, its parts and the samples' records say the same three times.

use super::{Fault, Finding, Report};
use crate::dataset::manifest::{MANIFEST, ManifestHash, PART, ROOT_HASH, SAMPLE, parse_lines};
use crate::dataset::store::{Store, StoreError};
use std::collections::{BTreeMap, BTreeSet};

/// Ids and the manifest's lines.
pub(super) type Lines = Vec<(String, String)>;

/// The lines that everything else is held against, by id: the manifest's own where it has its hash, otherwise what the
/// parts or records say, whichever has the hash.
pub(super) fn trusted_lines(
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
    let listed =
        manifest.as_deref().and_then(|m| parse_lines(m).ok()).map(|r| r.into_iter().map(|r| r.identity.id).collect());
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
        Ok(records) => records.into_iter().map(|r| r.identity.id).zip(text.lines().map(|l| format!("{l}\n"))).collect(),
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
pub(super) fn parts_of(lines: &Lines) -> Vec<(&str, String)> {
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
