//! Small scenes of one mesh, for the tests of light and shading.

use glam::DAffine3;
use satseed_scene::{Bands, Class, Instance, Material, Mesh, Object, Scene};

/// A mesh that stands where its positions say, its slots filled by materials in order.
pub(super) fn of(mesh: Mesh, materials: Vec<Material>) -> Scene {
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance {
            mesh: 0,
            world_from_object: DAffine3::IDENTITY,
            object: 0,
            material_set: 0,
            variation: [0.0; 4],
        }],
        material_sets: vec![(0..materials.len() as u32).collect()],
        materials,
        objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
        ..Scene::default()
    }
}

/// A mesh of one material.
pub(super) fn one(positions_m: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, material: Material) -> Scene {
    let slots = vec![0; triangles.len()];
    of(Mesh { positions_m, triangles, slots, ..Mesh::default() }, vec![material])
}

/// A flat square, Lambert, reflectance 0.4.
pub(super) fn plane() -> Scene {
    let corner = |x: f32, y: f32| [x * 100.0, y * 100.0, 3.0];
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    one(corners, vec![[0, 1, 2], [0, 2, 3]], Material::diffuse("plane", Class::Ground, Bands::grey(0.4)))
}
