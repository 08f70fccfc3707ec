//! What lies and grows on the ground: fallen blocks, shrubs.

use super::relief::Relief;
use crate::kit::rock::block;
use crate::kit::scatter::{Cell, Kind, Placed, add, lowest, place, variation};
use crate::kit::shrub::shrub;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Class, Field, Layer, Material, Scene, SeedPath};

/// Different meshes of blocks and of shrubs.
const VARIANTS: usize = 14;
/// Side of the cells in which at most one thing of each kind is placed, m.
const SHRUB_CELL_M: f64 = 2.0;
const BLOCK_CELL_M: f64 = 2.0;

/// Adds shrubs and blocks within `reach_m` of the pivot.
pub(super) fn scatter(scene: &mut Scene, relief: &Relief<'_>, reach_m: f64, rock_colors: Vec<Bands>, path: &SeedPath) {
    let blocks = path.child("block");
    let meshes = (0..VARIANTS).map(|k| block(&blocks.child("mesh").index(k as u64))).collect();
    let materials = vec![block_material(rock_colors, &blocks)];
    let things = place(reach_m, BLOCK_CELL_M, |cell| block_at(relief, &blocks, cell));
    add(scene, Kind { meshes, materials, class: Class::Rock }, reach_m, things);

    let shrubs = path.child("shrub");
    let meshes = (0..VARIANTS).map(|k| shrub(&shrubs.child("mesh").index(k as u64))).collect();
    let things = place(reach_m, SHRUB_CELL_M, |cell| shrub_at(relief, &shrubs, cell));
    let kind = Kind { meshes, materials: shrub_materials(&shrubs), class: Class::LowVegetation };
    add(scene, kind, reach_m, things);
}

/// Blocks lie on scree, fewer on the floor at the walls' feet, and on ledges. Sizes follow a power law.
fn block_at(relief: &Relief<'_>, path: &SeedPath, cell: Cell) -> Option<Placed> {
    let p = cell.point(0.5, 0.5);
    let cover = relief.cover(p);
    if cover.bank_m < -1.0 {
        return None;
    }
    let scree = smoothstep(0.15, 1.6, cover.scree_m);
    let clumps = smoothstep(-0.1, 0.35, fractal(p, path.hash_u32(), 24.0, 3, 0.5));
    let share = 0.006
        + 0.30 * scree * (0.25 + 0.75 * clumps)
        + 0.12 * clumps * smoothstep(4.0, 9.0, cover.climb_m) * smoothstep(60.0, 20.0, cover.climb_m)
        + fallen(relief, p) * (0.15 + 0.85 * clumps);
    if cell.draw(path.hash_u32()) > share {
        return None;
    }
    let mut rng = cell.key(path).rng();
    let p = cell.point(rng.unit(), rng.unit());
    // Pareto: number above a size falls with the power -1.8, density with -2.8.
    let size = (0.55 * libm::pow(1.0 - rng.unit(), -1.0 / 1.7)).min(4.0);
    let slope = relief.slope(p);
    if slope.length() > 1.3 || !relief.is_open(p, 0.6 * size) {
        return None;
    }
    let normal = DVec3::new(-slope.x, -slope.y, 1.0).normalize();
    let tilt =
        DQuat::from_rotation_arc(DVec3::Z, (normal + DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.35).normalize());
    let turn = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let scale = DVec3::new(1.0, rng.range(0.75, 1.1), rng.range(0.8, 1.3)) * size;
    // Its lowest points reach below the lowest ground around it.
    let base = lowest(relief, p, 0.5 * size);
    let z = (base + 0.02 * size).min(relief.height_m(p) + 0.15 * size);
    let at_m = p.extend(z);
    Some(Placed {
        at_m: p,
        world_from_object: DAffine3::from_scale_rotation_translation(scale, tilt * turn, at_m),
        variation: variation(&mut rng),
        mesh: rng.below(VARIANTS as u64) as u32,
        path: cell.name("block"),
    })
}

/// Share of cells with a block that fell from the cliff above: most at its foot and below high cliffs.
fn fallen(relief: &Relief<'_>, p: DVec2) -> f64 {
    let Some([away_m, cliff_m]) = relief.below_cliff_m(p) else { return 0.0 };
    0.20 * smoothstep(36.0, 1.0, away_m) * smoothstep(1.5, 14.0, cliff_m)
}

