//! Writes a dataset so that it can be stopped anywhere and taken up again.
//!
//! Order is everything here. `recipe.toml` comes first and says whose folder this is. A sample's files are put one by
//! one, then its record: from then on the sample stands and is never touched again. A scene's `part.jsonl` is the records
//! of its samples, and the manifest is the parts, both derived from what the records say and from nothing in memory.
//! Whatever the moment of a crash, what is missing is made by the same command again, and all bytes come out the same.

use super::formats::{FormatError, HeightMap, PixelKind, Plane, encode_height_map};
use super::layer::{Layer, View};
use super::manifest::{MANIFEST, ManifestHash, PAGES, PART, RECIPE, ROOT_HASH, SAMPLE};
use super::ownership::refusal;
use super::record::{FileRecord, SampleRecord};
use super::sample::{ContentError, Sample};
use super::store::{Store, StoreError};
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

/// Writes one dataset. It needs the folder's lock, which its caller holds.
pub struct Writer<'a> {
    store: &'a dyn Store,
    contents: Contents,
    recipe: FileRecord,
    /// Ids of the samples that stand.
    recorded: Mutex<BTreeSet<String>>,
    /// Records of the scenes' shared files, by scene.
    scenes: Mutex<BTreeMap<String, BTreeMap<String, FileRecord>>>,
}

impl<'a> Writer<'a> {
    /// Opens a store for a dataset: an empty one is begun, one with the same plan is taken up where it stopped.
    ///
    /// # Errors
    /// Where the store holds another plan, foreign files, or has lost what it had recorded.
    pub fn open(store: &'a dyn Store, contents: Contents) -> Result<Self, WriteError> {
        store.clear_unfinished()?;
        let entries: BTreeMap<String, Option<u64>> = store.list("")?.into_iter().map(|e| (e.path, e.bytes)).collect();
        if entries.contains_key(RECIPE) {
            let existing = store.get(RECIPE)?;
            if existing != contents.recipe_toml.as_bytes() {
                return Err(refusal(&String::from_utf8_lossy(&existing), &contents.recipe_toml));
            }
        } else if let Some(path) = entries.keys().next() {
            return Err(WriteError::Foreign { path: path.clone() });
        }
        let planned = contents.paths();
        if let Some(path) = entries
            .iter()
            .find(|(p, bytes)| !(planned.contains(*p) || PAGES.contains(&p.as_str())) || bytes.is_none())
            .map(|(p, _)| p)
        {
            return Err(WriteError::Foreign { path: path.clone() });
        }
        if !entries.contains_key(RECIPE) {
            store.put(RECIPE, contents.recipe_toml.as_bytes())?;
        }
        let recipe = FileRecord::of(RECIPE.to_owned(), contents.recipe_toml.as_bytes(), None);
        let mut recorded = BTreeSet::new();
        for id in contents.ids().filter(|id| entries.contains_key(&format!("{id}/{SAMPLE}"))) {
            check_standing(store, &id, &entries)?;
            recorded.insert(id);
        }
        Ok(Self { store, contents, recipe, recorded: Mutex::new(recorded), scenes: Mutex::default() })
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
        let Some(id) =
            locked(&self.recorded).range(below.clone()..).next().filter(|id| id.starts_with(&below)).cloned()
        else {
            return Ok(false);
        };
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

    /// Writes a scene's part where all its samples stand. Says whether they do.
    ///
    /// # Errors
    /// Where another part stands there, or the store fails.
    pub fn finish_scene(&self, scene: &str) -> Result<bool, WriteError> {
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
        let mut manifest = Vec::new();
        for scene in &self.contents.scenes {
            if !self.finish_scene(&scene.name)? {
                return Ok(None);
            }
            manifest.extend(self.store.get(&format!("{}/{PART}", scene.name))?);
        }
        let hash = ManifestHash::of(&manifest);
        self.put_again(MANIFEST, &manifest, false)?;
        self.put_again(ROOT_HASH, hash.to_file().as_bytes(), false)?;
        Ok(Some(hash))
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
        match self.store.put(path, bytes) {
            Err(StoreError::Exists { .. }) => {}
            done => return Ok(done?),
        }
        let existing = self.store.get(path)?;
        if existing == bytes {
            return Ok(());
        }
        let hash = |content: &[u8]| blake3::hash(content).to_hex().to_string();
        if !replaceable {
            return Err(WriteError::Differs { path: path.to_owned(), existing: hash(&existing), new: hash(bytes) });
        }
        self.store.discard(path)?;
        Ok(self.store.put(path, bytes)?)
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

/// The record of a sample that stands, held against the sizes of its files. Hashes are for `verify`.
fn check_standing(store: &dyn Store, id: &str, entries: &BTreeMap<String, Option<u64>>) -> Result<(), WriteError> {
    let damaged = |what: String| WriteError::Damaged { id: id.to_owned(), what };
    let text = String::from_utf8(store.get(&format!("{id}/{SAMPLE}"))?)
        .map_err(|_| damaged("its record is no text".into()))?;
    let record = SampleRecord::from_line(&text).map_err(|e| damaged(format!("of its record, {e}")))?;
    if record.id() != id || record.to_line() != text {
        return Err(damaged(format!("its record is that of `{}`, or was changed", record.id())));
    }
    for file in record.files.values() {
        match entries.get(&file.path) {
            Some(Some(bytes)) if *bytes == file.bytes => {}
            Some(_) => return Err(damaged(format!("`{}` has not the {} bytes that it had", file.path, file.bytes))),
            None => return Err(damaged(format!("`{}` is missing", file.path))),
        }
    }
    Ok(())
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
