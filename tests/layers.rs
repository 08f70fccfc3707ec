//! The rooms of the house: which may know which. Reads every source file and holds what it names against the table.
//!
//! Code for tests (`#[cfg(test)]` items and files of tests) is not looked at: it may reach further than what ships.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A room: a crate, or a module of the root package.
struct Room {
    name: &'static str,
    /// Modules of the root package that it may name.
    rooms: &'static [&'static str],
    /// Crates of the workspace that it may name.
    crates: &'static [&'static str],
}

const SCENE: &str = "satseed_scene";
const TRACER: &str = "satseed_tracer";
const GENERATORS: &str = "satseed_generators";
const ALL: &[&str] = &[
    "camera", "card", "cli", "dataset", "evaluate", "export", "gallery", "labels", "model", "pipeline", "plan",
    "recipe", "render", "sweep",
];

/// The table of docs/architecture.md. The scene is the vocabulary that everyone speaks.
const ROOMS: &[Room] = &[
    Room { name: "scene", rooms: &[], crates: &[] },
    Room { name: "generators", rooms: &[], crates: &[SCENE] },
    Room { name: "tracer", rooms: &[], crates: &[SCENE] },
    Room { name: "camera", rooms: &[], crates: &[SCENE] },
    Room { name: "labels", rooms: &["camera"], crates: &[SCENE, TRACER] },
    Room { name: "render", rooms: &["camera"], crates: &[SCENE, TRACER] },
    Room { name: "recipe", rooms: &["camera", "render"], crates: &[SCENE, GENERATORS] },
    Room { name: "plan", rooms: &["recipe"], crates: &[SCENE] },
    Room { name: "dataset", rooms: &["plan"], crates: &[SCENE] },
    Room { name: "evaluate", rooms: &["dataset"], crates: &[] },
    Room { name: "sweep", rooms: &["dataset", "evaluate", "plan", "recipe"], crates: &[] },
    Room { name: "card", rooms: &["dataset"], crates: &[] },
    Room { name: "gallery", rooms: &["dataset"], crates: &[] },
    Room { name: "export", rooms: &["dataset"], crates: &[] },
    Room { name: "model", rooms: &["dataset", "labels"], crates: &[SCENE] },
    Room {
        name: "pipeline",
        rooms: &["camera", "card", "dataset", "gallery", "labels", "plan", "recipe", "render"],
        crates: &[SCENE, TRACER, GENERATORS],
    },
    Room { name: "cli", rooms: ALL, crates: &["satseed", SCENE, TRACER, GENERATORS] },
    // The crate's root and the binary.
    Room { name: "lib", rooms: ALL, crates: &[] },
    Room { name: "main", rooms: ALL, crates: &["satseed"] },
];

/// Crates from outside that only some rooms may name. Others are free for all.
const OUTSIDE: &[(&str, &[&str])] = &[
    ("obvhs", &["tracer"]),
    ("rand_chacha", &["scene"]),
    ("spade", &["generators"]),
    ("schemars", &["generators", "recipe", "cli"]),
    ("toml", &["recipe"]),
    ("tiff", &["dataset", "evaluate"]),
    ("tiff_writer", &["dataset"]),
    ("tiff_core", &["dataset"]),
    ("base64", &["evaluate", "gallery"]),
    ("miniz_oxide", &["gallery"]),
    ("sha2", &["card"]),
    ("image", &["export", "gallery"]),
    ("png", &["dataset", "evaluate", "export"]),
    ("tar", &["export"]),
    // Object storage, in one room of the dataset's.
    ("futures_util", &["dataset"]),
    ("object_store", &["dataset"]),
    ("reqwest", &["dataset"]),
    ("rustls", &["dataset"]),
    ("tokio", &["dataset"]),
    ("half", &["evaluate"]),
    ("rustix", &["dataset", "pipeline"]),
    ("anyhow", &["cli", "main"]),
    ("clap", &["cli", "main"]),
    ("clap_complete", &["cli", "main"]),
    ("indicatif", &["cli"]),
    ("signal_hook", &["cli"]),
    ("tracing_subscriber", &["cli"]),
    ("rand", &[]),
    ("std_float", &[]),
];

