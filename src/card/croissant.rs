//! Croissant 1.0: metadata that dataset tools and search engines read (<http://mlcommons.org/croissant/1.0>).

use super::Facts;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

/// A manifest line's plain columns: name, type, meaning.
const COLUMNS: [(&str, &str, &str); 14] = [
    ("id", "sc:Text", "scene and pair; the pair's folder"),
    ("region", "sc:Text", "kind of landscape or city"),
    ("variant", "sc:Text", "the region's variant"),
    ("scene_seed", "sc:Integer", "seed that the scene is grown from"),
    ("split", "sc:Text", "train, val or test"),
    ("scene_params_hash", "sc:Text", "hash of the scene's parameters"),
    ("baseline_m", "sc:Float", "distance of the optical centres, m"),
    ("azimuth_deg", "sc:Float", "direction of the baseline, clockwise from north, degrees"),
    ("convergence_deg", "sc:Float", "angle under which the baseline is seen from z = 0, degrees"),
    ("valid_fraction", "sc:Float", "share of the left view's pixels that both views see"),
    ("occluded_fraction", "sc:Float", "share that the right view's frame holds, but behind something"),
    ("out_of_frame_fraction", "sc:Float", "share beyond the right view's frame"),
    ("disparity_min_px", "sc:Float", "lowest disparity of the left view, px"),
    ("disparity_max_px", "sc:Float", "highest disparity of the left view, px"),
];

/// A sample's files that every dataset has: name of the set, what ends the path, encoding, meaning.
const SETS: [(&str, &str, &str, &str); 4] = [
    ("images", "*/*/left.*", "image/png", "left images; the right ones stand beside them"),
    ("disparities", "*/*/disparity_left.tif", "image/tiff", "f32, px, u_L - u_R, signed, also where it is occluded"),
    ("validities", "*/*/validity_left.png", "image/png", "0 nothing hit, 1 valid, 2 occluded, 3 out of frame"),
    ("cameras", "*/*/camera.json", "application/json", "both cameras, baseline, doffs, disparity range"),
];

/// The text of `croissant.json`.
pub(super) fn text(facts: &Facts, manifest: &[u8]) -> String {
    let s = &facts.summary;
    let sha256 = Sha256::digest(manifest).iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
    let mut distribution = vec![json!({
        "@type": "cr:FileObject", "@id": "manifest.jsonl", "name": "manifest.jsonl",
        "description": "one line a pair, in plan order, with the BLAKE3 of every file",
        "contentUrl": "manifest.jsonl", "contentSize": format!("{} B", manifest.len()),
        "encodingFormat": "application/jsonlines", "sha256": sha256,
    })];
    distribution.extend(SETS.map(|(name, includes, format, description)| {
        json!({
            "@type": "cr:FileSet", "@id": name, "name": name, "description": description,
            "encodingFormat": format, "includes": includes,
        })
    }));
    let fields: Vec<Value> = COLUMNS
        .iter()
        .map(|(name, kind, description)| {
            json!({
                "@type": "cr:Field", "@id": format!("pairs/{name}"), "name": name, "description": description,
                "dataType": kind,
                "source": { "fileObject": { "@id": "manifest.jsonl" }, "extract": { "column": name } },
            })
        })
        .collect();
    let page = json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": format!("satseed-{}", &s.root_hash[..12]),
        "description": format!(
            "Synthetic satellite-stereo pairs with exact labels: {} pairs of {} scenes, grown from seeds by {}.",
            s.samples, s.scenes, facts.program
        ),
        "license": "https://creativecommons.org/publicdomain/zero/1.0/",
        "version": "1.0.0",
        "citeAs": format!("satseed dataset, root hash BLAKE3 {}", s.root_hash),
        "keywords": ["stereo matching", "disparity", "satellite", "remote sensing", "synthetic"],
        "isLiveDataset": false,
        "distribution": distribution,
        "recordSet": [{
            "@type": "cr:RecordSet", "@id": "pairs", "name": "pairs", "description": "the pairs, as the manifest has them",
            "key": { "@id": "pairs/id" }, "field": fields,
        }],
    });
    serde_json::to_string_pretty(&page).expect("it is plain data with text keys") + "\n"
}

/// The names that Croissant 1.0 prescribes.
fn context() -> Value {
    json!({
        "@language": "en", "@vocab": "https://schema.org/",
        "citeAs": "cr:citeAs", "column": "cr:column", "conformsTo": "dct:conformsTo", "cr": "http://mlcommons.org/croissant/",
        "data": { "@id": "cr:data", "@type": "@json" }, "dataType": { "@id": "cr:dataType", "@type": "@vocab" },
        "dct": "http://purl.org/dc/terms/", "equivalentProperty": "cr:equivalentProperty", "examples": { "@id": "cr:examples", "@type": "@json" },
        "extract": "cr:extract", "field": "cr:field", "fileProperty": "cr:fileProperty", "fileObject": "cr:fileObject",
        "fileSet": "cr:fileSet", "format": "cr:format", "includes": "cr:includes", "isLiveDataset": "cr:isLiveDataset",
        "jsonPath": "cr:jsonPath", "key": "cr:key", "md5": "cr:md5", "parentField": "cr:parentField", "path": "cr:path",
        "rai": "http://mlcommons.org/croissant/RAI/", "recordSet": "cr:recordSet", "references": "cr:references",
        "regex": "cr:regex", "repeated": "cr:repeated", "replace": "cr:replace", "samplingRate": "cr:samplingRate",
        "sc": "https://schema.org/", "separator": "cr:separator", "source": "cr:source", "subField": "cr:subField",
        "transform": "cr:transform",
    })
}
