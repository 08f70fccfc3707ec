//! Canyon: an incised plateau of hard and soft beds.

mod dress;
mod relief;
mod scatter;
mod strata;
mod undercuts;
mod valley;

use crate::kit::terrain::tiling::{Tiling, normal_of_slope, place_terrain};
use crate::kit::terrain::tin::{Breakline, Grain, Ground, TileMesh, triangulate};
use crate::{ParameterError, check_range};
use dress::slot;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use relief::{Cover, Extent, POST_M, Relief};
use satseed_scene::{Class, Mesh, Object, Scene, SeedPath, quantise_m};
use serde::{Deserialize, Serialize};
use strata::Strata;
use valley::{Channels, Fold, Trunk};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 4;

/// Parameters of a canyon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Depth of the river below the cap bed's mean height, m, 120..220; the plateau rises 10 to 30 m above the rim, so that
    /// the relief of a whole frame is larger by as much.
    pub relief_m: f64,
    /// Roughness of rock and soil below the scale of erosion, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour, 0..2; 1 is nature.
    pub texture_contrast: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { radius_m: 700.0, relief_m: 190.0, roughness: 1.0, texture_contrast: 1.0 }
    }
}

impl Params {
    #[allow(clippy::unused_self, reason = "other regions choose by their parameters")]
    pub(crate) fn variant(&self) -> &'static str {
        "gorge"
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("relief_m", self.relief_m, 120.0..=220.0)?;
        check_range("roughness", self.roughness, 0.0..=2.0)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        [-self.relief_m - 30.0, 60.0]
    }

    /// Rasters, triangulations in work and the finished meshes grow with the square of the radius; the erosion of the
    /// whole catchment does not. About twice what was measured: 29 MB at 60 m, 81 MB at 300 m (99 MB at roughness 2)
    /// and 240 MB at 700 m.
    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let side_m = 2.0 * (self.radius_m + 2.0 * TILE_M);
        (60e6 + side_m * side_m * (130.0 + 35.0 * self.roughness)) as u64
    }
}

/// Side of a terrain tile, m.
const TILE_M: f64 = 128.0;
/// How far the coarse ring reaches beyond the radius of full detail, m: the shadow of the whole relief at a sun 15
/// degrees high.
const RING_M: f64 = 800.0;

fn tiling(radius_m: f64) -> Tiling {
    Tiling::new(TILE_M, radius_m, RING_M, |nearest_m| {
        if nearest_m <= radius_m {
            Grain { post_m: POST_M, max_error_m: 0.05 }
        } else {
            Grain { post_m: 4.0, max_error_m: if nearest_m < radius_m + 200.0 { 0.5 } else { 1.5 } }
        }
    })
}

fn extent(radius_m: f64, tiling: &Tiling) -> Extent {
    Extent { radius_m, window_half_m: tiling.window_half_m, scene_half_m: tiling.scene_half_m() }
}

/// What decides a canyon's shape before there is a post of it.
struct Landscape {
    strata: Strata,
    fold: Fold,
    trunk: Trunk,
    channels: Channels,
}

impl Landscape {
    fn new(params: &Params, path: &SeedPath) -> Self {
        let strata = Strata::new(params.relief_m, &path.child("strata"));
        let fold = Fold::new(&path.child("fold"));
        let trunk = Trunk::new(params.relief_m, &path.child("trunk"));
        let channels = Channels::new(&strata, &fold, &trunk, &path.child("erosion"));
        Self { strata, fold, trunk, channels }
    }