const PRINTING: &[&str] = &["println!", "print!", "eprintln!", "eprint!", "dbg!"];

/// The text without comments, string contents and items marked `#[cfg(test)]`; line breaks stay.
fn shipped(text: &str) -> String {
    let code = without_comments_and_strings(text);
    let mut out = String::new();
    let mut rest = code.as_str();
    while let Some(at) = rest.find("#[cfg(test)]") {
        out.push_str(&rest[..at]);
        let item = &rest[at..];
        // The item ends with its block, or with a semicolon before any block.
        let open = item.find('{').unwrap_or(item.len());
        let end = match item.find(';') {
            Some(semicolon) if semicolon < open => semicolon + 1,
            _ => open + block_length(&item[open..]),
        };
        out.extend(item[..end].chars().filter(|c| *c == '\n'));
        rest = &item[end..];
    }
    out + rest
}

fn block_length(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

fn without_comments_and_strings(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::new();
    let mut i = 0;
    while i < chars.len() {
        let next = chars.get(i + 1).copied();
        match (chars[i], next) {
            ('/', Some('/')) => {
                while i < chars.len() && chars[i] != '\n' {
                    i += 1;
                }
            }
            ('/', Some('*')) => {
                let mut depth = 0;
                loop {
                    let pair = (chars.get(i).copied(), chars.get(i + 1).copied());
                    match pair {
                        (Some('/'), Some('*')) => (depth, i) = (depth + 1, i + 2),
                        (Some('*'), Some('/')) => (depth, i) = (depth - 1, i + 2),
                        (None, _) => break,
                        (c, _) => {
                            out.extend(c.filter(|c| *c == '\n'));
                            i += 1;
                        }
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
            ('r', Some('"' | '#')) if i == 0 || !chars[i - 1].is_alphanumeric() && chars[i - 1] != '_' => {
                let hashes = chars[i + 1..].iter().take_while(|c| **c == '#').count();
                if chars.get(i + 1 + hashes) != Some(&'"') {
                    out.push('r');
                    i += 1;
                    continue;
                }
                i += 2 + hashes;
                while i < chars.len()
                    && !(chars[i] == '"' && chars[i + 1..].iter().take_while(|c| **c == '#').count() >= hashes)
                {
                    out.extend(Some(chars[i]).filter(|c| *c == '\n'));
                    i += 1;
                }
                i += 1 + hashes;
            }
            ('"', _) => {
                i += 1;
                while i < chars.len() && chars[i] != '"' {
                    out.extend(Some(chars[i]).filter(|c| *c == '\n'));
                    i += if chars[i] == '\\' { 2 } else { 1 };
                }
                i += 1;
            }
            // A character literal that could look like something else; lifetimes have no closing quote.
            ('\'', Some('\\')) => {
                i += 2;
                while i < chars.len() && chars[i] != '\'' {
                    i += 1;
                }
                i += 1;
            }
            ('\'', Some(_)) if chars.get(i + 2) == Some(&'\'') => i += 3,
            (c, _) => {
                out.push(c);
                i += 1;
            }
        }
    }
    out
}

/// Paths in a text, each a list of names, `{a, b::c}` opened, with the line they begin on.
fn paths(code: &str) -> Vec<(usize, Vec<String>)> {
    let mut found = Vec::new();
    for (line, text) in statements(code) {
        open_braces(&text, line, &mut found);
    }
    found
}

/// Every maximal run of `name::name::{...}` in the text.
fn statements(code: &str) -> Vec<(usize, String)> {
    let chars: Vec<char> = code.chars().collect();
    let mut out = Vec::new();
    let (mut i, mut line) = (0, 1);
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    while i < chars.len() {
        if chars[i] == '\n' {
            line += 1;
        }
        if !is_name(chars[i]) || (i > 0 && is_name(chars[i - 1])) {
            i += 1;
            continue;
        }
        let (start, begun) = (i, line);
        loop {
            while i < chars.len() && is_name(chars[i]) {
                i += 1;
            }
            if chars[i..].starts_with(&[':', ':']) {
                i += 2;
                if chars.get(i) == Some(&'{') {
                    let inner: String = chars[i..].iter().collect();
                    let length = inner[..block_length(&inner)].chars().count();
                    line += chars[i..i + length].iter().filter(|c| **c == '\n').count();
                    i += length;
                    break;
                }
                if !chars.get(i).is_some_and(|c| is_name(*c)) {
                    break;
                }
            } else {
                break;
            }
        }
        out.push((begun, chars[start..i].iter().filter(|c| !c.is_whitespace()).collect()));
    }
    out
}

fn open_braces(path: &str, line: usize, out: &mut Vec<(usize, Vec<String>)>) {
    let Some((head, rest)) = path.split_once('{') else {
        let names: Vec<String> = path.split("::").filter(|n| !n.is_empty()).map(str::to_owned).collect();
        if !names.is_empty() {
            out.push((line, names));
        }
        return;
    };
    let body = rest.strip_suffix('}').unwrap_or(rest);
    let (mut depth, mut start) = (0, 0);
    for (at, c) in body.char_indices().chain([(body.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !body[start..at].is_empty() {
                    open_braces(&format!("{head}{}", &body[start..at]), line, out);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

/// What a file does against the table. `module` is its path inside its crate: `["labels", "view"]`.
fn violations(room: &Room, module: &[&str], text: &str) -> Vec<String> {
    let code = shipped(text);
    let mut found = BTreeSet::new();
    let in_root_package = !["scene", "generators", "tracer"].contains(&room.name);
    for (line, path) in paths(&code) {
        let mut say = |what: String| {
            found.insert(format!("line {line}: `{}` {what}", path.join("::")));
        };
        // crate::x, or as many `super`s as lead to the crate's root.
        let supers = path.iter().take_while(|n| *n == "super").count();
        let inner = if path[0] == "crate" {
            path.get(1)
        } else if supers > 0 && supers == module.len() {
            path.get(supers)
        } else {
            None
        };
        if let Some(other) = inner.filter(|_| in_root_package)
            && ALL.contains(&other.as_str())
            && other != room.name
            && !room.rooms.contains(&other.as_str())
        {
            say(format!("is a way from {} to {other}", room.name));
        }
        let first = path[0].as_str();
        if path.len() > 1 && first.starts_with("satseed") && !room.crates.contains(&first) {
            say(format!("is a way from {} to {first}", room.name));
        }
        if path.len() > 1
            && let Some((_, who)) = OUTSIDE.iter().find(|o| o.0 == first)
            && !who.contains(&room.name)
        {
            say(format!("is not for {}", room.name));
        }
    }
    if !["cli", "main"].contains(&room.name) {
        for (number, line) in code.lines().enumerate() {
            for word in PRINTING {
                let at = line.find(word);
                if at.is_some_and(|at| !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_')) {
                    found.insert(format!("line {}: `{word}` prints, and only cli does", number + 1));
                }
            }
        }
    }
    found.into_iter().collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            out.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
    out.sort();
    out
}

fn room(name: &str) -> &'static Room {
    ROOMS.iter().find(|r| r.name == name).unwrap_or_else(|| panic!("`{name}` is no room: it needs a row in the table"))
}

#[test]
fn no_arrow_turns_round() {
    let mut all = Vec::new();
    let mut files = 0;
    for (name, source) in
        [("scene", "scene/src"), ("generators", "generators/src"), ("tracer", "tracer/src"), ("", "src")]
    {
        let base = root().join(source);
        for file in sources(&base) {
            let inside = file.strip_prefix(&base).expect("it was found there").with_extension("");
            let mut module: Vec<&str> = inside.iter().map(|p| p.to_str().expect("a plain name")).collect();
            if module.last().is_some_and(|m| m.ends_with("_tests") || *m == "tests") {
                continue;
            }
            let room = room(if name.is_empty() { module[0] } else { name });
            if matches!(module.last(), Some(&"mod" | &"lib" | &"main")) {
                module.pop();
            }
            let text = std::fs::read_to_string(&file).expect("a source file");
            files += 1;
            all.extend(
                violations(room, &module, &text).into_iter().map(|v| format!("{source}/{}.rs {v}", inside.display())),
            );
        }
    }
    assert!(files > 60, "only {files} files were looked at");
    assert!(all.is_empty(), "{} ways that design has no door for:\n{}", all.len(), all.join("\n"));
}

/// Crates that each manifest may depend on, outside ones by the same table as the sources.
#[test]
fn manifests_keep_to_the_table() {
    let mut manifests = BTreeMap::new();
    for (name, folder) in [("scene", "scene"), ("generators", "generators"), ("tracer", "tracer")] {
        let text = std::fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
        let table: toml::Table = text.parse().expect("TOML");
        let names: Vec<String> =
            table["dependencies"].as_table().expect("dependencies").keys().map(|k| k.replace('-', "_")).collect();
        manifests.insert(name, names);
    }
    for (name, dependencies) in manifests {
        for d in dependencies {
            let inside = d.starts_with("satseed");
            assert!(!inside || room(name).crates.contains(&d.as_str()), "{name} may not depend on {d}");
            let outside = OUTSIDE.iter().find(|o| o.0 == d);
            assert!(outside.is_none_or(|o| o.1.contains(&name)), "{d} is not for {name}");
        }
    }
}

#[test]
fn planted_violations_are_found() {
    let count = |name: &str, module: &[&str], text: &str| violations(room(name), module, text).len();
    // Each of these is one forbidden way.
    assert_eq!(count("labels", &["labels", "view"], "use crate::render::Light;"), 1);
    assert_eq!(count("labels", &["labels", "view"], "use crate::{camera::Camera, dataset::{self, Store}};"), 2);
    assert_eq!(count("camera", &["camera", "rig"], "fn f() { crate::labels::reach_m(); }"), 1);
    assert_eq!(count("camera", &["camera", "rig"], "use super::super::plan::Plan;"), 1);
    assert_eq!(count("labels", &["labels"], "use super::recipe::Recipe;"), 1);
    assert_eq!(count("camera", &["camera"], "use satseed_tracer::Tracer;"), 1);
    assert_eq!(count("tracer", &["traverse"], "use satseed_generators::Region;"), 1);
    assert_eq!(count("scene", &["mesh"], "use obvhs::bvh2::Bvh2;"), 1);
    assert_eq!(count("generators", &["kit"], "let r = rand_chacha::ChaCha8Rng::from_seed(k);"), 1);
    assert_eq!(count("dataset", &["dataset"], "fn f() { println!(\"x\"); }"), 1);
    assert_eq!(count("dataset", &["dataset"], "#[cfg(test)]\nmod t { use crate::cli::X; }\nuse crate::cli::Y;"), 1);
    // And each of these is allowed.
    assert_eq!(count("labels", &["labels", "view"], "use crate::camera::Camera;\nuse super::Validity;"), 0);
    assert_eq!(count("labels", &["labels", "view"], "// use crate::render::Light;\nlet x = \"crate::cli::X\";"), 0);
    assert_eq!(count("dataset", &["dataset"], "#[cfg(test)]\nmod t { use crate::cli::X; }"), 0);
    assert_eq!(count("dataset", &["dataset"], "#[cfg(test)]\nmod t;\nuse crate::plan::Plan;"), 0);
    assert_eq!(count("cli", &["cli"], "println!(\"x\");"), 0);
    assert_eq!(
        count("tracer", &["bvh8"], "use obvhs::aabb::Aabb;\nlet c = '\"'; let l: &'static str = r#\"rand::x\"#;"),
        0
    );
    assert_eq!(count("dataset", &["dataset"], "fn f() { my_println!(); writeln!(w, \"x\"); }"), 0);
}
