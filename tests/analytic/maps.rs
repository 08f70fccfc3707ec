//! Surface models and the shadow label, exactly.

use crate::analytic::bodies::Boxes;
use crate::analytic::boxes::{Placement, boxes_scene};
use crate::support::stage::{RigCase, noon};
use glam::DVec3;
use satseed::camera::Datum;
use satseed::labels::{Extra, View, extract, surface_models};
use satseed_generators::Region;
use satseed_scene::{Class, Environment, Ray};
use satseed_tracer::Tracer;

/// Tops of what a line meets from the open, from above: solids that touch or run into each other are one.
fn open_tops(mut solids: Vec<(f64, f64)>) -> Vec<f64> {
    solids.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (low, high) in solids {
        match merged.last_mut() {
            Some(last) if high >= last.0 => last.0 = last.0.min(low),
            _ => merged.push((low, high)),
        }
    }
    let mut tops: Vec<f64> = Vec::new();
    for (_, high) in merged {
        if tops.last().is_none_or(|last| last - high > 1.0) {
            tops.push(high);
        }
    }
    tops
}

/// Over a plane: a bank in the ground, a bridge, a slab high up; a tower of a podium with its foot in the ground, a shaft
/// that stands in the podium and is full of floors; a mass that touches its podium; balconies above each other; a low
/// deck; a stack less than 1 m apart. First surface, bare ground and layers at every cell's centre.
#[test]
fn surface_models_of_boxes() {
    let mut solids = vec![
        [DVec3::new(-60.0, -60.0, -7.5), DVec3::new(-30.0, 60.0, 0.0)],
        [DVec3::new(-3.75, -60.0, 11.25), DVec3::new(5.0, 60.0, 12.5)],
        [DVec3::new(-20.0, -10.0, 30.0), DVec3::new(20.0, 5.0, 31.25)],
        [DVec3::new(12.5, 10.0, -7.25), DVec3::new(32.5, 30.0, 5.0)],
        [DVec3::new(15.0, 12.5, 4.375), DVec3::new(30.0, 27.5, 250.0)],
        [DVec3::new(12.5, -30.0, -7.25), DVec3::new(32.5, -15.0, 5.0)],
        [DVec3::new(15.0, -27.5, 5.0), DVec3::new(30.0, -17.5, 17.5)],
        [DVec3::new(35.0, -30.0, -5.9375), DVec3::new(38.75, 30.0, -5.625)],
        [DVec3::new(35.0, -20.0, -5.375), DVec3::new(38.75, 20.0, -5.1875)],
        [DVec3::new(35.0, -10.0, -5.375), DVec3::new(38.75, 10.0, -4.9375)],
    ];
    // More floors than any counter of layers may stop at, inside the shaft and out of its wall.
    for k in 0..80 {
        let z = 8.0 + 3.0 * f64::from(k);
        solids.push([DVec3::new(16.25, 13.75, z), DVec3::new(28.75, 27.0, z + 0.25)]);
        solids.push([DVec3::new(27.5, 15.0, z + 0.5), DVec3::new(31.875, 25.0, z + 0.75)]);
    }
    let bodies = Boxes { ground_z: -6.25, ground_half: 3200.0, solids };
    for placement in [Placement::Axis, Placement::Vertices] {
        let scene = boxes_scene(&bodies, placement, &[Class::Water, Class::Ground, Class::Bridge]);
        let models = surface_models(&scene, 41.3, 0.7);
        assert_eq!((models.dsm_m.width, models.dsm_m.height), (118, 118));
        let turn = crate::support::stage::world_from_baseline(placement.azimuth_rad()).transpose();
        let mut counts = std::collections::BTreeMap::new();
        for j in 0..118 {
            for i in 0..118 {
                let world = models.dsm_m.position(i, j);
                assert!((world.x - (i as f64 - 58.5) * 0.7).abs() < 1e-9, "cells are centred on the pivot");
                let p = turn * world.extend(0.0);
                let mut met: Vec<(f64, f64)> = bodies
                    .solids
                    .iter()
                    .filter(|b| p.x > b[0].x && p.x < b[1].x && p.y > b[0].y && p.y < b[1].y)
                    .map(|b| (b[0].z, b[1].z))
                    .collect();
                met.push((f64::NEG_INFINITY, bodies.ground_z));
                let tops = open_tops(met);
                assert_eq!(models.dsm_m.get(i, j), tops[0] as f32, "{p}");
                assert_eq!(models.dtm_m.get(i, j), bodies.ground_z as f32, "{p}");
                assert_eq!(models.ndsm_m.get(i, j), (tops[0] - bodies.ground_z) as f32, "{p}");
                assert_eq!(usize::from(models.layers.get(i, j)), tops.len(), "{p}");
                *counts.entry(tops.len()).or_insert(0) += 1;
            }
        }
        assert!([1, 2, 3, 81].iter().all(|n| counts.contains_key(n)), "{counts:?}");
    }
}

