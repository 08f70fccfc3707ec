//! Field: farmland of parcels, crops, hedges, lanes and a farmstead.

mod canopy;
mod crops;
mod dress;
mod farm;
mod hedges;
mod mosaic;
mod plan;
mod relief;
mod rows;
mod sections;

use crate::kit::scatter::{Kind, Placed, add};
use crate::kit::terrain::tiling::{Tiling, normal_of_slope, place_terrain};
use crate::kit::terrain::tin::{Breakline, Grain, Ground, TileMesh, triangulate};
use crate::{ParameterError, check_range};
use crops::Crop;
use dress::{Look, slot};
use glam::{DAffine3, DVec2};
use plan::{Edge, Plan};
use rayon::prelude::*;
use relief::{CARRIAGEWAY_M, DETAIL_LIMIT_M, POST_M, Relief};
use rows::Stand;
use satseed_scene::{Class, Instance, Material, Mesh, Object, Scene, SeedPath};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Raised whenever the same parameters and seed give other bytes.
pub const VERSION: u32 = 3;

/// How the land is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// A hedged mosaic of parcels along bending lanes.
    European,
    /// A grid of half-mile quarters with centre pivots, strips and straight roads.
    Pivot,
}

/// Parameters of farmland.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How the land is divided.
    pub variant: Variant,
    /// Radius of full detail around the pivot, m, 60..900.
    pub radius_m: f64,
    /// Height between the hills' tops and the valleys' floors at most, m, 0..60.
    pub relief_m: f64,
    /// Median area of the mosaic's parcels, hectares, 0.8..6.
    pub parcel_ha: f64,
    /// Factor on the number of hedges and of their trees, 0..2.
    pub hedges: f64,
    /// Factor on unevenness of soil and canopies, 0..2; 1 is nature.
    pub roughness: f64,
    /// Contrast of colour within and among ground and crops, 0..2; 1 is nature, and at 0 all have one colour and show their form alone.
    pub texture_contrast: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            variant: Variant::European,
            radius_m: 700.0,
            relief_m: 18.0,
            parcel_ha: 2.5,
            hedges: 1.0,
            roughness: 1.0,
            texture_contrast: 1.0,
        }
    }
}

impl Params {
    pub(crate) fn variant(&self) -> &'static str {
        match self.variant {
            Variant::European => "european",
            Variant::Pivot => "pivot",
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_range("radius_m", self.radius_m, 60.0..=900.0)?;
        check_range("relief_m", self.relief_m, 0.0..=60.0)?;
        check_range("parcel_ha", self.parcel_ha, 0.8..=6.0)?;
        check_range("hedges", self.hedges, 0.0..=2.0)?;
        check_range("roughness", self.roughness, 0.0..=2.0)?;
        check_range("texture_contrast", self.texture_contrast, 0.0..=2.0)
    }

    pub(crate) fn height_bounds_m(&self) -> [f64; 2] {
        // Hills, what lies along borders, roots and walls' feet; silos and tall trees.
        let half = 0.5 * self.relief_m + DETAIL_LIMIT_M;
        [-half - 3.0, half + 26.0]
    }

    pub(crate) fn memory_bound_bytes(&self) -> u64 {
        let side_m = 2.0 * (self.radius_m + RING_M + TILE_M);
        (300e6 + side_m * side_m * (260.0 + 60.0 * self.roughness)) as u64
    }
}

/// Side of a terrain tile, m.
const TILE_M: f64 = 128.0;
/// How far the coarse ring reaches beyond the radius of full detail, m.
const RING_M: f64 = 200.0;

fn tiling(radius_m: f64) -> Tiling {
    Tiling::new(TILE_M, radius_m, RING_M, |nearest_m| {
        if nearest_m <= radius_m {
            Grain { post_m: POST_M, max_error_m: 0.05 }
        } else {
            Grain { post_m: 2.0, max_error_m: if nearest_m < radius_m + 120.0 { 0.2 } else { 0.4 } }
        }
    })
}

fn ground(params: &Params, path: &SeedPath) -> Relief {
    let plan = Plan::new(params, &path.child("plan"));
    let tiling = tiling(params.radius_m);
    Relief::new(plan, tiling, params.radius_m, params.relief_m, params.roughness, &path.child("relief"))
}

