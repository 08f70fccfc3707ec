//! Takes typed, range-checked values out of a table and refuses what is left over.

use super::node::{Entry, Node, Table, Value};
use super::source::{Origin, RecipeError, plain};
use std::ops::RangeInclusive;

/// A table that is being read. Every key that is asked for is taken; [`Reader::finish`] refuses the rest.
pub(super) struct Reader {
    /// Path of the table, such as `camera`; empty at the root.
    path: String,
    table: Table,
    /// Where the table stands: for keys that are missing.
    pub(super) origin: Origin,
    /// Keys asked for, for the message about unknown ones.
    known: Vec<&'static str>,
}

impl Reader {
    pub(super) fn root(table: Table, origin: Origin) -> Self {
        Self { path: String::new(), table, origin, known: Vec::new() }
    }

    /// Reads `node` as a table; `path` names it.
    pub(super) fn of(path: &str, node: Node) -> Result<Self, RecipeError> {
        match node.value {
            Value::Table(table) => Ok(Self { path: path.to_owned(), table, origin: node.origin, known: Vec::new() }),
            _ => Err(wrong(path, &node, "a table")),
        }
    }

    /// The full name of a key of this table.
    pub(super) fn name(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    pub(super) fn take(&mut self, key: &'static str) -> Option<Node> {
        self.known.push(key);
        self.table.0.remove(key).map(|entry| entry.node)
    }

    /// The one entry that is left, taken whatever its key is.
    pub(super) fn take_rest(&mut self) -> Vec<(String, Entry)> {
        std::mem::take(&mut self.table.0).into_iter().collect()
    }

    /// A number with its place.
    pub(super) fn number(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
    ) -> Result<Option<(f64, Origin)>, RecipeError> {
        let name = self.name(key);
        self.take(key).map(|node| Ok((number(&name, &node, range)?, node.origin))).transpose()
    }

    /// A number, or the default.
    pub(super) fn number_or(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
        default: f64,
    ) -> Result<f64, RecipeError> {
        Ok(self.number(key, range)?.map_or(default, |(x, _)| x))
    }

    /// A number that has to be there.
    pub(super) fn required(&mut self, key: &'static str, range: RangeInclusive<f64>) -> Result<f64, RecipeError> {
        match self.number(key, range)? {
            Some((x, _)) => Ok(x),
            None => Err(self.missing(key)),
        }
    }

    /// A whole number with its place.
    pub(super) fn whole(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u64>,
    ) -> Result<Option<(u64, Origin)>, RecipeError> {
        let name = self.name(key);
        self.take(key).map(|node| Ok((whole(&name, &node, range)?, node.origin))).transpose()
    }

    /// One of a set of words.
    pub(super) fn word<T: Copy>(&mut self, key: &'static str, words: &[(&str, T)]) -> Result<Option<T>, RecipeError> {
        let name = self.name(key);
        self.take(key).map(|node| word(&name, &node, words)).transpose()
    }

    /// A table within this one, empty where it is missing.
    pub(super) fn table(&mut self, key: &'static str) -> Result<Self, RecipeError> {
        let name = self.name(key);
        match self.take(key) {
            Some(node) => Self::of(&name, node),
            None => Ok(Self { path: name, table: Table::default(), origin: self.origin.clone(), known: Vec::new() }),
        }
    }

    /// That a key is missing.
    pub(super) fn missing(&self, key: &str) -> RecipeError {
        self.origin.error(format!("`{}` is missing", self.name(key)))
    }

    /// Refuses what nobody asked for.
    pub(super) fn finish(self) -> Result<(), RecipeError> {
        let Some((key, entry)) = self.table.0.first_key_value() else { return Ok(()) };
        let place = if self.path.is_empty() { String::new() } else { format!(" in `{}`", self.path) };
        let key = plain(key, 60);
        Err(entry.key.error(format!("unknown key `{key}`{place}, known are {}", self.known.join(", "))))
    }
}

/// That a value is of the wrong kind.
pub(super) fn wrong(name: &str, node: &Node, expected: &str) -> RecipeError {
    node.origin.error(format!("`{name}` must be {expected}, found {}", node.describe()))
}

/// A number within a range.
pub(super) fn number(name: &str, node: &Node, range: RangeInclusive<f64>) -> Result<f64, RecipeError> {
    let x = match node.value {
        Value::Float(x) => x,
        Value::Integer(i) => i as f64,
        _ => {
            let (low, high) = range.into_inner();
            return Err(wrong(name, node, &format!("a number in {low} to {high}{}", unit_of(name))));
        }
    };
    if range.contains(&x) {
        return Ok(x);
    }
    let (low, high) = range.into_inner();
    let unit = unit_of(name);
    Err(node.origin.error(format!("`{name}` is {}, but must lie in {low} to {high}{unit}", node.describe())))
}

/// A whole number within a range.
pub(super) fn whole(name: &str, node: &Node, range: RangeInclusive<u64>) -> Result<u64, RecipeError> {
    let (low, high) = (*range.start(), *range.end());
    match node.value {
        Value::Integer(i) => match u64::try_from(i) {
            Ok(n) if range.contains(&n) => Ok(n),
            _ => Err(node.origin.error(format!("`{name}` is {i}, but must lie in {low} to {high}"))),
        },
        _ => Err(wrong(name, node, &format!("a whole number in {low} to {high}"))),
    }
}

/// One of a set of words.
pub(super) fn word<T: Copy>(name: &str, node: &Node, words: &[(&str, T)]) -> Result<T, RecipeError> {
    let found = match &node.value {
        Value::Text(text) => words.iter().find(|(w, _)| w == text).map(|(_, value)| *value),
        _ => None,
    };
    found.ok_or_else(|| {
        let list: Vec<_> = words.iter().map(|(w, _)| format!("\"{w}\"")).collect();
        wrong(name, node, &list.join(" or "))
    })
}

/// The unit that a key's name carries, for messages.
pub(super) fn unit_of(name: &str) -> &'static str {
    let name = name.split('[').next().unwrap_or(name);
    let last = name.rsplit('.').find(|part| !matches!(*part, "from" | "to")).unwrap_or(name);
    match last.rsplit('_').next() {
        Some("m") => " (metres)",
        Some("deg") => " (degrees)",
        Some("px") => " (pixels)",
        _ => "",
    }
}
