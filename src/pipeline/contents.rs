//! What the dataset of a plan holds.

use crate::dataset::{Contents, Layer, SceneContents, View};
use crate::plan::Plan;
use crate::recipe::{Label, Labels, Recipe};

/// The dataset of a plan, file by file.
pub fn contents(recipe: &Recipe, plan: &Plan) -> Contents {
    let scene = |spec: &crate::plan::SceneSpec| SceneContents {
        name: spec.name.clone(),
        samples: spec.pairs.iter().map(|p| p.folder().to_owned()).collect(),
    };
    Contents {
        recipe_toml: recipe_text(recipe, plan),
        scenes: plan.scenes.iter().map(scene).collect(),
        layers: layers(recipe.labels()),
    }
}

/// `recipe.toml`: the resolved recipe under the program's version and the plan's hash.
pub fn recipe_text(recipe: &Recipe, plan: &Plan) -> String {
    format!("# satseed {}\n# plan {}\n{}", env!("CARGO_PKG_VERSION"), plan.hash, recipe.to_toml())
}

/// The layer that a label is written as, in both views.
pub(super) fn layer_of(label: Label) -> Layer {
    match label {
        Label::DisparityRight => Layer::Disparity,
        Label::Class => Layer::Class,
        Label::Elevation => Layer::Elevation,
        Label::Instance => Layer::Instance,
        Label::Normal => Layer::Normal,
        Label::Shadow => Layer::Shadow,
        Label::Edge => Layer::Edge,
    }
}

fn layers(labels: &Labels) -> Vec<(Layer, View)> {
    let mut layers = vec![
        (Layer::Image, View::Left),
        (Layer::Image, View::Right),
        (Layer::Disparity, View::Left),
        (Layer::Validity, View::Left),
    ];
    for label in &labels.write {
        match label {
            Label::DisparityRight => layers.extend([(Layer::Disparity, View::Right), (Layer::Validity, View::Right)]),
            other => layers.extend([View::Left, View::Right].map(|view| (layer_of(*other), view))),
        }
    }
    layers.sort_unstable();
    layers
}