/// Shrubs stand along the wash, on shaded slopes, and in the plateau's soil, where low scrub is between them.
fn shrub_at(relief: &Relief<'_>, path: &SeedPath, cell: Cell) -> Option<Placed> {
    let seed = path.hash_u32();
    let first = cell.draw(seed);
    if first > 0.5 {
        return None;
    }
    let p = cell.point(0.5, 0.5);
    let cover = relief.cover(p);
    if cover.bank_m < 0.8 {
        return None;
    }
    let slope = relief.slope(p);
    let steep = slope.length();
    let level = smoothstep(1.1, 0.5, steep);
    let northward = smoothstep(-0.1, 0.5, -slope.y);
    let wash = smoothstep(40.0, 3.0, cover.bank_m).max(0.8 * smoothstep(500.0, 5000.0, cover.area_m2));
    let grove = fractal(p, seed, 38.0, 4, 0.55);
    let open = 0.075 + 0.07 * northward + 0.34 * wash;
    let share = level * open * smoothstep(-0.35, 0.45, grove) * 2.0;
    // Low scrub is spread over the soil between.
    let is_low = first > share;
    if is_low && first > share + level * 0.17 * smoothstep(-0.30, 0.20, fractal(p, seed ^ 1, 110.0, 3, 0.55)) {
        return None;
    }
    let mut rng = cell.key(path).rng();
    let p = cell.point(rng.unit(), rng.unit());
    let wet = wash > 0.5;
    let (height, width) = if is_low {
        let height = rng.lognormal(0.42, 0.25).clamp(0.28, 0.75);
        (height, height * rng.range(1.3, 2.1))
    } else {
        let height = rng.lognormal(if wet { 1.15 } else { 0.75 }, 0.35).clamp(0.45, 2.2);
        (height, height * rng.range(0.9, 1.45))
    };
    if !relief.is_open(p, 0.5 * width) {
        return None;
    }
    let base = lowest(relief, p, 0.2 * width) - 0.03;
    let at_m = p.extend(base);
    let lean = DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.12;
    let turn = DMat3::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let tilt = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, (DVec3::Z + lean).normalize()));
    let shape = DMat3::from_diagonal(DVec3::new(width, width * rng.range(0.8, 1.0), height));
    Some(Placed {
        at_m: p,
        world_from_object: DAffine3::from_mat3_translation(tilt * turn * shape, at_m),
        variation: [rng.signed() as f32, rng.signed() as f32, if wet { 0.6 } else { -0.4 }, rng.signed() as f32],
        mesh: rng.below(VARIANTS as u64) as u32,
        path: cell.name("shrub"),
    })
}

fn block_material(colors: Vec<Bands>, path: &SeedPath) -> Material {
    let seed = path.child("material").hash_u32();
    Material::diffuse("fallen block", Class::Rock, Bands::grey(0.2))
        .rough(0.4)
        .with(Layer::Choice { colors, variation: 0 })
        .with(Layer::Brightness { amount: Field::Variation(1).times(0.16) })
        .with(Layer::Mix {
            color: Bands::new(0.075, 0.085, 0.105, 0.16),
            amount: Field::Sum(vec![Field::Variation(2).times(0.35), Field::world_noise(seed, 1.3, 3)])
                .ramp(0.05, 0.5)
                .times(0.5),
        })
        .with(Layer::Brightness { amount: Field::world_noise(seed ^ 1, 0.4, 2).times(0.16) })
}

fn shrub_materials(path: &SeedPath) -> Vec<Material> {
    let seed = path.child("material").hash_u32();
    let leaf = Material {
        brdf: Brdf::Leaf { transmission: Bands::new(0.015, 0.04, 0.02, 0.16) },
        ..Material::diffuse("shrub leaves", Class::LowVegetation, Bands::new(0.052, 0.082, 0.066, 0.25))
            // Sage is greyer, what stands at water greener.
            .with(Layer::Mix {
                color: Bands::new(0.095, 0.12, 0.115, 0.26),
                amount: Field::Sum(vec![Field::Variation(2).times(-0.5), Field::Variation(0).times(0.5)])
                    .ramp(-0.2, 0.6),
            })
            .with(Layer::Mix {
                color: Bands::new(0.10, 0.13, 0.16, 0.24),
                amount: Field::Variation(3).ramp(0.72, 0.95).times(0.8),
            })
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.22) })
            .with(Layer::Brightness { amount: Field::world_noise(seed, 0.3, 2).times(0.2) })
    };
    let stem = Material::diffuse("shrub stems", Class::LowVegetation, Bands::new(0.08, 0.09, 0.11, 0.18));
    vec![leaf, stem]
}
