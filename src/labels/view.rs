//! The label maps of one view.

use super::{Validity, View, disparity_px, validity};
use crate::camera::{Camera, StereoRig};
use glam::DVec3;
use rayon::prelude::*;
use satseed_scene::{Class, Environment, Ray};
use satseed_tracer::{Hit, Origin, TILE_SIDE, Tracer, tile_order};

/// Which labels to work out besides disparity and validity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Extra {
    /// Height above the datum.
    pub elevation: bool,
    /// Semantic class.
    pub class: bool,
    /// Object number.
    pub instance: bool,
    /// Geometric normal.
    pub normal: bool,
    /// Share of the sun's disc that is seen.
    pub shadow: bool,
    /// Mixed pixels.
    pub edge: bool,
}

/// Label maps of one view, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewLabels {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `u_L - u_R`, px, for every hit, also where it is occluded or out of frame; one canonical NaN where nothing was hit.
    pub disparity_px: Vec<f32>,
    /// [`Validity`] as a number.
    pub validity: Vec<u8>,
    /// Height of the surface seen above the region's datum, m; one canonical NaN where nothing was hit.
    pub elevation_m: Option<Vec<f32>>,
    /// [`Class`] as a number; 0 where nothing was hit.
    pub class: Option<Vec<u8>>,
    /// Index into the scene's objects; 0 is the terrain, and where nothing was hit.
    pub instance: Option<Vec<u32>>,
    /// Unit geometric normal towards the camera, world frame; zero where nothing was hit.
    pub normal: Option<Vec<[f32; 3]>>,
    /// Direct sun, 0 dark to 255 full.
    pub shadow: Option<Vec<u8>>,
    /// 1 where the pixel's corner rays span more than 1 px of disparity, or only some of them hit.
    pub edge: Option<Vec<u8>>,
}

/// The one NaN that is written: its bits are the same on every machine.
pub(crate) const MISS_NAN: f32 = f32::from_bits(0x7fc0_0000);

#[derive(Clone, Copy)]
struct Pixel {
    disparity_px: f32,
    validity: Validity,
    elevation_m: f32,
    class: Class,
    instance: u32,
    normal: [f32; 3],
    shadow: u8,
}

const MISS: Pixel = Pixel {
    disparity_px: MISS_NAN,
    validity: Validity::Miss,
    elevation_m: MISS_NAN,
    class: Class::None,
    instance: 0,
    normal: [0.0; 3],
    shadow: 0,
};

/// Works out the labels of one view. Tiles run in parallel on the current rayon pool; the result does not depend on it.
pub fn extract(tracer: &Tracer, rig: &StereoRig, view: View, sun: &Environment, extra: Extra) -> ViewLabels {
    let (camera, other) = view.cameras(rig);
    let (width, height) = (camera.width_px, camera.height_px);
    let pixels = by_tiles(width, height, |cells| {
        let rays: Vec<Ray> = cells.iter().map(|(u, v)| camera.ray(f64::from(*u), f64::from(*v))).collect();
        let hits = tracer.closest_all(&rays);
        let validity = validity(tracer, other, &hits);
        let shadow = if extra.shadow { sun_shares(tracer, &hits, sun) } else { vec![0; hits.len()] };
        hits.iter()
            .zip(validity.into_iter().zip(shadow))
            .map(|(hit, (validity, shadow))| {
                hit.map_or(MISS, |hit| Pixel { validity, shadow, ..pixel(tracer, rig, extra, &hit) })
            })
            .collect()
    });
    ViewLabels {
        width,
        height,
        disparity_px: pixels.iter().map(|p| p.disparity_px).collect(),
        validity: pixels.iter().map(|p| p.validity as u8).collect(),
        elevation_m: extra.elevation.then(|| pixels.iter().map(|p| p.elevation_m).collect()),
        class: extra.class.then(|| pixels.iter().map(|p| p.class as u8).collect()),
        instance: extra.instance.then(|| pixels.iter().map(|p| p.instance).collect()),
        normal: extra.normal.then(|| pixels.iter().map(|p| p.normal).collect()),
        shadow: extra.shadow.then(|| pixels.iter().map(|p| p.shadow).collect()),
        edge: extra.edge.then(|| edges(tracer, rig, camera)),
    }
}

