//! Desert: dunes of the slab model over gravel flats and playa.

mod dress;
mod dunes;
mod grid;
mod mounds;
mod relief;
mod scatter;
mod tracks;
mod werner;

use crate::kit::terrain::tiling::{Tiling, normal_of_slope, place_terrain};
use crate::kit::terrain::tin::{Breakline, Grain, Ground, TileMesh, triangulate};
use crate::{ParameterError, check_range};
use dress::slot;
use dunes::{Domain, Dunes};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use relief::{DETAIL_LIMIT_M, Face, POST_M, Relief};
use satseed_scene::{Class, Mesh, Object, Scene, SeedPath};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tracks::Tracks;
use werner::Regime;

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 5;

/// Which dunes the wind makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Little sand, one wind: crescents and short ridges with bare ground between them.
    Barchan,
    /// Much sand, one wind: ridges across the wind.
    Transverse,
    /// Two winds in turn: ridges along their mean.
    Linear,
}

/// Parameters of a desert.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Which dunes.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Height of the large dunes above the ground around them, m, 4..30; their distance grows with it.
    pub relief_m: f64,
    /// Factor on the amount of sand, 0.4..2; 1 is the variant's own.
    pub sand: f64,
    /// Factor on megaripples, hummocks and all other relief smaller than a dune, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour and of fine ripples, 0..2; 1 is nature, and at 0 all ground has one colour and shows its form alone.
    pub texture_contrast: f64,
    /// Factor on the number of shrubs, 0..3.
    pub shrubs: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            variant: Variant::Barchan,
            radius_m: 700.0,
            relief_m: 12.0,
            sand: 1.0,
            roughness: 1.0,
            texture_contrast: 1.0,
            shrubs: 1.0,
        }
    }
}

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::Barchan => "barchan",
            Variant::Transverse => "transverse",
            Variant::Linear => "linear",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("relief_m", self.relief_m, 4.0..=30.0)?;
        check_range("sand", self.sand, 0.4..=2.0)?;
        check_range("roughness", self.roughness, 0.0..=2.0)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)?;
        check_range("shrubs", self.shrubs, 0.0..=3.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        // The ground's own rise and fall, what lies on it, shrubs and their roots; no dune is twice the stated height.
        [-8.0, 2.0 * self.relief_m + DETAIL_LIMIT_M + 8.0]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let side_m = 2.0 * (self.radius_m + RING_M + TILE_M);
        (150e6 + side_m * side_m * (120.0 + 60.0 * self.roughness)) as u64
    }

    /// Side of the slab model's cells, m: a dune is as many of them high and long whatever its size.
    fn cell_m(&self) -> f64 {
        (self.relief_m / 4.5).max(1.8)
    }

    fn regime(&self, path: &SeedPath) -> Regime {
        let mut rng = path.rng();
        let (hops, sweeps_a_wind, sweeps, mean, patch): (&[[i32; 2]], _, _, _, _) = match self.variant {
            Variant::Barchan => (&[[5, 0]], 1, 300, rng.range(4.0, 7.5), [170.0, 1.0]),
            Variant::Transverse => (&[[5, 0]], 1, 300, rng.range(14.0, 20.0), [170.0, 1.0]),
            Variant::Linear => (&[[3, 4], [3, -4]], 6, 360, rng.range(8.0, 12.0), [46.0, 7.0]),
        };
        Regime { hops: hops.to_vec(), sweeps_a_wind, sweeps, mean: mean * self.sand, patch }
    }
}

/// Side of a terrain tile, m.
const TILE_M: f64 = 128.0;
/// How far the coarse ring reaches beyond the radius of full detail, m: the shadow of the highest dunes at a sun 7 degrees
/// high, and what an oblique view shows behind the detail.
const RING_M: f64 = 250.0;
/// Where the wind blows, for every radius the same: so a small scene is a part of the large one. The square holds the
/// largest scene; sand repeats only farther apart than the full detail of a whole frame is wide.
const DOMAIN: Domain = Domain { period_m: 1536.0, half_m: 9.0 * TILE_M };

