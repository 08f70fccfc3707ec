//! Overhangs: a ground of one height a place, cut finer where it is steep, and moved sideways.
//!
//! Every point moves at its own height. At each height the plane is squeezed and stretched, and not folded as long as the
//! shift changes by less than the way along the plane: so a surface that is closed and nowhere crosses itself stays so. How
//! fast the shift changes with height is free: where a wall recedes downward, what lies above hangs over.

use super::sampling::gradient;
use glam::{DMat3, DVec2, DVec3};
use satseed_scene::{Mesh, Raster, quantise_m, quantise_point};
use std::collections::BTreeMap;

/// Sideways shifts over space.
pub trait Undercut: Sync {
    /// How far the ground at a point moves, m. A pure function, whose slope over the plane stays below 1.
    fn shift_m(&self, p_m: DVec3) -> DVec2;

    /// Whether the ground around a point stays where it is, so that something of a radius can stand there.
    fn spares(&self, p_m: DVec3, radius_m: f64) -> bool {
        let around = [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];
        let stays = |side: DVec3, z: f64| self.shift_m(p_m + (side + DVec3::Z * z) * radius_m).length() < 0.02;
        around.iter().all(|side| [-0.7, 0.0, 0.7].iter().all(|z| stays(*side, *z)))
    }
}

/// Directions into the walls of a ground, over the plane.
pub struct Inward(Raster<[f32; 2]>);

impl Inward {
    /// Up a distance that grows into the walls, about 1 long; `weight` says for each post (column, row) how much of it counts, 0
    /// where there is no wall.
    pub fn new(distance_m: &Raster<f32>, weight: impl Fn(usize, usize) -> f64) -> Self {
        let Raster { origin_m, cell_m, width, height, .. } = *distance_m;
        let direction = |post: usize| {
            let (i, j) = (post % width, post / width);
            let up = gradient(distance_m, i, j);
            (up / up.length().max(1.0) * weight(i, j)).as_vec2().to_array()
        };
        Self(Raster { origin_m, cell_m, width, height, data: (0..width * height).map(direction).collect() })
    }

    /// At a place; zero beyond the raster.
    pub fn at(&self, p: DVec2) -> DVec2 {
        let g = self.0.grid_from_world(p);
        let last = DVec2::new(self.0.width as f64, self.0.height as f64) - 1.0;
        if g.cmplt(DVec2::ZERO).any() || g.cmpge(last).any() {
            return DVec2::ZERO;
        }
        let (i, j) = (g.x as usize, g.y as usize);
        let posts = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| self.0.get(i + di, j + dj));
        if posts == [[0.0; 2]; 4] {
            return DVec2::ZERO;
        }
        let [a, b, c, d] = posts.map(|v| DVec2::new(v[0].into(), v[1].into()));
        let (u, v) = (g.x - i as f64, g.y - j as f64);
        (a.lerp(b, u)).lerp(c.lerp(d, u), v)
    }
}

/// How far an edge may stray from where its points move to, m.
const STRAY_M: f64 = 0.15;
/// Halves of edges are no shorter, m.
const SHORTEST_M: f64 = 0.5;
/// Distance of the levels on which steep edges are cut, m.
const LEVEL_M: f64 = 0.5;
/// Distance of the places of an edge that are asked how they move, m.
const PROBE_M: f64 = 0.5;
/// So often is a triangle cut at most. The parts of an edge are asked as often from both its sides; edges across thin triangles might be
/// cut for ever.
const DEEPEST: u32 = 10;
/// Step for slopes of the shift, m.
const STEP_M: f64 = 0.1;

/// Cuts and moves one tile of a ground. Tiles that share a border stay joined: what happens to an edge and to a vertex
/// follows from their own places alone. Normals follow the surface; slots stay.
pub fn carve(mesh: &mut Mesh, undercut: &impl Undercut) {
    cut(mesh, undercut);
    for (position, normal) in mesh.positions_m.iter_mut().zip(&mut mesh.normals) {
        let p = point(*position);
        let shift = undercut.shift_m(p);
        if shift == DVec2::ZERO {
            continue;
        }
        let slope = |axis: DVec3| {
            let d = undercut.shift_m(p + axis * STEP_M) - undercut.shift_m(p - axis * STEP_M);
            axis + (d / (2.0 * STEP_M)).extend(0.0)
        };
        let after = DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        if after.determinant() > 0.05 {
            // Normals go with the cofactors: they stay square to what was along the surface.
            let n = DVec3::from_array(normal.map(f64::from));
            *normal = (after.inverse().transpose() * n).normalize().as_vec3().to_array();
        }
        (position[0], position[1]) = (quantise_m(p.x + shift.x), quantise_m(p.y + shift.y));
    }
    separate(mesh);
}

/// A step of the lattice, m.
const LATTICE_M: f32 = 1.0 / 1024.0;

