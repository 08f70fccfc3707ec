//! What the tests of several regions ask of a scene.

use super::ground::Ground;
use glam::{DAffine3, DVec3};
use satseed_scene::{Instance, Scene};
use std::collections::BTreeMap;

/// World corners of all terrain triangles.
pub(crate) fn terrain(scene: &Scene) -> impl Iterator<Item = [DVec3; 3]> {
    scene.instances.iter().filter(|i| i.object == 0).flat_map(|i| {
        assert_eq!(i.world_from_object, DAffine3::IDENTITY);
        let mesh = &scene.meshes[i.mesh as usize];
        (0..mesh.triangles.len()).map(|t| mesh.corners(t))
    })
}

/// The terrain of a square of half side `half_m` is one surface whose only border is the square's.
pub(crate) fn assert_closed(scene: &Scene, half_m: f64) {
    scene.validate().unwrap();
    let mut uses: BTreeMap<[[u64; 3]; 2], [u32; 2]> = BTreeMap::new();
    for t in terrain(scene) {
        for k in 0..3 {
            let bits = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
            let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
            uses.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
    }
    for (edge, uses) in uses {
        let [a, b] = edge.map(|p| p.map(f64::from_bits));
        let on_rim = (0..2).any(|axis| a[axis] == b[axis] && a[axis].abs() == half_m);
        assert_eq!(uses.iter().sum::<u32>(), if on_rim { 1 } else { 2 }, "{a:?} {b:?}");
        assert!(on_rim || uses == [1, 1], "{a:?} {b:?}");
    }
}

/// No outline of a ground crossed another, and every edge within its square of half side `half_m` has two triangles, one
/// each way.
pub(crate) fn assert_whole(ground: &Ground, half_m: f32) {
    assert_eq!(ground.crossings, 0);
    let m = &ground.mesh;
    m.validate().unwrap();
    let bits = |v: u32| m.positions_m[v as usize].map(f32::to_bits);
    let mut edges: BTreeMap<([u32; 3], [u32; 3]), [u32; 2]> = BTreeMap::new();
    for t in &m.triangles {
        for k in 0..3 {
            let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
            let (key, way) = if a < b { ((a, b), 0) } else { ((b, a), 1) };
            edges.entry(key).or_default()[way] += 1;
        }
    }
    let border = |p: [u32; 3]| p.iter().take(2).any(|x| f32::from_bits(*x).abs() == half_m);
    for ((a, b), count) in edges {
        if border(a) && border(b) && count != [1, 1] {
            continue;
        }
        assert_eq!(count, [1, 1], "{:?} {:?}", a.map(f32::from_bits), b.map(f32::from_bits));
    }
}

/// World positions of an instance's vertices.
pub(crate) fn vertices<'a>(scene: &'a Scene, i: &'a Instance) -> impl Iterator<Item = DVec3> + 'a {
    let positions = scene.meshes[i.mesh as usize].positions_m.iter();
    positions.map(|p| i.world_from_object.transform_point3(DVec3::from_array(p.map(f64::from))))
}

/// Every vertex lies between two heights.
pub(crate) fn assert_between(scene: &Scene, [low, high]: [f64; 2], of: &str) {
    for i in &scene.instances {
        for p in vertices(scene, i) {
            assert!((low..=high).contains(&p.z), "{of}: {} outside {low}..{high}", p.z);
        }
    }
}

/// What stands (all but the terrain) within `radius_m` of the middle of a crop is what stands there in the whole: the same
/// names, places, shapes and materials; more than `least` things.
pub(crate) fn assert_same_things(crop: &Scene, whole: &Scene, radius_m: f64, least: usize) {
    let things = |scene: &Scene| -> BTreeMap<String, String> {
        let within = |i: &&Instance| i.object != 0 && i.world_from_object.translation.truncate().length() < radius_m;
        let thing = |i: &Instance| {
            let mesh = &scene.meshes[i.mesh as usize];
            let set = &scene.material_sets[i.material_set as usize];
            let materials: Vec<&str> = set.iter().map(|m| scene.materials[*m as usize].name.as_str()).collect();
            let shape: f64 = mesh.positions_m.iter().flatten().map(|x| f64::from(*x)).sum();
            let text =
                format!("{:?} {:?} {materials:?} {} {shape}", i.world_from_object, i.variation, mesh.triangles.len());
            (scene.objects[i.object as usize].path.clone(), text)
        };
        scene.instances.iter().filter(within).map(thing).collect()
    };
    let (crop, whole) = (things(crop), things(whole));
    assert!(crop.len() > least, "{}", crop.len());
    for (name, what) in &whole {
        assert_eq!(crop.get(name), Some(what), "{name}");
    }
    assert_eq!(crop.len(), whole.len());
}

/// A scene is legal, lies between its region's bounds of height, and is held in less memory than its bound says.
pub(crate) fn assert_within_bounds(scene: &Scene, height_bounds_m: [f64; 2], memory_bound_bytes: u64, of: &str) {
    scene.validate().unwrap();
    assert_between(scene, height_bounds_m, of);
    let (held, _) = scene.triangle_counts();
    let bytes = held * 200 + scene.instances.len() * 400;
    assert!((bytes as u64) < memory_bound_bytes, "{of}: {bytes}");
}

/// All that is not terrain reaches more than `by_m` below the ground.
pub(crate) fn assert_rooted(scene: &Scene, by_m: f64, height_m: impl Fn(glam::DVec2) -> f64) {
    for i in scene.instances.iter().filter(|i| i.object != 0) {
        let below = vertices(scene, i).map(|p| p.z - height_m(p.truncate())).fold(f64::MAX, f64::min);
        assert!(below < -by_m, "{}: {below}", scene.objects[i.object as usize].path);
    }
}

/// A measure that must rise with each step of a parameter.
pub(crate) fn assert_rises(what: &str, values: &[f64]) {
    assert!(values.windows(2).all(|v| v[1] > v[0] * 1.03 + 1e-9), "{what}: {values:?}");
}
