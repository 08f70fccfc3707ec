//! The JSON schema of a recipe, for editors: keys, words, ranges and what they mean while one types.
//!
//! It is as strict as a schema can be; what depends on several keys at once only reading the recipe tells.

use super::parts::{AMBIENT, BANDS, DisparityPrecision, Label, SensorCoding, SensorPreset, SplitRule};
use super::presets::PRESETS;
use super::{MAX_PIVOTS, MAX_SEED, MAX_STEPS};
use crate::render::sensor::{MAX_MTF, MIN_MTF};
use satseed_generators::Region;
use serde_json::{Map, Value, json};

/// The JSON schema (draft 2020-12) of a recipe in TOML.
pub fn schema() -> Value {
    let mut regions = serde_json::to_value(schemars::schema_for!(Region)).unwrap_or_default();
    let definitions = regions.get_mut("$defs").map_or_else(|| json!({}), Value::take);
    let mut scene = Map::new();
    scene.insert("pivots".into(), whole(1, MAX_PIVOTS, "how many scenes of it; their seeds follow from the recipe's"));
    scene.insert(
        "seeds".into(),
        json!({
            "type": "array", "minItems": 1, "items": { "type": "integer", "minimum": 0 },
            "description": "the scenes' own seeds, instead of `pivots`",
        }),
    );
    for one in regions["oneOf"].as_array_mut().into_iter().flatten() {
        if let Some(properties) = one.get_mut("properties").and_then(Value::as_object_mut) {
            scene.append(properties);
        }
    }
    let presets: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "satseed recipe",
        "description": "What a dataset is. docs/recipe.md tells more.",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "extends": { "enum": presets, "description": "the preset that this recipe is laid over" },
            "seed": whole(0, MAX_SEED, "seed of the recipe; the scenes' seeds follow from it"),
            "camera": table(camera()),
            "acquisition": table(acquisition()),
            "light": table(light()),
            "sensor": table(sensor()),
            "labels": table(labels()),
            "split": table(json!({
                "rule": words(SplitRule::ALL, "how pairs fall into train, val and test"),
            })),
            "scene": {
                "type": "array", "minItems": 1,
                "description": "a region with its parameters each",
                "items": { "type": "object", "additionalProperties": false, "minProperties": 1, "properties": scene },
            },
            "stages": versions("versions of the program's stages, in a dataset's own recipe.toml"),
            "generators": versions("versions of the regions' generators, in a dataset's own recipe.toml"),
        },
        "$defs": definitions,
    })
}

fn camera() -> Value {
    json!({
        "altitude_m": number(100.0, 1e6, "height of both cameras above z = 0, m"),
        "gsd_m": number(0.01, 30.0, "size of a pixel at z = 0, m"),
        "size_px": {
            "type": "array", "minItems": 2, "maxItems": 2,
            "items": { "type": "integer", "minimum": 8, "maximum": 16384 },
            "description": "width and height of a frame, px",
        },
        "datum": either(
            json!({ "enum": ["none", "pivot", "lowest"] }),
            json!({ "type": "number", "minimum": -1000.0, "maximum": 9000.0 }),
            "where the disparity is zero: at infinity, at the pivot's height, under the lowest point, or at a height in m",
        ),
    })
}

fn acquisition() -> Value {
    json!({
        "baseline_m": series(0.01, 2e6, "steps", "distances of the cameras, m"),
        "convergence_deg": series(0.01, 90.0, "steps", "angles 2 atan(B / 2H) instead of baselines, degrees"),
        "azimuth_deg": series(-360.0, 360.0, "draws", "directions from the left to the right camera, degrees clockwise from north"),
        "pivot_along_baseline": either(
            json!({ "const": "random" }),
            json!({ "type": "number", "minimum": -10.0, "maximum": 11.0 }),
            "where the pivot stands along the baseline: 0 under the left camera, 1 under the right one",
        ),
        "pairs_per_pivot": whole(1, 1_000_000, "takes only so many of a pivot's pairs"),
    })
}

