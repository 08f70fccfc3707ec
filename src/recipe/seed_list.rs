//! Seed lists: one scene a line, `region[/variant] seed [key=value ...]`; `#` starts a comment.

use super::node::{Entry, Node, Table, Value};
use super::set::Assignment;
use super::source::{Origin, RecipeError, Source, plain};
use super::write;
use satseed_generators::Region;
use std::ops::Range;
use std::sync::Arc;

/// The lines as `[[scene]]` entries.
pub(super) fn scenes_from(source: &Arc<Source>) -> Result<Node, RecipeError> {
    let mut scenes = Vec::new();
    let mut at = 0;
    for line in source.text.split_inclusive('\n') {
        let content = line.split('#').next().unwrap_or("");
        let words: Vec<_> = words(content).map(|word| word.start + at..word.end + at).collect();
        if !words.is_empty() {
            scenes.push(scene_from(source, &words)?);
        }
        at += line.len();
    }
    let origin = Origin::beginning(source);
    if scenes.is_empty() {
        return Err(origin.error("the seed list names no scene; a line is `region[/variant] seed [key=value ...]`"));
    }
    Ok(Node { value: Value::List(scenes), origin })
}

/// Byte ranges of the words of a line.
fn words(line: &str) -> impl Iterator<Item = Range<usize>> {
    line.split_whitespace().map(|word| {
        let start = word.as_ptr() as usize - line.as_ptr() as usize;
        start..start + word.len()
    })
}

fn scene_from(source: &Arc<Source>, words: &[Range<usize>]) -> Result<Node, RecipeError> {
    let text = |range: &Range<usize>| &source.text[range.clone()];
    let place = |range: Range<usize>| Origin::new(source, range);
    let first = &words[0];
    let (name, variant) = match text(first).split_once('/') {
        Some((name, variant)) => (name, Some(variant)),
        None => (text(first), None),
    };
    let name_place = place(first.start..first.start + name.len());
    let Some(default) = Region::by_name(name) else {
        let regions = Region::NAMES.join(", ");
        return Err(name_place.error(format!("`{}` is no region; regions are {regions}", plain(name, 60))));
    };
    let mut parameters = Table::default();
    if let Some(variant) = variant {
        let origin = place(first.start + name.len() + 1..first.end);
        if write::has_variants(&default) {
            let node = Node { value: Value::Text(variant.to_owned()), origin: origin.clone() };
            parameters.0.insert("variant".to_owned(), Entry { key: origin, node });
        } else if variant != default.variant() {
            let (found, only) = (plain(variant, 60), default.variant());
            return Err(origin.error(format!("{name} has one variant, {only}, found `{found}`")));
        }
    }
    let Some(second) = words.get(1) else {
        return Err(place(first.end..first.end).error(format!("a seed is missing after {}", plain(text(first), 60))));
    };
    let seed_place = place(second.clone());
    let digits = text(second).bytes().all(|b| b.is_ascii_digit());
    let Some(seed) = text(second).parse::<u64>().ok().filter(|_| digits) else {
        let found = plain(text(second), 60);
        return Err(seed_place.error(format!("a seed is a whole number in 0 to {}, found `{found}`", u64::MAX)));
    };
    for word in &words[2..] {
        Assignment::parse(source, word.clone())?.add_to(&mut parameters)?;
    }
    let seed = Node { value: Value::Integer(i128::from(seed)), origin: seed_place.clone() };
    let seeds = Node { value: Value::List(vec![seed]), origin: seed_place.clone() };
    let region = Node { value: Value::Table(parameters), origin: name_place.clone() };
    let entries = [
        (name.to_owned(), Entry { key: name_place.clone(), node: region }),
        ("seeds".to_owned(), Entry { key: seed_place, node: seeds }),
    ];
    Ok(Node { value: Value::Table(Table(entries.into())), origin: name_place })
}

/// The line of a seed list that names a scene.
pub fn seed_list_line(region: &Region, seed: u64) -> String {
    let variant = if write::has_variants(region) { format!("/{}", region.variant()) } else { String::new() };
    let mut words = vec![format!("{}{variant} {seed}", region.name())];
    words.extend(write::changed_parameters(region).into_iter().map(|(key, value)| format!("{key}={value}")));
    words.join(" ")
}
