//! A document as a tree of values that know where they stand, and how one document is laid over another.

use super::source::{Origin, RecipeError, Source, SourceKind, plain};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) origin: Origin,
}

/// A value. Numbers are finite.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Text(String),
    Integer(i128),
    Float(f64),
    Boolean(bool),
    /// As it is written.
    DateTime(String),
    List(Vec<Node>),
    Table(Table),
}

/// A table's entries by key.
#[derive(Clone, Debug, Default)]
pub(super) struct Table(pub(super) BTreeMap<String, Entry>);

/// One entry of a table.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// Where the key stands.
    pub(super) key: Origin,
    /// The value.
    pub(super) node: Node,
}

/// Deeper documents than any recipe needs are refused before anything walks them by recursion.
const DEPTH_LIMIT: u32 = 12;

impl Node {
    /// What the value is, for messages: `the text "north"`, `a table`.
    pub(super) fn describe(&self) -> String {
        match &self.value {
            Value::Text(t) => format!("the text \"{}\"", plain(t, 60)),
            Value::Integer(i) => format!("{i}"),
            Value::Float(x) => format!("{x:?}"),
            Value::Boolean(b) => format!("{b}"),
            Value::DateTime(text) => format!("the date or time {}", plain(text, 60)),
            Value::List(items) => format!("a list of {}", items.len()),
            Value::Table(_) => "a table".to_owned(),
        }
    }
}

/// Parses a whole TOML document.
pub(super) fn parse_document(source: &Arc<Source>) -> Result<Table, RecipeError> {
    let document = DeTable::parse(&source.text).map_err(|e| syntax_error(source, &e, 0))?;
    entries_from(source, document.get_ref(), 0, 0)
}

/// Parses one TOML value; `offset` is where `text` begins in the source. Bare text is a string: `camera.datum=pivot` needs
/// no quotes that a shell would eat.
pub(super) fn parse_value(source: &Arc<Source>, text: &str, offset: usize) -> Result<Node, RecipeError> {
    let is_bare = |b: u8| b.is_ascii_alphanumeric() || b"_-./+:".contains(&b);
    match DeValue::parse(text) {
        Ok(value) => node_from(source, &value, 0, offset),
        Err(_) if text.bytes().all(is_bare) => {
            let origin = Origin::new(source, offset..offset + text.len());
            Ok(Node { value: Value::Text(text.to_owned()), origin })
        }
        Err(e) => Err(syntax_error(source, &e, offset)),
    }
}

fn syntax_error(source: &Arc<Source>, e: &toml::de::Error, offset: usize) -> RecipeError {
    let span = e.span().unwrap_or(0..0);
    let what = match source.kind {
        SourceKind::File => "this is not TOML",
        SourceKind::Argument => "the value is not TOML",
    };
    Origin::new(source, span.start + offset..span.end + offset).error(format!("{what}: {}", e.message()))
}

fn entries_from(source: &Arc<Source>, table: &DeTable<'_>, depth: u32, offset: usize) -> Result<Table, RecipeError> {
    let mut entries = BTreeMap::new();
    for (key, value) in table {
        let span = key.span();
        let key_origin = Origin::new(source, span.start + offset..span.end + offset);
        let node = node_from(source, value, depth + 1, offset)?;
        entries.insert(key.get_ref().to_string(), Entry { key: key_origin, node });
    }
    Ok(Table(entries))
}

fn node_from(
    source: &Arc<Source>,
    value: &Spanned<DeValue<'_>>,
    depth: u32,
    offset: usize,
) -> Result<Node, RecipeError> {
    let span = value.span();
    let origin = Origin::new(source, span.start + offset..span.end + offset);
    if depth > DEPTH_LIMIT {
        return Err(origin.error(format!("tables and lists are nested deeper than {DEPTH_LIMIT} levels")));
    }
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(i) => match i128::from_str_radix(i.as_str(), i.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => return Err(origin.error("this integer has too many digits for any key of a recipe")),
        },
        DeValue::Float(x) => match x.as_str().parse::<f64>() {
            Ok(number) if number.is_finite() => Value::Float(number),
            _ => return Err(origin.error(format!("a number must be finite, found `{}`", plain(x.as_str(), 40)))),
        },
        DeValue::Boolean(b) => Value::Boolean(*b),
        DeValue::Datetime(moment) => Value::DateTime(moment.to_string()),
        DeValue::Array(items) => {
            let nodes: Result<_, _> = items.iter().map(|item| node_from(source, item, depth + 1, offset)).collect();
            Value::List(nodes?)
        }
        DeValue::Table(table) => Value::Table(entries_from(source, table, depth, offset)?),
    };
    Ok(Node { value, origin })
}

/// Keys of one table that say the same thing in two ways: naming one in a later layer drops the others
/// of the earlier. No table of a recipe has one of these keys with another meaning.
const ALTERNATIVES: &[[&[&str]; 2]] = &[
    [&["baseline_m"], &["convergence_deg"]],
    [&["elevation_deg", "azimuth_deg"], &["date", "local_solar_time", "latitude_deg"]],
];

impl Table {
    /// Lays `upper` over this table: tables merge key by key, everything else (lists too) is replaced.
    pub(super) fn lay_over(&mut self, upper: Self) {
        for [a, b] in ALTERNATIVES {
            let named = |keys: &[&str]| keys.iter().any(|key| upper.0.contains_key(*key));
            let dropped: &[&str] = match (named(a), named(b)) {
                (true, false) => b,
                (false, true) => a,
                _ => &[],
            };
            for key in dropped {
                self.0.remove(*key);
            }
        }
        for (name, entry) in upper.0 {
            match (self.0.get_mut(&name), entry) {
                (
                    Some(Entry { node: Node { value: Value::Table(lower), .. }, .. }),
                    Entry { node: Node { value: Value::Table(table), .. }, .. },
                ) => lower.lay_over(table),
                (_, entry) => drop(self.0.insert(name, entry)),
            }
        }
    }
}