/// All but validity and shadow of a pixel that hit something.
fn pixel(tracer: &Tracer, rig: &StereoRig, extra: Extra, hit: &Hit) -> Pixel {
    let scene = tracer.scene();
    Pixel {
        // A camera whose view of the point fails would have to lie below it; plans refuse such heights.
        disparity_px: disparity_px(rig, hit.point).map_or(MISS_NAN, |d| d as f32),
        elevation_m: hit.point.z as f32,
        class: if extra.class { scene.material(hit.instance, hit.triangle).class } else { Class::None },
        instance: scene.instances[hit.instance as usize].object,
        normal: hit.normal.to_array().map(|x| x as f32),
        ..MISS
    }
}

/// Values of all cells of a grid, row by row, worked out a tile at a time: `tile` gives the values of the cells (column,
/// row) that it is given.
fn by_tiles<T: Copy + Send>(width: u32, height: u32, tile: impl Fn(&[(u32, u32)]) -> Vec<T> + Sync) -> Vec<T> {
    let bands: Vec<Vec<T>> = (0..height)
        .step_by(TILE_SIDE as usize)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|top| {
            let rows = TILE_SIDE.min(height - top);
            let mut band: Vec<Option<T>> = vec![None; (width * rows) as usize];
            for left in (0..width).step_by(TILE_SIDE as usize) {
                let columns = TILE_SIDE.min(width - left);
                let cells: Vec<_> = tile_order(columns, rows).map(|(x, y)| (left + x, top + y)).collect();
                for ((u, v), value) in cells.iter().zip(tile(&cells)) {
                    band[((v - top) * width + u) as usize] = Some(value);
                }
            }
            band.into_iter().map(|value| value.expect("the tiles cover the band")).collect()
        })
        .collect();
    bands.into_iter().flatten().collect()
}

/// Points of the sun's disc that a shadow label asks: a fixed spiral, equal areas.
const DISC_POINTS: u32 = 16;

/// The shares of the solar disc that surface points see, 0..255; 0 where nothing was hit.
fn sun_shares(tracer: &Tracer, hits: &[Option<Hit>], sun: &Environment) -> Vec<u8> {
    let centre = sun.sun_direction();
    let (a, b) = centre.any_orthonormal_pair();
    let mut seen = vec![0_u32; hits.len()];
    for k in 0..DISC_POINTS {
        // Vogel's spiral: the golden angle, radius by the square root of the rank.
        let radius = Environment::SUN_ANGULAR_RADIUS_RAD * ((f64::from(k) + 0.5) / f64::from(DISC_POINTS)).sqrt();
        let (s, c) = libm::sincos(f64::from(k) * 2.399_963_229_728_653);
        let direction = (centre + (a * c + b * s) * libm::tan(radius)).normalize();
        let (asking, rays): (Vec<usize>, Vec<(Origin, DVec3)>) = hits
            .iter()
            .enumerate()
            .filter_map(|(i, hit)| {
                let hit = hit.as_ref().filter(|hit| direction.dot(hit.normal) > 0.0)?;
                Some((i, (Origin::on(hit), direction)))
            })
            .unzip();
        for (i, blocked) in asking.into_iter().zip(tracer.blocked_all(&rays)) {
            seen[i] += u32::from(!blocked);
        }
    }
    seen.into_iter().map(|n| (n * 255 / DISC_POINTS) as u8).collect()
}

/// 1 where the disparities at a pixel's four corners differ by more than 1 px, or some of them see nothing.
fn edges(tracer: &Tracer, rig: &StereoRig, camera: &Camera) -> Vec<u8> {
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let corners = by_tiles(camera.width_px + 1, camera.height_px + 1, |cells| {
        let ray = |(i, j): &(u32, u32)| camera.ray(f64::from(*i) - 0.5, f64::from(*j) - 0.5);
        let hits = tracer.closest_all(&cells.iter().map(ray).collect::<Vec<Ray>>());
        hits.iter().map(|hit| disparity_px(rig, hit.as_ref()?.point)).collect()
    });
    let corner = |i: usize, j: usize| corners[j * (width + 1) + i];
    let mut edge = Vec::with_capacity(width * height);
    for j in 0..height {
        for i in 0..width {
            let four = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
            let (mut low, mut high, mut hits) = (f64::INFINITY, f64::NEG_INFINITY, 0);
            for d in four.into_iter().flatten() {
                low = low.min(d);
                high = high.max(d);
                hits += 1;
            }
            edge.push(u8::from((hits > 0 && hits < 4) || high - low > 1.0));
        }
    }
    edge
}
