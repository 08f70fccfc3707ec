//! A region with its parameters out of a document: serde over [`Node`], so that every mistake keeps its place.

use super::node::{Node, Table, Value};
use super::reader::unit_of;
use super::source::{Origin, RecipeError};
use satseed_generators::Region;
use serde::de::value::{MapAccessDeserializer, StringDeserializer};
use serde::de::{DeserializeSeed, Error as _, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, forward_to_deserialize_any};
use std::fmt;

/// The region `name` with the parameters in `node`, each in its range. `path` names it in messages.
pub(super) fn region_from(path: &str, name: &str, key: &Origin, node: &Node) -> Result<Region, RecipeError> {
    if !matches!(node.value, Value::Table(_)) {
        let message = format!("`{path}` must be a table of parameters such as {{}}, found {}", node.describe());
        return Err(node.origin.error(message));
    }
    let one = One { key: Some((name.to_owned(), key.clone())), value: Some(node.clone()) };
    let region = Region::deserialize(MapAccessDeserializer::new(one)).map_err(|e| {
        let keys = e.path.iter().rev().fold(path.to_owned(), |path, key| format!("{path}.{key}"));
        e.origin.as_ref().unwrap_or(key).error(format!("in `{keys}`: {}", e.message))
    })?;
    region.check().map_err(|e| {
        let origin = find(node, e.key).map_or(key, |found| &found.origin);
        let found = find(node, e.key).map_or_else(|| format!("{:?}", e.found), Node::describe);
        let unit = unit_of(e.key);
        origin.error(format!("`{path}.{}` is {found}, but must lie in {} to {}{unit}", e.key, e.low, e.high))
    })?;
    Ok(region)
}

/// The value of a dotted key.
fn find<'a>(node: &'a Node, key: &str) -> Option<&'a Node> {
    let mut node = node;
    for part in key.split('.') {
        let Value::Table(Table(entries)) = &node.value else { return None };
        node = &entries.get(part)?.node;
    }
    Some(node)
}

/// What serde says, with the place of the value that it is about.
#[derive(Debug)]
pub(super) struct PlacedError {
    message: String,
    origin: Option<Origin>,
    /// Keys from the inside outwards.
    path: Vec<String>,
}

impl PlacedError {
    fn at(mut self, origin: &Origin) -> Self {
        self.origin.get_or_insert_with(|| origin.clone());
        self
    }
}

impl fmt::Display for PlacedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for PlacedError {}

impl serde::de::Error for PlacedError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { message: message.to_string(), origin: None, path: Vec::new() }
    }
}

impl IntoDeserializer<'_, PlacedError> for Node {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Node {
    type Error = PlacedError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PlacedError> {
        let origin = self.origin;
        match self.value {
            Value::Text(text) => visitor.visit_string(text),
            Value::Integer(i) => match (i64::try_from(i), u64::try_from(i)) {
                (Ok(i), _) => visitor.visit_i64(i),
                (_, Ok(u)) => visitor.visit_u64(u),
                _ => Err(PlacedError::custom(format!("{i} is beyond 64 bits"))),
            },
            Value::Float(x) => visitor.visit_f64(x),
            Value::Boolean(b) => visitor.visit_bool(b),
            Value::DateTime(_) => Err(PlacedError::custom("a date or time has no meaning here")),
            Value::List(items) => visitor.visit_seq(Items(items.into_iter())),
            Value::Table(table) => visitor.visit_map(Entries { rest: table.0.into_iter(), value: None }),
        }
        .map_err(|e| e.at(&origin))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PlacedError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, PlacedError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, PlacedError> {
        let origin = self.origin.clone();
        match self.value {
            Value::Text(text) => {
                let word: StringDeserializer<PlacedError> = text.into_deserializer();
                word.deserialize_enum(name, variants, visitor)
            }
            Value::Table(table) => {
                let entries = Entries { rest: table.0.into_iter(), value: None };
                MapAccessDeserializer::new(entries).deserialize_enum(name, variants, visitor)
            }
            _ => {
                let message = format!("found {}, expected one of {}", self.describe(), variants.join(", "));
                Err(PlacedError::custom(message))
            }
        }
        .map_err(|e| e.at(&origin))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

/// `{ name = node }`.
struct One {
    key: Option<(String, Origin)>,
    value: Option<Node>,
}

impl<'de> MapAccess<'de> for One {
    type Error = PlacedError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, PlacedError> {
        let Some((name, origin)) = self.key.take() else { return Ok(None) };
        key_from(seed, name, &origin).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, PlacedError> {
        seed.deserialize(self.value.take().ok_or_else(|| PlacedError::custom("a value was asked for twice"))?)
    }
}

struct Items(std::vec::IntoIter<Node>);

impl<'de> SeqAccess<'de> for Items {
    type Error = PlacedError;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, PlacedError> {
        self.0.next().map(|node| seed.deserialize(node)).transpose()
    }
}

struct Entries {
    rest: std::collections::btree_map::IntoIter<String, super::node::Entry>,
    value: Option<(String, Node)>,
}

impl<'de> MapAccess<'de> for Entries {
    type Error = PlacedError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, PlacedError> {
        let Some((name, entry)) = self.rest.next() else { return Ok(None) };
        self.value = Some((name.clone(), entry.node));
        key_from(seed, name, &entry.key).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, PlacedError> {
        let (name, node) = self.value.take().ok_or_else(|| PlacedError::custom("a value was asked for twice"))?;
        seed.deserialize(node).map_err(|mut e| {
            e.path.push(name);
            e
        })
    }
}

fn key_from<'de, K: DeserializeSeed<'de>>(seed: K, name: String, origin: &Origin) -> Result<K::Value, PlacedError> {
    let key: StringDeserializer<PlacedError> = name.into_deserializer();
    seed.deserialize(key).map_err(|e| e.at(origin))
}
