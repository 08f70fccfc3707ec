//! What the dataset of a plan holds.

use crate::dataset::formats::{PixelKind, Pixels};
use crate::dataset::{Contents, Layer, SceneContents, View};
use crate::plan::{Plan, SceneSpec, Shard, Share};
use crate::recipe::{Label, RadianceFile, Recipe, Sensor};
use crate::render::Image;
use crate::render::sensor::{Coding, ImagePixels};
use std::ops::Range;

/// The dataset of a plan, file by file.
pub fn contents(recipe: &Recipe, plan: &Plan) -> Contents {
    contents_of(recipe, plan, &Shard::WHOLE.of(recipe, plan))
}

/// The same of a part of it.
pub(super) fn contents_of(recipe: &Recipe, plan: &Plan, shares: &[Share]) -> Contents {
    let scene = |share: &Share| scene_contents(&plan.scenes[share.scene], share.pairs.clone());
    Contents {
        recipe_toml: recipe_text(recipe, plan),
        scenes: shares.iter().map(scene).collect(),
        layers: layers(recipe),
    }
}

/// What a scene's folder holds of some of its pairs.
pub(super) fn scene_contents(spec: &SceneSpec, pairs: Range<usize>) -> SceneContents {
    SceneContents {
        name: spec.name.clone(),
        samples: spec.pairs[pairs].iter().map(|p| p.folder().to_owned()).collect(),
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
pub(super) fn image_pixels(image: Image, file: RadianceFile) -> Pixels {
    match (image.pixels, image.channels) {
        (ImagePixels::Bytes(v), 1) => Pixels::Gray(v),
        (ImagePixels::Bytes(v), 3) => Pixels::Rgb(v),
        (ImagePixels::Bytes(v), _) => Pixels::Bytes4(v),
        (ImagePixels::Counts(v), n) => Pixels::Counts(n as u8, v),
        (ImagePixels::Radiance(v), n) => match file {
            RadianceFile::Tiff => Pixels::Radiance(n as u8, v),
            RadianceFile::Exr => Pixels::SceneLinear(n as u8, v),
        },
    }
}

/// What kind of values a sensor's images hold.
fn image_kind(sensor: &Sensor) -> PixelKind {
    let bands = sensor.imager.bands.count() as u8;
    match (sensor.imager.coding, bands) {
        (Coding::Stretched { .. }, 1) => PixelKind::Gray,
        (Coding::Stretched { .. }, 3) => PixelKind::Rgb,
        (Coding::Stretched { .. }, _) => PixelKind::Bytes4,
        (Coding::Counts, n) => PixelKind::Counts(n),
        (Coding::Radiance, n) => match sensor.radiance_file {
            RadianceFile::Tiff => PixelKind::Radiance(n),
            RadianceFile::Exr => PixelKind::SceneLinear(n),
        },
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
    let image = image_kind(recipe.sensor());
    let kind = |layer: Layer| if layer == Layer::Image { image } else { layer.kinds()[0] };
    layers.into_iter().map(|(layer, view)| (layer, view, kind(layer))).collect()
}
