//! From a name on the command line to a recipe: files, presets, seed lists and overrides, laid over each other.

use super::node::{self, Entry, Node, Table, Value};
use super::presets::{PRESETS, Preset};
use super::source::{Origin, RecipeError, Source, SourceKind, plain};
use super::{MAX_RECIPE_BYTES, Recipe, read, seed_list, set};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest seed list, bytes.
pub const MAX_SEED_LIST_BYTES: u64 = 4 << 20;
/// Longest chain of `extends`.
const MAX_EXTENDS: usize = 8;

/// What is changed of a recipe when it is loaded. Later ones win: recipe, seed list, seed, `set` in order.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// `key.path=value` each.
    pub set: Vec<String>,
    /// Replaces the recipe's seed.
    pub seed: Option<u64>,
    /// A seed list whose scenes replace the recipe's.
    pub seed_list: Option<PathBuf>,
}

impl Recipe {
    /// Loads a preset by its name, or a file by its path, with changes.
    pub fn load(recipe: &str, changes: &Changes) -> Result<Self, RecipeError> {
        let source = match Preset::by_name(recipe) {
            Some(preset) => preset_source(preset),
            None => recipe_file(recipe)?,
        };
        let list = changes.seed_list.as_deref().map(seed_list_file).transpose()?;
        Self::from_sources(&source, list.as_ref(), changes.seed, &changes.set)
    }

    /// Reads the text of a recipe; `name` is what messages call it.
    pub fn parse(name: &str, text: &str) -> Result<Self, RecipeError> {
        Self::parse_with(name, text, &[])
    }

    /// Reads the text of a recipe and lays `key.path=value`s over it.
    pub fn parse_with(name: &str, text: &str, set: &[String]) -> Result<Self, RecipeError> {
        Self::from_sources(&Source::new(name, text, SourceKind::File), None, None, set)
    }

    /// This recipe's text with the scenes of a seed list instead of its own; `name` is what messages call the list.
    pub fn parse_with_seed_list(recipe: &Preset, name: &str, list: &str) -> Result<Self, RecipeError> {
        let list = Source::new(name, list, SourceKind::File);
        Self::from_sources(&preset_source(recipe), Some(&list), None, &[])
    }

    fn from_sources(
        recipe: &Arc<Source>,
        list: Option<&Arc<Source>>,
        seed: Option<u64>,
        set: &[String],
    ) -> Result<Self, RecipeError> {
        let mut document = resolve(recipe, &|name| Preset::by_name(name).map(preset_source), &mut Vec::new())?;
        if let Some(list) = list {
            let scenes = seed_list::scenes_from(list)?;
            let key = scenes.origin.clone();
            document.0.insert("scene".to_owned(), Entry { key, node: scenes });
        }
        if let Some(seed) = seed {
            set::apply_seed(&mut document, seed);
        }
        for text in set {
            set::apply(&mut document, text)?;
        }
        read::recipe_from(document, Origin::beginning(recipe))
    }
}

fn preset_source(preset: &Preset) -> Arc<Source> {
    Source::new(format!("preset {}", preset.name), preset.text, SourceKind::File)
}

/// Parses a source and lays it over what it extends.
fn resolve(
    source: &Arc<Source>,
    preset: &dyn Fn(&str) -> Option<Arc<Source>>,
    chain: &mut Vec<String>,
) -> Result<Table, RecipeError> {
    let mut document = node::parse_document(source)?;
    let Some(Entry { node: Node { value, origin }, .. }) = document.0.remove("extends") else { return Ok(document) };
    let names = || PRESETS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
    let Value::Text(name) = value else {
        return Err(origin.error(format!("`extends` must be the name of a preset; presets are {}", names())));
    };
    let Some(base) = preset(&name) else {
        let name = plain(&name, 60);
        return Err(origin.error(format!("`extends` names \"{name}\", which is no preset; presets are {}", names())));
    };
    if chain.contains(&name) {
        return Err(origin.error(format!("`extends` runs in a circle: {} extends \"{name}\" again", chain.join(", "))));
    }
    if chain.len() >= MAX_EXTENDS {
        return Err(origin.error(format!("`extends` is nested deeper than {MAX_EXTENDS} presets")));
    }
    chain.push(name);
    let mut lower = resolve(&base, preset, chain)?;
    lower.lay_over(document);
    Ok(lower)
}

fn recipe_file(path: &str) -> Result<Arc<Source>, RecipeError> {
    let looks_like_a_file = path.contains(['/', '\\', '.']);
    if !looks_like_a_file && !Path::new(path).exists() {
        let names: Vec<_> = PRESETS.iter().map(|p| p.name).collect();
        let (path, names) = (plain(path, 100), names.join(", "));
        return Err(RecipeError::placeless(format!("`{path}` is neither a preset ({names}) nor a file")));
    }
    text_file(Path::new(path), "recipe", MAX_RECIPE_BYTES)
}

fn seed_list_file(path: &Path) -> Result<Arc<Source>, RecipeError> {
    text_file(path, "seed list", MAX_SEED_LIST_BYTES)
}

/// Reads at most `limit` bytes of UTF-8.
fn text_file(path: &Path, what: &str, limit: u64) -> Result<Arc<Source>, RecipeError> {
    let name = path.display().to_string();
    let failed = |e: std::io::Error| RecipeError::placeless(format!("cannot read {what} {}: {e}", plain(&name, 200)));
    let file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit {
        return Err(RecipeError::placeless(format!("{what} {name} is larger than {limit} bytes, which is the limit")));
    }
    String::from_utf8(bytes).map(|text| Source::new(name.clone(), text, SourceKind::File)).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let lossy = Source::new(name, String::from_utf8_lossy(e.as_bytes()), SourceKind::File);
        Origin::new(&lossy, at..at + '\u{fffd}'.len_utf8()).error(format!("a {what} must be UTF-8, this byte is not"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve_among(presets: &[(&str, &str)]) -> Result<Table, RecipeError> {
        let find = |name: &str| {
            let (name, text) = presets.iter().find(|(n, _)| *n == name)?;
            Some(Source::new(format!("preset {name}"), *text, SourceKind::File))
        };
        resolve(&find(presets[0].0).unwrap(), &find, &mut Vec::new())
    }

    #[test]
    fn circles_and_long_chains_are_refused() {
        let error = resolve_among(&[("a", "extends = 'b'"), ("b", "\n extends = 'c'"), ("c", "extends = 'b'")]);
        let error = error.unwrap_err();
        assert_eq!(error.line_column(), Some((1, 11)));
        assert!(error.message().contains("circle: b, c extends \"b\" again"), "{error}");
        let texts: Vec<_> = (0..20).map(|i| (format!("p{i}"), format!("extends = 'p{}'", i + 1))).collect();
        let chain: Vec<_> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        assert!(resolve_among(&chain).unwrap_err().message().contains("deeper than 8"));
    }

    #[test]
    fn tables_merge_lists_and_scenes_are_replaced() {
        let base = "seed = 1\n[camera]\ngsd_m = 0.3\nsize_px = [1, 2]\n[[scene]]\na = {}\n[[scene]]\nb = {}";
        let top = "extends = 'base'\nseed = 2\n[camera]\nsize_px = [3, 4]\n[[scene]]\nc = {}";
        let table = resolve_among(&[("top", top), ("base", base)]).unwrap();
        let Value::Table(camera) = &table.0["camera"].node.value else { panic!() };
        assert_eq!(camera.0.len(), 2);
        let Value::List(scenes) = &table.0["scene"].node.value else { panic!() };
        assert_eq!(scenes.len(), 1);
        assert!(!table.0.contains_key("extends"));
    }
}
