//! Search for cracks: open edges, T-junctions, edges run through twice the same way.
//!
//! Positions are world positions, compared bit by bit, so that the seams of tiles and instances count as what a ray
//! meets there.

use glam::DVec3;
use satseed_scene::Scene;

type Key = [u64; 3];

/// An edge that does not have exactly one triangle on each side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenEdge {
    pub(crate) from: DVec3,
    pub(crate) to: DVec3,
    /// Triangles that run through it from `from` to `to`, and the other way.
    pub(crate) uses: [u32; 2],
}

impl OpenEdge {
    /// Horizontal distance of the edge's middle from the pivot.
    pub(crate) fn radius_m(&self) -> f64 {
        ((self.from + self.to) / 2.0).truncate().length()
    }
}

/// World triangles of some instances.
pub(crate) fn triangles(scene: &Scene, wanted: impl Fn(u32) -> bool) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        if wanted(i as u32) {
            let count = scene.meshes[instance.mesh as usize].triangles.len();
            out.extend((0..count).map(|t| scene.corners(i as u32, t as u32)));
        }
    }
    out
}

/// Bits of a position; -0 and 0 are one place.
fn key(p: DVec3) -> Key {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// All edges that are not shared by exactly two triangles of opposite direction.
pub(crate) fn open_edges(triangles: &[[DVec3; 3]]) -> Vec<OpenEdge> {
    let mut edges: Vec<(Key, Key, bool)> = Vec::with_capacity(triangles.len() * 3);
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            edges.push(if a <= b { (a, b, false) } else { (b, a, true) });
        }
    }
    edges.sort_unstable();
    edges
        .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
        .filter_map(|same| {
            let backward = same.iter().filter(|e| e.2).count() as u32;
            let uses = [same.len() as u32 - backward, backward];
            let point = |k: Key| DVec3::from(k.map(f64::from_bits));
            (uses != [1, 1]).then(|| OpenEdge { from: point(same[0].0), to: point(same[0].1), uses })
        })
        .collect()
}

/// Vertices of open edges that lie inside another open edge: (edge, vertex).
pub(crate) fn t_junctions(open: &[OpenEdge], within_m: f64) -> Vec<(OpenEdge, DVec3)> {
    let mut ends: Vec<DVec3> = open.iter().flat_map(|e| [e.from, e.to]).collect();
    ends.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    ends.dedup();
    let mut found = Vec::new();
    for e in open {
        let way = e.to - e.from;
        let length = way.length();
        let (low, high) = (e.from.x.min(e.to.x) - within_m, e.from.x.max(e.to.x) + within_m);
        let first = ends.partition_point(|p| p.x < low);
        for p in ends[first..].iter().take_while(|p| p.x <= high) {
            let along = (*p - e.from).dot(way) / length;
            let off = (*p - e.from - way * (along / length)).length();
            if *p != e.from && *p != e.to && along > 0.0 && along < length && off <= within_m {
                found.push((*e, *p));
            }
        }
    }
    found
}
