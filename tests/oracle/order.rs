//! A tracer's answer does not depend on its trees: other orders of triangles and instances, other meshes, same hits.

use super::scenes::{ALTITUDES_M, FAMILIES, member};
use crate::support::stage::Stage;
use glam::DAffine3;
use satseed_scene::{Class, Mesh, Rng, Scene, SeedPath};
use satseed_tracer::{Tracer, tie_tolerance_m};

/// The scene with triangles and instances in another order, and where each went: new id -> old id.
fn shuffled(scene: &Scene, rng: &mut Rng) -> (Scene, Vec<u32>, Vec<Vec<u32>>) {
    let mut new = scene.clone();
    let mut triangles = Vec::new();
    for mesh in &mut new.meshes {
        let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        rng.shuffle(&mut order);
        mesh.triangles = order.iter().map(|t| mesh.triangles[*t as usize]).collect();
        mesh.slots = order.iter().map(|t| mesh.slots[*t as usize]).collect();
        triangles.push(order);
    }
    let mut instances: Vec<u32> = (0..new.instances.len() as u32).collect();
    rng.shuffle(&mut instances);
    new.instances = instances.iter().map(|i| scene.instances[*i as usize].clone()).collect();
    (new, instances, triangles)
}

#[test]
fn other_orders_give_the_same_hits() {
    let mut rng = SeedPath::root("order", 1).rng();
    let (mut same, mut tied) = (0_u64, 0_u64);
    for family in &FAMILIES {
        for altitude_m in ALTITUDES_M {
            let (scene, rig) = member(family, 31, altitude_m);
            let tracer = Tracer::new(&scene);
            let (other_scene, instances, triangles) = shuffled(&scene, &mut rng);
            let other = Tracer::new(&other_scene);
            for (u, v) in (0..40).flat_map(|v| (0..40).map(move |u| (f64::from(u), f64::from(v)))) {
                let ray = rig.left.ray(u, v);
                let (a, b) = (tracer.closest(&ray, 1e7), other.closest(&ray, 1e7));
                assert_eq!(a.is_some(), b.is_some(), "{}: ({u}, {v})", family.name);
                let (Some(a), Some(b)) = (a, b) else { continue };
                let instance = instances[b.instance as usize];
                let mesh = scene.instances[instance as usize].mesh as usize;
                let old = (instance, triangles[mesh][b.triangle as usize]);
                if (a.instance, a.triangle) == old {
                    assert_eq!((a.t.to_bits(), a.point.to_array()), (b.t.to_bits(), b.point.to_array()));
                    same += 1;
                } else {
                    // Ties are decided by id, and the ids are others.
                    assert!((a.t - b.t).abs() <= 2.0 * tie_tolerance_m(a.t), "{}: ({u}, {v})", family.name);
                    tied += 1;
                }
            }
        }
    }
    assert!(same > 5 * tied && tied > 0, "{same} the same, {tied} tied");
}

/// One mesh of everything in world coordinates against the same cut into as many meshes as there are triangles.
#[test]
fn one_mesh_or_many() {
    for name in ["soup", "height fields", "closed solids"] {
        let family = FAMILIES.iter().find(|f| f.name == name).expect("a family");
        let (scene, rig) = member(family, 8, 1000.0);
        let (mut one, mut many) = (Stage::new(), Stage::new());
        let mut all = Mesh::default();
        for t in super::brute::expand(&scene) {
            let positions_m: Vec<[f32; 3]> = t.corners.iter().map(|c| c.as_vec3().to_array()).collect();
            let first = all.positions_m.len() as u32;
            all.positions_m.extend(&positions_m);
            all.triangles.push([first, first + 1, first + 2]);
            all.slots.push(0);
            let single = Mesh { positions_m, triangles: vec![[0, 1, 2]], slots: vec![0], ..Mesh::default() };
            many.add(single, DAffine3::IDENTITY, Class::Rock);
        }
        one.add(all, DAffine3::IDENTITY, Class::Rock);
        let (one, many) = (one.finish(), many.finish());
        let (one, many) = (Tracer::new(&one), Tracer::new(&many));
        for (u, v) in (0..40).flat_map(|v| (0..40).map(move |u| (f64::from(u), f64::from(v)))) {
            let ray = rig.right.ray(u, v);
            let (a, b) = (one.closest(&ray, 1e7), many.closest(&ray, 1e7));
            assert_eq!(
                a.map(|h| (h.triangle, h.t.to_bits())),
                b.map(|h| (h.instance, h.t.to_bits())),
                "{name}: ({u}, {v})"
            );
        }
    }
}
