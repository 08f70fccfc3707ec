//! A sample or scene made again, held against the one that stands.

use super::formats::{FormatError, Plane};
use super::layer::View;
use super::reader::{Dataset, ReadError};
use super::record::{FileRecord, SampleRecord};
use super::sample::Sample;
use super::verify::{Fault, Finding};
use super::writer::{SceneFiles, to_json};

/// Holds a sample made again against its record and, where they differ, against its files: both hashes, and the first
/// pixel that is another.
///
/// # Errors
/// Where the store fails.
pub fn compare_sample(
    dataset: &Dataset<'_>,
    record: &SampleRecord,
    mut made: Sample,
) -> Result<Vec<Finding>, ReadError> {
    let fault = |path: &str, reason: String| ReadError::File { path: path.to_owned(), reason };
    made.count().map_err(|e| fault(record.id(), e.to_string()))?;
    let mut findings = Vec::new();
    let mut names = vec!["camera".to_owned()];
    let camera = to_json(&made.camera);
    findings.extend(compare_text(record, "camera", &format!("{}/camera.json", record.id()), &camera));
    for (layer, view, plane) in &made.planes {
        let name = layer.key(*view);
        let path = format!("{}/{}", record.id(), layer.file_name(*view, plane.kind()));
        names.push(name.clone());
        let Some(standing) = record.files.get(&name) else {
            findings.push(Finding::new(path, Fault::NotReproduced, "the record does not name it"));
            continue;
        };
        let bytes = plane.encode().map_err(|e: FormatError| fault(&path, e.to_string()))?;
        let new = FileRecord::of(path, &bytes, Some(plane.pixel_hash()));
        if new.pixels_blake3 != standing.pixels_blake3 {
            let camera = if *view == View::Left { &made.camera.left } else { &made.camera.right };
            let read = dataset.store().get(&standing.path).ok();
            let old = read.and_then(|b| Plane::decode(&b, plane.kind(), camera.width_px, camera.height_px).ok());
            findings.push(Finding::new(
                &new.path,
                Fault::NotReproduced,
                difference(standing, &new, old.as_ref(), plane),
            ));
        } else if new != *standing {
            let detail = format!(
                "its pixels are the same, but BLAKE3 of the file is {} and was made as {}: another encoder",
                standing.blake3, new.blake3
            );
            findings.push(Finding::new(&new.path, Fault::NotReproduced, detail));
        }
    }
    for (name, file) in &record.files {
        if file.path.starts_with(&format!("{}/", record.id())) && !names.contains(name) {
            findings.push(Finding::new(&file.path, Fault::NotReproduced, "its recipe does not make such a file"));
        }
    }
    Ok(findings)
}

/// Holds a scene's shared files made again against what a sample's record says of them.
///
/// # Errors
/// Where a height map cannot be encoded.
pub fn compare_scene(
    dataset: &Dataset<'_>,
    record: &SampleRecord,
    made: &SceneFiles,
) -> Result<Vec<Finding>, ReadError> {
    let scene = record.scene();
    let mut findings: Vec<Finding> =
        compare_text(record, "scene", &format!("{scene}/scene.json"), &made.scene_json).into_iter().collect();
    for (name, map) in [("dsm", &made.dsm), ("dtm", &made.dtm), ("ndsm", &made.ndsm)] {
        let new = map.pixel_hash().to_hex().to_string();
        let standing = record.files.get(name).and_then(|f| f.pixels_blake3.clone()).unwrap_or_default();
        if new != standing {
            let cell = match dataset.height_map(record, name) {
                Ok(old) if old.heights_m.len() == map.heights_m.len() => {
                    let differs = |(a, b): (&f32, &f32)| a.to_bits() != b.to_bits();
                    let at = old.heights_m.iter().zip(&map.heights_m).position(differs);
                    at.map_or_else(String::new, |i| {
                        let (x, y) = (i % map.width as usize, i / map.width as usize);
                        let (old, new) = (old.heights_m[i], map.heights_m[i]);
                        format!("; first at column {x}, row {y} from the south: {old} m stands, {new} m was made")
                    })
                }
                _ => String::new(),
            };
            let detail = format!("BLAKE3 of its pixels is {standing}, but was made as {new}{cell}");
            findings.push(Finding::new(format!("{scene}/{name}.tif"), Fault::NotReproduced, detail));
        }
    }
    Ok(findings)
}

fn compare_text(record: &SampleRecord, name: &str, path: &str, made: &str) -> Option<Finding> {
    let new = blake3::hash(made.as_bytes()).to_hex().to_string();
    let standing = record.files.get(name).map_or("nothing", |f| f.blake3.as_str());
    (new != standing)
        .then(|| Finding::new(path, Fault::NotReproduced, format!("BLAKE3 {standing} stands, but {new} was made")))
}

fn difference(standing: &FileRecord, new: &FileRecord, old: Option<&Plane>, made: &Plane) -> String {
    let hash = |r: &FileRecord| r.pixels_blake3.clone().unwrap_or_default();
    let hashes = format!("BLAKE3 of its pixels is {}, but was made as {}", hash(standing), hash(new));
    match old.and_then(|old| old.first_difference(made).map(|i| (old, i))) {
        Some((old, i)) => {
            let (u, v) = (i % made.width as usize, i / made.width as usize);
            format!("{hashes}; first at pixel ({u}, {v}): {} stands, {} was made", old.describe(i), made.describe(i))
        }
        None => hashes,
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::tests::synthetic;
    use super::super::writer_tests::{contents, generate, scene_files};
    use super::*;
    use crate::dataset::MemoryStore;
    use crate::dataset::formats::Pixels;

    #[test]
    fn a_difference_is_told_by_both_hashes_and_its_first_pixel() {
        let store = MemoryStore::default();
        generate(&store, &contents()).unwrap();
        let dataset = Dataset::open(&store).unwrap();
        let record = dataset.record("canyon-gorge-7/b00-a01").unwrap();
        let same = || synthetic("canyon-gorge-7", "b00-a01", 12, 9);
        assert_eq!(compare_sample(&dataset, record, same()).unwrap(), []);

        let mut other = same();
        let old = {
            let Pixels::Float(d) = &mut other.planes[2].2.pixels else { panic!() };
            let hit = (30..108).find(|i| !d[*i].is_nan()).unwrap();
            let old = d[hit];
            d[hit] += 0.5;
            (hit, old, d[hit])
        };
        let findings = compare_sample(&dataset, record, other).unwrap();
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert_eq!(findings[0].path, "canyon-gorge-7/b00-a01/disparity_left.tif");
        let (hit, from, to) = old;
        let words = format!("first at pixel ({}, {}): {from} ", hit % 12, hit / 12);
        assert!(findings[0].detail.contains(&words), "{} / {words}", findings[0].detail);
        assert!(findings[0].detail.contains(&format!("{to} (")), "{}", findings[0].detail);

        let mut moved = same();
        moved.camera.left.cx_px += 1e-9;
        let findings = compare_sample(&dataset, record, moved).unwrap();
        assert_eq!(findings[0].path, "canyon-gorge-7/b00-a01/camera.json");

        let mut files = scene_files("canyon-gorge-7");
        assert_eq!(compare_scene(&dataset, record, &files).unwrap(), []);
        files.dsm.heights_m[7] += 0.25;
        let findings = compare_scene(&dataset, record, &files).unwrap();
        assert!(findings[0].detail.contains("column 2, row 1 from the south: 17 m stands, 17.25 m"), "{findings:?}");
    }
}
