//! Forest: stands of several species over eroded hills, with a stream, a track, rides, gaps and clearings.

mod dress;
mod floor;
mod growth;
mod land;
mod lines;
mod plant;
mod stands;

use crate::kit::terrain::tiling::{Tiling, normal_of_slope, place_terrain};
use crate::kit::terrain::tin::{Grain, Ground, TileMesh, triangulate};
use crate::{ParameterError, check_range};
use glam::{DVec2, DVec3};
use growth::Growth;
use land::Land;
use rayon::prelude::*;
use satseed_scene::{Class, Mesh, Object, Scene, SeedPath};
use serde::{Deserialize, Serialize};
use stands::Stands;

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 4;

/// How the forest is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Mostly broad-leaved and mixed stands.
    Mixed,
    /// Mostly planted spruce, pine and larch.
    Conifer,
    /// Much of it felled or young.
    Logged,
}

/// Parameters of a forest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How the forest is kept.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Height of the hills within 700 m of the pivot, lowest to highest, m, 20..150.
    pub relief_m: f64,
    /// Factor on pits, mounds and all other relief smaller than the hills, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour among trees and over the ground, 0..2; 1 is nature, and at 0 every leaf has one colour.
    pub texture_contrast: f64,
    /// Factor on how densely trees stand, 0.5..1.5; 1 is a closed forest.
    pub density: f64,
    /// Factor on the share of conifers, 0..3; 1 is the variant's own.
    pub conifers: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            variant: Variant::Mixed,
            radius_m: 700.0,
            relief_m: 70.0,
            roughness: 1.0,
            texture_contrast: 1.0,
            density: 1.0,
            conifers: 1.0,
        }
    }
}

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Mixed => "mixed",
            Variant::Conifer => "conifer",
            Variant::Logged => "logged",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("relief_m", self.relief_m, 20.0..=150.0)?;
        check_range("roughness", self.roughness, 0.0..=2.0)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)?;
        check_range("density", self.density, 0.5..=1.5)?;
        check_range("conifers", self.conifers, 0.0..=3.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        // Hills, what lies on them, roots below and the highest crowns above.
        let reach = land::REACH * self.relief_m + land::DETAIL_M;
        [-reach - 4.0, reach + 52.0]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let side_m = 2.0 * (self.radius_m + RING_M + TILE_M);
        (600e6 + side_m * side_m * (220.0 + 60.0 * self.roughness)) as u64
    }
}

/// Side of a terrain tile, m.
const TILE_M: f64 = 128.0;
/// How far the coarse ring reaches beyond the radius of full detail, m.
const RING_M: f64 = 220.0;
/// How far from the pivot anything may stand in the largest scene, m.
const REACH_M: f64 = 900.0 + RING_M;
/// Half the side of the square in which hills, streams and stands are made, whatever the radius: so a small scene is a part
/// of the large one. It holds all tiles of the largest scene.
const HALF_M: f64 = 12.0 * TILE_M;

fn tiling(radius_m: f64) -> Tiling {
    Tiling::new(TILE_M, radius_m, RING_M, |nearest_m| {
        if nearest_m <= radius_m {
            Grain { post_m: land::POST_M, max_error_m: 0.05 }
        } else {
            Grain { post_m: 4.0, max_error_m: 0.5 }
        }
    })
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let path = path.child(params.variant());
    let Tiling { layout, window_half_m } = tiling(params.radius_m);
    let scene_half_m = -layout.origin_m.x;
    let land = Land::new(params.relief_m, params.roughness, window_half_m, &path.child("land"));
    let stands = Stands::new(&land, params, &path.child("stands"));
    let growth = Growth::new(&land, &stands, params, scene_half_m, &path.child("trees"));
    let tiles = triangulate(&layout, &land, &[]);
    let cover = dress::cover(&land, &stands, &growth, scene_half_m, &path.child("cover"));
    let materials = dress::materials(params.texture_contrast, &path.child("materials"));
    let meshes: Vec<Mesh> = tiles.into_par_iter().map(|tile| dressed(tile, &land, &stands)).collect();
    let mut scene = Scene {
        material_sets: vec![(0..materials.len() as u32).collect()],
        materials,
        rasters: vec![cover],
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        pivot_height_m: land.height_m(DVec2::ZERO),
        full_detail_radius_m: params.radius_m,
        ..Scene::default()
    };
    place_terrain(&mut scene, meshes);
    let near_m = (window_half_m - 4.0).min(params.radius_m + 60.0);
    let far_m = scene_half_m.min(params.radius_m + RING_M) - 10.0;
    plant::plant(&mut scene, &land, &growth, [near_m, far_m], params.texture_contrast, &path.child("plant"));
    floor::scatter(&mut scene, &land, &stands, &growth, near_m, params.texture_contrast, &path.child("floor"));
    scene
}

/// A tile with normals of the ground and the material slot of each triangle.
fn dressed(tile: TileMesh, land: &Land, stands: &Stands) -> Mesh {
    let normals =
        tile.positions_m.iter().map(|p| normal_of_slope(land.slope(DVec2::new(p[0].into(), p[1].into())))).collect();
    let slots = tile
        .triangles
        .iter()
        .map(|t| {
            let corners = t.map(|v| DVec3::from_array(tile.positions_m[v as usize].map(f64::from)));
            dress::slot_at(land, stands, ((corners[0] + corners[1] + corners[2]) / 3.0).truncate())
        })
        .collect();
    Mesh { positions_m: tile.positions_m, triangles: tile.triangles, slots, normals, uvs_m: Vec::new() }
}

#[cfg(test)]
mod tests;
