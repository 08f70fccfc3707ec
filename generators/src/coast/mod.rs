//! Coast: a beach with dunes or a cliff with coves, and the sea before it.

mod chop;
mod cover;
mod dress;
mod notch;
mod relief;
mod scatter;
mod shore;
mod swell;

use crate::kit::terrain::tiling::{Tiling, normal_of_slope, place_terrain};
use crate::kit::terrain::tin::{Grain, Ground, TileMesh, triangulate};
use crate::{ParameterError, check_range};
use cover::slot;
pub(crate) use dress::{coded_depth, over_depth};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use relief::{POST_M, Relief};
use satseed_scene::{Class, Mesh, Object, Scene, SeedPath};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 4;

/// What the sea meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// A sandy beach before dunes, with groynes.
    Beach,
    /// Headlands of rock with coves between them.
    Cliff,
}

/// Parameters of a coast.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// What the sea meets.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Height of the land behind the shore, m, 5..45: of cliffs' tops; dunes are about a quarter of it high.
    pub relief_m: f64,
    /// Factor on rock's and dunes' small relief and on the wind's waves, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour on land and sea, foam excepted, 0..2; 1 is nature.
    pub texture_contrast: f64,
    /// Height of the swell off the shore, crest to trough, m, 0.2..2.
    pub swell_m: f64,
    /// Factor on the number of plants, 0..3.
    pub plants: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            variant: Variant::Beach,
            radius_m: 700.0,
            relief_m: 22.0,
            roughness: 1.0,
            texture_contrast: 1.0,
            swell_m: 0.9,
            plants: 1.0,
        }
    }
}

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Beach => "beach",
            Variant::Cliff => "cliff",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("relief_m", self.relief_m, 5.0..=45.0)?;
        check_range("roughness", self.roughness, 0.0..=2.0)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)?;
        check_range("swell_m", self.swell_m, 0.2..=2.0)?;
        check_range("plants", self.plants, 0.0..=3.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        // Troughs and the feet of what stands in the water; hills behind the shore, and bushes on them.
        [-2.0 - self.swell_m - relief::ROOT_M, 1.9 * self.relief_m + 12.0 + 3.0 * self.roughness]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let side_m = 2.0 * (self.radius_m + RING_M + TILE_M);
        (200e6 + side_m * side_m * (150.0 + 60.0 * self.roughness)) as u64
    }
}

/// Side of a terrain tile, m.
const TILE_M: f64 = 128.0;
/// How far the coarse ring reaches beyond the radius of full detail, m: the shadow of the highest cliffs at a sun 10 degrees
/// high, and what an oblique view shows behind the detail.
const RING_M: f64 = 250.0;
/// Half the side of the square over which shore and swell are worked out, m, for every radius the same: so a small scene is
/// a part of the large one.
const HALF_M: f64 = 1216.0;

fn tiling(radius_m: f64) -> Tiling {
    Tiling::new(TILE_M, radius_m, RING_M, |nearest_m| {
        if nearest_m <= radius_m {
            Grain { post_m: POST_M, max_error_m: 0.05 }
        } else {
            Grain { post_m: 2.0, max_error_m: if nearest_m < radius_m + 120.0 { 0.2 } else { 0.4 } }
        }
    })
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let path = path.child(params.variant());
    let tiling = tiling(params.radius_m);
    let (window_half_m, scene_half_m) = (tiling.window_half_m, tiling.scene_half_m());
    let relief = Relief::new(params, window_half_m, &path.child("relief"));
    let tiles = triangulate(&tiling.layout, &relief, &[]);
    let materials = dress::materials(&relief, params.texture_contrast, &path.child("materials"));
    let mut scene = Scene {
        material_sets: vec![(0..materials.len() as u32).collect()],
        materials,
        rasters: vec![cover::cover(&relief, scene_half_m)],
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        pivot_height_m: relief.height_m(DVec2::ZERO),
        full_detail_radius_m: params.radius_m,
        ..Scene::default()
    };
    let meshes: Vec<Mesh> = tiles
        .into_par_iter()
        .enumerate()
        .map(|(k, tile)| dressed(&tile, relief.slabs.tile(&tiling.layout, k), &relief))
        .collect();
    place_terrain(&mut scene, meshes);
    // What stands at the rim must find the ground under all of it in full detail.
    let reach_m = (window_half_m - 6.0).min(params.radius_m + 60.0);
    scatter::scatter(&mut scene, &relief, reach_m, params.plants, &path.child("scatter"));
    scene
}

/// A tile with normals of the source surfaces and the material slot of each triangle. Where water meets land a vertex
/// stands twice, with the normal of each. Then the slabs over the tile's notches.
fn dressed(tile: &TileMesh, mut slabs: Mesh, relief: &Relief) -> Mesh {
    let mut mesh = Mesh::default();
    let mut index: BTreeMap<(u32, bool), u32> = BTreeMap::new();
    for t in &tile.triangles {
        let corners = t.map(|v| DVec3::from_array(tile.positions_m[v as usize].map(f64::from)));
        let middle = (corners[0] + corners[1] + corners[2]).truncate() / 3.0;
        let surface = relief.surface(middle);
        let water = surface.water_m > surface.land_m;
        let corner = |k: usize| {
            *index.entry((t[k], water)).or_insert_with(|| {
                mesh.positions_m.push(tile.positions_m[t[k] as usize]);
                let p = corners[k].truncate();
                // Far off, triangles are larger than waves, and few of their slopes would pass for all.
                let slope = if water && !relief.is_detailed(p) { DVec2::ZERO } else { relief.slope(p, water) };
                mesh.normals.push(normal_of_slope(slope));
                mesh.positions_m.len() as u32 - 1
            })
        };
        let triangle = [0, 1, 2].map(corner);
        mesh.triangles.push(triangle);
        mesh.slots.push(if water { slot::WATER } else { land_slot(relief, corners, &surface) });
    }
    slabs.slots = (0..slabs.triangles.len())
        .map(|t| {
            let corners = slabs.corners(t);
            let surface = relief.surface((corners[0] + corners[1] + corners[2]).truncate() / 3.0);
            land_slot(relief, corners, &surface)
        })
        .collect();
    mesh.append(slabs);
    mesh
}

fn land_slot(relief: &Relief, corners: [DVec3; 3], surface: &relief::Surface) -> u16 {
    let [a, b, c] = corners;
    cover::slot_of(relief, (a + b + c).truncate() / 3.0, surface, (b - a).cross(c - a).normalize().z)
}

#[cfg(test)]
mod tests;