/// On the lattice, corners of slivers may have become one, or come to lie on a line: moves one of them on by a step or a few. Not those
/// on the tile's border, which its neighbour has too.
fn separate(mesh: &mut Mesh) {
    let mut border: Option<Vec<bool>> = None;
    for round in 0..24 {
        let bits = |v: u32| mesh.positions_m[v as usize].map(f32::to_bits);
        let mut order: Vec<u32> = (0..mesh.positions_m.len() as u32).collect();
        order.sort_unstable_by_key(|v| (bits(*v), *v));
        let mut bad: Vec<[u32; 3]> =
            order.windows(2).filter(|w| bits(w[0]) == bits(w[1])).map(|w| [w[1], w[0], w[0]]).collect();
        let flat = |t: &usize| {
            let [a, b, c] = mesh.corners(*t);
            (b - a).cross(c - a) == DVec3::ZERO
        };
        bad.extend((0..mesh.triangles.len()).filter(flat).map(|t| mesh.triangles[t]));
        if bad.is_empty() {
            return;
        }
        let border = border.get_or_insert_with(|| on_border(mesh));
        let mut to_move: Vec<u32> =
            bad.iter().filter_map(|t| t.iter().copied().find(|v| !border[*v as usize])).collect();
        to_move.sort_unstable();
        to_move.dedup();
        for v in to_move {
            // Another way each round, and farther.
            let (axis, steps) = ((v + round) as usize % 3, 1 + round / 6);
            let sign = if round / 3 % 2 == 0 { 1.0 } else { -1.0 };
            mesh.positions_m[v as usize][axis] += sign * steps as f32 * LATTICE_M;
        }
    }
}

/// Which vertices belong to an edge of one triangle alone.
fn on_border(mesh: &Mesh) -> Vec<bool> {
    let sides = mesh.triangles.iter().flat_map(|t| [0, 1, 2].map(|k| (t[k], t[(k + 1) % 3])));
    let mut edges: Vec<(u32, u32)> = sides.map(|(a, b)| (a.min(b), a.max(b))).collect();
    edges.sort_unstable();
    let mut border = vec![false; mesh.positions_m.len()];
    for same in edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
        (border[same[0].0 as usize], border[same[0].1 as usize]) = (true, true);
    }
    border
}

fn point(position: [f32; 3]) -> DVec3 {
    DVec3::from_array(position.map(f64::from))
}

/// Halves every edge that strays, again and again: parts are shaped like the whole. A triangle without one is finished.
fn cut(mesh: &mut Mesh, undercut: &impl Undercut) {
    let triangles = core::mem::take(&mut mesh.triangles).into_iter().zip(core::mem::take(&mut mesh.slots));
    let mut open: Vec<([u32; 3], u16, u32)> = triangles.map(|(t, slot)| (t, slot, 0)).rev().collect();
    // The middles of edges that are halved; `None` for those that are whole.
    let mut cuts: BTreeMap<(u32, u32), Option<u32>> = BTreeMap::new();
    while let Some((t, slot, depth)) = open.pop() {
        let at = [0, 1, 2].map(|k| {
            let (a, b) = (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
            let [p, q] = [a, b].map(|v| point(mesh.positions_m[v as usize]));
            let cut = || {
                let at = cut_at(p, q, undercut)?;
                mesh.positions_m.push(quantise_point(at));
                let [m, n] = [a, b].map(|v| point(mesh.normals[v as usize]));
                let part = at.distance(p) / q.distance(p);
                mesh.normals.push(m.lerp(n, part).try_normalize().unwrap_or(m).as_vec3().to_array());
                Some(mesh.positions_m.len() as u32 - 1)
            };
            if depth < DEEPEST { *cuts.entry((a, b)).or_insert_with(cut) } else { None }
        });
        if at == [None; 3] {
            mesh.triangles.push(t);
            mesh.slots.push(slot);
        } else {
            parts(t, at, |part| open.push((part, slot, depth + 1)));
        }
    }
}

/// The parts of a triangle some of whose edges are cut; edge k leads from corner k to the next.
fn parts(t: [u32; 3], cuts: [Option<u32>; 3], mut part: impl FnMut([u32; 3])) {
    // Turned until the first edge is cut and the last is not, if there are both.
    let turn = (0..3).find(|k| cuts[*k].is_some() && cuts[(k + 2) % 3].is_none()).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| t[(turn + k) % 3]);
    match [0, 1, 2].map(|k| cuts[(turn + k) % 3]) {
        [None, ..] => part(t),
        [Some(m), None, _] => {
            part([a, m, c]);
            part([m, b, c]);
        }
        [Some(m), Some(n), None] => {
            part([m, b, n]);
            part([a, m, n]);
            part([a, n, c]);
        }
        [Some(m), Some(n), Some(o)] => {
            part([a, m, o]);
            part([m, b, n]);
            part([o, n, c]);
            part([m, n, o]);
        }
    }
}

