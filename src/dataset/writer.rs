//! Writes a dataset so that it can be stopped anywhere and taken up again.
//!
//! Order is everything here. `recipe.toml` comes first and says whose folder this is. A sample's files are put one by
//! one, then its record: from then on the sample stands and is never touched again. A scene's `part.jsonl` is the records
//! of its samples, and the manifest is the parts, both derived from what the records say and from nothing in memory.
//! Whatever the moment of a crash, what is missing is made by the same command again, and all bytes come out the same.

use super::formats::{FormatError, HeightMap, PixelKind, Plane, encode_height_map};
use super::join::{put_manifest, put_same};
use super::layer::{Layer, View};
use super::manifest::{MANIFEST, ManifestHash, PAGES, PART, RECIPE, ROOT_HASH, SAMPLE};
use super::ownership::refusal;
use super::record::{FileRecord, SampleRecord};
use super::sample::{ContentError, Sample};
use super::store::{Store, StoreError, UNFINISHED};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::PoisonError;

/// What a finished dataset holds, file by file: derived from a plan before anything is made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contents {
    /// The text of `recipe.toml`: the resolved recipe with the plan's hash and the versions of generators and stages.
    pub recipe_toml: String,
    /// Scenes in plan order.
    pub scenes: Vec<SceneContents>,
    /// Which arrays every sample has, of which kind.
    pub layers: Vec<(Layer, View, PixelKind)>,
}

/// What one scene's folder holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneContents {
    /// Its name, the folder.
    pub name: String,
    /// Its samples' names in plan order.
    pub samples: Vec<String>,
}

/// The files of a scene that all its samples share.
#[derive(Clone, Debug)]
pub struct SceneFiles {
    /// `scene.json`: parameters, height bounds, object table.
    pub scene_json: String,
    /// First surface from above.
    pub dsm: HeightMap,
    /// Bare ground.
    pub dtm: HeightMap,
    /// First surface above the ground.
    pub ndsm: HeightMap,
}

/// Why a dataset cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The store could not.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// An array cannot be encoded.
    #[error("`{path}`: {reason}")]
    Format {
        /// Which file.
        path: String,
        /// Why.
        reason: FormatError,
    },
    /// A sample contradicts itself.
    #[error("sample `{id}`: {reason}; this is a bug in satseed, nothing of the sample was recorded")]
    Content {
        /// Which sample.
        id: String,
        /// What.
        reason: ContentError,
    },
    /// The folder holds files that no dataset of this plan has.
    #[error("`{path}` stands in the folder, but is no part of this dataset: choose an empty folder, or remove it")]
    Foreign {
        /// Which file.
        path: String,
    },
    /// The folder belongs to another plan.
    #[error("the folder holds another dataset: {difference}; choose an empty folder, or run its own recipe again")]
    OtherPlan {
        /// The first line of `recipe.toml` that differs.
        difference: String,
    },
    /// The folder belongs to the same plan, but to a program that makes other bytes of it.
    #[error(
        "the folder was begun with version {standing} of {what}, but this one has version {own}, and bytes of both would \
         be mixed: go on with the program that began it, or choose an empty folder"
    )]
    OtherVersion {
        /// Of what: a stage, a generator or the program.
        what: String,
        /// The version that stands in the folder.
        standing: String,
        /// This program's.
        own: String,
    },
    /// A file that must be the same again is not.
    #[error(
        "`{path}` should be the same each time it is made, but BLAKE3 {existing} stands there and {new} was made now: \
         the file was changed, or the machine that made it computes differently"
    )]
    Differs {
        /// Which file.
        path: String,
        /// Hash of what stands.
        existing: String,
        /// Hash of what was made.
        new: String,
    },
    /// What was recorded is no longer there.
    #[error("sample `{id}` is recorded, but {what}: remove the folder `{id}` and run the same command again")]
    Damaged {
        /// Which sample.
        id: String,
        /// What is wrong.
        what: String,
    },
}

/// Writes one dataset, or a part of one. It needs the folder's lock, which its caller holds: alone for all of a dataset,
/// shared for a part.
pub struct Writer<'a> {
    store: &'a dyn Store,
    /// What it writes.
    contents: Contents,
    is_part: bool,
    recipe: FileRecord,
    /// Ids of the samples that stand.
    recorded: Mutex<BTreeSet<String>>,
    /// Of each scene, a sample of another part that stands.
    neighbours: BTreeMap<String, String>,
    /// Records of the scenes' shared files, by scene.
    scenes: Mutex<BTreeMap<String, BTreeMap<String, FileRecord>>>,
}

