//! What trees hold, as a bound: so many bytes a triangle of a mesh, however often it is placed, and so many an instance.
#![allow(clippy::print_stdout)]

use glam::{DAffine3, DVec3};
use satseed_scene::{Bands, Class, Instance, Material, Mesh, Object, Rng, Scene, SeedPath, quantise_point};
use satseed_tracer::{BYTES_PER_INSTANCE, BYTES_PER_TRIANGLE, BYTES_PER_WIDE_TRIANGLE, Tracer};

/// What a mesh's tree holds beside its triangles: a node and a block that may be nearly empty.
const BYTES_PER_MESH: usize = 640;

/// A wavy ground of `n` by `n` posts.
fn ground(n: u32, post_m: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let p = DVec3::new(f64::from(i), f64::from(j), 0.0) * post_m;
            mesh.positions_m.push(quantise_point(p + DVec3::Z * ((i * 7 + j * 13) % 11) as f64 * 0.2));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    mesh
}

/// Loose triangles of any size in a box.
fn loose(count: u32, box_m: f64, size_m: f64, rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..count {
        let at = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * box_m;
        for _ in 0..3 {
            let off = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * size_m;
            mesh.positions_m.push(quantise_point(at + off));
        }
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    mesh
}

fn scene(mut meshes: Vec<Mesh>, placed: &[(u32, u32)], rng: &mut Rng) -> Scene {
    for m in &mut meshes {
        m.slots = vec![0; m.triangles.len()];
    }
    let mut instances = Vec::new();
    for (mesh, count) in placed {
        for _ in 0..*count {
            let at = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 500.0;
            instances.push(Instance {
                mesh: *mesh,
                world_from_object: DAffine3::from_translation(at),
                object: 0,
                material_set: 0,
                variation: [0.0; 4],
            });
        }
    }
    Scene {
        meshes,
        instances,
        materials: vec![Material::diffuse("grey", Class::Ground, Bands::grey(0.2))],
        material_sets: vec![vec![0]],
        objects: vec![Object { path: "all".to_owned(), class: Class::Ground }],
        ..Scene::default()
    }
}

#[test]
fn trees_stay_within_their_bound() {
    let mut rng = SeedPath::root("memory", 1).rng();
    let cases = [
        ("fine ground", BYTES_PER_TRIANGLE, vec![ground(300, 0.5)], vec![(0, 1)]),
        ("coarse ground", BYTES_PER_WIDE_TRIANGLE, vec![ground(100, 90.0)], vec![(0, 1)]),
        ("leaves", BYTES_PER_TRIANGLE, vec![loose(20_000, 4.0, 0.2, &mut rng)], vec![(0, 1)]),
        ("a heap of all sizes", BYTES_PER_WIDE_TRIANGLE, vec![loose(20_000, 400.0, 80.0, &mut rng)], vec![(0, 1)]),
        (
            "many small meshes",
            BYTES_PER_TRIANGLE,
            (0..500).map(|k| loose(12 + k % 30, 3.0, 1.0, &mut rng)).collect(),
            vec![],
        ),
        ("many instances", BYTES_PER_TRIANGLE, vec![loose(3_000, 4.0, 0.2, &mut rng)], vec![(0, 30_000)]),
    ];
    for (name, bytes_per_triangle, meshes, mut placed) in cases {
        if placed.is_empty() {
            placed = (0..meshes.len() as u32).map(|mesh| (mesh, 1)).collect();
        }
        let scene = scene(meshes, &placed, &mut rng);
        let (held, _) = scene.triangle_counts();
        let bound = held * bytes_per_triangle
            + scene.instances.len() * BYTES_PER_INSTANCE
            + (scene.meshes.len() + 1) * BYTES_PER_MESH;
        let bytes = Tracer::new(&scene).bytes();
        assert!(bytes <= bound, "{name}: {bytes} bytes, at most {bound} are promised");
        // A bound that is far off says nothing.
        assert!(bytes * 3 > bound, "{name}: {bytes} bytes, {bound} are promised");
    }
}
