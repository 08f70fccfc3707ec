//! Things on the ground: one at most in each cell of a grid, drawn by the cell's own key, placed as instances.

use super::terrain::tin::Ground;
use glam::{DAffine3, DVec2};
use rayon::prelude::*;
use satseed_scene::{Class, Instance, Material, Mesh, Object, Rng, Scene, SeedPath, hash_cell, unit_from_hash};

/// Something and where it stands.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Where, m.
    pub at_m: DVec2,
    /// Its frame to the world's.
    pub world_from_object: DAffine3,
    /// The instance's numbers.
    pub variation: [f32; 4],
    /// Which of its kind's meshes.
    pub mesh: u32,
    /// Its path in the scene's object table.
    pub path: String,
}

/// A kind of things: their meshes and materials.
#[derive(Clone, Debug)]
pub struct Kind {
    /// Its meshes.
    pub meshes: Vec<Mesh>,
    /// Materials by slot.
    pub materials: Vec<Material>,
    /// Class of each as an object.
    pub class: Class,
}

/// Adds those things of a kind that stand within `reach_m` of the pivot.
pub fn add(scene: &mut Scene, kind: Kind, reach_m: f64, things: Vec<Placed>) {
    let first_mesh = scene.meshes.len() as u32;
    let first_material = scene.materials.len() as u32;
    let material_set = scene.material_sets.len() as u32;
    scene.material_sets.push((0..kind.materials.len() as u32).map(|k| first_material + k).collect());
    scene.materials.extend(kind.materials);
    scene.meshes.extend(kind.meshes);
    for thing in things.into_iter().filter(|t| t.at_m.length() <= reach_m) {
        scene.instances.push(Instance {
            mesh: first_mesh + thing.mesh,
            world_from_object: thing.world_from_object,
            object: scene.objects.len() as u32,
            material_set,
            variation: thing.variation,
        });
        scene.objects.push(Object { path: thing.path, class: kind.class });
    }
}

/// A cell of a square grid over the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Eastward and northward number.
    pub at: (i32, i32),
    /// Its side, m.
    pub side_m: f64,
}

impl Cell {
    /// A place within it, by shares of its side.
    pub fn point(self, u: f64, v: f64) -> DVec2 {
        DVec2::new(f64::from(self.at.0) + u, f64::from(self.at.1) + v) * self.side_m
    }

    /// The key of its own randomness.
    pub fn key(self, path: &SeedPath) -> SeedPath {
        path.index((u64::from(self.at.0 as u32) << 32) | u64::from(self.at.1 as u32))
    }

    /// A first draw, 0..1, that spares the full stream where nothing can stand.
    pub fn draw(self, seed: u32) -> f64 {
        f64::from(unit_from_hash(hash_cell(self.at.0, self.at.1, 0, seed)))
    }

    /// The name of what stands in it.
    pub fn name(self, kind: &str) -> String {
        format!("{kind}/{}_{}", self.at.0, self.at.1)
    }
}

/// Asks every cell within reach of the pivot, rows in parallel, for what stands in it.
pub fn place(reach_m: f64, side_m: f64, at: impl Fn(Cell) -> Option<Placed> + Sync) -> Vec<Placed> {
    let half = libm::ceil(reach_m / side_m) as i32;
    (-half..half)
        .into_par_iter()
        .flat_map_iter(|j| {
            let at = &at;
            (-half..half).filter_map(move |i| at(Cell { at: (i, j), side_m }))
        })
        .collect()
}

/// Four numbers of an instance's own.
pub fn variation(rng: &mut Rng) -> [f32; 4] {
    core::array::from_fn(|_| rng.signed() as f32)
}

/// The lowest ground under a thing of a radius, m: at its middle and at eight places around it.
pub fn lowest(ground: &impl Ground, p: DVec2, radius_m: f64) -> f64 {
    let d = radius_m * core::f64::consts::FRAC_1_SQRT_2;
    let around =
        [(radius_m, 0.0), (-radius_m, 0.0), (0.0, radius_m), (0.0, -radius_m), (d, d), (-d, d), (d, -d), (-d, -d)];
    around.iter().map(|(x, y)| ground.height_m(p + DVec2::new(*x, *y))).fold(ground.height_m(p), f64::min)
}
