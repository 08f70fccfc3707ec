//! What lies and grows on the coast: boulders below cliffs, groynes of blocks, tufts of marram, bushes.

use super::relief::{Hinterland, Relief};
use crate::kit::rock::block;
use crate::kit::scatter::{self, Cell, Kind, Placed, add, place, variation};
use crate::kit::shrub::{planted, shrub};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Class, Field, Layer, Material, Rng, Scene, SeedPath, quantise_m};

/// Different meshes of each kind.
const VARIANTS: usize = 16;
const BOULDER_CELL_M: f64 = 3.0;
const TUFT_CELL_M: f64 = 2.2;
const BUSH_CELL_M: f64 = 4.5;

/// Adds everything within `reach_m` of the pivot.
pub(super) fn scatter(scene: &mut Scene, relief: &Relief, reach_m: f64, plants: f64, path: &SeedPath) {
    let stones = path.child("stone");
    let meshes = (0..VARIANTS).map(|k| block(&stones.child("mesh").index(k as u64))).collect();
    let things = if relief.cliffs {
        place(reach_m, BOULDER_CELL_M, |cell| boulder(relief, &stones, cell))
    } else {
        groynes(relief, &path.child("groyne"))
    };
    add(
        scene,
        Kind { meshes, materials: vec![stone_material(relief.cliffs, &stones)], class: Class::Rock },
        reach_m,
        things,
    );

    let bushes = path.child("bush");
    let meshes = (0..VARIANTS).map(|k| shrub(&bushes.child("mesh").index(k as u64))).collect();
    let things = place(reach_m, BUSH_CELL_M, |cell| bush(relief, &bushes, plants, cell));
    let leaf = Bands::new(0.036, 0.056, 0.044, 0.24);
    add(scene, Kind { meshes, materials: leaves("bush", leaf, &bushes), class: Class::LowVegetation }, reach_m, things);

    let tufts = path.child("tuft");
    let meshes = (0..VARIANTS).map(|k| shrub(&tufts.child("mesh").index(k as u64))).collect();
    let things = place(reach_m, TUFT_CELL_M, |cell| tuft(relief, &tufts, plants, cell));
    let straw = Bands::new(0.072, 0.102, 0.092, 0.26);
    add(
        scene,
        Kind { meshes, materials: leaves("marram", straw, &tufts), class: Class::LowVegetation },
        reach_m,
        things,
    );
}

/// The lowest ground under a thing of a radius, m; on the lattice, so that a crop's things stand where the whole's do.
fn lowest(relief: &Relief, p: DVec2, radius_m: f64) -> f64 {
    let land = |q: DVec2| relief.surface(q).land_m;
    f64::from(quantise_m(scatter::lowest(&land, p, radius_m)))
}

/// A block of a size, at random turned, its middle at a height.
fn lying(at: DVec3, size_m: f64, rng: &mut Rng, path: String) -> Placed {
    let turn = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let lean = (DVec3::Z + DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.45).normalize();
    let tilt = DQuat::from_rotation_arc(DVec3::Z, lean);
    let scale = DVec3::new(1.0, rng.range(0.75, 1.1), rng.range(0.75, 1.15)) * size_m;
    Placed {
        at_m: at.truncate(),
        world_from_object: DAffine3::from_scale_rotation_translation(scale, tilt * turn, at),
        variation: variation(rng),
        mesh: rng.below(VARIANTS as u64) as u32,
        path,
    }
}

