//! Meshes of plain bodies. Lengths are metres; every vertex is a multiple of 1/1024 m.

use glam::DVec3;
use satseed_scene::{Mesh, Rng, quantise_point};

/// A mesh of one slot from corners in f64, which are brought to the lattice.
pub(crate) fn mesh(points: &[DVec3], triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        positions_m: points.iter().map(|p| quantise_point(*p)).collect(),
        slots: vec![0; triangles.len()],
        triangles,
        ..Mesh::default()
    }
}

/// A closed box.
pub(crate) fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let points: Vec<DVec3> = (0..8)
        .map(|k| {
            let pick = |bit: usize, axis: usize| if k >> bit & 1 == 0 { low[axis] } else { high[axis] };
            DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        })
        .collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    mesh(&points, quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

/// A closed prism over a convex polygon of (x, z) corners, counter-clockwise with x to the right and z up; it reaches
/// from `-half_y` to `half_y`.
pub(crate) fn prism(profile: &[[f64; 2]], half_y: f64) -> Mesh {
    let n = profile.len() as u32;
    let points: Vec<DVec3> =
        [-half_y, half_y].iter().flat_map(|y| profile.iter().map(|p| DVec3::new(p[0], *y, p[1]))).collect();
    let mut triangles = Vec::new();
    for k in 0..n {
        let j = (k + 1) % n;
        triangles.extend([[k, n + k, n + j], [k, n + j, j]]);
    }
    for k in 1..n - 1 {
        triangles.extend([[0, k, k + 1], [n, n + k + 1, n + k]]);
    }
    mesh(&points, triangles)
}

/// A grid of `cells` x `cells` squares from (x0, y0), two triangles each, of heights by grid corner. The diagonals
/// alternate.
pub(crate) fn grid(x0: f64, y0: f64, cell: f64, cells: u32, height: &mut dyn FnMut(f64, f64) -> f64) -> Mesh {
    let n = cells + 1;
    let mut points = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let (x, y) = (x0 + f64::from(i) * cell, y0 + f64::from(j) * cell);
            points.push(DVec3::new(x, y, height(x, y)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let [a, b, c, d] = [j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    mesh(&points, triangles)
}

/// A sphere: an octahedron whose faces are halved `levels` times, every vertex on the sphere but for the lattice.
pub(crate) fn sphere(centre: DVec3, radius: f64, levels: u32) -> Mesh {
    let mut points = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32, points: &mut Vec<DVec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b, &mut points), middle(b, c, &mut points), middle(c, a, &mut points));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let points: Vec<DVec3> = points.iter().map(|p| centre + *p * radius).collect();
    mesh(&points, triangles)
}

/// A closed star-shaped solid with dents: a sphere whose vertices are pulled in and out.
pub(crate) fn dented(centre: DVec3, radius: f64, levels: u32, depth: f64, rng: &mut Rng) -> Mesh {
    let mut m = sphere(DVec3::ZERO, 1.0, levels);
    let sizes: Vec<f64> = m.positions_m.iter().map(|_| radius * (1.0 + depth * rng.signed())).collect();
    for (p, size) in m.positions_m.iter_mut().zip(sizes) {
        *p = quantise_point(centre + DVec3::from(p.map(f64::from)) * size);
    }
    m
}

/// Drops the triangles that the lattice left without area.
pub(crate) fn without_flat_triangles(mut m: Mesh) -> Mesh {
    let keep: Vec<[u32; 3]> = (0..m.triangles.len())
        .filter(|t| {
            let [a, b, c] = m.corners(*t);
            (b - a).cross(c - a) != DVec3::ZERO
        })
        .map(|t| m.triangles[t])
        .collect();
    m.slots = vec![0; keep.len()];
    m.triangles = keep;
    m
}