impl<'a> Writer<'a> {
    /// Opens a store for a dataset: an empty one is begun, one with the same plan is taken up where it stopped.
    ///
    /// # Errors
    /// Where the store holds another plan, foreign files, or has lost what it had recorded.
    pub fn open(store: &'a dyn Store, contents: Contents) -> Result<Self, WriteError> {
        if !store.is_shared() {
            store.clear_unfinished()?;
        }
        let entries = entries_of(store, "")?;
        own_recipe(store, &contents, &entries)?;
        let planned = contents.paths();
        let known = |path: &str| planned.contains(path) || PAGES.contains(&path);
        if let Some((path, _)) = entries.iter().find(|(path, bytes)| !known(path) || bytes.is_none()) {
            return Err(WriteError::Foreign { path: path.clone() });
        }
        Self::standing(store, contents, &entries, false)
    }

    /// Opens a store for a part of a dataset, which others may be writing other parts of: `contents` has the scenes and
    /// samples of this part only. Only their folders are looked at, and nothing is cleared.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_part(store: &'a dyn Store, contents: Contents) -> Result<Self, WriteError> {
        let mut entries = match store.get(RECIPE) {
            Err(StoreError::NotFound { .. }) => entries_of(store, "")?,
            Err(other) => return Err(other.into()),
            Ok(_) => BTreeMap::from([(RECIPE.to_owned(), Some(0))]),
        };
        own_recipe(store, &contents, &entries)?;
        for scene in &contents.scenes {
            entries.extend(entries_of(store, &scene.name)?);
        }
        Self::standing(store, contents, &entries, true)
    }

    /// A writer that knows what stands.
    fn standing(
        store: &'a dyn Store,
        contents: Contents,
        entries: &BTreeMap<String, Option<u64>>,
        is_part: bool,
    ) -> Result<Self, WriteError> {
        let recipe = FileRecord::of(RECIPE.to_owned(), contents.recipe_toml.as_bytes(), None);
        let ids: Vec<String> = contents.ids().filter(|id| entries.contains_key(&format!("{id}/{SAMPLE}"))).collect();
        ids.par_iter().try_for_each(|id| check_standing(store, id, entries).map(|_| ()))?;
        let mut neighbours = BTreeMap::new();
        for id in entries.keys().filter_map(|path| path.strip_suffix(SAMPLE)?.strip_suffix('/')) {
            if let Some((scene, _)) = id.split_once('/') {
                neighbours.entry(scene.to_owned()).or_insert_with(|| id.to_owned());
            }
        }
        let recorded = Mutex::new(ids.into_iter().collect());
        Ok(Self { store, contents, is_part, recipe, recorded, neighbours, scenes: Mutex::default() })
    }

    /// Whether a sample stands already.
    pub fn is_recorded(&self, id: &str) -> bool {
        locked(&self.recorded).contains(id)
    }

    /// How many samples stand.
    pub fn recorded(&self) -> usize {
        locked(&self.recorded).len()
    }

    /// Writes a scene's shared files, or finds them as they must be. It comes before the scene's samples.
    ///
    /// # Errors
    /// Where a recorded sample names other content, or the store fails.
    pub fn put_scene(&self, scene: &str, files: &SceneFiles) -> Result<(), WriteError> {
        let mut made = vec![("scene", MadeFile::text(format!("{scene}/scene.json"), &files.scene_json))];
        let maps: Vec<_> = [("dsm", &files.dsm), ("dtm", &files.dtm), ("ndsm", &files.ndsm)]
            .into_par_iter()
            .map(|(name, map)| Ok((name, MadeFile::heights(format!("{scene}/{name}.tif"), map)?)))
            .collect::<Result<_, WriteError>>()?;
        made.extend(maps);
        let below = format!("{scene}/");
        let named = locked(&self.recorded).iter().any(|id| id.starts_with(&below));
        let mut shared = BTreeMap::new();
        for (name, file) in made {
            self.put_again(&file.path, &file.bytes, !named)?;
            shared.insert(name.to_owned(), file.record());
        }
        locked(&self.scenes).insert(scene.to_owned(), shared);
        Ok(())
    }

    /// Takes a scene's shared files as they stand where a recorded sample of the scene names them, and says whether one
    /// does: they need not be made again, which for a large scene takes longer than many of its pairs.
    ///
    /// # Errors
    /// Where that record cannot be read.
    pub fn adopt_scene(&self, scene: &str) -> Result<bool, WriteError> {
        let below = format!("{scene}/");
        let own = locked(&self.recorded).range(below.clone()..).next().filter(|id| id.starts_with(&below)).cloned();
        let Some(id) = own.or_else(|| self.neighbours.get(scene).cloned()) else { return Ok(false) };
        let text = String::from_utf8_lossy(&self.store.get(&format!("{id}/{SAMPLE}"))?).into_owned();
        let record = SampleRecord::from_line(&text)
            .map_err(|e| WriteError::Damaged { id, what: format!("of its record, {e}") })?;
        let shared =
            record.files.into_iter().filter(|(name, _)| matches!(name.as_str(), "scene" | "dsm" | "dtm" | "ndsm"));
        locked(&self.scenes).insert(scene.to_owned(), shared.collect());
        Ok(true)
    }

    /// Writes a sample's files and then its record.
    ///
    /// # Errors
    /// Where the sample contradicts itself or the store fails; the sample is then not recorded.
    pub fn put_sample(&self, mut sample: Sample) -> Result<SampleRecord, WriteError> {
        let id = sample.identity.id.clone();
        let content = |reason| WriteError::Content { id: id.clone(), reason };
        let statistics = sample.count().map_err(content)?;
        sample.check().map_err(content)?;

        let camera = MadeFile::text(format!("{id}/camera.json"), &to_json(&sample.camera));
        let arrays: Vec<_> = sample
            .planes
            .par_iter()
            .map(|(layer, view, plane)| {
                let file = MadeFile::array(format!("{id}/{}", layer.file_name(*view, plane.kind())), plane)?;
                Ok((layer.key(*view), file))
            })
            .collect::<Result<_, WriteError>>()?;
        let mut files = locked(&self.scenes).get(sample.identity.scene()).cloned().unwrap_or_default();
        files.insert("recipe".to_owned(), self.recipe.clone());
        for (name, file) in arrays.into_iter().chain([("camera".to_owned(), camera)]) {
            self.put_again(&file.path, &file.bytes, true)?;
            files.insert(name, file.record());
        }
        let record = SampleRecord::new(sample.identity, &statistics, files);
        self.put_again(&format!("{id}/{SAMPLE}"), record.to_line().as_bytes(), false)?;
        locked(&self.recorded).insert(id);
        Ok(record)
    }

    /// Writes a scene's part where all its samples stand. Says whether they do. A part of a dataset is no place for that:
    /// what several writers made is joined by [`join`](super::join).
    ///
    /// # Errors
    /// Where another part stands there, or the store fails.
    pub fn finish_scene(&self, scene: &str) -> Result<bool, WriteError> {
        if self.is_part {
            return Ok(false);
        }
        let contents = self.contents.scenes.iter().find(|s| s.name == scene);
        let Some(part) = contents.map(|s| self.part(s)).transpose()?.flatten() else { return Ok(false) };
        self.put_again(&format!("{scene}/{PART}"), &part, false)?;
        Ok(true)
    }

    /// Writes the manifest and the dataset's root hash where all scenes are complete, and gives that hash.
    ///
    /// # Errors
    /// Where another manifest stands there, or the store fails.
    pub fn finish(&self) -> Result<Option<ManifestHash>, WriteError> {
        for scene in &self.contents.scenes {
            if !self.finish_scene(&scene.name)? {
                return Ok(None);
            }
        }
        put_manifest(self.store, &mut self.contents.scenes.iter().map(|scene| scene.name.clone())).map(Some)
    }

    /// The records of a scene's samples as they stand in the store, if all do.
    fn part(&self, scene: &SceneContents) -> Result<Option<Vec<u8>>, StoreError> {
        let ids: Vec<String> = scene.samples.iter().map(|s| format!("{}/{s}", scene.name)).collect();
        if !ids.iter().all(|id| self.is_recorded(id)) {
            return Ok(None);
        }
        let lines: Vec<_> = ids.iter().map(|id| self.store.get(&format!("{id}/{SAMPLE}"))).collect::<Result<_, _>>()?;
        Ok(Some(lines.concat()))
    }

    /// Puts a file that an earlier run may have put already. The same content is fine. Other content is an error, except
    /// where no record names the file yet (`replaceable`): then nobody was promised it, it is what a machine that lost
    /// its power kept of a file, and it is made anew.
    fn put_again(&self, path: &str, bytes: &[u8], replaceable: bool) -> Result<(), WriteError> {
        match put_same(self.store, path, bytes) {
            Err(WriteError::Differs { .. }) if replaceable && !self.is_part && !self.store.is_shared() => {
                self.store.discard(path)?;
                Ok(self.store.put(path, bytes)?)
            }
            done => done,
        }
    }
}

