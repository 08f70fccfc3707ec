//! Joins what the parts of one plan wrote: the only place where records become parts, and parts the manifest.
//!
//! Scene by scene, and nothing but the scene at hand is in memory: what it takes does not grow with the dataset, and the
//! time grows with it in proportion.

use super::manifest::{MANIFEST, ManifestHash, PAGES, PART, ROOT_HASH, SAMPLE};
use super::record::{FileRecord, SampleRecord};
use super::store::{Store, StoreError};
use super::writer::{SceneContents, WriteError, check_standing, entries_of};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// What was joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joined {
    /// Of the manifest.
    pub root_hash: ManifestHash,
    /// How many samples it has.
    pub samples: u64,
}

/// Why parts cannot be joined.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JoinError {
    /// Some samples are not made yet.
    #[error(
        "{missing} of {samples} samples are missing, the first of them `{first}`: run the shards that have them again, or \
         generate without --shard, which makes what is missing; nothing was joined"
    )]
    Missing {
        /// How many.
        missing: u64,
        /// Of how many.
        samples: u64,
        /// The first in plan order.
        first: String,
    },
    /// Samples of one scene were made of different scenes.
    #[error(
        "`{path}` has BLAKE3 {one_hash} in the record of `{one}` and {other_hash} in that of `{other}`: the machines that made \
         them compute differently; remove the samples of one of them and run its shards again elsewhere"
    )]
    Contradiction {
        /// The file that both name.
        path: String,
        /// A sample.
        one: String,
        /// What its record says.
        one_hash: String,
        /// Another.
        other: String,
        /// What that record says.
        other_hash: String,
    },
    /// What stands cannot be read or written, or is not what it should be.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl From<StoreError> for JoinError {
    fn from(error: StoreError) -> Self {
        Self::Write(error.into())
    }
}

/// Writes every scene's part, the manifest and the root hash of a dataset whose samples all stand, on the current rayon
/// pool. `scenes` gives the plan's scenes in order, each time from the first. Where anything is missing or contradicts,
/// nothing is written. The caller holds the folder's lock.
///
/// # Errors
/// [`JoinError::Missing`] with how many, otherwise the first thing that is wrong.
pub fn join<I: Iterator<Item = SceneContents>>(
    store: &dyn Store,
    recipe_toml: &str,
    scenes: impl Fn() -> I,
) -> Result<Joined, JoinError> {
    let recipe = FileRecord::of(super::RECIPE.to_owned(), recipe_toml.as_bytes(), None);
    let (mut samples, mut missing, mut first) = (0, 0, None);
    for scene in scenes() {
        samples += scene.samples.len() as u64;
        let absent = absent(store, &scene)?;
        missing += absent.len() as u64;
        first = first.or_else(|| absent.into_iter().next());
    }
    if let Some(first) = first {
        return Err(JoinError::Missing { missing, samples, first });
    }
    for scene in scenes() {
        let part = part(store, &scene, &recipe)?;
        put_same(store, &format!("{}/{PART}", scene.name), &part)?;
    }
    let root_hash = put_manifest(store, &mut scenes().map(|scene| scene.name))?;
    Ok(Joined { root_hash, samples })
}

/// The samples of a scene that have no record.
fn absent(store: &dyn Store, scene: &SceneContents) -> Result<Vec<String>, StoreError> {
    let entries = entries_of(store, &scene.name)?;
    let ids = scene.samples.iter().map(|sample| format!("{}/{sample}", scene.name));
    Ok(ids.filter(|id| !entries.contains_key(&format!("{id}/{SAMPLE}"))).collect())
}