    fn relief(&self, extent: Extent, roughness: f64, path: &SeedPath) -> Relief<'_> {
        let Self { strata, fold, trunk, channels } = self;
        Relief::new(strata, fold, trunk, channels, extent, roughness, &path.child("relief"))
    }
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let landscape = Landscape::new(params, &path);
    let tiling = tiling(params.radius_m);
    let extent = extent(params.radius_m, &tiling);
    let Extent { window_half_m, scene_half_m, .. } = extent;
    let relief = landscape.relief(extent, params.roughness, &path);
    let Landscape { strata, fold, trunk, .. } = &landscape;
    let banks = relief.banks(window_half_m + relief::MARGIN_M);
    let river = River::new(&banks);
    let tiles = triangulate(&tiling.layout, &relief, &banks.map(|points_m| Breakline { points_m }));
    let materials = dress::materials(strata, trunk.is_dry, params.texture_contrast, &path.child("materials"));
    let mut scene = Scene {
        material_sets: vec![(0..materials.len() as u32).collect()],
        materials,
        rasters: dress::rasters(fold, &relief, scene_half_m, &path.child("cover")),
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        pivot_height_m: relief.height_m(DVec2::ZERO),
        full_detail_radius_m: params.radius_m,
        ..Scene::default()
    };
    let meshes: Vec<Mesh> = tiles
        .into_par_iter()
        .enumerate()
        .map(|(k, tile)| dressed(tile, relief.slabs.tile(&tiling.layout, k), &relief, &river, trunk.is_dry))
        .collect();
    place_terrain(&mut scene, meshes);
    let reach_m = window_half_m.min(params.radius_m + 60.0);
    scatter::scatter(&mut scene, &relief, reach_m, strata.cliff_colors(), &path.child("scatter"));
    scene
}

/// A tile and the slabs over it as one mesh, with normals of the source raster and the material slot of each triangle.
fn dressed(tile: TileMesh, slabs: Mesh, relief: &Relief<'_>, river: &River, is_dry: bool) -> Mesh {
    let TileMesh { positions_m, triangles } = tile;
    let normals = positions_m.iter().map(|p| normal_at(relief, DVec2::new(p[0].into(), p[1].into()))).collect();
    let mut mesh = Mesh { positions_m, triangles, normals, ..Mesh::default() };
    mesh.append(slabs);
    mesh.slots = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            let middle = ((a + b + c) / 3.0).truncate();
            let upward = (b - a).cross(c - a).normalize().z;
            let Cover { bank_m, scree_m, .. } = relief.cover(middle);
            if bank_m < 4.0 && river.contains(middle) {
                return if is_dry { slot::SAND } else { slot::WATER };
            }
            if upward > 0.9 && bank_m < 22.0 {
                slot::SAND
            } else if upward > 0.7 && (scree_m > 0.3 || bank_m < 45.0) || (0.74..0.9).contains(&upward) {
                slot::GROUND
            } else {
                slot::ROCK
            }
        })
        .collect();
    mesh
}

/// The source raster's normal; straight up on the banks' lines, from where the water's surface has its normals.
fn normal_at(relief: &Relief<'_>, p: DVec2) -> [f32; 3] {
    let is_within = p.abs().max_element() < -relief.window.origin_m.x;
    let is_bank = is_within && relief.cover(p).bank_m < 0.5;
    normal_of_slope(if is_bank { DVec2::ZERO } else { relief.slope(p) })
}

/// The river's area between its banks, for asking whether a place lies in it.
struct River {
    /// Quads between neighbouring points of both banks, with their boxes.
    quads: Vec<[DVec2; 4]>,
}

impl River {
    fn new(banks: &[Vec<DVec3>; 2]) -> Self {
        // The vertices that the triangulation uses stand on the lattice.
        let flat = |p: DVec3| DVec2::new(quantise_m(p.x).into(), quantise_m(p.y).into());
        let quads = banks[0]
            .windows(2)
            .zip(banks[1].windows(2))
            .map(|(l, r)| [flat(r[0]), flat(r[1]), flat(l[1]), flat(l[0])])
            .collect();
        Self { quads }
    }

    fn contains(&self, p: DVec2) -> bool {
        self.quads.iter().any(|q| {
            let low = q[0].min(q[1]).min(q[2]).min(q[3]);
            let high = q[0].max(q[1]).max(q[2]).max(q[3]);
            p.cmpge(low).all()
                && p.cmple(high).all()
                && (0..4).all(|k| (q[(k + 1) % 4] - q[k]).perp_dot(p - q[k]) >= 0.0)
        })
    }
}

#[cfg(test)]
mod tests;
