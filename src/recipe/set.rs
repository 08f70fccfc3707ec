//! `key.path=value`: overrides of the command line, and the parameters of a seed list's line.

use super::node::{self, Entry, Node, Table, Value};
use super::source::{Origin, RecipeError, Source, SourceKind, plain};
use satseed_generators::Region;
use std::ops::Range;
use std::sync::Arc;

/// One `key.path=value`.
pub(super) struct Assignment {
    /// The parts of the key, at least one.
    keys: Vec<(String, Origin)>,
    value: Node,
}

/// Deepest key path.
const MAX_KEY_PARTS: usize = 8;

impl Assignment {
    /// Parses `source.text[span]`.
    pub(super) fn parse(source: &Arc<Source>, span: Range<usize>) -> Result<Self, RecipeError> {
        let text = &source.text[span.clone()];
        let origin = Origin::new(source, span.clone());
        let Some((path, value)) = text.split_once('=') else {
            let message = format!("`{}` is not KEY=VALUE, such as camera.gsd_m=0.5", plain(text, 60));
            return Err(origin.error(message));
        };
        let mut keys = Vec::new();
        let mut at = span.start;
        for part in path.split('.') {
            let lead = part.len() - part.trim_start().len();
            let name = part.trim();
            let place = Origin::new(source, at + lead..at + lead + name.len());
            if name.is_empty() || !name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-') {
                let message = format!("`{}` is not a key path such as camera.gsd_m", plain(path, 60));
                return Err(place.error(message));
            }
            keys.push((name.to_owned(), place));
            at += part.len() + 1;
        }
        if keys.len() > MAX_KEY_PARTS {
            return Err(origin.error(format!("a key path has at most {MAX_KEY_PARTS} parts, found {}", keys.len())));
        }
        let start = span.end - value.len();
        if value.trim().is_empty() {
            return Err(Origin::new(source, start..span.end).error("nothing stands after `=`"));
        }
        Ok(Self { keys, value: node::parse_value(source, value, start)? })
    }

    /// Name of the whole key.
    fn name(&self) -> String {
        self.keys.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(".")
    }

    /// The tables that the path after its first `skip` parts stands for, down to the value.
    fn nested(&self, skip: usize) -> Table {
        let mut node = self.value.clone();
        for (name, origin) in self.keys[skip + 1..].iter().rev() {
            let entry = Entry { key: origin.clone(), node };
            node = Node { value: Value::Table(Table([(name.clone(), entry)].into())), origin: origin.clone() };
        }
        let (name, origin) = &self.keys[skip];
        Table([(name.clone(), Entry { key: origin.clone(), node })].into())
    }

    /// Lays the value into a table of parameters; an error where it is there already.
    pub(super) fn add_to(&self, table: &mut Table) -> Result<(), RecipeError> {
        if contains(table, &self.keys) {
            let (_, origin) = &self.keys[0];
            return Err(origin.error(format!("`{}` stands twice in this line", self.name())));
        }
        table.lay_over(self.nested(0));
        Ok(())
    }

    /// Lays the value over a whole document.
    fn override_in(self, document: &mut Table) -> Result<(), RecipeError> {
        let (first, first_origin) = &self.keys[0];
        match first.as_str() {
            "extends" => {
                Err(first_origin.error("`extends` stands in a file only: name the preset as RECIPE and set keys of it"))
            }
            "scene" if self.keys.len() > 1 => self.override_scenes(document),
            _ => {
                document.lay_over(self.nested(0));
                Ok(())
            }
        }
    }

    /// `scene.canyon.relief_m=150` and `scene.canyon.pivots=3` change every canyon entry, `scene.pivots=3` all entries.
    fn override_scenes(&self, document: &mut Table) -> Result<(), RecipeError> {
        let (second, origin) = &self.keys[1];
        let no_region = || {
            let regions = Region::NAMES.join(", ");
            origin.error(format!("after `scene` comes pivots or a region, found `{second}`; regions are {regions}"))
        };
        let of_entry = |key: &str| matches!(key, "pivots" | "seeds");
        if !of_entry(second) && !Region::NAMES.contains(&second.as_str()) {
            return Err(no_region());
        }
        let skip = match self.keys.get(2) {
            Some((third, _)) if self.keys.len() == 3 && of_entry(third) => 2,
            _ => 1,
        };
        let scenes = match document.0.get_mut("scene") {
            Some(Entry { node: Node { value: Value::List(scenes), .. }, .. }) => scenes.as_mut_slice(),
            _ => &mut [],
        };
        let mut found = false;
        for scene in scenes {
            let Value::Table(table) = &mut scene.value else { continue };
            if of_entry(second) || table.0.contains_key(second) {
                table.lay_over(self.nested(skip));
                found = true;
            }
        }
        if found { Ok(()) } else { Err(origin.error(format!("no `[[scene]]` of this recipe is a {second}"))) }
    }
}

fn contains(table: &Table, keys: &[(String, Origin)]) -> bool {
    let Some(((name, _), rest)) = keys.split_first() else { return true };
    match table.0.get(name) {
        Some(Entry { node: Node { value: Value::Table(inner), .. }, .. }) if !rest.is_empty() => contains(inner, rest),
        found => found.is_some(),
    }
}

/// Lays one `--set` over a document.
pub(super) fn apply(document: &mut Table, text: &str) -> Result<(), RecipeError> {
    let source = Source::new(format!("--set {text}"), text, SourceKind::Argument);
    Assignment::parse(&source, 0..text.len())?.override_in(document)
}

/// Lays `--seed` over a document.
pub(super) fn apply_seed(document: &mut Table, seed: u64) {
    let source = Source::new("--seed", seed.to_string(), SourceKind::Argument);
    let origin = Origin::new(&source, 0..source.text.len());
    let node = Node { value: Value::Integer(i128::from(seed)), origin: origin.clone() };
    document.0.insert("seed".to_owned(), Entry { key: origin, node });
}
