//! Nanoseconds a shade, by material and footprint, on one thread: `cargo bench --bench materials [-- ROUNDS [all]]`.
//!
//! The points are those that a frame of each region sees, and those that its bounced rays meet; medians of rounds. `all`
//! prints every material, else the ten that take most of the time.
#![allow(clippy::print_stdout, clippy::format_collect, missing_docs)]

use glam::{DVec2, DVec3};
use satseed::camera::{Datum, RigSpec, StereoRig};
use satseed_generators::Region;
use satseed_scene::{Material, Ray, Scene, SeedPath, SurfacePoint};
use satseed_tracer::{Hit, Origin, Tracer};
use std::time::Instant;

const RADIUS_M: f64 = 110.0;
const FRAME_PX: u32 = 450;
/// Of 16 and 4 samples a pixel of 0.3 m, of a whole pixel, and of a bounced ray (at least).
const FOOTPRINTS_M: [f64; 4] = [0.075, 0.15, 0.3, 1.5];

/// Places, each with the index of its material.
type Places = Vec<(u32, SurfacePoint)>;

fn main() {
    let rounds = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(5);
    let all = std::env::args().any(|a| a == "all");
    for name in Region::NAMES {
        let region = Region::by_name(name).expect("it is registered").with_radius_m(RADIUS_M);
        measure(name, &region.build(1), rounds, all);
    }
}

fn measure(name: &str, scene: &Scene, rounds: usize, all: bool) {
    let (seen, bounced) = points(scene);
    let mut sink = 0.0;
    // Rows: material, its share of the points, ns at each footprint.
    let mut rows: Vec<(&str, f64, Vec<f64>)> = Vec::new();
    for (k, material) in scene.materials.iter().enumerate() {
        let mine = |points: &[(u32, SurfacePoint)], footprint_m: Option<f64>| -> Vec<SurfacePoint> {
            let of = points.iter().filter(|p| p.0 == k as u32);
            of.map(|p| SurfacePoint { footprint_m: footprint_m.unwrap_or(p.1.footprint_m), ..p.1 }).collect()
        };
        let mut sets: Vec<_> = FOOTPRINTS_M[..3].iter().map(|f| mine(&seen, Some(*f))).collect();
        sets.push(mine(&bounced, None));
        if sets[0].is_empty() {
            continue;
        }
        let times = sets.iter().map(|set| median_ns(scene, material, set, rounds, &mut sink)).collect();
        rows.push((&material.name, sets[0].len() as f64 / seen.len() as f64, times));
    }
    println!("{name}: {} points seen, {} bounced; ns a shade (sum of albedos {sink:.0})", seen.len(), bounced.len());
    println!("  {:24} {:>7} {:>7} {:>7} {:>7} {:>7}", "", "share", "0.075", "0.15", "0.3", "bounce");
    rows.sort_by(|a, b| (b.1 * b.2[1]).total_cmp(&(a.1 * a.2[1])));
    for (material, share, times) in rows.iter().take(if all { rows.len() } else { 10 }) {
        let times: String = times.iter().map(|t| format!(" {t:7.0}")).collect();
        println!("  {material:24} {:6.1}%{times}", share * 100.0);
    }
    let mean: String = (0..FOOTPRINTS_M.len())
        .map(|f| format!(" {:7.0}", rows.iter().filter(|r| r.2[f] > 0.0).map(|r| r.1 * r.2[f]).sum::<f64>()))
        .collect();
    println!("  {:24} {:7}{mean}", "mean", "");
}

/// Median over rounds of the time of one shade of `set`, ns; 0 of an empty set.
fn median_ns(scene: &Scene, material: &Material, set: &[SurfacePoint], rounds: usize, sink: &mut f64) -> f64 {
    if set.is_empty() {
        return 0.0;
    }
    let mut times: Vec<f64> = (0..rounds)
        .map(|_| {
            let start = Instant::now();
            for p in set {
                *sink += f64::from(material.shade(p, &scene.rasters).albedo.0[1]);
            }
            start.elapsed().as_secs_f64() * 1e9 / set.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[rounds / 2]
}

/// Material and place of what a frame sees, and of what one bounced ray from each of these meets.
fn points(scene: &Scene) -> (Places, Places) {
    let tracer = Tracer::new(scene);
    let camera = StereoRig::new(RigSpec {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [FRAME_PX; 2],
        baseline_m: 150.0,
        azimuth_rad: 0.4,
        pivot_along_baseline: 0.5,
        pivot_m: DVec3::new(0.0, 0.0, scene.pivot_height_m),
        datum: Datum::Height(scene.pivot_height_m),
    })
    .left;
    let mut rng = SeedPath::root("bounce", 1).rng();
    let (mut seen, mut bounced) = (Vec::new(), Vec::new());
    for i in 0..FRAME_PX * FRAME_PX {
        let ray = camera.ray(f64::from(i % FRAME_PX), f64::from(i / FRAME_PX));
        let Some(hit) = tracer.closest(&ray, 3000.0) else { continue };
        seen.push(place(scene, &ray, &hit, 0.15));
        let d = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 0.99 + hit.normal;
        let ray = Ray { origin: hit.point, direction: d.normalize() };
        if let Some(hit) = tracer.closest_from(&Origin::on(&hit), ray.direction, 3000.0) {
            bounced.push(place(scene, &ray, &hit, FOOTPRINTS_M[3].max(0.3 * hit.t)));
        }
    }
    (seen, bounced)
}

fn place(scene: &Scene, ray: &Ray, hit: &Hit, footprint_m: f64) -> (u32, SurfacePoint) {
    let instance = &scene.instances[hit.instance as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    let corners = mesh.triangles[hit.triangle as usize].map(|v| v as usize);
    let mut uv_m = DVec2::ZERO;
    for (k, weight) in hit.weights.iter().enumerate() {
        if let Some(uv) = mesh.uvs_m.get(corners[k]) {
            uv_m += DVec2::new(f64::from(uv[0]), f64::from(uv[1])) * *weight;
        }
    }
    let slot = mesh.slots[hit.triangle as usize] as usize;
    let point = SurfacePoint {
        world_m: hit.point,
        object_m: instance.world_from_object.inverse().transform_point3(hit.point),
        uv_m,
        normal: if hit.normal.dot(ray.direction) < 0.0 { hit.normal } else { -hit.normal },
        footprint_m,
        variation: instance.variation,
    };
    (scene.material_sets[instance.material_set as usize][slot], point)
}
