//! One tile: borders, breaklines, then the worst post again and again.

use super::border::Border;
use super::breakline::Piece;
use super::{Ground, Layout, TileMesh};
use glam::{DVec2, DVec3};
use satseed_scene::quantise_m;
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, PositionInTriangulation, Triangulation};
use std::collections::BinaryHeap;

/// In posts: those on an edge are looked at from both sides, so that rounding loses none.
const SLACK: f64 = 1e-7;

#[derive(Clone, Copy)]
struct Vertex {
    at_m: DVec3,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        Point2::new(self.at_m.x, self.at_m.y)
    }
}

/// A post waiting to become a vertex: by its error, then by number, so that no other order shows.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Bits of the (positive) error: they order as it does.
    error: u32,
    post: u32,
    face: u32,
    version: u32,
    /// A corner of the face: where the search for the post begins.
    near: u32,
}

struct Tile {
    corner_m: DVec2,
    post_m: f64,
    side: usize,
    /// Heights of the posts, `side + 1` squared, row by row from the south.
    heights_m: Vec<f32>,
    tolerance_m: f64,
    cdt: ConstrainedDelaunayTriangulation<Vertex>,
    heap: BinaryHeap<Candidate>,
    /// How often each face has changed: candidates of an older version are void.
    versions: Vec<u32>,
    taken: Vec<bool>,
}

pub(super) fn tile(
    layout: &Layout,
    column: usize,
    row: usize,
    ground: &impl Ground,
    borders: &[Border; 4],
    pieces: &[Piece],
) -> TileMesh {
    let grain = layout.grains[row * layout.columns + column];
    let side = libm::round(layout.tile_m / grain.post_m) as usize;
    let corner_m = layout.corner_m(column, row);
    let heights_m = (0..=side)
        .flat_map(|j| (0..=side).map(move |i| corner_m + DVec2::new(i as f64, j as f64) * grain.post_m))
        .map(|p| ground.height_m(p) as f32)
        .collect();
    let mut tile = Tile {
        corner_m,
        post_m: grain.post_m,
        side,
        heights_m,
        tolerance_m: grain.max_error_m - 1.0 / 1024.0,
        cdt: ConstrainedDelaunayTriangulation::new(),
        heap: BinaryHeap::new(),
        versions: Vec::new(),
        taken: vec![false; (side + 1) * (side + 1)],
    };
    for border in borders {
        for v in &border.vertices_m {
            tile.insert(*v, None);
        }
    }
    for piece in pieces {
        tile.constrain(*piece);
    }
    tile.refine();
    tile.mesh()
}

impl Tile {
    /// Inserts a vertex unless one stands there already; its height then stays.
    fn insert(&mut self, at_m: DVec3, hint: Option<FixedVertexHandle>) -> FixedVertexHandle {
        let position = Point2::new(at_m.x, at_m.y);
        // Posts come with a hint and are never taken twice; borders and breaklines share points.
        if let (None, PositionInTriangulation::OnVertex(v)) = (hint, self.cdt.locate(position)) {
            return v;
        }
        let inserted = match hint {
            Some(hint) => self.cdt.insert_with_hint(Vertex { at_m }, hint),
            None => self.cdt.insert(Vertex { at_m }),
        };
        let g = (at_m.truncate() - self.corner_m) / self.post_m;
        if g == g.floor() {
            self.taken[g.y as usize * (self.side + 1) + g.x as usize] = true;
        }
        inserted.expect("coordinates on the lattice are finite and neither tiny nor huge")
    }

    fn constrain(&mut self, piece: Piece) {
        let [a, b] = piece.ends_m.map(|p| self.insert(p, None));
        // A breakline that crosses another against the rules is left out, rather than moved off the lattice.
        if self.cdt.can_add_constraint(a, b) {
            self.cdt.add_constraint(a, b);
        }
    }