/// A scene's lines of the manifest, from the records of its samples.
fn part(store: &dyn Store, scene: &SceneContents, recipe: &FileRecord) -> Result<Vec<u8>, JoinError> {
    let mut entries = entries_of(store, &scene.name)?;
    entries.insert(recipe.path.clone(), Some(recipe.bytes));
    let ids: Vec<String> = scene.samples.iter().map(|sample| format!("{}/{sample}", scene.name)).collect();
    let records: Vec<SampleRecord> =
        ids.par_iter().map(|id| check_standing(store, id, &entries)).collect::<Result<_, _>>()?;
    // What several records name they must name alike, and of the recipe what it is.
    let mut shared: BTreeMap<&str, (&str, &FileRecord)> =
        BTreeMap::from([(recipe.path.as_str(), ("recipe.toml", recipe))]);
    let mut known: BTreeSet<String> = BTreeSet::from([recipe.path.clone(), format!("{}/{PART}", scene.name)]);
    let mut lines = Vec::new();
    for record in &records {
        let own = format!("{}/", record.id());
        for file in record.files.values().filter(|file| !file.path.starts_with(&own)) {
            let (one, first) = *shared.entry(&file.path).or_insert((record.id(), file));
            if first != file {
                return Err(JoinError::Contradiction {
                    path: file.path.clone(),
                    one: one.to_owned(),
                    one_hash: first.blake3.clone(),
                    other: record.id().to_owned(),
                    other_hash: file.blake3.clone(),
                });
            }
        }
        known.insert(format!("{own}{SAMPLE}"));
        known.extend(record.files.values().map(|file| file.path.clone()));
        lines.extend(record.to_line().into_bytes());
    }
    match entries.into_keys().find(|path| !known.contains(path) && !PAGES.contains(&path.as_str())) {
        Some(path) => Err(WriteError::Foreign { path }.into()),
        None => Ok(lines),
    }
}

/// Writes the manifest of the parts of these scenes, and after it its hash: with that the dataset is complete.
///
/// # Errors
/// Where another manifest stands there, or the store fails.
pub(super) fn put_manifest(
    store: &dyn Store,
    scenes: &mut dyn Iterator<Item = String>,
) -> Result<ManifestHash, WriteError> {
    let mut hasher = blake3::Hasher::new();
    let mut parts = scenes.map(|scene| {
        let part = store.get(&format!("{scene}/{PART}"))?;
        hasher.update(&part);
        Ok(part)
    });
    let put = store.put_chunks(MANIFEST, &mut parts);
    if let Err(StoreError::Exists { .. }) = put {
        // Whoever wrote it, and however far this one was read: it must be what the parts are.
        for part in parts {
            part?;
        }
        let new = hasher.finalize();
        let mut existing = blake3::Hasher::new();
        store.get_chunks(MANIFEST, &mut |piece| {
            existing.update(piece);
        })?;
        let existing = existing.finalize();
        if existing != new {
            let [existing, new] = [existing, new].map(|hash| hash.to_hex().to_string());
            return Err(WriteError::Differs { path: MANIFEST.to_owned(), existing, new });
        }
    } else {
        put?;
    }
    let hash = ManifestHash::from_hash(hasher.finalize());
    put_same(store, ROOT_HASH, hash.to_file().as_bytes())?;
    Ok(hash)
}

/// Puts a file that may stand already, with the same content.
///
/// # Errors
/// [`WriteError::Differs`] with both hashes where other content stands there.
pub fn put_same(store: &dyn Store, path: &str, bytes: &[u8]) -> Result<(), WriteError> {
    match store.put(path, bytes) {
        Err(StoreError::Exists { .. }) => {}
        done => return Ok(done?),
    }
    let existing = store.get(path)?;
    if existing == bytes {
        return Ok(());
    }
    let hash = |content: &[u8]| blake3::hash(content).to_hex().to_string();
    Err(WriteError::Differs { path: path.to_owned(), existing: hash(&existing), new: hash(bytes) })
}

/// Brings a scene's samples that stand in one store into another, each with its record last. What stands in both must be
/// the same. Says how many were there to bring.
///
/// # Errors
/// Where a file is not what its record says, or another one than what stands.
pub fn bring(from: &dyn Store, to: &dyn Store, scene: &SceneContents) -> Result<usize, WriteError> {
    let entries = entries_of(from, &scene.name)?;
    let ids: Vec<String> = scene.samples.iter().map(|sample| format!("{}/{sample}", scene.name)).collect();
    let standing: Vec<&String> = ids.iter().filter(|id| entries.contains_key(&format!("{id}/{SAMPLE}"))).collect();
    let mut shared = BTreeSet::new();
    for id in &standing {
        let record = check_standing(from, id, &entries)?;
        let own = format!("{id}/");
        let files: Vec<&FileRecord> =
            record.files.values().filter(|f| f.path.starts_with(&own) || shared.insert(f.path.clone())).collect();
        files.par_iter().try_for_each(|file| {
            let content = from.get(&file.path)?;
            let hash = blake3::hash(&content).to_hex().to_string();
            if hash != file.blake3 {
                let what = format!("`{}` has BLAKE3 {hash} instead of {}", file.path, file.blake3);
                return Err(WriteError::Damaged { id: (*id).clone(), what });
            }
            put_same(to, &file.path, &content)
        })?;
        put_same(to, &format!("{id}/{SAMPLE}"), record.to_line().as_bytes())?;
    }
    Ok(standing.len())
}
