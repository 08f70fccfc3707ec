//! Canyon: an incised plateau of hard and soft beds.

mod relief;
mod strata;
mod valley;

use crate::kit::terrain::tin::{Breakline, Grain, Ground, Layout, triangulate};
use crate::{ParameterError, check_range};
use glam::{DAffine3, DVec2};
use relief::{POST_M, Relief};
use satseed_scene::{Bands, Class, Instance, Material, Mesh, Object, Scene, SeedPath};
use serde::{Deserialize, Serialize};
use strata::Strata;
use valley::{Channels, Fold, Trunk};

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 1;

/// Parameters of a canyon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Depth from rim to floor, m, 120..220.
    pub relief_m: f64,
    /// Roughness of rock and soil below the scale of erosion, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour, 0..2; 1 is nature.
    pub texture_contrast: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { radius_m: 700.0, relief_m: 170.0, roughness: 1.0, texture_contrast: 1.0 }
    }
}

impl Params {
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

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        4 << 30
    }
}

/// Side of a terrain tile, m.
const TILE_M: f64 = 128.0;
/// How far the coarse ring reaches beyond the radius of full detail, m: the shadow of the whole relief at a sun 15
/// degrees high.
const RING_M: f64 = 800.0;

fn layout(radius_m: f64) -> (Layout, f64) {
    let half = |reach: f64| libm::ceil(reach / TILE_M);
    let tiles = (2.0 * half(radius_m + RING_M)) as usize;
    let origin_m = DVec2::splat(-half(radius_m + RING_M) * TILE_M);
    let grains = (0..tiles * tiles)
        .map(|t| {
            let low = origin_m + DVec2::new((t % tiles) as f64, (t / tiles) as f64) * TILE_M;
            let nearest = DVec2::ZERO.clamp(low, low + TILE_M).length();
            if nearest <= radius_m {
                Grain { post_m: POST_M, max_error_m: 0.05 }
            } else {
                Grain { post_m: 4.0, max_error_m: if nearest < radius_m + 200.0 { 0.5 } else { 1.5 } }
            }
        })
        .collect();
    (Layout { origin_m, tile_m: TILE_M, columns: tiles, rows: tiles, grains }, half(radius_m) * TILE_M)
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let strata = Strata::new(params.relief_m, &path.child("strata"));
    let fold = Fold::new(&path.child("fold"));
    let trunk = Trunk::new(params.relief_m, &path.child("trunk"));
    let channels = Channels::new(&strata, &fold, &trunk, &path.child("erosion"));
    let (layout, window_half_m) = layout(params.radius_m);
    let halves = (window_half_m, -layout.origin_m.x);
    let relief = Relief::new(&strata, &fold, &trunk, &channels, halves, params.roughness, &path.child("relief"));
    let tiles = triangulate(&layout, &relief, &[]);
    let mut scene = Scene {
        materials: vec![Material::diffuse("rock", Class::Rock, Bands::grey(0.2))],
        material_sets: vec![vec![0]],
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        pivot_height_m: relief.height_m(DVec2::ZERO),
        full_detail_radius_m: params.radius_m,
        ..Scene::default()
    };
    for tile in tiles {
        scene.instances.push(Instance {
            mesh: scene.meshes.len() as u32,
            world_from_object: DAffine3::IDENTITY,
            object: 0,
            material_set: 0,
            variation: [0.0; 4],
        });
        scene.meshes.push(Mesh {
            slots: vec![0; tile.triangles.len()],
            positions_m: tile.positions_m,
            triangles: tile.triangles,
            ..Mesh::default()
        });
    }
    scene
}