fn light() -> Value {
    let angles = json!({
        "elevation_deg": number(10.0, 90.0, "above the horizon, degrees"),
        "azimuth_deg": number(-360.0, 360.0, "clockwise from north, degrees"),
        "date": { "type": "string", "pattern": "^[0-9]{4}-[0-9]{2}-[0-9]{2}$", "description": "day, such as 2024-06-21" },
        "local_solar_time": { "type": "string", "pattern": "^[0-9]{2}:[0-9]{2}$", "description": "sundial time, such as 10:30" },
        "latitude_deg": number(-90.0, 90.0, "north of the equator, degrees"),
    });
    json!({
        "sun": table(angles),
        "aerosol_optical_depth": number(0.0, 1.0, "at 550 nm"),
        "ambient": words(AMBIENT, "light of the sky: known once a scene, or worked out for each sample"),
    })
}

fn sensor() -> Value {
    let none_or = |low, high, what: &str| {
        either(json!({ "const": "none" }), json!({ "type": "number", "minimum": low, "maximum": high }), what)
    };
    json!({
        "preset": words(SensorPreset::ALL, "where the settings below start"),
        "samples_per_pixel": whole(1, 4096, "rays that a pixel's colour is averaged over"),
        "bands": words(BANDS, "what it sees"),
        "mtf_at_nyquist": none_or(MIN_MTF, MAX_MTF, "sharpness of the optics"),
        "smear_px": number(0.0, 2.0, "motion along the track, px"),
        "snr": none_or(5.0, 100_000.0, "signal to noise at reflectance 0.3"),
        "read_noise": number(0.0, 0.05, "noise without signal, reflectance"),
        "column_gain": number(0.0, 0.05, "deviation of the columns' gains"),
        "colour_ratio": whole(1, 8, "how many times coarser the colour bands are"),
        "colour_offset_px": number(-2.0, 2.0, "shift of the colour bands, px"),
        "coding": words(SensorCoding::ALL, "what numbers an image holds"),
        "stretch_percent": {
            "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number", "minimum": 0, "maximum": 100 },
            "description": "percentiles that become black and white",
        },
        "gamma": number(0.2, 1.0, "exponent of the stretch"),
    })
}

fn labels() -> Value {
    let write: Vec<&str> = Label::ALL.iter().map(|(word, _)| *word).collect();
    json!({
        "write": {
            "type": "array", "uniqueItems": true, "items": { "enum": write },
            "description": "what is written beside the left view's disparity and validity",
        },
        "disparity_precision": words(DisparityPrecision::ALL, "how finely a disparity file tells a value"),
    })
}

#[allow(clippy::needless_pass_by_value)] // It is called with what was made for it.
fn table(properties: Value) -> Value {
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

fn number(low: f64, high: f64, what: &str) -> Value {
    json!({ "type": "number", "minimum": low, "maximum": high, "description": what })
}

fn whole(low: u64, high: u64, what: &str) -> Value {
    json!({ "type": "integer", "minimum": low, "maximum": high, "description": what })
}

fn words<T>(words: &[(&str, T)], what: &str) -> Value {
    json!({ "enum": words.iter().map(|(word, _)| *word).collect::<Vec<_>>(), "description": what })
}

#[allow(clippy::needless_pass_by_value)]
fn either(a: Value, b: Value, what: &str) -> Value {
    json!({ "anyOf": [a, b], "description": what })
}

/// A number, a list, or two ends and a count.
fn series(low: f64, high: f64, count: &str, what: &str) -> Value {
    let number = json!({ "type": "number", "minimum": low, "maximum": high });
    let ends = json!({
        "type": "object", "additionalProperties": false, "required": ["from", "to", count],
        "properties": { "from": number, "to": number, count: { "type": "integer", "minimum": 1, "maximum": MAX_STEPS } },
    });
    json!({ "anyOf": [number, { "type": "array", "minItems": 1, "items": number }, ends], "description": what })
}

fn versions(what: &str) -> Value {
    json!({ "type": "object", "additionalProperties": { "type": "integer", "minimum": 0 }, "description": what })
}
