//! Whose folder it is: a `recipe.toml` that stands, held against the one that would be written.

use super::writer::WriteError;
use std::collections::BTreeMap;

/// Tables of a resolved recipe that hold versions of the program's parts.
const VERSIONS: [&str; 2] = ["stages", "generators"];

/// Why a folder whose `recipe.toml` is `standing` is not that of `new`. Comments follow from the rest, so they are named
/// only where nothing else differs.
pub(super) fn refusal(standing: &str, new: &str) -> WriteError {
    let (old, own) = (Parts::of(standing), Parts::of(new));
    if old.recipe == own.recipe {
        let entries = old.versions.keys().chain(own.versions.keys());
        let other = entries.filter(|entry| old.versions.get(*entry) != own.versions.get(*entry)).min();
        if let Some(entry) = other {
            let version = |parts: &Parts<'_>| parts.versions.get(entry).map_or("none", |v| v).to_owned();
            let [table, name] = entry;
            let what = format!("{} `{}`", if *table == "stages" { "stage" } else { "generator" }, short(name));
            return WriteError::OtherVersion { what, standing: short(&version(&old)), own: short(&version(&own)) };
        }
        if let Some((a, b)) = first_difference(&old.comments, &own.comments) {
            let plain = |line: &str| short(line.trim_start_matches("# "));
            return WriteError::OtherVersion { what: "the program".into(), standing: plain(a), own: plain(b) };
        }
    }
    let difference = match first_difference(&old.recipe, &own.recipe) {
        Some((a, b)) => format!("its recipe.toml says `{}` where this one says `{}`", short(a), short(b)),
        None => "its recipe.toml is longer or shorter than this one".to_owned(),
    };
    WriteError::OtherPlan { difference }
}

/// A resolved recipe, which has one line a value.
struct Parts<'a> {
    comments: Vec<&'a str>,
    /// Lines that are no versions.
    recipe: Vec<&'a str>,
    /// Versions by table and name.
    versions: BTreeMap<[&'a str; 2], &'a str>,
}

impl<'a> Parts<'a> {
    fn of(text: &'a str) -> Self {
        let mut parts = Self { comments: Vec::new(), recipe: Vec::new(), versions: BTreeMap::new() };
        let mut table = "";
        for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
            if line.starts_with('#') {
                parts.comments.push(line);
                continue;
            }
            if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                table = name;
            }
            match line.split_once(" = ") {
                Some((name, version)) if VERSIONS.contains(&table) => {
                    parts.versions.insert([table, name], version);
                }
                _ if VERSIONS.contains(&table) && line.starts_with('[') => {}
                _ => parts.recipe.push(line),
            }
        }
        parts
    }
}

fn first_difference<'a>(a: &[&'a str], b: &[&'a str]) -> Option<(&'a str, &'a str)> {
    a.iter().zip(b).find(|(a, b)| a != b).map(|(a, b)| (*a, *b))
}

/// A stranger's text, short enough for a message.
fn short(text: &str) -> String {
    text.chars().take(100).flat_map(char::escape_default).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: &str = "# satseed 0.1.0\n# plan 77aa\n# The resolved recipe.\nseed = 1\n\n[camera]\ngsd_m = 0.3\n\n[stages]\n\
                       plan = 1\nrender = 3\n\n[generators]\ncanyon = 2\n";

    fn said(from: &str, to: &str) -> String {
        // The plan's hash is another one whatever changes.
        let standing = OWN.replace("77aa", "33bb").replace(from, to);
        refusal(&standing, OWN).to_string()
    }

    #[test]
    fn another_version_is_no_other_recipe() {
        let error = said("render = 3", "render = 2");
        assert!(error.contains("version 2 of stage `render`") && error.contains("this one has version 3"), "{error}");
        let error = said("canyon = 2", "canyon = 1");
        assert!(error.contains("version 1 of generator `canyon`"), "{error}");
        let error = said("[stages]\nplan = 1\nrender = 3\n\n", "");
        assert!(error.contains("version none of stage `plan`"), "{error}");
        let error = refusal(&OWN.replace("0.1.0", "0.0.9"), OWN).to_string();
        assert!(error.contains("version satseed 0.0.9 of the program"), "{error}");
    }

    #[test]
    fn another_recipe_is_told_by_its_first_line() {
        let error = said("gsd_m = 0.3", "gsd_m = 0.5");
        assert!(error.contains("another dataset") && error.contains("says `gsd_m = 0.5` where"), "{error}");
        // Where both differ the recipe counts: no version would make them equal.
        let error = said("gsd_m = 0.3\n\n[stages]\nplan = 1", "gsd_m = 0.5\n\n[stages]\nplan = 9");
        assert!(error.contains("says `gsd_m = 0.5` where"), "{error}");
        let error = said("gsd_m = 0.3\n", "gsd_m = 0.3\nmore = 1\n");
        assert!(error.contains("longer or shorter"), "{error}");
    }
}
