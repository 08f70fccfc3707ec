//! Dry-land shrubs: leaf clusters around a few stems.

use super::scatter::{Placed, lowest, variation};
use super::terrain::tin::Ground;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use satseed_scene::{Mesh, Rng, SeedPath, quantise_m, quantise_point};

/// Slot of the leaves in a shrub's material set.
pub const LEAF_SLOT: u16 = 0;
/// Slot of the stems.
pub const STEM_SLOT: u16 = 1;

/// How deep the stems go below the ground, in heights of the shrub.
pub const ROOT: f64 = 0.45;

/// A shrub 1 m high and about 1.1 m wide on the origin: five to nine lumps of leaf clusters on stems that begin
/// [`ROOT`] below the ground, 250 to 450 triangles.
pub fn shrub(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut mesh = Mesh::default();
    let lumps = 5 + rng.below(5) as usize;
    let turn = rng.range(0.0, core::f64::consts::TAU);
    for lump in 0..lumps {
        // Around the middle like the seeds of a sunflower, lower at the rim.
        let share = (lump as f64 + 0.5) / lumps as f64;
        let (sin, cos) = libm::sincos(turn + lump as f64 * 2.399_963);
        let out = 0.42 * share.sqrt() * rng.range(0.75, 1.25);
        let size = rng.range(0.17, 0.27);
        let height = (0.78 - 0.45 * share + rng.signed() * 0.1).clamp(size * 0.8, 1.0 - size);
        let middle = DVec3::new(cos * out, sin * out, height);
        stem(&mut mesh, middle, &mut rng);
        for _ in 0..16 + rng.below(8) {
            leaf(&mut mesh, middle, size, &mut rng);
        }
    }
    mesh
}

/// A shrub of a size, its stems in the ground. `variants` is how many meshes its kind has.
pub fn planted(
    ground: &impl Ground,
    p: DVec2,
    [width_m, height_m]: [f64; 2],
    variants: usize,
    rng: &mut Rng,
    path: String,
) -> Placed {
    // On the lattice, so that a crop's plants stand where the whole's do.
    let base = f64::from(quantise_m(lowest(ground, p, 0.2 * width_m))) - 0.03;
    let lean = DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.12;
    let turn = DMat3::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
    let tilt = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, (DVec3::Z + lean).normalize()));
    let shape = DMat3::from_diagonal(DVec3::new(width_m, width_m * rng.range(0.75, 1.0), height_m));
    Placed {
        at_m: p,
        world_from_object: DAffine3::from_mat3_translation(tilt * turn * shape, p.extend(base)),
        variation: variation(rng),
        mesh: rng.below(variants as u64) as u32,
        path,
    }
}

/// A leaf cluster: a bent quad on the lump's shell, turned roughly outward.
fn leaf(mesh: &mut Mesh, middle: DVec3, size: f64, rng: &mut Rng) {
    let outward = direction(rng);
    let at = middle + outward * size * rng.range(0.7, 1.0) * DVec3::new(1.0, 1.0, 0.8);
    let normal = (outward + direction(rng) * 0.8 + DVec3::Z * 0.3).normalize();
    let (u, v) = normal.any_orthonormal_pair();
    let (sin, cos) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let (u, v) = (u * cos + v * sin, v * cos - u * sin);
    let (long, wide) = (size * rng.range(0.45, 0.7), size * rng.range(0.28, 0.45));
    let bend = normal * (-0.25 * long);
    let corners = [at - u * long + bend, at - v * wide, at + u * long + bend, at + v * wide];
    push(mesh, &corners, &[[0, 1, 2], [0, 2, 3]], LEAF_SLOT);
}

/// A three-sided stem from below the ground to a lump's middle, closed on top: else its inside is seen from above.
fn stem(mesh: &mut Mesh, top: DVec3, rng: &mut Rng) {
    let foot = DVec3::new(top.x * 0.25, top.y * 0.25, -ROOT);
    let thick = rng.range(0.012, 0.022);
    let side = |k: f64| {
        let (sin, cos) = libm::sincos(k * core::f64::consts::TAU / 3.0);
        DVec3::new(cos, sin, 0.0) * thick
    };
    let corners = [
        foot + side(0.0),
        foot + side(1.0),
        foot + side(2.0),
        top + side(0.0) * 0.5,
        top + side(1.0) * 0.5,
        top + side(2.0) * 0.5,
    ];
    push(mesh, &corners, &[[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5], [3, 4, 5]], STEM_SLOT);
}

fn push(mesh: &mut Mesh, corners: &[DVec3], triangles: &[[u32; 3]], slot: u16) {
    let first = mesh.positions_m.len() as u32;
    mesh.positions_m.extend(corners.iter().map(|p| quantise_point(*p)));
    mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| first + v)));
    mesh.slots.extend(triangles.iter().map(|_| slot));
}

/// Uniform on the sphere (Archimedes: height and turn are independent).
fn direction(rng: &mut Rng) -> DVec3 {
    let z = rng.signed();
    let (sin, cos) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let r = f64::sqrt((1.0 - z * z).max(0.0));
    DVec3::new(r * cos, r * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrubs_are_legal_rooted_and_differ() {
        let path = SeedPath::root("shrub", 1);
        let shrubs: Vec<Mesh> = (0..20).map(|i| shrub(&path.index(i))).collect();
        for mesh in &shrubs {
            mesh.validate().unwrap();
            assert!((180..=520).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
            let (low, high) = mesh.bounds_m().unwrap();
            assert!((low.z + ROOT).abs() < 0.01 && high.z > 0.7 && high.z < 1.2, "{low} {high}");
            assert!(low.truncate().min_element() > -0.9 && high.truncate().max_element() < 0.9);
        }
        assert_ne!(shrubs[0], shrubs[1]);
    }
}
