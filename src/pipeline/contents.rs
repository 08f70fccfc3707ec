//! What the dataset of a plan holds.

use crate::dataset::formats::{PixelKind, Pixels};
use crate::dataset::{Contents, Layer, SceneContents, View};
use crate::plan::Plan;
use crate::recipe::{Label, Recipe};
use crate::render::sensor::{Coding, ImagePixels};
use crate::render::{Image, Sensor};

/// The dataset of a plan, file by file.
pub fn contents(recipe: &Recipe, plan: &Plan) -> Contents {
    let scene = |spec: &crate::plan::SceneSpec| SceneContents {
        name: spec.name.clone(),
        samples: spec.pairs.iter().map(|p| p.folder().to_owned()).collect(),
    };
    Contents {
        recipe_toml: recipe_text(recipe, plan),
        scenes: plan.scenes.iter().map(scene).collect(),
        layers: layers(recipe),
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

/// An image's values, as the dataset's formats have them.
pub(super) fn image_pixels(image: Image) -> Pixels {
    match (image.pixels, image.channels) {
        (ImagePixels::Bytes(v), 1) => Pixels::Gray(v),
        (ImagePixels::Bytes(v), 3) => Pixels::Rgb(v),
        (ImagePixels::Bytes(v), _) => Pixels::Bytes4(v),
        (ImagePixels::Counts(v), n) => Pixels::Counts(n as u8, v),
        (ImagePixels::Radiance(v), n) => Pixels::Radiance(n as u8, v),
    }
}

/// What kind of values a sensor's images hold.
fn image_kind(sensor: &Sensor) -> PixelKind {
    let bands = sensor.bands.count() as u8;
    match (sensor.coding, bands) {
        (Coding::Stretched { .. }, 1) => PixelKind::Gray,
        (Coding::Stretched { .. }, 3) => PixelKind::Rgb,
        (Coding::Stretched { .. }, _) => PixelKind::Bytes4,
        (Coding::Counts, n) => PixelKind::Counts(n),
        (Coding::Radiance, n) => PixelKind::Radiance(n),
    }
}

fn layers(recipe: &Recipe) -> Vec<(Layer, View, PixelKind)> {
    let labels = recipe.labels();
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
    let image = image_kind(&recipe.sensor().imager);
    let kind = |layer: Layer| if layer == Layer::Image { image } else { layer.kinds()[0] };
    layers.into_iter().map(|(layer, view)| (layer, view, kind(layer))).collect()
}
