//! Recipes: TOML text to a [`Recipe`], and back.
//!
//! A [`Recipe`] that exists is legal: its fields are private, and the only way to one is through the checks of this
//! module. Text becomes a tree of values that know where they stand (`node`); presets, files, seed lists and `--set` are
//! laid over each other as such trees; only then are the tables read (`read`), so that a mistake anywhere is told with
//! its file, line and column. Nothing here knows what is done with a recipe.

mod load;
mod node;
mod parts;
mod presets;
mod read;
mod reader;
mod region;
mod schema;
mod seed_list;
mod sensor;
mod set;
mod source;
mod sun;
mod versions;
mod write;

pub use load::{Changes, MAX_SEED_LIST_BYTES};
pub use parts::{
    Acquisition, Azimuths, Baselines, Camera, Datum, DisparityPrecision, Label, Labels, Light, PairGeometry,
    PivotAlongBaseline, Pivots, RadianceFile, SceneEntry, Sensor, SensorCoding, SensorPreset, Series, SplitRule,
};
pub use presets::{PRESETS, Preset};
pub use schema::schema;
pub use seed_list::seed_list_line;
pub use source::RecipeError;
pub use sun::{Date, Sun};
pub use versions::{STAGES, Stage};
pub(crate) use write::{changed_parameters, parameters_text};

/// A region with its parameters, as a recipe names it.
pub use satseed_generators::Region;

/// Largest recipe file, bytes.
pub const MAX_RECIPE_BYTES: u64 = 1 << 20;
/// Most baselines, and most azimuths.
const MAX_STEPS: u64 = 1000;
/// Most pivots of one `[[scene]]`. The seeds of a recipe's pivots are `seed * MAX_PIVOTS + number`.
pub(crate) const MAX_PIVOTS: u64 = 10_000;
/// Largest seed of a recipe: scene seeds stay below 2^63, which every TOML reader holds.
const MAX_SEED: u64 = 900_000_000_000_000;

/// What a dataset is: everything that decides its bytes, and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    seed: u64,
    camera: Camera,
    acquisition: Acquisition,
    light: Light,
    sensor: Sensor,
    labels: Labels,
    split: SplitRule,
    scenes: Vec<SceneEntry>,
}

impl Recipe {
    /// The seed, 0..9e14. The scenes' own seeds follow from it.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The rig.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The pairs of a pivot.
    pub fn acquisition(&self) -> &Acquisition {
        &self.acquisition
    }

    /// Sun and air.
    pub fn light(&self) -> &Light {
        &self.light
    }

    /// What makes pixels of radiance.
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// What is written beside the images.
    pub fn labels(&self) -> &Labels {
        &self.labels
    }

    /// How pairs fall into splits.
    pub fn split(&self) -> SplitRule {
        self.split
    }

    /// A region as the recipe's first `[[scene]]` of it has it, with another variant where one is named; where no
    /// `[[scene]]` has it, its defaults.
    pub fn region(&self, name: &str, variant: Option<&str>) -> Result<Region, RecipeError> {
        let same = |scene: &&SceneEntry| scene.region.name() == name;
        let wanted = |scene: &&SceneEntry| variant.is_none_or(|v| scene.region.variant() == v);
        let scenes = || self.scenes.iter().filter(same);
        if let Some(scene) = scenes().find(wanted) {
            return Ok(scene.region.clone());
        }
        let base = scenes().next().map(|scene| scene.region.clone()).or_else(|| Region::by_name(name));
        let Some(base) = base else {
            let (name, names) = (source::plain(name, 60), Region::NAMES.join(", "));
            return Err(RecipeError::placeless(format!("`{name}` is no region; regions are {names}")));
        };
        match variant {
            None => Ok(base),
            Some(variant) => write::with_variant(&base, variant),
        }
    }

    /// The scenes, in the order of the recipe; at least one.
    pub fn scenes(&self) -> &[SceneEntry] {
        &self.scenes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;

    #[test]
    fn quickstart_parses_and_round_trips() {
        let recipe = Recipe::parse("quickstart", include_str!("../../presets/quickstart.toml")).unwrap();
        let text = recipe.to_toml();
        assert_eq!(Recipe::parse("again", &text).unwrap(), recipe, "{text}");
        let plan = Plan::new(&recipe).unwrap();
        assert_eq!(plan.pair_count(), 8);
    }
}