pub(crate) fn build(params: &Params, path: SeedPath) -> Scene {
    let path = path.child(params.variant());
    let relief = ground(params, &path);
    let plan = &relief.plan;
    let tiles = triangulate(&relief.tiling().layout, &relief, &breaklines(&relief));
    let look = Look::new(plan, params.texture_contrast, &path.child("materials"));
    let mut materials = look.borders();
    for parcel in &plan.parcels {
        materials.extend([true, false].map(|bare| look.ground(parcel, bare)));
    }
    let mut scene = Scene {
        material_sets: vec![(0..materials.len() as u32).collect()],
        materials,
        rasters: vec![dress::cover(&relief, &path.child("cover"))],
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        pivot_height_m: relief.height_m(DVec2::ZERO),
        full_detail_radius_m: params.radius_m,
        ..Scene::default()
    };
    let meshes: Vec<Mesh> = tiles.into_par_iter().map(|tile| dressed(tile, &relief)).collect();
    place_terrain(&mut scene, meshes);
    crops(&mut scene, &relief, &look, &path.child("crops"));
    rest(&mut scene, &relief, params.hedges, &path);
    scene
}

/// Outlines of parcels, and the edges of lanes.
fn breaklines(relief: &Relief) -> Vec<Breakline> {
    let half_m = relief.tiling().scene_half_m();
    let near = |p: &DVec2| p.abs().max_element() < half_m + 8.0;
    let raised = |line: Vec<DVec2>| {
        // Only what lies in the scene, in stretches.
        let mut lines = vec![Vec::new()];
        for p in line {
            if near(&p) {
                let last = lines.len() - 1;
                lines[last].push(relief.on_ground(p));
            } else if !lines[lines.len() - 1].is_empty() {
                lines.push(Vec::new());
            }
        }
        lines.into_iter().filter(|l| l.len() > 1).map(|points_m| Breakline { points_m })
    };
    let plan = &relief.plan;
    let mut all: Vec<Breakline> = Vec::new();
    for parcel in &plan.parcels {
        let mut ring = parcel.world.clone();
        ring.push(ring[0]);
        all.extend(raised(ring));
    }
    for border in plan.borders.iter().filter(|b| b.edge == Edge::Lane) {
        let [a, b] = border.ends;
        let side = (b - a).normalize().perp() * CARRIAGEWAY_M;
        for s in [-1.0, 1.0] {
            let n = libm::ceil(a.distance(b) / 5.0) as usize;
            let line = (0..=n).map(|k| plan.warp.world(a.lerp(b, k as f64 / n as f64) + side * s)).collect();
            all.extend(raised(line));
        }
    }
    all
}

/// A tile with normals of the source surface and the slot of each triangle.
fn dressed(tile: TileMesh, relief: &Relief) -> Mesh {
    let plan = &relief.plan;
    let flat = |v: u32| {
        let p = tile.positions_m[v as usize];
        DVec2::new(p[0].into(), p[1].into())
    };
    let normals = (0..tile.positions_m.len()).map(|v| normal_of_slope(relief.slope(flat(v as u32)))).collect();
    let slots = tile
        .triangles
        .iter()
        .map(|t| {
            let middle = (flat(t[0]) + flat(t[1]) + flat(t[2])) / 3.0;
            let q = plan.warp.plan(middle);
            if let Some(k) = plan.parcel_at(q) {
                return slot::parcel(k, relief.is_detailed(middle));
            }
            match plan.nearest(q) {
                Some(n) => match plan.borders[n.border as usize].edge {
                    Edge::Lane if n.side_m.abs() <= CARRIAGEWAY_M => slot::LANE,
                    Edge::Track => slot::TRACK,
                    Edge::Ditch => slot::DITCH,
                    _ => slot::VERGE,
                },
                None => slot::VERGE,
            }
        })
        .collect();
    Mesh { positions_m: tile.positions_m, triangles: tile.triangles, slots, normals, uvs_m: Vec::new() }
}

