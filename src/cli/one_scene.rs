//! The one scene that `preview` and `scene` are about.

use super::args::OneSceneArgs;
use anyhow::Context as _;
use satseed::plan::{SceneSpec, scenes};
use satseed::recipe::{Changes, Recipe};

/// A scene, and the recipe whose cameras and light are meant.
pub(crate) struct OneScene {
    pub(crate) recipe: Recipe,
    pub(crate) spec: SceneSpec,
}

impl OneScene {
    /// What the arguments name, with overrides that come after theirs.
    pub(crate) fn of(args: &OneSceneArgs, more: &[&str]) -> anyhow::Result<Self> {
        let set = args.set.iter().cloned().chain(more.iter().map(|s| (*s).to_owned())).collect();
        let recipe = Recipe::load(&args.recipe, &Changes { set, ..Changes::default() })?;
        let region = recipe.region(&args.region, args.variant.as_deref())?;
        let seed = match args.seed {
            Some(seed) => seed,
            None => first_seed(&recipe, region.name())?,
        };
        let spec = SceneSpec::of(&recipe, &region, seed);
        Ok(Self { recipe, spec })
    }
}

/// The seed of the recipe's first scene of a region.
fn first_seed(recipe: &Recipe, region: &str) -> anyhow::Result<u64> {
    let scenes = scenes(recipe)?;
    let scene = scenes.iter().find(|s| s.region.name() == region);
    scene.map(|s| s.seed).with_context(|| format!("the recipe has no scene of `{region}`: name one with --seed N"))
}
