//! Contact sheets: the same views of the same seeds after every change, to be looked at.
//!
//! `cargo run --release --example contact_sheets [REGION ...]` writes docs/sheets/<region>-{nadir,detail,oblique}.jpg:
//! five seeds and more, each variant among them; the whole frame from above, two crops of 512 x 512 pixels at the
//! sensor's own 0.3 m, three oblique views. docs/sheets/regions.jpg has the first frame and crop of each region beside each other.

#![allow(clippy::print_stderr)]

use anyhow::Context as _;
use glam::{DMat3, DVec2, DVec3};
use image::{
    ExtendedColorType, ImageEncoder as _, ImageFormat, Rgb, RgbImage, codecs::jpeg::JpegEncoder, imageops::replace,
};
use satseed::camera::Camera;
use satseed::plan::Plan;
use satseed::recipe::{Preset, Recipe};
use satseed::render::{AmbientMode, Exposure, Image, Light, Sensor, Settings, develop, expose};
use satseed_generators::Region;
use satseed_scene::{Environment, Ray, SeedPath};
use satseed_tracer::Tracer;
use std::path::Path;

/// Fewest scenes of a region; seeds count from 1.
const SCENES: usize = 5;
/// Half a frame's side on the ground, m.
const HALF_FRAME_M: f64 = 307.2;
const CELL_PX: u32 = 512;
/// Between cells.
const GAP_PX: u32 = 6;
const SENSOR: Sensor = Sensor::WORLDVIEW3_RGB;

fn main() -> anyhow::Result<()> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let names: Vec<&str> =
        if asked.is_empty() { Region::NAMES.to_vec() } else { asked.iter().map(String::as_str).collect() };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sheets");
    std::fs::create_dir_all(&folder)?;
    let preset = Preset::by_name("satseed").context("the preset `satseed`")?;
    let plan = Plan::new(&Recipe::parse_with(preset.name, preset.text, &[])?)?;
    for name in names {
        let variants = plan.variants(name);
        anyhow::ensure!(!variants.is_empty(), "no region is called `{name}`; there are {}", Region::NAMES.join(", "));
        let mut sheets: [Vec<Vec<Image>>; 3] = Default::default();
        // A sheet shows all kinds of dunes, fields, forests, coasts and cities, and no fewer than five scenes.
        let count = variants.len().max(SCENES);
        for (seed, region) in (1..).zip(variants.iter().cycle().take(count)) {
            let scene = region.build(seed);
            scene.validate()?;
            eprintln!("{name}/{} {seed}: {:?} triangles held and placed", region.variant(), scene.triangle_counts());
            let tracer = Tracer::new(&scene);
            let own = Light::of(&tracer, &environment());
            let shared = own.clone().with_ambient(AmbientMode::PerScene, scene.full_detail_radius_m);
            // Pixels of a wide view share little.
            let [whole, crops, oblique] = views(&tracer);
            let views = [(whole, &own), (crops, &shared), (oblique, &own)];
            let [whole, crops, oblique] = views.map(|(cameras, light)| exposures(&tracer, &cameras, light));
            // As in a dataset, a crop has its frame's stretch: water alone would else be as bright as a beach.
            let count = whole.len();
            let mut from_above = develop([whole, crops].concat(), SENSOR);
            sheets[1].push(from_above.split_off(count));
            sheets[0].push(from_above);
            // There is much more air before some oblique views than before others.
            sheets[2].push(oblique.into_iter().flat_map(|view| develop(vec![view], SENSOR)).collect());
        }
        // The frames from above stand in one row.
        let nadir: Vec<Image> = sheets[0].drain(..).flatten().collect();
        write(&folder.join(format!("{name}-nadir.jpg")), &[nadir])?;
        write(&folder.join(format!("{name}-detail.jpg")), &transposed(&sheets[1]))?;
        write(&folder.join(format!("{name}-oblique.jpg")), &sheets[2])?;
    }
    all_regions(&folder)
}

/// The first frame and the first crop of each region's sheets beside each other: one look, one sun, one sensor.
fn all_regions(folder: &Path) -> anyhow::Result<()> {
    let columns = Region::NAMES.len() as u32;
    let mut both = RgbImage::from_pixel(columns * (CELL_PX + GAP_PX) - GAP_PX, 2 * CELL_PX + GAP_PX, Rgb([255; 3]));
    for (k, name) in (0..).zip(Region::NAMES) {
        for (row, sheet) in (0..).zip(["nadir", "detail"]) {
            let path = folder.join(format!("{name}-{sheet}.jpg"));
            let sheet = image::open(&path).with_context(|| format!("{} cannot be read", path.display()))?;
            let first = sheet.crop_imm(0, 0, CELL_PX, CELL_PX).to_rgb8();
            let step = i64::from(CELL_PX + GAP_PX);
            replace(&mut both, &first, k * step, row * step);
        }
    }
    Ok(both.save_with_format(folder.join("regions.jpg"), ImageFormat::Jpeg)?)
}

