//! Broad-leaved trees of streets and yards: limbs and a crown of opaque leaf clusters with gaps between them.

use super::mesh_builder::MeshBuilder;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, Rng, SeedPath};

/// Slot of bark.
pub const BARK: u16 = 0;
/// Slot of leaves.
pub const LEAVES: u16 = 1;

/// Shape of a species. Lengths are of the mesh before an instance scales it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Species {
    /// Height of the crown's centre, m.
    pub centre_m: f64,
    /// Half width and half height of the crown, m.
    pub crown_m: [f64; 2],
    /// Number of leaf clusters.
    pub clusters: u32,
    /// Radius of a cluster relative to the crown's half width.
    pub cluster: f64,
    /// 0 round, 1 conical: how much the crown narrows upward.
    pub cone: f64,
}

/// Maple and linden, honey locust, young street tree, spruce.
pub const SPECIES: [Species; 4] = [
    Species { centre_m: 6.2, crown_m: [3.6, 3.4], clusters: 74, cluster: 0.25, cone: 0.25 },
    Species { centre_m: 6.0, crown_m: [3.9, 2.5], clusters: 76, cluster: 0.2, cone: 0.1 },
    Species { centre_m: 4.0, crown_m: [1.9, 2.4], clusters: 46, cluster: 0.3, cone: 0.35 },
    Species { centre_m: 5.6, crown_m: [2.3, 5.0], clusters: 66, cluster: 0.31, cone: 0.95 },
];

/// One individual: z = 0 is the ground, the trunk begins below it.
pub fn tree(species: &Species, path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = MeshBuilder::default();
    let [half_width, half_height] = species.crown_m;
    let lean = DVec3::new(rng.signed() * 0.35, rng.signed() * 0.35, 0.0);
    let fork = DVec3::new(0.0, 0.0, (species.centre_m - half_height * 0.75).max(1.2)) + lean * 0.4;
    let trunk = 0.05 * half_width + 0.05;
    b.limb(BARK, DVec3::new(0.0, 0.0, -0.7), fork, [trunk * 1.25, trunk], 6);
    // A lopsided crown: its ellipsoid is pushed about by a few bumps.
    let bumps: Vec<(DVec3, f64)> = (0..5).map(|_| (direction(&mut rng), rng.range(-0.28, 0.22))).collect();
    let centre = DVec3::new(0.0, 0.0, species.centre_m) + lean;
    let mut placed = 0;
    while placed < species.clusters {
        placed += 1;
        let d = direction(&mut rng);
        if d.z < -0.75 || rng.chance(0.12) {
            continue;
        }
        let bump: f64 = bumps.iter().map(|(v, k)| k * v.dot(d).max(0.0)).sum();
        let depth = rng.range(0.58, 0.98) + bump;
        let narrow = 1.0 - species.cone * (0.5 + 0.5 * d.z);
        let offset = DVec3::new(d.x * half_width * narrow, d.y * half_width * narrow, d.z * half_height) * depth;
        let at = centre + offset;
        let r = half_width * species.cluster * rng.range(0.7, 1.25) * (1.0 - 0.45 * species.cone * (0.5 + 0.5 * d.z));
        cluster(&mut b, at, r, &mut rng);
        if placed % 9 == 0 {
            b.limb(BARK, fork - DVec3::Z * 0.2, at, [trunk * 0.55, 0.03], 4);
        }
    }
    b.finish()
}

fn direction(rng: &mut Rng) -> DVec3 {
    DVec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(DVec3::Z)
}

/// An irregular closed lump of leaves: an icosahedron with every corner at a distance of its own.
pub(crate) fn cluster(b: &mut MeshBuilder, centre: DVec3, radius_m: f64, rng: &mut Rng) {
    const PHI: f64 = 1.618_033_988_749_895;
    const CORNERS: [[f64; 3]; 12] = [
        [-1.0, PHI, 0.0],
        [1.0, PHI, 0.0],
        [-1.0, -PHI, 0.0],
        [1.0, -PHI, 0.0],
        [0.0, -1.0, PHI],
        [0.0, 1.0, PHI],
        [0.0, -1.0, -PHI],
        [0.0, 1.0, -PHI],
        [PHI, 0.0, -1.0],
        [PHI, 0.0, 1.0],
        [-PHI, 0.0, -1.0],
        [-PHI, 0.0, 1.0],
    ];
    const FACES: [[usize; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    // Turned at random so that no two lumps line up.
    let axis = direction(rng);
    let turn = glam::DQuat::from_axis_angle(axis, rng.range(0.0, core::f64::consts::TAU));
    let flat = rng.range(0.6, 0.9);
    let p = CORNERS.map(|c| {
        let d = turn * DVec3::from_array(c).normalize();
        let q = d * (radius_m * rng.range(0.62, 1.3));
        centre + DVec3::new(q.x, q.y, q.z * flat)
    });
    for f in FACES {
        let corner = |i: usize| (p[i], DVec2::new(p[i].x, p[i].z));
        b.fan(LEAVES, &[corner(f[0]), corner(f[1]), corner(f[2])]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn trees_are_closed_and_stand_in_the_ground() {
        for (k, s) in SPECIES.iter().enumerate() {
            let m = tree(s, &SeedPath::root("tree", k as u64));
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
            let (low, high) = m.bounds_m().unwrap();
            assert!(low.z <= -0.5 && high.z > 5.0 && high.x - low.x < 11.0, "{low} {high}");
            assert!((400..1900).contains(&m.triangles.len()), "{}", m.triangles.len());
        }
    }
}