/// Fallen blocks at the foot of cliffs and around reefs.
fn boulder(relief: &Relief, path: &SeedPath, cell: Cell) -> Option<Placed> {
    let (draw, corner) = (cell.draw(path.hash_u32()), cell.point(0.0, 0.0));
    if draw > 0.75 {
        return None;
    }
    let s = relief.surface(corner);
    let d = s.place.inland_m;
    if !(-30.0..16.0).contains(&d) || s.land_m > 6.0 || s.land_m < -2.5 {
        return None;
    }
    let heaps = smoothstep(-0.15, 0.3, fractal(corner, path.hash_u32() ^ 3, 38.0, 3, 0.6));
    let near = smoothstep(-30.0, -4.0, d) * smoothstep(16.0, 9.0, d);
    if draw > 0.75 * (0.06 + 0.94 * heaps) * near * (1.0 - 0.85 * smoothstep(0.3, 0.8, s.place.sandy)) {
        return None;
    }
    let mut rng = cell.key(path).rng();
    let p = cell.point(rng.unit(), rng.unit());
    // Number above a size falls with the power -2.
    let size = (0.7 / f64::sqrt(1.0 - rng.unit())).min(5.0);
    let z = lowest(relief, p, 0.4 * size) + 0.10 * size - 0.03;
    relief.is_open(p, 0.6 * size).then(|| lying(p.extend(z), size, &mut rng, cell.name("boulder")))
}

/// Groynes of quarried blocks, square to the shore, from the berm into the water.
fn groynes(relief: &Relief, path: &SeedPath) -> Vec<Placed> {
    let mut rng = path.child("rule").rng();
    if rng.chance(0.25) {
        return Vec::new();
    }
    let (apart_m, long_m, offset) = (rng.range(130.0, 230.0), rng.range(55.0, 100.0), rng.unit());
    let cells = (900.0 / apart_m) as i32 + 1;
    let along = relief.shore.out.perp();
    let mut things = Vec::new();
    for k in -cells..=cells {
        let path = path.index(k as u32 as u64);
        let mut rng = path.rng();
        if rng.chance(0.2) {
            continue;
        }
        // Down the line of equal place along the coast to the shore itself.
        let line = along * ((f64::from(k) + offset + 0.12 * rng.signed()) * apart_m);
        let Some(shore) = relief.shore_on(line) else { continue };
        let direction = (relief.shore.out + along * (0.12 * rng.signed())).normalize();
        let reach = long_m * rng.range(0.75, 1.15);
        let begin = rng.range(14.0, 26.0);
        let steps = ((reach + begin) / 0.85) as u64;
        for step in 0..steps {
            let t = step as f64 * 0.85;
            let middle = shore + direction * (t - begin);
            let crest = 1.5 - 0.010 * t;
            // A heap three or four blocks wide at its crest and wider at its foot.
            for lane in 0..9_u64 {
                let mut rng = path.index(step).index(lane).rng();
                let off = (lane as f64 - 4.0) * 0.95 + 0.35 * rng.signed();
                let p = middle + direction.perp() * off + direction * (0.3 * rng.signed());
                let end = smoothstep(0.0, 3.0, t) * smoothstep(0.0, 3.0, reach + begin - t);
                let z = crest - 0.62 * (off.abs() - 1.1).max(0.0) - 2.0 * (1.0 - end) + 0.18 * rng.signed();
                let ground = lowest(relief, p, 0.4);
                let size = rng.range(1.05, 1.9);
                if z < ground - 0.3 * size || z < -1.6 {
                    continue;
                }
                // Lower blocks carry the upper ones; what hangs too high over the bottom stands on it.
                let z = z.min(ground + 0.42 * size + 2.2);
                things.push(lying(
                    p.extend(f64::from(quantise_m(z))),
                    size,
                    &mut rng,
                    format!("groyne/{k}/{step}_{lane}"),
                ));
                let mut below = z - 0.75 * size;
                let mut layer = 0;
                while below > ground - 0.2 && layer < 4 {
                    let q = p + DVec2::new(rng.signed(), rng.signed()) * 0.25;
                    let path = format!("groyne/{k}/{step}_{lane}/{layer}");
                    things.push(lying(q.extend(f64::from(quantise_m(below))), size * 1.15, &mut rng, path));
                    below -= 0.8 * size;
                    layer += 1;
                }
            }
        }
    }
    things
}