/// A file that is ready to be put.
struct MadeFile {
    path: String,
    bytes: Vec<u8>,
    pixels: Option<blake3::Hash>,
}

impl MadeFile {
    fn text(path: String, text: &str) -> Self {
        Self { path, bytes: text.as_bytes().to_vec(), pixels: None }
    }

    fn array(path: String, plane: &Plane) -> Result<Self, WriteError> {
        match plane.encode() {
            Ok(bytes) => Ok(Self { path, bytes, pixels: Some(plane.pixel_hash()) }),
            Err(reason) => Err(WriteError::Format { path, reason }),
        }
    }

    fn heights(path: String, map: &HeightMap) -> Result<Self, WriteError> {
        match encode_height_map(map) {
            Ok(bytes) => Ok(Self { path, bytes, pixels: Some(map.pixel_hash()) }),
            Err(reason) => Err(WriteError::Format { path, reason }),
        }
    }

    fn record(self) -> FileRecord {
        FileRecord::of(self.path, &self.bytes, self.pixels)
    }
}

impl Contents {
    /// All samples' ids in plan order.
    pub fn ids(&self) -> impl Iterator<Item = String> {
        self.scenes.iter().flat_map(|scene| scene.samples.iter().map(move |s| format!("{}/{s}", scene.name)))
    }