/// What stands on the parcels: canopies, rows, swaths and bales.
fn crops(scene: &mut Scene, relief: &Relief, look: &Look, path: &SeedPath) {
    let plan = &relief.plan;
    let standing: Vec<(Vec<Mesh>, Vec<Placed>)> = plan
        .parcels
        .par_iter()
        .map(|p| {
            if !relief.may_be_detailed(&p.world) {
                return (Vec::new(), Vec::new());
            }
            let rows = Stand::of(p).map_or_else(Vec::new, |stand| rows::place(relief, p, &stand, &path.child("rows")));
            (canopy::sheets(relief, p), rows)
        })
        .collect();
    // Meshes of rows are those of the crop, for all its parcels.
    let mut first_mesh: BTreeMap<Crop, u32> = BTreeMap::new();
    for (parcel, (sheets, rows)) in plan.parcels.iter().zip(standing) {
        if sheets.is_empty() && rows.is_empty() {
            continue;
        }
        let straw = matches!(parcel.crop, Crop::Straw | Crop::Hay);
        let look = if straw {
            let bright = if parcel.crop == Crop::Hay { 0.85 } else { 1.0 };
            let swath = look.straw("swath", Class::Crop, bright);
            dress::ParcelLook { crop: swath.clone(), side: swath }
        } else {
            look.crop(parcel, Class::Crop)
        };
        let material_set = add_set(scene, vec![look.crop, look.side]);
        let object = add_object(scene, format!("parcel/{}", parcel.code), Class::Crop);
        for mesh in sheets {
            scene.instances.push(Instance {
                mesh: scene.meshes.len() as u32,
                world_from_object: DAffine3::IDENTITY,
                object,
                material_set,
                variation: [0.0; 4],
            });
            scene.meshes.push(mesh);
        }
        let Some(stand) = Stand::of(parcel).filter(|_| !rows.is_empty()) else { continue };
        let first = *first_mesh.entry(parcel.crop).or_insert_with(|| {
            let first = scene.meshes.len() as u32;
            scene.meshes.extend(rows::meshes(&stand, &path.child(parcel.crop.facts().name)));
            first
        });
        scene.instances.extend(rows.into_iter().map(|row| Instance {
            mesh: first + row.mesh,
            world_from_object: row.world_from_object,
            object,
            material_set,
            variation: row.variation,
        }));
    }
    let bales = path.child("bales");
    let things = plan.parcels.iter().filter(|p| p.crop == Crop::Bales).flat_map(|p| rows::bales(relief, p, &bales));
    let kind = Kind {
        meshes: vec![rows::bale()],
        materials: vec![look.straw("bale", Class::OtherStructure, 1.05)],
        class: Class::OtherStructure,
    };
    add(scene, kind, f64::MAX, things.collect());
}

/// Hedges, trees, the farmstead, pivots' machines.
fn rest(scene: &mut Scene, relief: &Relief, hedges: f64, path: &SeedPath) {
    let plan = &relief.plan;
    let green = path.child("green");
    let (pieces, mut trees) = hedges::along_borders(relief, hedges, &green);
    for parcel in &plan.parcels {
        trees.extend(hedges::within(relief, parcel, hedges, &green.child("within")));
    }
    add(scene, hedges::hedge_kind(&green), f64::MAX, pieces);
    add(scene, hedges::tree_kind(&green), f64::MAX, trees);
    let mut things = farm::laterals(relief, plan, &path.child("lateral"));
    if let Some(yard) = plan.yard {
        things.extend(farm::farmstead(relief, &plan.parcels[yard], &path.child("farm")));
    }
    for farm::Thing { kind, placed } in things {
        add(scene, kind, f64::MAX, vec![placed]);
    }
}

fn add_set(scene: &mut Scene, materials: Vec<Material>) -> u32 {
    let first = scene.materials.len() as u32;
    scene.material_sets.push((first..first + materials.len() as u32).collect());
    scene.materials.extend(materials);
    scene.material_sets.len() as u32 - 1
}

fn add_object(scene: &mut Scene, path: String, class: Class) -> u32 {
    scene.objects.push(Object { path, class });
    scene.objects.len() as u32 - 1
}

#[cfg(test)]
mod tests;
