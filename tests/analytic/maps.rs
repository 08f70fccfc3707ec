//! Surface models and the shadow label, exactly.

use crate::analytic::bodies::Boxes;
use crate::analytic::boxes::{Placement, boxes_scene};
use crate::support::stage::{RigCase, noon};
use glam::DVec3;
use satseed::camera::Datum;
use satseed::labels::{Extra, View, extract, surface_models};
use satseed_scene::{Class, Environment};
use satseed_tracer::Tracer;

/// A bridge, a bank and a tower over a plane: first surface, bare ground and layers at every cell's centre.
#[test]
fn surface_models_of_boxes() {
    let bodies = Boxes {
        ground_z: -6.25,
        ground_half: 3200.0,
        solids: vec![
            [DVec3::new(-60.0, -60.0, -7.5), DVec3::new(-30.0, 60.0, 0.0)],
            [DVec3::new(-3.75, -60.0, 11.25), DVec3::new(5.0, 60.0, 12.5)],
            [DVec3::new(-20.0, -10.0, 30.0), DVec3::new(20.0, 5.0, 31.25)],
        ],
    };
    for placement in [Placement::Axis, Placement::Vertices] {
        let scene = boxes_scene(&bodies, placement, &[Class::Water, Class::Ground, Class::Bridge]);
        let tracer = Tracer::new(&scene);
        let models = surface_models(&tracer, 41.3, 0.7);
        assert_eq!((models.dsm_m.width, models.dsm_m.height), (118, 118));
        let turn = crate::support::stage::world_from_baseline(placement.azimuth_rad()).transpose();
        let mut counts = [0; 5];
        for j in 0..118 {
            for i in 0..118 {
                let world = models.dsm_m.position(i, j);
                assert!((world.x - (i as f64 - 58.5) * 0.7).abs() < 1e-9, "cells are centred on the pivot");
                let p = turn * world.extend(0.0);
                let mut tops: Vec<f64> = bodies
                    .solids
                    .iter()
                    .filter(|b| p.x > b[0].x && p.x < b[1].x && p.y > b[0].y && p.y < b[1].y)
                    .map(|b| b[1].z)
                    .collect();
                tops.push(bodies.ground_z);
                tops.sort_by(|a, b| b.total_cmp(a));
                assert_eq!(models.dsm_m.get(i, j), tops[0] as f32, "{p}");
                assert_eq!(models.dtm_m.get(i, j), bodies.ground_z as f32, "{p}");
                assert_eq!(usize::from(models.layers.get(i, j)), tops.len(), "{p}");
                counts[tops.len()] += 1;
            }
        }
        assert!(counts[1] > 0 && counts[2] > 0 && counts[3] > 0, "{counts:?}");
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
