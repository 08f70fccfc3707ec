//! Closed solids of foliage and wood with shading normals of their own.
//!
//! Everything is closed, so that a vertical line enters and leaves a crown as often: layers can be counted.

use glam::{DQuat, DVec3};
use satseed_scene::{Mesh, Rng, quantise_point};

/// Corners and faces of a ball: an icosahedron, once or not at all divided.
pub(super) struct Ball {
    corners: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
}

impl Ball {
    /// Twenty faces.
    pub(super) fn coarse() -> Self {
        const PHI: f64 = 1.618_033_988_749_895;
        let corners = [(0, 1), (1, 2), (2, 0)].into_iter().flat_map(|(one, phi)| {
            [(1.0, PHI), (-1.0, PHI), (1.0, -PHI), (-1.0, -PHI)].map(|(a, b)| {
                let mut p = DVec3::ZERO;
                (p[one], p[phi]) = (a, b);
                p.normalize()
            })
        });
        let corners: Vec<DVec3> = corners.collect();
        // Neighbours on the unit icosahedron stand 1.05 apart, all others 1.7 or more.
        let near = |a: usize, b: usize| corners[a].distance(corners[b]) < 1.2;
        let mut faces = Vec::with_capacity(20);
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    if near(a, b) && near(b, c) && near(a, c) {
                        let outward = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(corners[a]);
                        faces.push(if outward > 0.0 { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        Self { corners, faces }
    }

    /// Eighty faces.
    pub(super) fn fine() -> Self {
        let Self { mut corners, faces } = Self::coarse();
        let mut middles: Vec<(usize, usize, usize)> = Vec::with_capacity(30);
        let mut fine = Vec::with_capacity(80);
        for [a, b, c] in faces {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                let (p, q) = (p.min(q), p.max(q));
                if let Some(known) = middles.iter().find(|m| (m.0, m.1) == (p, q)) {
                    return known.2;
                }
                corners.push((corners[p] + corners[q]).normalize());
                middles.push((p, q, corners.len() - 1));
                corners.len() - 1
            });
            fine.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self { corners, faces: fine }
    }
}

/// A mesh in the making.
#[derive(Default)]
pub(super) struct Solids {
    mesh: Mesh,
}

impl Solids {
    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }

    fn vertex(&mut self, p: DVec3, normal: DVec3) -> u32 {
        self.mesh.positions_m.push(quantise_point(p));
        self.mesh.normals.push(normal.as_vec3().to_array());
        self.mesh.positions_m.len() as u32 - 1
    }

    fn triangle(&mut self, t: [u32; 3], slot: u16) {
        let [a, b, c] = t.map(|v| DVec3::from_array(self.mesh.positions_m[v as usize].map(f64::from)));
        if (b - a).cross(c - a) != DVec3::ZERO {
            self.mesh.triangles.push(t);
            self.mesh.slots.push(slot);
        }
    }

    /// A ragged ball. Every corner lies at its own distance, a share of the radius between `1 - jag` and `1 + jag`, and
    /// is shaded as a point of both the ball and what `shaded_from` is the middle of.
    #[allow(clippy::too_many_arguments, reason = "a lump has that many properties")]
    pub(super) fn lump(
        &mut self,
        slot: u16,
        ball: &Ball,
        centre: DVec3,
        radii_m: DVec3,
        jag: f64,
        shaded_from: DVec3,
        rng: &mut Rng,
    ) {
        let turn = DQuat::from_axis_angle(direction(rng), rng.range(0.0, core::f64::consts::TAU));
        let outward = (centre - shaded_from).normalize_or(DVec3::Z);
        let first = self.mesh.positions_m.len() as u32;
        for c in &ball.corners {
            let d = turn * *c;
            let p = centre + d * radii_m * (1.0 + jag * rng.signed());
            let n = (d * 0.8 + outward * 0.35 + direction(rng) * 0.42 + DVec3::Z * 0.1).normalize_or(d);
            self.vertex(p, n);
        }
        for f in &ball.faces {
            self.triangle(f.map(|v| first + v as u32), slot);
        }
    }

    /// A solid of four corners, shaded as if it looked along `normal`; whichever way round they are given.
    pub(super) fn wedge(&mut self, slot: u16, corners: [DVec3; 4], normal: DVec3) {
        let [a, b, c, d] = corners;
        let inside_out = (b - a).cross(c - a).dot(d - a) > 0.0;
        let v = corners.map(|p| self.vertex(p, normal));
        for t in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]] {
            let [i, j, k] = t.map(|k: usize| v[k]);
            self.triangle(if inside_out { [i, k, j] } else { [i, j, k] }, slot);
        }
    }

    /// A spray of leaves: a bent diamond that looks along `outward`.
    pub(super) fn spray(&mut self, slot: u16, at: DVec3, outward: DVec3, size_m: f64, rng: &mut Rng) {
        let normal = (outward + direction(rng) * 0.7).normalize_or(DVec3::Z);
        let (u, v) = normal.any_orthonormal_pair();
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let (u, v) =
            ((u * c + v * s) * (size_m * rng.range(0.8, 1.3)), (v * c - u * s) * (size_m * rng.range(0.45, 0.8)));
        let bend = normal * (-0.35 * size_m);
        self.wedge(slot, [at + u + bend, at + v, at - u + bend, at - v], (normal + outward).normalize_or(normal));
    }

    /// A closed tube of `sides` corners along a straight line.
    pub(super) fn limb(&mut self, slot: u16, from: DVec3, to: DVec3, radii_m: [f64; 2], sides: u32) {
        let axis = (to - from).normalize_or(DVec3::Z);
        let (t, b) = axis.any_orthonormal_pair();
        let first = self.mesh.positions_m.len() as u32;
        for (end, r) in [(from, radii_m[0]), (to, radii_m[1])] {
            for k in 0..sides {
                let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / f64::from(sides));
                let out = t * c + b * s;
                self.vertex(end + out * r, out);
            }
        }
        for k in 0..sides {
            let n = (k + 1) % sides;
            self.triangle([first + k, first + n, first + sides + n], slot);
            self.triangle([first + k, first + sides + n, first + sides + k], slot);
        }
        for k in 1..sides - 1 {
            self.triangle([first, first + k + 1, first + k], slot);
            self.triangle([first + sides, first + sides + k, first + sides + k + 1], slot);
        }
    }
}

/// Uniform on the sphere (Archimedes: height and turn are independent).
pub(super) fn direction(rng: &mut Rng) -> DVec3 {
    let z = rng.signed();
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let r = f64::sqrt((1.0 - z * z).max(0.0));
    DVec3::new(r * c, r * s, z)
}

/// A level direction.
pub(super) fn level(turn_rad: f64) -> DVec3 {
    let (s, c) = libm::sincos(turn_rad);
    DVec3::new(c, s, 0.0)
}