/// The cameras of the three sheets: whole frame, crops, oblique.
fn views(tracer: &Tracer) -> [Vec<Camera>; 3] {
    let whole = nadir(DVec2::ZERO, 2.0 * HALF_FRAME_M / f64::from(CELL_PX));
    let crops = [DVec2::new(20.0, -10.0), DVec2::new(-160.0, 130.0)].map(|at| nadir(at, 0.3));
    let oblique = [
        (DVec2::ZERO, DVec3::new(-260.0, -330.0, 300.0)),
        (DVec2::new(60.0, 40.0), DVec3::new(70.0, -110.0, 80.0)),
        (DVec2::new(-90.0, 20.0), DVec3::new(35.0, 40.0, 28.0)),
    ]
    .map(|(at, from)| {
        let ground = on_ground(tracer, at);
        // Never inside a building or below a slope, and never right before a wall.
        let eye = ground + from;
        let clear = on_ground(tracer, eye.truncate()).z + 12.0;
        let mut eye = eye.with_z(eye.z.max(clear));
        while !sees(tracer, eye, ground) {
            eye.z += 10.0;
        }
        Camera::looking_at(eye, ground, [CELL_PX, CELL_PX * 3 / 4], f64::from(CELL_PX) * 0.85)
    });
    [vec![whole], crops.to_vec(), oblique.to_vec()]
}

/// A frame from 1 km, north up.
fn nadir(centre: DVec2, gsd_m: f64) -> Camera {
    let focal_px = 1000.0 / gsd_m;
    // The whole scene is seen from over the pivot; a crop is a part of that frame, with its lean.
    let middle = (f64::from(CELL_PX) - 1.0) / 2.0;
    Camera {
        width_px: CELL_PX,
        height_px: CELL_PX,
        fx_px: focal_px,
        fy_px: focal_px,
        cx_px: middle - centre.x / gsd_m,
        cy_px: middle + centre.y / gsd_m,
        position_m: DVec3::new(0.0, 0.0, 1000.0),
        world_from_camera: DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
    }
}

/// Whether most of the way from an eye to where it looks is free; from high enough above it is.
fn sees(tracer: &Tracer, eye: DVec3, at: DVec3) -> bool {
    let way = at - eye;
    let ray = Ray { origin: eye, direction: way.normalize() };
    tracer.closest(&ray, 0.7 * way.length()).is_none()
}

fn on_ground(tracer: &Tracer, at: DVec2) -> DVec3 {
    let down = Ray { origin: at.extend(2000.0), direction: DVec3::NEG_Z };
    tracer.closest(&down, 4000.0).map_or(at.extend(0.0), |hit| hit.point)
}

fn environment() -> Environment {
    Environment {
        sun_elevation_rad: 42.0_f64.to_radians(),
        sun_azimuth_rad: 145.0_f64.to_radians(),
        aerosol_optical_depth: 0.12,
    }
}

fn exposures(tracer: &Tracer, cameras: &[Camera], light: &Light) -> Vec<Exposure> {
    let settings = Settings { samples_per_pixel: 4, sensor: SENSOR };
    cameras.iter().map(|camera| expose(tracer, camera, light, settings, &SeedPath::root("contact sheet", 0))).collect()
}

fn transposed(rows: &[Vec<Image>]) -> Vec<Vec<Image>> {
    (0..rows[0].len()).map(|k| rows.iter().map(|row| row[k].clone()).collect()).collect()
}

/// Cells side by side, rows below each other, a thin gap between.
fn write(path: &Path, rows: &[Vec<Image>]) -> anyhow::Result<()> {
    let (cell_width, cell_height) = (rows[0][0].width, rows[0][0].height);
    let width = (cell_width + GAP_PX) * rows[0].len() as u32 - GAP_PX;
    let height = (cell_height + GAP_PX) * rows.len() as u32 - GAP_PX;
    let mut pixels = vec![255; (width * height * 3) as usize];
    for (j, row) in rows.iter().enumerate() {
        for (i, cell) in row.iter().enumerate() {
            let left = (i as u32 * (cell_width + GAP_PX) * 3) as usize;
            for (v, line) in cell.bytes().chunks_exact(cell_width as usize * 3).enumerate() {
                let start = (j as u32 * (cell_height + GAP_PX) + v as u32) as usize * width as usize * 3 + left;
                pixels[start..start + line.len()].copy_from_slice(line);
            }
        }
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, 75).write_image(&pixels, width, height, ExtendedColorType::Rgb8)?;
    std::fs::write(path, bytes).with_context(|| format!("{} cannot be written", path.display()))
}
