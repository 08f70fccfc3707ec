//! Rays a second, by kind, on one thread: `cargo bench --bench trace [-- ROUNDS]`.
//!
//! A scene of 2 million terrain triangles, 3,000 blocks and 20,000 instanced clumps; medians of alternating rounds.
#![allow(clippy::print_stdout, missing_docs)]

use glam::{DAffine3, DQuat, DVec2, DVec3};
use satseed::camera::{Camera, Datum, RigSpec, StereoRig};
use satseed_scene::{
    Bands, Class, Instance, Material, Mesh, Object, Ray, Scene, SeedPath, gradient_noise_2d, quantise_point,
};
use satseed_tracer::{Hit, Origin, Tracer};
use std::time::Instant;

const HALF_M: f64 = 500.0;
const FRAME_PX: u32 = 700;

fn main() {
    let rounds = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(5);
    let scene = scene();
    let start = Instant::now();
    let tracer = Tracer::new(&scene);
    let (held, placed) = scene.triangle_counts();
    println!(
        "{held} triangles held, {placed} placed; trees in {:.2} s, {:.1} bytes a held triangle",
        start.elapsed().as_secs_f64(),
        tracer.bytes() as f64 / held as f64
    );
    let rig = StereoRig::new(RigSpec {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [FRAME_PX; 2],
        baseline_m: 200.0,
        azimuth_rad: 0.4,
        pivot_along_baseline: 0.5,
        pivot_m: DVec3::ZERO,
        datum: Datum::Height(0.0),
    });
    let hits = primary(&tracer, &rig.left);
    let sun = DVec3::new(0.4, -0.5, 0.77).normalize();
    let starts: Vec<Origin> = hits.iter().map(Origin::on).collect();
    let mut table: [(&str, Vec<f64>); 7] =
        ["primary", "label", "sun", "ambient", "primary, bundles", "label, bundles", "sun, bundles"]
            .map(|n| (n, Vec::new()));
    let frame = tiled(&rig.left);
    let tiled_hits: Vec<Hit> = tracer.closest_all(&frame).into_iter().flatten().collect();
    let label: Vec<(Origin, DVec3)> = tiled_hits.iter().map(|h| (Origin::on(h), rig.right.position_m)).collect();
    let sunward: Vec<(Origin, DVec3)> = tiled_hits.iter().map(|h| (Origin::on(h), sun)).collect();
    let mut sink = 0;
    for _ in 0..rounds {
        let mut time = |k: usize, run: &mut dyn FnMut() -> usize| {
            let start = Instant::now();
            sink += run();
            table[k].1.push(hits.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        };
        time(0, &mut || primary(&tracer, &rig.left).len());
        time(1, &mut || starts.iter().filter(|o| tracer.occluded(o, rig.right.position_m)).count());
        time(2, &mut || starts.iter().filter(|o| tracer.blocked(o, sun, 3000.0)).count());
        time(4, &mut || frame.chunks(256).map(|tile| tracer.closest_all(tile).len()).sum());
        time(5, &mut || label.chunks(256).map(|tile| tracer.occluded_all(tile).len()).sum());
        time(6, &mut || sunward.chunks(256).map(|tile| tracer.blocked_all(tile).len()).sum());
        time(3, &mut || {
            let mut rng = SeedPath::root("ambient", 1).rng();
            hits.iter()
                .filter(|h| {
                    let d = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 0.99 + h.normal;
                    tracer.closest_from(&Origin::on(h), d.normalize(), 3000.0).is_some()
                })
                .count()
        });
    }
    for (name, mut speeds) in table {
        speeds.sort_by(f64::total_cmp);
        println!("{name:16} {:6.2} Mrays/s median of {rounds}", speeds[speeds.len() / 2]);
    }
    println!("({sink} answers)");
}

fn primary(tracer: &Tracer, camera: &Camera) -> Vec<Hit> {
    (0..FRAME_PX * FRAME_PX)
        .filter_map(|i| {
            let ray: Ray = camera.ray(f64::from(i % FRAME_PX), f64::from(i / FRAME_PX));
            tracer.closest(&ray, 3000.0)
        })
        .collect()
}

/// The frame's rays in tiles of 16 x 16.
fn tiled(camera: &Camera) -> Vec<Ray> {
    let mut rays = Vec::new();
    for tile in 0..(FRAME_PX / 16) * (FRAME_PX / 16) {
        let (left, top) = (tile % (FRAME_PX / 16) * 16, tile / (FRAME_PX / 16) * 16);
        for k in 0..256 {
            // Packets of 4 x 4.
            let (p, r) = (k / 16, k % 16);
            let (u, v) = (left + p % 4 * 4 + r % 4, top + p / 4 * 4 + r / 4);
            rays.push(camera.ray(f64::from(u), f64::from(v)));
        }
    }
    rays
}

fn scene() -> Scene {
    let root = SeedPath::root("bench", 1);
    let height = |p: DVec2| {
        (0..6).fold(0.0, |sum, k| {
            let l = 200.0 / f64::from(1 << k);
            sum + f64::from(gradient_noise_2d(p.x / l, p.y / l, k)) * l * 0.12
        })
    };
    let n = 1000_u32;
    let mut terrain = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let p = DVec2::new(f64::from(i), f64::from(j)) / f64::from(n) * 2.0 * HALF_M - DVec2::splat(HALF_M);
            terrain.positions_m.push(quantise_point(p.extend(height(p))));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            terrain.triangles.push([a, a + 1, a + n + 2]);
            terrain.triangles.push([a, a + n + 2, a + n + 1]);
        }
    }
    let mut blocks = Mesh::default();
    let mut rng = root.child("blocks").rng();
    for _ in 0..3000 {
        let p = DVec2::new(rng.signed(), rng.signed()) * HALF_M;
        let size = DVec3::new(rng.range(5.0, 15.0), rng.range(5.0, 15.0), rng.lognormal(12.0, 0.6));
        cuboid(&mut blocks, p.extend(height(p) - 2.0), size);
    }
    let mut clump = Mesh::default();
    let mut rng = root.child("clump").rng();
    for _ in 0..600 {
        let at = DVec3::new(rng.normal(), rng.normal(), rng.normal() + 3.0);
        let first = clump.positions_m.len() as u32;
        for _ in 0..3 {
            let q = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 0.3;
            clump.positions_m.push(quantise_point(at + q));
        }
        clump.triangles.push([first, first + 1, first + 2]);
    }
    let mut instances: Vec<Instance> = (0..2).map(|mesh| instance(mesh, DAffine3::IDENTITY)).collect();
    let mut rng = root.child("place").rng();
    for _ in 0..20_000 {
        let p = DVec2::new(rng.signed(), rng.signed()) * HALF_M;
        let turn = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
        instances.push(instance(
            2,
            DAffine3::from_scale_rotation_translation(DVec3::splat(rng.range(0.7, 1.4)), turn, p.extend(height(p))),
        ));
    }
    let mut meshes = vec![terrain, blocks, clump];
    for m in &mut meshes {
        m.slots = vec![0; m.triangles.len()];
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

fn instance(mesh: u32, world_from_object: DAffine3) -> Instance {
    Instance { mesh, world_from_object, object: 0, material_set: 0, variation: [0.0; 4] }
}

fn cuboid(mesh: &mut Mesh, low: DVec3, size: DVec3) {
    let first = mesh.positions_m.len() as u32;
    for k in 0..8_u32 {
        let bit = |b: u32| f64::from(k >> b & 1);
        mesh.positions_m.push(quantise_point(low + DVec3::new(bit(0), bit(1), bit(2)) * size));
    }
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        mesh.triangles.push([first + a, first + b, first + c]);
        mesh.triangles.push([first + a, first + c, first + d]);
    }
}