    /// Every path that the finished dataset has.
    pub fn paths(&self) -> BTreeSet<String> {
        let mut paths: BTreeSet<String> = [RECIPE, MANIFEST, ROOT_HASH].map(str::to_owned).into();
        for scene in &self.scenes {
            paths.extend(["scene.json", "dsm.tif", "dtm.tif", "ndsm.tif", PART].map(|f| format!("{}/{f}", scene.name)));
        }
        for id in self.ids() {
            paths.extend([SAMPLE, "camera.json"].map(|f| format!("{id}/{f}")));
            let name =
                |(layer, view, kind): &(Layer, View, PixelKind)| format!("{id}/{}", layer.file_name(*view, *kind));
            paths.extend(self.layers.iter().map(name));
        }
        paths
    }
}

/// The files at or below a folder that are not just being written, with their sizes.
pub(super) fn entries_of(store: &dyn Store, prefix: &str) -> Result<BTreeMap<String, Option<u64>>, StoreError> {
    let finished = |path: &str| !path.rsplit('/').next().is_some_and(|name| name.starts_with(UNFINISHED));
    Ok(store.list(prefix)?.into_iter().filter(|e| finished(&e.path)).map(|e| (e.path, e.bytes)).collect())
}

/// Makes a store that of a recipe, or finds that it is.
fn own_recipe(
    store: &dyn Store,
    contents: &Contents,
    entries: &BTreeMap<String, Option<u64>>,
) -> Result<(), WriteError> {
    let own = contents.recipe_toml.as_bytes();
    if !entries.contains_key(RECIPE) {
        if let Some(path) = entries.keys().next() {
            return Err(WriteError::Foreign { path: path.clone() });
        }
        match store.put(RECIPE, own) {
            Err(StoreError::Exists { .. }) => {}
            done => return Ok(done?),
        }
    }
    same_recipe(store, &contents.recipe_toml)
}

/// Whether a store is that of a recipe.
///
/// # Errors
/// Where it holds another one, with the first thing that differs.
pub fn same_recipe(store: &dyn Store, recipe_toml: &str) -> Result<(), WriteError> {
    let existing = store.get(RECIPE)?;
    if existing == recipe_toml.as_bytes() {
        return Ok(());
    }
    Err(refusal(&String::from_utf8_lossy(&existing), recipe_toml))
}

/// The record of a sample that stands, held against the sizes of its files. Hashes are for `verify`.
pub(super) fn check_standing(
    store: &dyn Store,
    id: &str,
    entries: &BTreeMap<String, Option<u64>>,
) -> Result<SampleRecord, WriteError> {
    let damaged = |what: String| WriteError::Damaged { id: id.to_owned(), what };
    let text = String::from_utf8(store.get(&format!("{id}/{SAMPLE}"))?)
        .map_err(|_| damaged("its record is no text".into()))?;
    let record = SampleRecord::from_line(&text).map_err(|e| damaged(format!("of its record, {e}")))?;
    if record.id() != id || record.to_line() != text {
        return Err(damaged(format!("its record is that of `{}`, or was changed", record.id())));
    }
    for (name, file) in &record.files {
        match entries.get(&file.path) {
            // The recipe's text is compared as a whole.
            _ if name == "recipe" => {}
            Some(Some(bytes)) if *bytes == file.bytes => {}
            Some(_) => return Err(damaged(format!("`{}` has not the {} bytes that it had", file.path, file.bytes))),
            None => return Err(damaged(format!("`{}` is missing", file.path))),
        }
    }
    Ok(record)
}

/// JSON as the dataset holds it: indented, with a final line end.
pub fn to_json<T: serde::Serialize>(value: &T) -> String {
    let mut text = serde_json::to_string_pretty(value).expect("a record is plain data with text keys");
    text.push('\n');
    text
}

/// Every change under these locks is one insert, so a panic elsewhere leaves them whole.
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
