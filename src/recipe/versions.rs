//! The versions that a dataset's bytes come from, beside the recipe: those of the regions' generators and of the stages
//! after them. They stand in every resolved recipe, and so in the plan's hash and in each record of a dataset, so that a
//! program that would make other bytes never adds to what an earlier one made.

use super::Recipe;
use super::node::{Entry, Node};
use super::reader::{Reader, whole};
use super::source::{RecipeError, plain};
use satseed_generators::Region;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A stage between a scene and its dataset, whose code decides bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// Its name under `[stages]`.
    pub name: &'static str,
    /// Raised whenever the same recipe and seed give other bytes by a change of this stage; CHANGELOG.md says why.
    pub version: u32,
}

/// All stages. What the tracer or the scene's materials answer belongs to those that ask: a change there raises `render`
/// where it changes an image, `labels` where it changes a label or a surface model.
pub const STAGES: [Stage; 4] = [
    // Which pairs, where their cameras stand, which split: `src/plan`, `src/camera`.
    Stage { name: "plan", version: 3 },
    // Light, sampling, sensor: `src/render`.
    Stage { name: "render", version: 6 },
    // Label maps and surface models: `src/labels`.
    Stage { name: "labels", version: 1 },
    // Which files there are, what their text says, how arrays are encoded: `src/dataset`, `src/pipeline`.
    Stage { name: "files", version: 1 },
];

/// The tables `[stages]` and `[generators]` of a resolved recipe.
pub(super) fn tables(recipe: &Recipe) -> String {
    let mut out = String::from("\n[stages]\n");
    for stage in STAGES {
        writeln!(out, "{} = {}", stage.name, stage.version).expect("writing to a String cannot fail");
    }
    let generators: BTreeMap<_, _> = recipe.scenes.iter().map(|s| (s.region.name(), s.region.version())).collect();
    out.push_str("\n[generators]\n");
    for (name, version) in generators {
        writeln!(out, "{name} = {version}").expect("writing to a String cannot fail");
    }
    out
}

/// Refuses a resolved recipe whose `[stages]` are not this build's.
pub(super) fn check_stages(mut table: Reader) -> Result<(), RecipeError> {
    for (name, Entry { key, node }) in table.take_rest() {
        let Some(stage) = STAGES.iter().find(|s| s.name == name) else {
            let names = STAGES.map(|s| s.name).join(", ");
            return Err(key.error(format!("`stages` names {}, but stages are {names}", plain(&name, 60))));
        };
        check("stages", &name, &node, stage.version)?;
    }
    Ok(())
}

/// Refuses a resolved recipe whose `[generators]` are not this build's.
pub(super) fn check_generators(mut table: Reader) -> Result<(), RecipeError> {
    for (name, Entry { key, node }) in table.take_rest() {
        let Some(region) = Region::by_name(&name) else {
            let names = Region::NAMES.join(", ");
            return Err(key.error(format!("`generators` names {}, but regions are {names}", plain(&name, 60))));
        };
        check("generators", &name, &node, region.version())?;
    }
    Ok(())
}

fn check(table: &str, name: &str, node: &Node, own: u32) -> Result<(), RecipeError> {
    let version = whole(&format!("{table}.{name}"), node, 1..=u64::from(u32::MAX))?;
    if version == u64::from(own) {
        return Ok(());
    }
    let what = if table == "generators" { "generator" } else { "stage" };
    Err(node.origin.error(format!(
        "the recipe was resolved with version {version} of {what} {name}, this build has version {own}: other bytes would \
         come out; remove the line to accept that"
    )))
}
