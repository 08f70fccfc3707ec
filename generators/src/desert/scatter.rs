//! What grows and lies on the flats: shrubs on their mounds, tufts, stones.

use super::mounds::Mound;
use super::relief::Relief;
use crate::kit::rock::block;
use crate::kit::shrub::shrub;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{
    Bands, Brdf, Class, Field, Instance, Layer, Material, Mesh, Object, Rng, Scene, SeedPath, hash_cell, quantise_m,
    unit_from_hash,
};

/// Different meshes of each kind.
const VARIANTS: usize = 14;
/// Side of the cells in which at most one tuft or stone is placed, m.
const CELL_M: f64 = 4.0;

/// Something and where it stands.
struct Placed {
    at_m: DVec2,
    world_from_object: DAffine3,
    variation: [f32; 4],
    mesh: u32,
    path: String,
}

/// Adds shrubs, tufts and stones within `reach_m` of the pivot.
pub(super) fn scatter(scene: &mut Scene, relief: &Relief, reach_m: f64, shrubs: f64, path: &SeedPath) {
    let stones = path.child("stone");
    let meshes = (0..VARIANTS).map(|k| block(&stones.child("mesh").index(k as u64))).collect();
    let things = place(reach_m, |cell, corner| stone(relief, &stones, cell, corner));
    add(scene, meshes, vec![stone_material(&stones)], Class::Rock, reach_m, things);

    let plants = path.child("shrub");
    let meshes = (0..VARIANTS).map(|k| shrub(&plants.child("mesh").index(k as u64))).collect();
    let mut things: Vec<Placed> = relief.mounds.all().flat_map(|m| on_mound(relief, m, &plants)).collect();
    things.extend(place(reach_m, |cell, corner| tuft(relief, &plants, shrubs, cell, corner)));
    add(scene, meshes, shrub_materials(&plants), Class::LowVegetation, reach_m, things);
}

fn add(
    scene: &mut Scene,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    class: Class,
    reach_m: f64,
    things: Vec<Placed>,
) {
    let first_mesh = scene.meshes.len() as u32;
    let first_material = scene.materials.len() as u32;
    let material_set = scene.material_sets.len() as u32;
    scene.material_sets.push((0..materials.len() as u32).map(|k| first_material + k).collect());
    scene.materials.extend(materials);
    scene.meshes.extend(meshes);
    for thing in things.into_iter().filter(|t| t.at_m.length() <= reach_m) {
        scene.instances.push(Instance {
            mesh: first_mesh + thing.mesh,
            world_from_object: thing.world_from_object,
            object: scene.objects.len() as u32,
            material_set,
            variation: thing.variation,
        });
        scene.objects.push(Object { path: thing.path, class });
    }
}

/// Asks every cell of a square grid within reach, rows in parallel, for what stands in it.
fn place(reach_m: f64, at: impl Fn((i32, i32), DVec2) -> Option<Placed> + Sync) -> Vec<Placed> {
    let half = libm::ceil(reach_m / CELL_M) as i32;
    (-half..half)
        .into_par_iter()
        .flat_map_iter(|j| {
            let at = &at;
            (-half..half).filter_map(move |i| at((i, j), DVec2::new(i.into(), j.into()) * CELL_M))
        })
        .collect()
}

/// The key of a cell's own randomness.
fn key(path: &SeedPath, cell: (i32, i32)) -> SeedPath {
    path.index((u64::from(cell.0 as u32) << 32) | u64::from(cell.1 as u32))
}

fn variation(rng: &mut Rng) -> [f32; 4] {
    core::array::from_fn(|_| rng.signed() as f32)
}

/// The lowest ground under a thing of a radius, m; on the lattice, so that a crop's things stand where the whole's do.
fn lowest(relief: &Relief, p: DVec2, radius_m: f64) -> f64 {
    let d = radius_m * core::f64::consts::FRAC_1_SQRT_2;
    let around =
        [(radius_m, 0.0), (-radius_m, 0.0), (0.0, radius_m), (0.0, -radius_m), (d, d), (-d, d), (d, -d), (-d, -d)];
    let low = around.iter().map(|(x, y)| relief.height_m(p + DVec2::new(*x, *y))).fold(relief.height_m(p), f64::min);
    quantise_m(low).into()
}

/// A shrub of a size, its stems in the ground.
fn planted(relief: &Relief, p: DVec2, width_m: f64, height_m: f64, rng: &mut Rng, path: String) -> Placed {
    let base = lowest(relief, p, 0.2 * width_m) - 0.03;
    let lean = DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.12;
    let turn = DMat3::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let tilt = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, (DVec3::Z + lean).normalize()));
    let shape = DMat3::from_diagonal(DVec3::new(width_m, width_m * rng.range(0.75, 1.0), height_m));
    Placed {
        at_m: p,
        world_from_object: DAffine3::from_mat3_translation(tilt * turn * shape, p.extend(base)),
        variation: variation(rng),
        mesh: rng.below(VARIANTS as u64) as u32,
        path,
    }
}

