//! Loose blocks: convex hulls of a few points.

use glam::DVec3;
use satseed_scene::{Mesh, SeedPath, quantise_point};

/// Points from which a block is made; not all end on its hull.
const POINTS: usize = 15;

/// A block of about 1 m: a box with broken corners and faces, as jointed rock falls. Its middle is the origin. The mesh
/// is closed, every triangle of slot 0 and without shading normals, so that its faces look flat.
pub fn block(path: &SeedPath) -> Mesh {
    // A draw whose points lie four in a plane gives no clean hull; the next one does.
    (0..64).find_map(|attempt| attempt_block(&path.index(attempt))).expect("random points have a hull")
}

fn attempt_block(path: &SeedPath) -> Option<Mesh> {
    let mut rng = path.rng();
    let half = DVec3::new(0.5, rng.range(0.32, 0.5), rng.range(0.22, 0.42));
    let points: Vec<[f32; 3]> = (0..POINTS)
        .map(|_| {
            // On the box's surface: one coordinate at its face, the others drawn towards the edges.
            let face = rng.below(3) as usize;
            let mut p = DVec3::ZERO;
            for axis in 0..3 {
                let spread = rng.signed();
                p[axis] = spread * (1.35 - 0.35 * spread.abs());
            }
            p[face] = if rng.chance(0.5) { 1.0 } else { -1.0 } * rng.range(0.85, 1.0);
            quantise_point(p.clamp(DVec3::splat(-1.0), DVec3::ONE) * half)
        })
        .collect();
    hull(&points)
}

/// The convex hull by trying every triple: fine for a dozen points. `None` where four lie in a plane of the hull.
fn hull(points: &[[f32; 3]]) -> Option<Mesh> {
    let at: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let n = at.len();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                let normal = (at[j] - at[i]).cross(at[k] - at[i]);
                let side = |m: usize| normal.dot(at[m] - at[i]);
                let others = || (0..n).filter(|m| ![i, j, k].contains(m));
                if others().all(|m| side(m) < 0.0) {
                    triangles.push([i as u32, j as u32, k as u32]);
                } else if others().all(|m| side(m) > 0.0) {
                    triangles.push([i as u32, k as u32, j as u32]);
                }
            }
        }
    }
    let mut new_index = vec![u32::MAX; n];
    let mut positions_m = Vec::new();
    for v in triangles.iter_mut().flatten() {
        let old = *v as usize;
        if new_index[old] == u32::MAX {
            new_index[old] = positions_m.len() as u32;
            positions_m.push(points[old]);
        }
        *v = new_index[old];
    }
    // Euler: a closed hull of triangles has 2 V - 4 of them.
    (triangles.len() >= 8 && triangles.len() + 4 == 2 * positions_m.len()).then(|| Mesh {
        slots: vec![0; triangles.len()],
        positions_m,
        triangles,
        ..Mesh::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_closed_convex_and_differ() {
        let path = SeedPath::root("rock", 1);
        let blocks: Vec<Mesh> = (0..30).map(|i| block(&path.index(i))).collect();
        for mesh in &blocks {
            mesh.validate().unwrap();
            let (low, high) = mesh.bounds_m().unwrap();
            assert!(low.min_element() >= -0.5 && high.max_element() <= 0.5);
            let volume: f64 = (0..mesh.triangles.len())
                .map(|t| {
                    let [a, b, c] = mesh.corners(t);
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!(volume > 0.08 && volume < 0.8, "{volume}");
        }
        assert_ne!(blocks[0], blocks[1]);
    }
}
