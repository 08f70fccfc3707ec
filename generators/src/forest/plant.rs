//! Trees as instances, and what their bark and leaves look like.

use super::growth::{Growth, Health, Tree};
use super::land::Land;
use crate::kit::scatter::lowest;
use crate::kit::terrain::noise::fractal;
use crate::kit::woods::{self, INDIVIDUALS, SIZES, Species};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use rayon::prelude::*;
use satseed_scene::{
    Bands, Brdf, Class, Field, Fractal, Instance, Layer, Material, Mesh, Object, Scene, SeedPath, Space, quantise_m,
};

/// Snags, m of height and crown radius.
const SNAG: [f64; 2] = [20.0, 3.0];
const SNAGS: usize = 16;
/// Far trees, m of height and crown radius; so many of each form.
const FAR: [f64; 2] = [22.0, 3.5];
const FARS: usize = 6;

/// Colours of a species: reflectance and transmittance of its leaves or needles, and its bark.
fn colors(species: Species) -> [Bands; 3] {
    let leaf = |b, g, r, n| Bands::new(b, g, r, n);
    match species {
        Species::Oak => {
            [leaf(0.028, 0.062, 0.049, 0.42), leaf(0.005, 0.016, 0.010, 0.28), leaf(0.08, 0.095, 0.11, 0.2)]
        }
        Species::Beech => {
            [leaf(0.029, 0.068, 0.051, 0.45), leaf(0.005, 0.018, 0.011, 0.3), leaf(0.15, 0.16, 0.17, 0.25)]
        }
        Species::Birch => {
            [leaf(0.036, 0.076, 0.066, 0.42), leaf(0.007, 0.020, 0.014, 0.28), leaf(0.3, 0.32, 0.33, 0.4)]
        }
        Species::Spruce => {
            [leaf(0.024, 0.053, 0.040, 0.27), leaf(0.003, 0.010, 0.004, 0.1), leaf(0.07, 0.08, 0.10, 0.16)]
        }
        Species::Pine => {
            [leaf(0.030, 0.063, 0.053, 0.29), leaf(0.004, 0.012, 0.006, 0.1), leaf(0.07, 0.11, 0.17, 0.25)]
        }
        Species::Larch => {
            [leaf(0.029, 0.066, 0.056, 0.34), leaf(0.005, 0.017, 0.009, 0.18), leaf(0.08, 0.10, 0.13, 0.2)]
        }
    }
}

/// Leaves of a colour: each tree has its hue and brightness, its lumps and sprays theirs.
pub(super) fn leaves(name: &str, class: Class, [color, through]: [Bands; 2], contrast: f32, seed: u32) -> Material {
    let k = contrast;
    let noise = |salt: u32, wavelength_m: f32| Field::Noise(Fractal::new(Space::Object, seed ^ salt, wavelength_m, 2));
    let mut m = Material::diffuse(name, class, color)
        .with(Layer::Brightness {
            amount: Field::Sum(vec![Field::Variation(1).times(0.20 * k), Field::Variation(2).times(0.08 * k)]),
        })
        .with(Layer::Tint {
            tint: Bands::new(0.1, 0.0, 0.7, 0.0),
            amount: Field::Sum(vec![
                // Toward olive and rust more than toward blue-green, of which leaves have little.
                Field::Variation(0).affine(0.17 * k, 0.07 * k),
                Field::Variation(2).times(0.08 * k),
            ]),
        })
        .with(Layer::Tint { tint: Bands::new(0.35, 0.1, 0.35, 0.1), amount: Field::Variation(3).times(0.14 * k) })
        .with(Layer::Brightness { amount: noise(1, 1.9).times(0.30 * k) })
        .with(Layer::Brightness { amount: noise(2, 0.45).times(0.46 * k) })
        .bumpy(noise(3, 0.55), 0.09 * k);
    m.brdf = Brdf::Leaf { transmission: through };
    m
}

/// Adds all trees: in full detail within `near_m` of the pivot, as simple forms up to `far_m`.
pub(super) fn plant(
    scene: &mut Scene,
    land: &Land,
    growth: &Growth,
    [near_m, far_m]: [f64; 2],
    contrast: f64,
    path: &SeedPath,
) {
    let first_mesh = scene.meshes.len() as u32;
    let meshes = path.child("mesh");
    let mut made: Vec<Mesh> = (0..Species::ALL.len() * SIZES * INDIVIDUALS)
        .into_par_iter()
        .map(|k| {
            let (species, size) = (Species::ALL[k / (SIZES * INDIVIDUALS)], k / INDIVIDUALS % SIZES);
            woods::tree(species, size, &meshes.index(k as u64))
        })
        .collect();
    let snags = path.child("snag");
    made.extend((0..SNAGS).map(|k| woods::snag(SNAG[0], SNAG[1], &snags.index(k as u64))));
    let fars = path.child("far");
    made.extend((0..2 * FARS).map(|k| woods::far(FAR[0], FAR[1], k >= FARS, &fars.index(k as u64))));
    scene.meshes.extend(made);
    let sets = material_sets(scene, contrast as f32, &path.child("material"));

    let placed: Vec<(Instance, Object)> = growth
        .trees
        .par_iter()
        .filter(|t| t.at_m.length() <= far_m)
        .map(|t| instance(land, t, t.at_m.length() <= near_m, first_mesh, &sets, path))
        .collect();
    for (mut instance, object) in placed {
        instance.object = scene.objects.len() as u32;
        scene.instances.push(instance);
        scene.objects.push(object);
    }
}