/// Tufts of marram on the dunes.
fn tuft(relief: &Relief, path: &SeedPath, plants: f64, cell: Cell) -> Option<Placed> {
    if relief.cliffs {
        return None;
    }
    let (draw, corner) = (cell.draw(path.hash_u32()), cell.point(0.5, 0.5));
    if draw > 0.6 * plants {
        return None;
    }
    let s = relief.surface(corner);
    let (belt_m, _) = relief.belt();
    let share = relief.marram(corner, &s)
        * smoothstep(1.5 * belt_m + 50.0, 0.8 * belt_m + 25.0, s.place.inland_m - relief.dune_toe_m(corner));
    let clear = 1.0 - relief.path(corner, &s.place).0.max(relief.track(corner, &s.place));
    if draw > 0.6 * plants * share * clear {
        return None;
    }
    let mut rng = cell.key(path).rng();
    let p = cell.point(rng.unit(), rng.unit());
    let height = rng.lognormal(0.55, 0.25).clamp(0.3, 0.95);
    let width = height * rng.range(1.0, 1.8);
    Some(planted(&|q: DVec2| relief.surface(q).land_m, p, [width, height], VARIANTS, &mut rng, cell.name("tuft")))
}

/// Bushes in groups on the land behind.
fn bush(relief: &Relief, path: &SeedPath, plants: f64, cell: Cell) -> Option<Placed> {
    let seed = path.hash_u32();
    let (draw, corner) = (cell.draw(seed), cell.point(0.5, 0.5));
    if draw > 0.8 * plants {
        return None;
    }
    let s = relief.surface(corner);
    let d = s.place.inland_m
        - if relief.cliffs {
            24.0 + 0.4 * relief.top_m(corner)
        } else {
            relief.dune_toe_m(corner) + 0.8 * relief.belt().0
        };
    if d < 0.0 {
        return None;
    }
    // Heath itself is colour; few bushes stand in it.
    let (mass, full) = (relief.scrub(corner), if relief.hinterland() == Hinterland::Heath { 0.3 } else { 1.0 });
    let share = 0.8 * plants * (0.008 + 0.992 * mass * full) * smoothstep(0.0, 30.0, d);
    if draw > share * (1.0 - relief.track(corner, &s.place)) {
        return None;
    }
    let mut rng = cell.key(path).rng();
    let p = cell.point(rng.unit(), rng.unit());
    let height = (rng.lognormal(1.05, 0.4) * (1.0 + 0.35 * mass * full)).clamp(0.5, 3.2);
    let width = height * rng.range(1.2, 2.4);
    if relief.track(p, &s.place) > 0.0 {
        return None;
    }
    Some(planted(&|q: DVec2| relief.surface(q).land_m, p, [width, height], VARIANTS, &mut rng, cell.name("bush")))
}

fn stone_material(natural: bool, path: &SeedPath) -> Material {
    let seed = path.child("material").hash_u32();
    let base = if natural { Bands::new(0.115, 0.135, 0.150, 0.19) } else { Bands::new(0.150, 0.168, 0.176, 0.21) };
    Material::diffuse("stone", Class::Rock, base)
        .rough(0.4)
        .with(Layer::Brightness { amount: Field::Variation(1).times(0.30) })
        .with(Layer::Brightness { amount: Field::world_noise(seed, 0.9, 3).times(0.22) })
        .with(Layer::Mix {
            color: Bands::new(0.040, 0.046, 0.044, 0.09),
            amount: Field::Along(satseed_scene::Coordinate::HEIGHT).ramp(1.0, 0.3).times(0.8),
        })
}

fn leaves(name: &str, color: Bands, path: &SeedPath) -> Vec<Material> {
    let seed = path.child("material").hash_u32();
    let leaf = Material {
        brdf: Brdf::Leaf { transmission: Bands::new(0.012, 0.03, 0.02, 0.14) },
        ..Material::diffuse(name, Class::LowVegetation, color)
            .with(Layer::Mix {
                color: Bands::new(0.095, 0.125, 0.130, 0.25),
                amount: Field::Variation(0).ramp(-0.2, 0.9).times(0.6),
            })
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.22) })
            .with(Layer::Brightness { amount: Field::world_noise(seed, 0.3, 2).times(0.2) })
    };
    vec![leaf, Material::diffuse("stems", Class::LowVegetation, Bands::new(0.08, 0.09, 0.11, 0.18))]
}
