//! The page: its text, with the data between.

use super::reduced::{Reduced, reduced};
use super::{GalleryError, MOST_SAMPLES};
use crate::dataset::{CameraRecord, Dataset, Identity, Layer, SampleRecord, Seal, View};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/gallery.css");
/// One script; a file uses what stands in those before it.
const SCRIPTS: [&str; 5] = [
    include_str!("page/data.js"),
    include_str!("page/grid.js"),
    include_str!("page/surface.js"),
    include_str!("page/viewer.js"),
    include_str!("page/main.js"),
];

/// Longest side of a picture, px, by how many samples there are at most: a page stays under about 100 MB.
const SIDES: [(usize, u32); 4] = [(140, 512), (250, 384), (560, 256), (usize::MAX, 192)];

/// What the page knows of the dataset before anything is decoded.
#[derive(Serialize)]
struct Facts<'a> {
    root_hash: String,
    in_dataset: usize,
    recipe: String,
    scenes: BTreeMap<&'a str, serde_json::Value>,
    samples: Vec<SampleFacts<'a>>,
}

#[derive(Serialize)]
struct SampleFacts<'a> {
    #[serde(flatten)]
    identity: &'a Identity,
    valid_fraction: f64,
    occluded_fraction: f64,
    out_of_frame_fraction: f64,
    disparity_min_px: Option<f32>,
    disparity_max_px: Option<f32>,
    gsd_m: f64,
    altitude_m: f64,
    doffs_px: f64,
    camera: CameraRecord,
    /// Labels stand for every so many pixels and rows.
    every: u32,
    columns: u32,
    rows: u32,
    /// Where the images lie, from the page, if a browser can show them.
    left_path: Option<&'a str>,
    right_path: Option<&'a str>,
}

#[derive(Serialize)]
struct Packed {
    left: String,
    right: String,
    labels: String,
}

/// The gallery of a dataset as the bytes of an HTML file, on the current rayon pool. `beside`: it will lie in the dataset's
/// folder, so that it can show the whole images.
///
/// # Errors
/// Where the dataset cannot be read.
pub fn gallery_html(dataset: &Dataset<'_>, beside: bool) -> Result<Vec<u8>, GalleryError> {
    let all = dataset.records();
    let count = all.len().min(MOST_SAMPLES);
    let records: Vec<&SampleRecord> = (0..count).map(|i| &all[i * all.len() / count]).collect();
    let side = SIDES.iter().find(|(most, _)| count <= *most).map_or(192, |(_, side)| *side);
    let read: Vec<(SampleFacts<'_>, String)> = records
        .par_iter()
        .enumerate()
        .map(|(index, record)| sample(dataset, record, index, side, beside))
        .collect::<Result<_, _>>()?;
    let (samples, packed): (Vec<_>, Vec<_>) = read.into_iter().unzip();
    let mut scenes = BTreeMap::new();
    for record in &records {
        if !scenes.contains_key(record.scene()) {
            let text = dataset.text(record, "scene")?;
            // A scene file that says nothing costs its rows of the table and nothing else.
            let told = serde_json::from_str::<serde_json::Value>(&text).unwrap_or_default();
            scenes.insert(record.scene(), scene_facts(&told));
        }
    }
    let recipe = records.first().map(|r| dataset.text(r, "recipe")).transpose()?.unwrap_or_default();
    let root_hash = dataset.root_hash().hex();
    let facts = Facts { root_hash: root_hash.clone(), in_dataset: all.len(), recipe, scenes, samples };

    let (before, rest) = TEMPLATE.split_once("{{data}}").unwrap_or((TEMPLATE, ""));
    let data: usize = packed.iter().map(String::len).sum();
    let mut page = Vec::with_capacity(data + (1 << 20));
    page.extend(before.replace("{{style}}", STYLE).bytes());
    page.extend(block("dataset", &facts).bytes());
    for p in packed {
        page.extend(p.bytes());
    }
    page.extend(rest.replace("{{script}}", &SCRIPTS.concat()).bytes());
    Ok(Seal::put(page, &root_hash))
}

/// Data as an element that no browser runs.
fn block(id: &str, data: &impl Serialize) -> String {
    let json = serde_json::to_string(data).expect("facts are plain data with text keys");
    // `</script>` in a stranger's text would end the element.
    format!("<script type=\"application/json\" id=\"{id}\">{}</script>\n", json.replace('<', "\\u003c"))
}

/// What a scene file tells that people ask for.
fn scene_facts(told: &serde_json::Value) -> serde_json::Value {
    let mut facts = serde_json::Map::new();
    if let Some(parameters) = told.get("parameters").and_then(|p| p.as_object()) {
        facts.extend(parameters.iter().filter(|(name, _)| *name != "variant").map(|(k, v)| (k.clone(), v.clone())));
    }
    for name in ["pivot_height_m", "datum_m", "triangles", "generator_version"] {
        if let Some(value) = told.get(name).filter(|v| !v.is_null()) {
            facts.insert(name.to_owned(), value.clone());
        }
    }
    facts.into()
}

fn sample<'r>(
    dataset: &Dataset<'_>,
    record: &'r SampleRecord,
    index: usize,
    side: u32,
    beside: bool,
) -> Result<(SampleFacts<'r>, String), GalleryError> {
    let camera = dataset.camera(record)?;
    let plane = |layer, view| dataset.plane(record, &camera, layer, view);
    let disparity_px = plane(Layer::Disparity, View::Left)?.into_floats();
    let validity = plane(Layer::Validity, View::Left)?.into_bytes();
    let images = (plane(Layer::Image, View::Left)?, plane(Layer::Image, View::Right)?);
    let Reduced { every, columns, rows, left, right, labels } = reduced(&images, &disparity_px, &validity, side)
        .map_err(|reason| GalleryError::Format { id: record.id().to_owned(), reason })?;
    let path = |name: &str| {
        let path = record.files.get(name).map(|f| f.path.as_str());
        path.filter(|p| beside && Path::new(p).extension().is_some_and(|e| e == "png"))
    };
    let packed = Packed { left: STANDARD.encode(left), right: STANDARD.encode(right), labels: STANDARD.encode(labels) };
    let facts = SampleFacts {
        identity: &record.identity,
        valid_fraction: record.valid_fraction,
        occluded_fraction: record.occluded_fraction,
        out_of_frame_fraction: record.out_of_frame_fraction,
        disparity_min_px: record.disparity_min_px,
        disparity_max_px: record.disparity_max_px,
        gsd_m: camera.gsd_m,
        altitude_m: camera.altitude_m,
        doffs_px: camera.doffs_px,
        camera: camera.left,
        every,
        columns,
        rows,
        left_path: path("left"),
        right_path: path("right"),
    };
    Ok((facts, block(&format!("sample-{index}"), &packed)))
}