/// Where an edge is to be cut, if it is; the same for both directions. Steep edges are cut on levels that all of them share, so that
/// what lies beside one another moves alike; flat ones in the middle.
fn cut_at(a: DVec3, b: DVec3, undercut: &impl Undercut) -> Option<DVec3> {
    // From the same end whoever asks.
    let (a, b) = if (a.z, a.x, a.y) <= (b.z, b.x, b.y) { (a, b) } else { (b, a) };
    let length = a.distance(b);
    let [from, to] = [a, b].map(|end| undercut.shift_m(end));
    let probes = libm::ceil(length / PROBE_M).max(1.0) as u32;
    let parts = (1..probes).map(|k| f64::from(k) / f64::from(probes));
    let mut shifts = parts.map(|part| (undercut.shift_m(a.lerp(b, part)), part));
    // The level that is a multiple of the highest power of two.
    let (low, high) = ((libm::floor(a.z / LEVEL_M) as i64 + 1), (libm::ceil(b.z / LEVEL_M) as i64 - 1));
    if low <= high {
        if from == DVec2::ZERO && to == DVec2::ZERO && shifts.all(|s| s.0 == DVec2::ZERO) {
            return None;
        }
        let coarsest = (0..40).rev().map(|k| 1_i64 << k).find(|step| high.div_euclid(*step) * step >= low)?;
        let z = (high.div_euclid(coarsest) * coarsest) as f64 * LEVEL_M;
        return Some(a.lerp(b, (z - a.z) / (b.z - a.z)).with_z(z));
    }
    let strays = length >= 2.0 * SHORTEST_M && shifts.any(|(s, part)| s.distance(from.lerp(to, part)) > STRAY_M);
    strays.then(|| (a + b) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::terrain::sampling::smoothstep;

    /// Hollows the foot of a wall along x = 0.
    struct Notch;

    impl Undercut for Notch {
        fn shift_m(&self, p: DVec3) -> DVec2 {
            let beside = (1.0 - (p.y / 8.0).abs()).max(0.0);
            DVec2::new(2.0 * beside * smoothstep(0.2, 0.6, p.z) * smoothstep(3.0, 2.6, p.z), 0.0)
        }
    }

    /// A wall 10 m high that leans 0.5 m, in columns about as wide as a height field's.
    fn wall(low_y: f32, high_y: f32) -> Mesh {
        let columns = ((high_y - low_y) * 2.0) as u32;
        let corner = |k: u32| [0.5 * (k % 2) as f32, low_y + 0.5 * (k / 2) as f32, 10.0 * (k % 2) as f32];
        let positions_m: Vec<_> = (0..2 * columns + 2).map(corner).collect();
        let normal = DVec3::new(-10.0, 0.0, 0.5).normalize().as_vec3().to_array();
        let quad = |k: u32| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]];
        Mesh {
            normals: vec![normal; positions_m.len()],
            positions_m,
            triangles: (0..columns).flat_map(quad).collect(),
            slots: (0..2 * columns).map(|k| 7 + k as u16 % 2).collect(),
            uvs_m: Vec::new(),
        }
    }

    fn area_m2(mesh: &Mesh) -> f64 {
        (0..mesh.triangles.len()).map(|t| mesh.corners(t)).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    }

    #[test]
    fn a_wall_recedes_under_what_stays_above() {
        let mut mesh = wall(-16.0, 16.0);
        carve(&mut mesh, &Notch);
        mesh.validate().unwrap();
        assert!(mesh.positions_m.iter().any(|p| p[2] > 2.0 && p[2] < 3.0 && p[0] > 1.8), "no hollow");
        let ledge = |p: &&[f32; 3]| p[2] >= 3.0;
        assert!(mesh.positions_m.iter().filter(ledge).all(|p| p[0] <= 0.5), "what lies above has moved");
        assert!(area_m2(&mesh) > area_m2(&wall(-16.0, 16.0)) + 20.0, "{}", area_m2(&mesh));
        assert!(mesh.slots.contains(&7) && mesh.slots.contains(&8));
    }

    /// Two tiles cut their common border alike, each by itself, and a wall where nothing moves is left as it is.
    #[test]
    fn tiles_stay_joined() {
        let [mut west, mut east] = [wall(-16.0, 0.0), wall(0.0, 16.0)];
        carve(&mut west, &Notch);
        carve(&mut east, &Notch);
        let border = |mesh: &Mesh| {
            let mut at: Vec<[u32; 3]> =
                mesh.positions_m.iter().filter(|p| p[1] == 0.0).map(|p| p.map(f32::to_bits)).collect();
            at.sort_unstable();
            at
        };
        assert!(border(&west).len() > 5 && border(&west) == border(&east), "{:?}", border(&west));
        let mut still = wall(20.0, 30.0);
        carve(&mut still, &Notch);
        assert_eq!(still, wall(20.0, 30.0));
    }

    #[test]
    fn normals_follow() {
        struct Lean;
        impl Undercut for Lean {
            fn shift_m(&self, p: DVec3) -> DVec2 {
                DVec2::new(-0.1 - 0.3 * p.z, 0.0)
            }
        }
        let mut mesh = wall(0.0, 4.0);
        carve(&mut mesh, &Lean);
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let square = (b - a).cross(c - a).normalize();
            for v in mesh.triangles[t] {
                assert!(point(mesh.normals[v as usize]).dot(square) > 0.9999, "{:?}", mesh.normals[v as usize]);
            }
        }
    }
}