fn tiling(radius_m: f64) -> Tiling {
    Tiling::new(TILE_M, radius_m, RING_M, |nearest_m| {
        if nearest_m <= radius_m {
            Grain { post_m: POST_M, max_error_m: 0.05 }
        } else {
            Grain { post_m: 2.0, max_error_m: if nearest_m < radius_m + 120.0 { 0.2 } else { 0.4 } }
        }
    })
}

fn ground(params: &Params, domain: Domain, window_half_m: f64, path: &SeedPath) -> Relief {
    let (s, c) = libm::sincos(path.child("wind").rng().range(0.0, core::f64::consts::TAU));
    let regime = params.regime(&path.child("regime"));
    let dunes = Dunes::new(domain, params.cell_m(), params.relief_m, DVec2::new(c, s), &regime, &path.child("dunes"));
    Relief::new(dunes, window_half_m, params.relief_m, params.roughness, params.shrubs, &path.child("relief"))
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    build_within(params, DOMAIN, &path)
}

/// A scene of a domain.
fn build_within(params: &Params, domain: Domain, path: &SeedPath) -> Scene {
    let path = path.child(params.variant());
    let tiling = tiling(params.radius_m);
    let (window_half_m, scene_half_m) = (tiling.window_half_m, tiling.scene_half_m());
    let relief = ground(params, domain, window_half_m, &path);
    let brinks: Vec<Breakline> = relief
        .dunes
        .brinks
        .iter()
        .map(|line| Breakline {
            points_m: line.iter().map(|p| *p + DVec3::Z * relief.ground_m(p.truncate())).collect(),
        })
        .collect();
    let tiles = triangulate(&tiling.layout, &relief, &brinks);
    let tracks = Tracks::new(&relief.dunes, domain.half_m, &path.child("tracks"));
    let materials = dress::materials(&relief, params.texture_contrast, &path.child("materials"));
    let mut scene = Scene {
        material_sets: vec![(0..materials.len() as u32).collect()],
        materials,
        rasters: vec![dress::cover(&relief, &tracks, scene_half_m, params.relief_m, &path.child("cover"))],
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        pivot_height_m: relief.height_m(DVec2::ZERO),
        full_detail_radius_m: params.radius_m,
        ..Scene::default()
    };
    let meshes: Vec<Mesh> = tiles.into_par_iter().map(|tile| dressed(&tile, &relief)).collect();
    place_terrain(&mut scene, meshes);
    // What stands at the rim must find the ground under all of it in full detail.
    let reach_m = (window_half_m - 4.0).min(params.radius_m + 60.0);
    scatter::scatter(&mut scene, &relief, reach_m, params.shrubs, &path.child("scatter"));
    scene
}

/// A tile with normals of the source surfaces and the material slot of each triangle. Where the wind's surface and the
/// slip face's meet, a vertex stands twice, with the normal of each: so the edge stays sharp in the light as well.
fn dressed(tile: &TileMesh, relief: &Relief) -> Mesh {
    let mut mesh = Mesh::default();
    let mut index: BTreeMap<(u32, Face), u32> = BTreeMap::new();
    for t in &tile.triangles {
        let corners = t.map(|v| DVec3::from_array(tile.positions_m[v as usize].map(f64::from)));
        let middle = (corners[0] + corners[1] + corners[2]).truncate() / 3.0;
        let face = relief.top_m(middle).1;
        let corner = |k: usize| {
            *index.entry((t[k], face)).or_insert_with(|| {
                mesh.positions_m.push(tile.positions_m[t[k] as usize]);
                mesh.normals.push(normal_of_slope(relief.slope(corners[k].truncate(), face)));
                mesh.positions_m.len() as u32 - 1
            })
        };
        let triangle = [0, 1, 2].map(corner);
        mesh.triangles.push(triangle);
        mesh.slots.push(match face {
            Face::Slip => slot::SLIP,
            Face::Body if relief.dunes.sand(middle).thick_m > dress::SAND_FROM_M => slot::SAND,
            Face::Body => slot::FLAT,
        });
    }
    mesh
}

#[cfg(test)]
mod tests;