/// One to four shrubs crown a mound.
fn on_mound(relief: &Relief, mound: &Mound, path: &SeedPath) -> Vec<Placed> {
    let path = path.child("mound");
    let mut rng = key(&path, mound.cell).rng();
    let count = 1 + rng.below(if mound.height_m > 0.55 { 4 } else { 2 });
    (0..count)
        .map(|k| {
            let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let out = if count == 1 { 0.1 } else { rng.range(0.15, 0.75) } * mound.radius_m;
            let p = mound.at_m + DVec2::new(c, s) * out;
            let height = (mound.height_m * rng.range(0.8, 1.5)).clamp(0.35, 1.5);
            let width = height * rng.range(1.0, 1.6);
            let name = format!("shrub/{}_{}/{k}", mound.cell.0, mound.cell.1);
            planted(relief, p, width, height, &mut rng, name)
        })
        .collect()
}

/// Low tufts stand scattered on flats and thin sand, in groups.
fn tuft(relief: &Relief, path: &SeedPath, shrubs: f64, cell: (i32, i32), corner: DVec2) -> Option<Placed> {
    let path = path.child("tuft");
    let seed = path.hash_u32();
    let draw = f64::from(unit_from_hash(hash_cell(cell.0, cell.1, 0, seed)));
    if draw > 0.30 * shrubs {
        return None;
    }
    let groups = smoothstep(-0.1, 0.4, fractal(corner, seed, 85.0, 4, 0.6));
    let sand = relief.dunes.sand(corner);
    let share =
        0.30 * shrubs * (0.05 + 0.95 * groups) * smoothstep(1.2, 0.3, sand.thick_m) * smoothstep(0.8, 0.3, sand.lee);
    if draw > share {
        return None;
    }
    let mut rng = key(&path, cell).rng();
    let p = corner + DVec2::new(rng.unit(), rng.unit()) * CELL_M;
    let height = rng.lognormal(0.38, 0.3).clamp(0.2, 0.9);
    let width = height * rng.range(1.1, 1.9);
    Some(planted(relief, p, width, height, &mut rng, format!("tuft/{}_{}", cell.0, cell.1)))
}

/// Stones lie on bare flats.
fn stone(relief: &Relief, path: &SeedPath, cell: (i32, i32), corner: DVec2) -> Option<Placed> {
    let seed = path.hash_u32();
    let draw = f64::from(unit_from_hash(hash_cell(cell.0, cell.1, 0, seed)));
    if draw > 0.06 {
        return None;
    }
    let groups = smoothstep(0.0, 0.4, fractal(corner, seed, 60.0, 3, 0.6));
    let sand = relief.dunes.sand(corner);
    if draw > 0.06 * groups * smoothstep(0.5, 0.1, sand.thick_m) {
        return None;
    }
    let mut rng = key(path, cell).rng();
    let p = corner + DVec2::new(rng.unit(), rng.unit()) * CELL_M;
    // Pareto: number above a size falls with the power -1.8.
    let size = (0.25 * libm::pow(1.0 - rng.unit(), -1.0 / 1.8)).min(1.4);
    let turn = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let lean = (DVec3::Z + DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.3).normalize();
    let tilt = DQuat::from_rotation_arc(DVec3::Z, lean);
    let scale = DVec3::new(1.0, rng.range(0.75, 1.1), rng.range(0.7, 1.1)) * size;
    let z = lowest(relief, p, 0.5 * size) + 0.02 * size - 0.05;
    Some(Placed {
        at_m: p,
        world_from_object: DAffine3::from_scale_rotation_translation(scale, tilt * turn, p.extend(z)),
        variation: variation(&mut rng),
        mesh: rng.below(VARIANTS as u64) as u32,
        path: format!("stone/{}_{}", cell.0, cell.1),
    })
}

fn stone_material(path: &SeedPath) -> Material {
    let seed = path.child("material").hash_u32();
    Material::diffuse("stone", Class::Rock, Bands::new(0.115, 0.135, 0.155, 0.19))
        .rough(0.4)
        .with(Layer::Brightness { amount: Field::Variation(1).times(0.25) })
        .with(Layer::Brightness { amount: Field::world_noise(seed, 0.4, 2).times(0.16) })
}

fn shrub_materials(path: &SeedPath) -> Vec<Material> {
    let seed = path.child("material").hash_u32();
    let leaf = Material {
        brdf: Brdf::Leaf { transmission: Bands::new(0.012, 0.03, 0.02, 0.14) },
        ..Material::diffuse("shrub leaves", Class::LowVegetation, Bands::new(0.060, 0.085, 0.080, 0.22))
            // Half of them are grey and leafless at any time of the year.
            .with(Layer::Mix {
                color: Bands::new(0.10, 0.125, 0.145, 0.22),
                amount: Field::Variation(0).ramp(-0.4, 0.5),
            })
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.22) })
            .with(Layer::Brightness { amount: Field::world_noise(seed, 0.3, 2).times(0.2) })
    };
    let stem = Material::diffuse("shrub stems", Class::LowVegetation, Bands::new(0.08, 0.09, 0.11, 0.18));
    vec![leaf, stem]
}
