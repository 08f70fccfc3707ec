//! What grows and lies on the flats: shrubs on their mounds, tufts, stones.

use super::mounds::Mound;
use super::relief::Relief;
use crate::kit::rock::block;
use crate::kit::scatter::{self, Cell, Kind, Placed, add, place, variation};
use crate::kit::shrub::{planted, shrub};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Class, Field, Layer, Material, Scene, SeedPath, quantise_m};

/// Different meshes of each kind.
const VARIANTS: usize = 14;
/// Share of the cells with a tuft where they stand closest.
const MOST_TUFTS: f64 = 0.75;
/// Side of the cells in which at most one tuft or stone is placed, m.
const CELL_M: f64 = 4.0;

/// Adds shrubs, tufts and stones within `reach_m` of the pivot.
pub(super) fn scatter(scene: &mut Scene, relief: &Relief, reach_m: f64, shrubs: f64, path: &SeedPath) {
    let stones = path.child("stone");
    let meshes = (0..VARIANTS).map(|k| block(&stones.child("mesh").index(k as u64))).collect();
    let things = place(reach_m, CELL_M, |cell| stone(relief, &stones, cell));
    add(scene, Kind { meshes, materials: vec![stone_material(&stones)], class: Class::Rock }, reach_m, things);

    let plants = path.child("shrub");
    let meshes = (0..VARIANTS).map(|k| shrub(&plants.child("mesh").index(k as u64))).collect();
    let mut things: Vec<Placed> = relief.mounds.all().flat_map(|m| on_mound(relief, m, &plants)).collect();
    things.extend(place(reach_m, CELL_M, |cell| tuft(relief, &plants, shrubs, cell)));
    let kind = Kind { meshes, materials: shrub_materials(&plants), class: Class::LowVegetation };
    add(scene, kind, reach_m, things);
}

/// The lowest ground under a thing of a radius, m; on the lattice, so that a crop's things stand where the whole's do.
fn lowest(relief: &Relief, p: DVec2, radius_m: f64) -> f64 {
    quantise_m(scatter::lowest(relief, p, radius_m)).into()
}

/// One to four shrubs crown a mound.
fn on_mound(relief: &Relief, mound: &Mound, path: &SeedPath) -> Vec<Placed> {
    let path = path.child("mound");
    let mut rng = Cell { at: mound.cell, side_m: CELL_M }.key(&path).rng();
    let count = 1 + rng.below(if mound.height_m > 0.55 { 4 } else { 2 });
    (0..count)
        .map(|k| {
            let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let out = if count == 1 { 0.1 } else { rng.range(0.15, 0.75) } * mound.radius_m;
            let p = mound.at_m + DVec2::new(c, s) * out;
            let height = (mound.height_m * rng.range(0.8, 1.5)).clamp(0.35, 1.5);
            let width = height * rng.range(1.3, 2.1);
            let name = format!("shrub/{}_{}/{k}", mound.cell.0, mound.cell.1);
            planted(relief, p, [width, height], VARIANTS, &mut rng, name)
        })
        .collect()
}

/// Low tufts stand scattered on flats and thin sand, in groups.
fn tuft(relief: &Relief, path: &SeedPath, shrubs: f64, cell: Cell) -> Option<Placed> {
    let path = path.child("tuft");
    let seed = path.hash_u32();
    let (draw, corner) = (cell.draw(seed), cell.point(0.0, 0.0));
    if draw > MOST_TUFTS * shrubs {
        return None;
    }
    let groups = smoothstep(-0.1, 0.4, fractal(corner, seed, 85.0, 4, 0.6));
    let sand = relief.dunes.sand(corner);
    let share = MOST_TUFTS
        * shrubs
        * (0.14 + 0.86 * groups)
        * smoothstep(1.2, 0.3, sand.thick_m)
        * smoothstep(0.8, 0.3, sand.lee);
    if draw > share {
        return None;
    }
    let mut rng = cell.key(&path).rng();
    let p = cell.point(rng.unit(), rng.unit());
    let height = rng.lognormal(0.38, 0.3).clamp(0.2, 0.9);
    let width = height * rng.range(1.4, 2.4);
    Some(planted(relief, p, [width, height], VARIANTS, &mut rng, cell.name("tuft")))
}

/// Stones lie on bare flats.
fn stone(relief: &Relief, path: &SeedPath, cell: Cell) -> Option<Placed> {
    let seed = path.hash_u32();
    let (draw, corner) = (cell.draw(seed), cell.point(0.0, 0.0));
    if draw > 0.06 {
        return None;
    }
    let groups = smoothstep(0.0, 0.4, fractal(corner, seed, 60.0, 3, 0.6));
    let sand = relief.dunes.sand(corner);
    if draw > 0.06 * groups * smoothstep(0.5, 0.1, sand.thick_m) {
        return None;
    }
    let mut rng = cell.key(path).rng();
    let p = cell.point(rng.unit(), rng.unit());
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
        path: cell.name("stone"),
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
        // Of one leaf: a crown, hollow and shaded by itself, is half as bright.
        brdf: Brdf::Leaf { transmission: Bands::new(0.025, 0.045, 0.04, 0.14) },
        ..Material::diffuse("shrub leaves", Class::LowVegetation, Bands::new(0.150, 0.212, 0.215, 0.34))
            // Half of them are grey and leafless at any time of the year.
            .with(Layer::Mix {
                color: Bands::new(0.180, 0.228, 0.262, 0.35),
                amount: Field::Variation(0).ramp(-0.4, 0.5),
            })
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.22) })
            .with(Layer::Brightness { amount: Field::world_noise(seed, 0.3, 2).times(0.2) })
    };
    let stem = Material::diffuse("shrub stems", Class::LowVegetation, Bands::new(0.11, 0.13, 0.155, 0.22));
    vec![leaf, stem]
}