    fn refine(&mut self) {
        let faces: Vec<_> = self.cdt.inner_faces().map(|f| f.fix()).collect();
        for face in faces {
            self.scan(face);
        }
        while let Some(worst) = self.heap.pop() {
            if self.versions[worst.face as usize] != worst.version {
                continue;
            }
            let (i, j) = (worst.post as usize % (self.side + 1), worst.post as usize / (self.side + 1));
            let p = self.corner_m + DVec2::new(i as f64, j as f64) * self.post_m;
            let z = f64::from(quantise_m(f64::from(self.heights_m[worst.post as usize])));
            let hint = FixedVertexHandle::from_index(worst.near as usize);
            let vertex = self.insert(p.extend(z), Some(hint));
            // A Delaunay insertion changes the triangles around the new vertex and no others.
            let star: Vec<_> =
                self.cdt.vertex(vertex).out_edges().filter_map(|e| e.face().as_inner().map(|f| f.fix())).collect();
            for face in star {
                self.scan(face);
            }
        }
    }

    /// Finds the post of a face that lies farthest from it and puts it on the heap if that is too far.
    fn scan(&mut self, face: FixedFaceHandle<InnerTag>) {
        let index = face.index();
        if self.versions.len() <= index {
            self.versions.resize(index + 64, 0);
        }
        self.versions[index] += 1;
        let vertices = self.cdt.face(face).vertices();
        let near = vertices[0].fix().index() as u32;
        let [a, b, c] = vertices.map(|v| v.data().at_m);
        let (ab, ac) = (b - a, c - a);
        let area = ab.x * ac.y - ab.y * ac.x;
        let slope_x = (ab.z * ac.y - ac.z * ab.y) / area;
        let slope_y = (ac.z * ab.x - ab.z * ac.x) / area;
        let last = self.side - 1;
        let local = |p: DVec3| (p.truncate() - self.corner_m) / self.post_m;
        let corners = [local(a), local(b), local(c)];
        let low = corners.iter().map(|p| p.y).fold(f64::MAX, f64::min);
        let high = corners.iter().map(|p| p.y).fold(f64::MIN, f64::max);
        let first_row = libm::ceil(low - SLACK).max(1.0) as usize;
        let last_row = libm::floor(high + SLACK).min(last as f64) as usize;
        let (mut most, mut post) = (self.tolerance_m, None);
        for j in first_row..=last_row {
            let y = (j as f64).clamp(low, high);
            let (mut from, mut to) = (f64::MAX, f64::MIN);
            for k in 0..3 {
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                if y < p.y.min(q.y) || y > p.y.max(q.y) {
                    continue;
                }
                let x = if p.y == q.y { p.x } else { p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y)) };
                from = from.min(x);
                to = to.max(x);
                if p.y == q.y {
                    from = from.min(q.x);
                    to = to.max(q.x);
                }
            }
            let first = libm::ceil(from - SLACK).max(1.0) as usize;
            let end = libm::floor(to + SLACK).min(last as f64);
            if end < first as f64 {
                continue;
            }
            let start = self.corner_m + DVec2::new(first as f64, j as f64) * self.post_m;
            let mut plane = a.z + slope_x * (start.x - a.x) + slope_y * (start.y - a.y);
            let step = slope_x * self.post_m;
            let row = j * (self.side + 1);
            for p in row + first..=row + end as usize {
                let error = (f64::from(self.heights_m[p]) - plane).abs();
                if error > most && !self.taken[p] {
                    most = error;
                    post = Some(p);
                }
                plane += step;
            }
        }
        if let Some(post) = post {
            self.heap.push(Candidate {
                error: (most as f32).to_bits(),
                post: post as u32,
                face: index as u32,
                version: self.versions[index],
                near,
            });
        }
    }

    fn mesh(&self) -> TileMesh {
        TileMesh {
            positions_m: self.cdt.vertices().map(|v| v.data().at_m.as_vec3().to_array()).collect(),
            triangles: self.cdt.inner_faces().map(|f| f.vertices().map(|v| v.fix().index() as u32)).collect(),
        }
    }
}
