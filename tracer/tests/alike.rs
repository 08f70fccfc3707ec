//! Bundles, single rays and instruction sets give the same answers, to the bit.

use glam::{DAffine3, DQuat, DVec3};
use satseed_scene::{Bands, Class, Instance, Material, Mesh, Object, Ray, Rng, Scene, SeedPath, quantise_point};
use satseed_tracer::{Hit, InstructionSet, Origin, Tracer};

fn direction(rng: &mut Rng) -> DVec3 {
    DVec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(DVec3::Z)
}

/// Triangles of all sizes in a box: leaves of a few centimetres, and some that are wider than a leaf's 16 bits reach.
fn heap(count: u32, box_m: f64, rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..count {
        let at = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * box_m;
        let size_m = rng.lognormal(0.5, 1.2).min(150.0);
        for _ in 0..3 {
            mesh.positions_m.push(quantise_point(at + direction(rng) * size_m));
        }
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    mesh.slots = vec![0; mesh.triangles.len()];
    mesh
}

fn scene(rng: &mut Rng) -> Scene {
    let meshes = vec![heap(2_000, 60.0, rng), heap(300, 4.0, rng)];
    let placed =
        |mesh, world_from_object| Instance { mesh, world_from_object, object: 0, material_set: 0, variation: [0.0; 4] };
    let mut instances = vec![placed(0, DAffine3::IDENTITY)];
    for _ in 0..150 {
        let turn = DQuat::from_axis_angle(direction(rng), rng.range(0.0, 6.0));
        let at = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 60.0;
        let size = DVec3::splat(rng.range(0.5, 2.0));
        instances.push(placed(1, DAffine3::from_scale_rotation_translation(size, turn, at)));
    }
    // Two in one place: every ray that meets one has a tie.
    instances.push(instances[7].clone());
    Scene {
        meshes,
        instances,
        materials: vec![Material::diffuse("grey", Class::Ground, Bands::grey(0.2))],
        material_sets: vec![vec![0]],
        objects: vec![Object { path: "all".to_owned(), class: Class::Ground }],
        ..Scene::default()
    }
}

fn bits(hit: Option<Hit>) -> Option<(u32, u32, [u64; 10])> {
    let h = hit?;
    let numbers = [h.t, h.weights[0], h.weights[1], h.weights[2], h.point.x, h.point.y, h.point.z];
    let normal = h.normal.to_array();
    let all = core::array::from_fn(|k| if k < 7 { numbers[k] } else { normal[k - 7] }.to_bits());
    Some((h.instance, h.triangle, all))
}

#[test]
fn every_way_gives_the_same_bits() {
    let path = SeedPath::root("alike", 1);
    let scene = scene(&mut path.child("scene").rng());
    let mut rng = path.child("rays").rng();
    let mut tracer = Tracer::new(&scene);
    let (mut met, mut blocked) = (0, 0);
    for bundle in 0..120 {
        // From one place, in nearly one direction or less so, up to directions of their own.
        let (from, to) = (direction(&mut rng) * 300.0, direction(&mut rng) * 40.0);
        let (main, spread) = ((to - from).normalize(), [0.001, 0.01, 0.1, 2.0][bundle % 4]);
        let rays: Vec<Ray> = (0..200)
            .map(|_| Ray { origin: from, direction: (main + direction(&mut rng) * (spread * rng.unit())).normalize() })
            .collect();
        tracer = tracer.with_instructions(InstructionSet::Portable);
        let hits: Vec<Option<Hit>> = rays.iter().map(|r| tracer.closest(r, tracer.reach_m(r.origin))).collect();
        let starts: Vec<Origin> = hits.iter().flatten().map(Origin::on).collect();
        let away = direction(&mut rng);
        let onward: Vec<(Origin, DVec3)> = starts.iter().map(|o| (*o, away)).collect();
        let lines: Vec<(Origin, DVec3)> = starts.iter().map(|o| (*o, from)).collect();
        let further: Vec<_> =
            onward.iter().map(|(o, d)| bits(tracer.closest_from(o, *d, tracer.reach_m(o.point())))).collect();
        let shut: Vec<bool> = lines.iter().map(|(o, p)| tracer.occluded(o, *p)).collect();
        met += starts.len();
        blocked += further.iter().flatten().count();
        let hits: Vec<_> = hits.into_iter().map(bits).collect();
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
            tracer = tracer.with_instructions(set);
            assert_eq!(tracer.closest_all(&rays).into_iter().map(bits).collect::<Vec<_>>(), hits, "{set:?}, {bundle}");
            let found: Vec<_> = tracer.closest_from_all(&onward).into_iter().map(bits).collect();
            assert_eq!(found, further, "{set:?}, {bundle}");
            let any: Vec<bool> = further.iter().map(Option::is_some).collect();
            assert_eq!(tracer.blocked_all(&onward), any, "{set:?}, {bundle}");
            assert_eq!(tracer.occluded_all(&lines), shut, "{set:?}, {bundle}");
        }
    }
    assert!(met > 10_000 && blocked > 3_000, "{met} hits and {blocked} blocked rays test too little");
}