/// Surface models lay triangles onto a grid, labels trace rays: over a whole scene of each region both see the same
/// surface from above, and the same ground where nothing stands on it.
#[test]
fn surface_models_agree_with_rays() {
    for name in Region::NAMES {
        let region = Region::by_name(name).expect("registered").with_radius_m(60.0);
        let scene = region.build(1);
        let tracer = Tracer::new(&scene);
        let models = surface_models(&scene, 60.0, 0.3);
        let (mut bare, mut covered) = (0, 0);
        for j in 0..models.dsm_m.height {
            for i in 0..models.dsm_m.width {
                let down = Ray { origin: models.dsm_m.position(i, j).extend(1000.0), direction: DVec3::NEG_Z };
                let hit = tracer.closest(&down, 2000.0).expect("ground everywhere");
                let (dsm, dtm) = (models.dsm_m.get(i, j), models.dtm_m.get(i, j));
                assert!((f64::from(dsm) - hit.point.z).abs() < 1e-4, "{name} at {}: {dsm}", hit.point);
                if scene.instances[hit.instance as usize].object == 0 {
                    assert_eq!(dsm, dtm, "{name} at {}", hit.point);
                    bare += 1;
                } else {
                    assert!(dtm <= dsm, "{name} at {}", hit.point);
                    covered += 1;
                }
            }
        }
        assert!(bare > 10_000 && covered > 100, "{name}: {bare} {covered}");
    }
}

/// A 60 m box under a sun in the west: lit roof, dark wall, and a shadow that ends where h / tan says, with the solar
/// disc's penumbra.
#[test]
fn shadow_of_a_box() {
    let bodies = Boxes {
        ground_z: 0.0,
        ground_half: 3200.0,
        solids: vec![[DVec3::new(-30.0, -520.0, -1.25), DVec3::new(28.75, 520.0, 60.0)]],
    };
    let scene = boxes_scene(&bodies, Placement::Axis, &[Class::Ground, Class::Roof]);
    let tracer = Tracer::new(&scene);
    let elevation = 0.7;
    let sun = Environment { sun_elevation_rad: elevation, sun_azimuth_rad: 1.5 * core::f64::consts::PI, ..noon() };
    let rig = RigCase {
        altitude_m: 1000.0,
        gsd_m: 0.05,
        size_px: [3000, 2],
        feet_m: [55.0, 115.0],
        azimuth_rad: Placement::Axis.azimuth_rad(),
        datum: Datum::Height(0.0),
        shift_px: [0.0; 2],
    }
    .rig();
    let extra = Extra { shadow: true, instance: true, elevation: true, ..Extra::default() };
    let labels = extract(&tracer, &rig, View::Left, &sun, extra);
    let (shadow, object) = (labels.shadow.expect("asked"), labels.instance.expect("asked"));
    let z = labels.elevation_m.expect("asked");
    let tip = |e: f64| 28.75 + 60.0 / libm::tan(e);
    let r = Environment::SUN_ANGULAR_RADIUS_RAD;
    let (dark_end, lit_from) = (tip(elevation + r), tip(elevation - r) + 0.01);
    let (mut dark, mut part, mut lit, mut last) = (0, 0, 0, 0);
    for u in 0..3000_usize {
        let ray = rig.left.ray(u as f64, 0.0);
        let x = ray.origin.x - ray.direction.x / ray.direction.z * ray.origin.z;
        match (object[u], z[u]) {
            (1, 60.0) => assert_eq!(shadow[u], 255, "roof at column {u}"),
            // The camera stands east of the box: this wall looks away from the sun.
            (1, _) => assert_eq!(shadow[u], 0, "wall at column {u}"),
            _ if x < -30.0 || x > lit_from => {
                assert_eq!(shadow[u], 255, "ground at x = {x}");
                lit += 1;
            }
            _ if x < dark_end => {
                assert_eq!(shadow[u], 0, "ground at x = {x}");
                dark += 1;
            }
            _ => {
                assert!(shadow[u] >= last, "the penumbra grows lighter");
                last = shadow[u];
                part += 1;
                if (x - tip(elevation)).abs() < 0.05 {
                    assert!((96..160).contains(&shadow[u]), "half the disc at the tip, not {}", shadow[u]);
                }
            }
        }
    }
    assert!(dark > 500 && part > 8 && lit > 100, "{dark} {part} {lit}");
}
