//! No ray slips between triangles that share an edge or a vertex.

use super::scenes::town;
use crate::support::solids::{cuboid, dented, grid, sphere, without_flat_triangles};
use crate::support::stage::Stage;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use rayon::prelude::*;
use satseed_scene::{Class, Ray, Rng, Scene, SeedPath, gradient_noise_2d};
use satseed_tracer::Tracer;

const CHUNK: u64 = 10_000;

fn any_turn(rng: &mut Rng) -> DMat3 {
    DMat3::from_quat(DQuat::from_xyzw(rng.normal(), rng.normal(), rng.normal(), rng.normal()).normalize())
}

/// A point of a random triangle's edge, or one of its corners.
fn on_an_edge(scene: &Scene, rng: &mut Rng) -> DVec3 {
    let instance = rng.below(scene.instances.len() as u64) as u32;
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
    let [a, b, _] = {
        let mut corners = scene.corners(instance, rng.below(mesh.triangles.len() as u64) as u32);
        corners.rotate_left(rng.below(3) as usize);
        corners
    };
    match rng.below(4) {
        0 => a,
        1 => a.lerp(b, rng.unit() * 1e-9),
        _ => a.lerp(b, rng.unit()),
    }
}

/// Runs chunks of rays in parallel; each ray is from `ray`, and `ok` says whether its hit is right.
fn shoot(what: &str, rays: u64, one: impl Fn(&mut Rng) -> Result<(), String> + Sync) {
    (0..rays.div_ceil(CHUNK)).into_par_iter().for_each(|chunk| {
        let mut rng = SeedPath::root("watertight", 1).child(what).index(chunk).rng();
        for _ in 0..CHUNK {
            if let Err(error) = one(&mut rng) {
                panic!("{what}: {error}");
            }
        }
    });
}

/// From inside a closed solid every ray must meet it, wherever it is aimed.
fn closed_solids(rays: u64) {
    let mut rng = SeedPath::root("closed", 1).rng();
    let centre = DVec3::new(130.0, -57.0, 11.0);
    let meshes = [
        ("box", cuboid(centre - DVec3::new(9.0, 4.0, 2.0), centre + DVec3::new(3.0, 7.0, 5.0))),
        ("sphere", sphere(centre, 40.0, 4)),
        ("dented", without_flat_triangles(dented(centre, 30.0, 4, 0.4, &mut rng))),
        ("tiny sphere", without_flat_triangles(sphere(centre, 0.05, 2))),
    ];
    for (name, mesh) in meshes {
        for turned in [false, true] {
            let place = if turned {
                DAffine3::from_translation(DVec3::new(3.0, 200.0, 0.7)) * DAffine3::from_mat3(any_turn(&mut rng))
            } else {
                DAffine3::IDENTITY
            };
            let mut stage = Stage::new();
            stage.add(mesh.clone(), place, Class::Rock);
            let scene = stage.finish();
            let tracer = Tracer::new(&scene);
            let inside = place.transform_point3(centre);
            shoot(&format!("{name}, turned {turned}"), rays / 8, |rng| {
                let aim = on_an_edge(&scene, rng);
                let origin = inside + (aim - inside) * (0.5 * rng.unit() * rng.unit());
                let ray = Ray { origin, direction: (aim - origin).normalize() };
                tracer.closest(&ray, 1e4).map(|_| ()).ok_or_else(|| format!("{ray:?} leaves the solid"))
            });
        }
    }
}

/// Terrain in tiles, some tiles twice as fine but with the same border, under one common placement: rays from a
/// satellite's directions meet it where they are aimed, also where four tiles meet.
fn tiles(rays: u64) {
    let height = |x: f64, y: f64| 8.0 * f64::from(gradient_noise_2d(x / 23.0, y / 23.0, 5));
    let mut rng = SeedPath::root("tiles", 1).rng();
    let turn = DAffine3::from_translation(DVec3::new(17.0, -4.0, 3.3)) * DAffine3::from_rotation_z(0.83);
    for (name, place) in [("as they are", DAffine3::IDENTITY), ("turned", turn)] {
        let mut stage = Stage::new();
        for j in 0..6 {
            for i in 0..6 {
                let m = grid(f64::from(i) * 16.0 - 48.0, f64::from(j) * 16.0 - 48.0, 1.0, 16, &mut |x, y| height(x, y));
                stage.add(m, place, Class::Ground);
            }
        }
        let scene = stage.finish();
        let tracer = Tracer::new(&scene);
        let borders: Vec<DVec3> = scene
            .meshes
            .iter()
            .flat_map(|m| m.positions_m.iter().map(|p| DVec3::from(p.map(f64::from))))
            .filter(|p| (p.x % 16.0 == 0.0 || p.y % 16.0 == 0.0) && p.x.abs() < 40.0 && p.y.abs() < 40.0)
            .collect();
        assert!(borders.len() > 500);
        let altitude_m = *rng.pick(&[1000.0]);
        shoot(&format!("tiles {name}"), rays / 2, |rng| {
            let aim = if rng.chance(0.5) {
                // On a seam between tiles.
                let p = *rng.pick(&borders);
                let along = if p.x % 16.0 == 0.0 { DVec3::Y } else { DVec3::X };
                let q = p + along;
                let q = q.with_z(f64::from(satseed_scene::quantise_m(height(q.x, q.y))));
                place.transform_point3(p.lerp(q, rng.unit()))
            } else {
                let p = on_an_edge(&scene, rng);
                let local = place.inverse().transform_point3(p);
                if local.x.abs() > 40.0 || local.y.abs() > 40.0 {
                    return Ok(());
                }
                p
            };
            let altitude_m = if rng.chance(0.5) { altitude_m } else { 617_000.0 };
            let eye = DVec3::new(0.2 * altitude_m * rng.signed(), 0.2 * altitude_m * rng.signed(), altitude_m);
            let length = (aim - eye).length();
            let ray = Ray { origin: eye, direction: (aim - eye) / length };
            match tracer.closest(&ray, 1e7) {
                None => Err(format!("{ray:?} finds no ground at {aim}")),
                Some(hit) if hit.t > length * (1.0 + 1e-11) => Err(format!("{ray:?} meets {} beyond {aim}", hit.point)),
                Some(_) => Ok(()),
            }
        });
    }
}

#[test]
fn a_million_rays_meet_what_they_are_aimed_at() {
    closed_solids(600_000);
    tiles(400_000);
}

#[test]
#[ignore = "long: 10^8 rays"]
fn a_hundred_million_rays_meet_what_they_are_aimed_at() {
    closed_solids(60_000_000);
    tiles(40_000_000);
}

/// Rays at edges of a whole scene, from above: none falls through the ground.
#[test]
fn no_ray_falls_through_a_town() {
    let scene = town(8, 128, 1.0, 60);
    let tracer = Tracer::new(&scene);
    shoot("town", 200_000, |rng| {
        let aim = on_an_edge(&scene, rng);
        if aim.x.abs() > 50.0 || aim.y.abs() > 50.0 {
            return Ok(());
        }
        let eye = DVec3::new(150.0 * rng.signed(), 150.0 * rng.signed(), 1000.0);
        let ray = Ray { origin: eye, direction: (aim - eye).normalize() };
        // Trees lean past the aim, so the ground may be met somewhat further on.
        tracer.closest(&ray, 1e7).map(|_| ()).ok_or_else(|| format!("{ray:?} falls through"))
    });
}
