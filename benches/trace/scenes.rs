//! What is traced: fields of any number of triangles and instances, and the regions themselves.

use glam::{DAffine3, DQuat, DVec2, DVec3};
use satseed_generators::Region;
use satseed_generators::kit::trees::{SPECIES, Species, tree};
use satseed_scene::{
    Bands, Class, Environment, Instance, Material, Mesh, Object, Ray, Scene, SeedPath, gradient_noise_2d,
    quantise_point,
};
use satseed_tracer::Tracer;

/// A scene of the benches.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Subject {
    /// A square kilometre of terrain and 3,000 blocks of about this many triangles together, and instanced clumps.
    Field {
        /// Thousands of triangles.
        thousands: u32,
        /// Instances of a clump of 600 triangles.
        clumps: u32,
    },
    /// A region with its default parameters, seed 1.
    Region(&'static str),
    /// The canyon with 50,000 instanced trees of 3,000 triangles and more.
    Forest,
}

/// All of them, by name.
pub(crate) const SUBJECTS: [(&str, Subject); 12] = [
    ("field-0.1M", field(100, 0)),
    ("field-0.3M", field(300, 0)),
    ("field-1M", field(1_000, 0)),
    ("field-3M", field(3_000, 0)),
    ("field-10M", field(10_000, 0)),
    ("field-30M", field(30_000, 0)),
    ("clumps-2k", field(1_000, 2_000)),
    ("clumps-20k", field(1_000, 20_000)),
    ("clumps-200k", field(1_000, 200_000)),
    ("toronto", Subject::Region("toronto")),
    ("canyon", Subject::Region("canyon")),
    ("forest", Subject::Forest),
];

/// Sun of the scenes, as in the preset `satunreal`.
pub(crate) fn sun() -> DVec3 {
    Environment {
        sun_elevation_rad: 42.0_f64.to_radians(),
        sun_azimuth_rad: 145.0_f64.to_radians(),
        aerosol_optical_depth: 0.12,
    }
    .sun_direction()
}

const fn field(thousands: u32, clumps: u32) -> Subject {
    Subject::Field { thousands, clumps }
}

impl Subject {
    pub(crate) fn build(self) -> Scene {
        match self {
            Self::Field { thousands, clumps } => field_scene(thousands, clumps),
            Self::Region(name) => Region::by_name(name).expect("it is registered").build(1),
            Self::Forest => forest(),
        }
    }
}

const HALF_M: f64 = 500.0;
const BLOCKS: u32 = 3000;

fn height_m(p: DVec2) -> f64 {
    (0..6).fold(0.0, |sum, k| {
        let l = 200.0 / f64::from(1 << k);
        sum + f64::from(gradient_noise_2d(p.x / l, p.y / l, k)) * l * 0.12
    })
}

fn field_scene(thousands: u32, clumps: u32) -> Scene {
    let root = SeedPath::root("bench", 1);
    let n = f64::from(thousands * 1000 - BLOCKS * 12).max(2.0) / 2.0;
    let mut blocks = Mesh::default();
    let mut rng = root.child("blocks").rng();
    for _ in 0..BLOCKS {
        let p = DVec2::new(rng.signed(), rng.signed()) * HALF_M;
        let size = DVec3::new(rng.range(5.0, 15.0), rng.range(5.0, 15.0), rng.lognormal(12.0, 0.6));
        cuboid(&mut blocks, p.extend(height_m(p) - 2.0), size);
    }
    let mut meshes = vec![terrain(n.sqrt() as u32), blocks, clump(&root.child("clump"))];
    for m in &mut meshes {
        m.slots = vec![0; m.triangles.len()];
    }
    let mut instances: Vec<Instance> = (0..2).map(|mesh| instance(mesh, DAffine3::IDENTITY)).collect();
    let mut rng = root.child("place").rng();
    for _ in 0..clumps {
        let p = DVec2::new(rng.signed(), rng.signed()) * HALF_M;
        instances.push(instance(2, standing(p.extend(height_m(p)), &mut rng)));
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

/// A square of `n` by `n` posts.
fn terrain(n: u32) -> Mesh {
    let mut terrain = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let p = DVec2::new(f64::from(i), f64::from(j)) / f64::from(n) * 2.0 * HALF_M - DVec2::splat(HALF_M);
            terrain.positions_m.push(quantise_point(p.extend(height_m(p))));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            terrain.triangles.push([a, a + 1, a + n + 2]);
            terrain.triangles.push([a, a + n + 2, a + n + 1]);
        }
    }
    terrain
}

/// Loose leaves.
fn clump(path: &SeedPath) -> Mesh {
    let mut clump = Mesh::default();
    let mut rng = path.rng();
    for _ in 0..600 {
        let at = DVec3::new(rng.normal(), rng.normal(), rng.normal() + 3.0);
        let first = clump.positions_m.len() as u32;
        for _ in 0..3 {
            let q = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * 0.3;
            clump.positions_m.push(quantise_point(at + q));
        }
        clump.triangles.push([first, first + 1, first + 2]);
    }
    clump
}

/// Fewest triangles of a tree of the forest.
const TREE_TRIANGLES: usize = 3000;
const TREES: usize = 50_000;
/// Individuals of each species.
const INDIVIDUALS: u64 = 2;

/// The canyon's ground with trees on all of it that is not too steep, within its radius of full detail.
fn forest() -> Scene {
    let mut scene = Region::by_name("canyon").expect("it is registered").build(1);
    let path = SeedPath::root("forest", 1);
    let set = scene.material_sets.len() as u32;
    let material = |name: &str| Material::diffuse(name, Class::Tree, Bands::grey(0.2));
    scene.material_sets.push(vec![scene.materials.len() as u32, scene.materials.len() as u32 + 1]);
    scene.materials.extend([material("bark"), material("leaves")]);
    let first_mesh = scene.meshes.len() as u32;
    for (k, species) in SPECIES.iter().enumerate() {
        // Five times the clusters, of 0.45 times the width: as much leaf.
        let fine = Species { clusters: species.clusters * 5, cluster: species.cluster * 0.45, ..*species };
        for individual in 0..INDIVIDUALS {
            let mesh = tree(&fine, &path.index(k as u64).index(individual));
            assert!(mesh.triangles.len() >= TREE_TRIANGLES, "a tree of {} triangles", mesh.triangles.len());
            scene.meshes.push(mesh);
        }
    }
    let meshes = scene.meshes.len() as u64 - u64::from(first_mesh);
    let mut trees = Vec::with_capacity(TREES);
    {
        let tracer = Tracer::new(&scene);
        let mut rng = path.child("place").rng();
        while trees.len() < TREES {
            let p = DVec2::new(rng.signed(), rng.signed()) * scene.full_detail_radius_m;
            let (mesh, placed) = (first_mesh + rng.below(meshes) as u32, standing(p.extend(0.0), &mut rng));
            let ray = Ray { origin: p.extend(1000.0), direction: DVec3::NEG_Z };
            let ground = tracer.closest(&ray, 3000.0).filter(|hit| hit.normal.z > 0.6);
            if let Some(hit) = ground {
                let world_from_object = DAffine3::from_translation(DVec3::Z * hit.point.z) * placed;
                trees.push(Instance { material_set: set, ..instance(mesh, world_from_object) });
            }
        }
    }
    scene.instances.extend(trees);
    scene
}

/// Turned about the vertical, and larger or smaller.
fn standing(at_m: DVec3, rng: &mut satseed_scene::Rng) -> DAffine3 {
    let turn = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    DAffine3::from_scale_rotation_translation(DVec3::splat(rng.range(0.7, 1.4)), turn, at_m)
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