/// For each species the set of green and of brown trees, and the set of dead ones.
struct Sets {
    green: Vec<u32>,
    brown: Vec<u32>,
    dead: u32,
}

fn material_sets(scene: &mut Scene, k: f32, path: &SeedPath) -> Sets {
    let seed = path.hash_u32();
    let mut add = |m: Material| {
        scene.materials.push(m);
        scene.materials.len() as u32 - 1
    };
    let bark = |name: &str, color: Bands| {
        Material::diffuse(name, Class::Tree, color)
            .rough(0.3)
            .with(Layer::Brightness { amount: Field::object_noise(seed ^ 7, 0.8, 2).times(0.3 * k) })
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.15 * k) })
    };
    let mut sets = Vec::new();
    for (n, species) in Species::ALL.into_iter().enumerate() {
        let [leaf, through, stem] = colors(species);
        let name = format!("{species:?}").to_lowercase();
        let salt = (n as u32 + 1) << 8;
        let stem = add(bark(&format!("{name} bark"), stem));
        let green = add(leaves(&format!("{name} leaves"), Class::Tree, [leaf, through], k, seed ^ salt));
        let (dry, glow) = if species.is_conifer() {
            (Bands::new(0.036, 0.056, 0.062, 0.24), Bands::new(0.003, 0.006, 0.010, 0.06))
        } else {
            (Bands::new(0.032, 0.060, 0.062, 0.28), Bands::new(0.004, 0.012, 0.012, 0.1))
        };
        let brown = leaves(&format!("{name} leaves, brown"), Class::Tree, [dry, glow], k, seed ^ salt ^ 1)
            // Some have only begun to turn.
            .with(Layer::Mix {
                color: leaf * 0.9,
                amount: Field::Sum(vec![
                    Field::Variation(2).times(0.7),
                    Field::object_noise(seed ^ salt ^ 2, 2.6, 2).times(0.8),
                ])
                .ramp(-0.1, 0.7),
            });
        let brown = add(brown);
        sets.push([vec![stem, green], vec![stem, brown]]);
    }
    let grey = add(bark("dead wood", Bands::new(0.15, 0.165, 0.175, 0.26)));
    let first = scene.material_sets.len() as u32;
    let count = sets.len() as u32;
    scene.material_sets.extend(sets.into_iter().flatten());
    scene.material_sets.push(vec![grey, grey]);
    Sets {
        green: (0..count).map(|n| first + 2 * n).collect(),
        brown: (0..count).map(|n| first + 2 * n + 1).collect(),
        dead: first + 2 * count,
    }
}

fn instance(land: &Land, tree: &Tree, near: bool, first_mesh: u32, sets: &Sets, path: &SeedPath) -> (Instance, Object) {
    let Tree { at_m, species, height_m, crown_m, health, key } = *tree;
    let cell = (u64::from(key.0 as u32) << 32) | u64::from(key.1 as u32);
    let mut rng = path.child("tree").index(cell).index(key.2 as u64).rng();
    let n = Species::ALL.iter().position(|s| *s == species).unwrap_or(0);
    let individuals = SIZES * INDIVIDUALS;
    let all = Species::ALL.len() * individuals;
    let (mesh, [full_height, full_crown]) = if !near {
        let kind = FARS * usize::from(species.is_conifer());
        (all + SNAGS + kind + rng.below(FARS as u64) as usize, FAR)
    } else if health == Health::Dead {
        (all + rng.below(SNAGS as u64) as usize, SNAG)
    } else {
        // The size whose crown is nearest in proportion; only low trees have leaves to the ground.
        let sizes = species.sizes();
        let off = |k: usize| {
            let ratio = crown_m / sizes[k][1];
            let ratio = ratio.max(1.0 / ratio);
            if (k == 0) == (height_m < 9.0) { ratio } else { ratio * 2.0 }
        };
        let size = (0..SIZES).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(0);
        (n * individuals + size * INDIVIDUALS + rng.below(INDIVIDUALS as u64) as usize, sizes[size])
    };
    let wide = crown_m / full_crown;
    let scale = DVec3::new(wide * rng.range(0.92, 1.08), wide, height_m / full_height);
    let turn = DMat3::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let lean = DVec3::new(rng.normal(), rng.normal(), 0.0) * if species.is_conifer() { 0.012 } else { 0.03 };
    let tilt =
        DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, (DVec3::Z + lean.clamp_length_max(0.09)).normalize()));
    let base = f64::from(quantise_m(lowest(land, at_m, 0.25))) - 0.08;
    // Hue goes in groups: kin of one seed tree, of one soil.
    let mut variation: [f32; 4] = core::array::from_fn(|_| rng.signed() as f32);
    let kin = fractal(at_m, path.child("kin").hash_u32(), 52.0, 2, 0.6) as f32;
    variation[0] = (0.7 * variation[0] + 1.5 * kin).clamp(-1.0, 1.0);
    let instance = Instance {
        mesh: first_mesh + mesh as u32,
        world_from_object: DAffine3::from_mat3_translation(
            tilt * turn * DMat3::from_diagonal(scale),
            at_m.extend(base),
        ),
        object: 0,
        material_set: match health {
            Health::Green => sets.green[n],
            Health::Brown => sets.brown[n],
            Health::Dead => sets.dead,
        },
        variation,
    };
    let path = format!("tree/{}_{}/{}", key.0, key.1, key.2);
    (instance, Object { path, class: Class::Tree })
}
