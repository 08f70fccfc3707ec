//! Overhangs: hollows cut into a height field, and the rock over them.
//!
//! A wall that overhangs has several heights at a place, a height field has one. So the ground becomes the hollow's floor, and
//! the rock over it a slab: a body of its own, whose top is what the ground was and whose underside is the hollow's roof. It
//! reaches beyond the hollow into the rock. A slab is two sheets over one triangulation of the plan, the upper above the lower
//! wherever they do not meet: so it is closed and nowhere crosses itself, whatever the heights are, and whoever looks from
//! outside sees no back of ground or slab.

use super::tin::Layout;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Mesh, Raster, quantise_point};

/// A hollow at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hollow {
    /// Which of the ground's hollows: those of a higher level lie higher.
    pub level: u32,
    /// Height of its floor, m.
    pub floor_m: f64,
    /// Height of its roof, m; below the floor where the hollow is closed.
    pub roof_m: f64,
    /// How far the slab over it reaches around this place, m; negative beyond it, where no hollow need be told below
    /// -[`UNTOLD_M`]. The hollow must be closed where this is less than about two posts.
    pub cover_m: f64,
}

impl Hollow {
    /// How far a slab usually reaches into the rock behind its hollow, m.
    pub const BEARING_M: f64 = 1.3;

    /// A depth, m, where hollows end: all of it at `keep` 1, closed at 0.
    pub fn faded(depth_m: f64, keep: f64) -> f64 {
        depth_m * keep - 1.5 * (1.0 - keep)
    }

    /// How high a hollow of a depth is vaulted at a distance behind its lip, both in m: from 1 at the lip to 0 at the back
    /// wall, and down to -1 within the rock, where it is closed.
    pub fn vault(depth_m: f64, behind_m: f64) -> f64 {
        let t = ((depth_m - behind_m) / (0.7 * depth_m.max(0.9))).clamp(-1.0, 1.0);
        if t > 0.0 { t * (2.0 - t) } else { t }
    }
}

/// A slab at one post.
#[derive(Clone, Copy, Debug)]
struct Post {
    /// The post's number and the hollow's level.
    at: (u32, u32),
    roof_m: f32,
    top_m: f32,
    /// How far within the slab: positive inside.
    inside_m: f32,
}

/// The slabs over a ground's hollows.
pub struct Slabs {
    shape: Raster<()>,
    /// By post, then by level.
    posts: Vec<Post>,
}

/// A hollow farther than this beyond its slab may be left untold, m.
pub const UNTOLD_M: f64 = 1.0;
/// A slab ends where it is thinner, m.
const THINNEST_M: f64 = 0.05;
/// How far a slab's top lies below the ground that it stands for, m, and below that of the next slab: they run into each
/// other, and their edges must not be the same.
const SINK_M: f64 = 0.02;

impl Slabs {
    /// No slab, over posts like those of a ground.
    pub fn none(ground: &Raster<f32>) -> Self {
        let Raster { origin_m, cell_m, width, height, .. } = *ground;
        Self { shape: Raster { origin_m, cell_m, width, height, data: Vec::new() }, posts: Vec::new() }
    }

    /// Cuts `hollows` (by ascending level, at any place) into a ground: the floors are left, and the slabs.
    pub fn cut(ground: &mut Raster<f32>, hollows: impl Fn(DVec2) -> Vec<Hollow> + Sync) -> Self {
        let Self { shape, .. } = Self::none(ground);
        let rows: Vec<Vec<Post>> = ground
            .data
            .par_chunks_mut(shape.width)
            .enumerate()
            .map(|(j, row)| {
                let mut posts = Vec::new();
                for (i, z) in row.iter_mut().enumerate() {
                    let hollows = hollows(shape.position(i, j));
                    slabs_at(&hollows, (j * shape.width + i) as u32, f64::from(*z), &mut posts);
                    let open = hollows.iter().find(|h| h.roof_m > h.floor_m);
                    *z = open.map_or(*z, |h| z.min(h.floor_m as f32));
                }
                posts
            })
            .collect();
        Self { shape, posts: rows.concat() }
    }

    /// The slabs of one tile of a layout as closed bodies, but for where they go on in the next tile. The posts divide the
    /// tile's side, and stand on its corners.
    pub fn tile(&self, layout: &Layout, tile: usize) -> Mesh {
        let mut mesh = Mesh::default();
        let corner_m = layout.corner_m(tile % layout.columns, tile / layout.columns);
        let first = ((corner_m - self.shape.origin_m) / self.shape.cell_m).round();
        let (column, row) = (first.x as i64, first.y as i64);
        let side = libm::round(layout.tile_m / self.shape.cell_m) as i64;
        let mut posts = Vec::new();
        let rows = row.max(0)..(row + side + 1).min(self.shape.height as i64);
        for j in rows {
            let number = |i: i64| (j * self.shape.width as i64 + i) as u32;
            let from = number(column.clamp(0, self.shape.width as i64));
            let end = number((column + side + 1).clamp(0, self.shape.width as i64));
            let [from, end] = [from, end].map(|n| self.posts.partition_point(|p| p.at.0 < n));
            let within = |p: &Post| (j - row) * (side + 1) + i64::from(p.at.0 - number(0)) - column;
            posts.extend(self.posts[from..end].iter().map(|p| (p.at.1, within(p) as usize, *p)));
        }
        posts.sort_by_key(|p| (p.0, p.1));
        for level in posts.chunk_by(|a, b| a.0 == b.0) {
            Slab { side: side as usize + 1, corner_m, post_m: self.shape.cell_m, posts: level }.add_to(&mut mesh);
        }
        mesh
    }
}

/// Adds the slabs over the hollows of a post.
fn slabs_at(hollows: &[Hollow], post: u32, ground_m: f64, posts: &mut Vec<Post>) {
    let (mut top_m, mut sink_m) = (ground_m, SINK_M);
    let before = posts.len();
    for h in hollows.iter().rev() {
        let top = top_m - sink_m;
        posts.push(Post {
            at: (post, h.level),
            roof_m: h.roof_m as f32,
            top_m: top as f32,
            inside_m: (top - h.roof_m - THINNEST_M).min(h.cover_m) as f32,
        });
        if h.roof_m > h.floor_m && h.floor_m < top_m {
            (top_m, sink_m) = (h.floor_m, SINK_M);
        } else if h.cover_m > 0.0 {
            sink_m += SINK_M;
        }
    }
    posts[before..].reverse();
}

/// One slab within a tile.
struct Slab<'a> {
    /// Posts along the tile's side, both corners among them.
    side: usize,
    corner_m: DVec2,
    post_m: f64,
    /// Level, number within the tile, and what it is, by number.
    posts: &'a [(u32, usize, Post)],
}

/// A place of a slab's plan: a post (0), or where the outline crosses the edge from it eastward, northward or to the north-east.
type Place = (usize, u8);

impl Slab<'_> {
    fn post(&self, number: usize) -> Option<&Post> {
        self.posts.binary_search_by_key(&number, |p| p.1).ok().map(|k| &self.posts[k].2)
    }

    fn is_inside(&self, number: usize) -> bool {
        self.post(number).is_some_and(|p| p.inside_m > 0.0)
    }

    /// Both sheets; on the outline they meet.
    fn add_to(&self, mesh: &mut Mesh) {
        let triangles = self.plan();
        let mut places: Vec<Place> = triangles.iter().flatten().copied().collect();
        places.sort_unstable();
        places.dedup();
        let ends: Vec<[DVec3; 2]> = places.iter().map(|p| self.ends(*p)).collect();
        for upper in [false, true] {
            let first = mesh.positions_m.len() as u32;
            mesh.positions_m.extend(ends.iter().map(|e| quantise_point(e[usize::from(upper)])));
            let mut normals = vec![DVec3::ZERO; places.len()];
            for t in &triangles {
                let [a, b, c] = t.map(|p| places.binary_search(&p).expect("every corner is listed") as u32);
                let t = if upper { [a, b, c] } else { [a, c, b] };
                mesh.triangles.push(t.map(|v| first + v));
                let [p, q, r] = mesh.corners(mesh.triangles.len() - 1);
                for v in t {
                    normals[v as usize] += (q - p).cross(r - p);
                }
            }
            mesh.normals.extend(normals.iter().map(|n| n.normalize().as_vec3().to_array()));
        }
    }

    /// Triangles of the plan, counter-clockwise: the halves of the posts' cells, cut at the outline.
    fn plan(&self) -> Vec<[Place; 3]> {
        let n = self.side;
        let mut cells: Vec<usize> = (self.posts.iter().filter(|p| p.2.inside_m > 0.0))
            .flat_map(|p| {
                let (i, j) = (p.1 % n, p.1 / n);
                let (west, south) = (i.saturating_sub(1), j.saturating_sub(1));
                [(i, j), (west, j), (i, south), (west, south)].map(|(i, j)| (i.min(n - 2), j.min(n - 2)))
            })
            .map(|(i, j)| j * n + i)
            .collect();
        cells.sort_unstable();
        cells.dedup();
        let mut triangles = Vec::new();
        for sw in cells {
            let (se, ne, nw) = (sw + 1, sw + n + 1, sw + n);
            // Each corner with the edge that leads from it to the next.
            self.cut([(sw, (sw, 1)), (se, (se, 2)), (ne, (sw, 3))], &mut triangles);
            self.cut([(sw, (sw, 3)), (ne, (nw, 1)), (nw, (sw, 2))], &mut triangles);
        }
        triangles
    }

    /// The part of a triangle within the outline.
    fn cut(&self, corners: [(usize, Place); 3], triangles: &mut Vec<[Place; 3]>) {
        let inside = corners.map(|c| self.is_inside(c.0));
        let mut outline: Vec<Place> = Vec::with_capacity(4);
        for k in 0..3 {
            if inside[k] {
                outline.push((corners[k].0, 0));
            }
            if inside[k] != inside[(k + 1) % 3] {
                outline.push(corners[k].1);
            }
        }
        if outline.len() == 4 {
            // From a post, so that no triangle has its corners on the outline alone.
            let turn = usize::from(outline[0].1 != 0);
            outline.rotate_left(turn);
            triangles.push([outline[0], outline[2], outline[3]]);
        }
        if outline.len() >= 3 {
            triangles.push([outline[0], outline[1], outline[2]]);
        }
    }

    /// The ends of a slab's column at a place: on the roof and on the top.
    fn ends(&self, (number, edge): Place) -> [DVec3; 2] {
        let at = |k: usize| self.corner_m + DVec2::new((k % self.side) as f64, (k / self.side) as f64) * self.post_m;
        let here = self.post(number);
        if edge == 0 {
            let here = here.expect("a post within the slab");
            return [here.roof_m, here.top_m].map(|z| at(number).extend(f64::from(z)));
        }
        let next = number + [1, self.side, self.side + 1][usize::from(edge) - 1];
        let there = self.post(next);
        // Where a post is not told the slab's end lies level.
        let (from, to) = (here.or(there), there.or(here));
        let (from, to) = (from.expect("one end is inside"), to.expect("one end is inside"));
        let inside = [here, there].map(|p| p.map_or(-UNTOLD_M, |p| f64::from(p.inside_m)));
        let part = (inside[0] / (inside[0] - inside[1])).clamp(0.1, 0.9);
        let z = f64::from(from.roof_m) + (f64::from(to.roof_m) - f64::from(from.roof_m)) * part;
        [at(number).lerp(at(next), part).extend(z); 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::terrain::tin::Grain;
    use std::collections::BTreeMap;

    /// A step 10 m high along a wavy line, in two tiles, with two hollows in its face.
    fn step() -> (Raster<f32>, Layout, impl Fn(DVec2) -> Vec<Hollow> + Sync) {
        let behind = |p: DVec2| p.y - libm::sin(p.x * 0.7);
        let mut ground = Raster::filled(DVec2::new(-20.0, -10.0), 0.5, 81, 41, 0.0_f32);
        for k in 0..ground.data.len() {
            let p = ground.position(k % 81, k / 81);
            ground.data[k] = ((behind(p) * 20.0).clamp(0.0, 10.0) + 0.01 * p.x) as f32;
        }
        let grain = Grain { post_m: 0.5, max_error_m: 0.05 };
        let layout =
            Layout { origin_m: DVec2::new(-20.0, -10.0), tile_m: 20.0, columns: 2, rows: 1, grains: vec![grain; 2] };
        let hollows = move |p: DVec2| {
            [(0, 1.0, 5.0), (1, 6.5, 3.0)].map(|(level, floor_m, depth): (u32, f64, f64)| {
                // Closed before the tiles' borders.
                let depth = depth - (p.x / 4.0) * (p.x / 4.0);
                let t = ((depth - behind(p)) / 2.0).clamp(-1.0, 1.0);
                let cover_m = (depth + 1.5 - behind(p)).min(behind(p) + 6.0);
                Hollow { level, floor_m, roof_m: floor_m + 2.0 * t, cover_m }
            })
        };
        (ground, layout, move |p| hollows(p).to_vec())
    }

    #[test]
    fn slabs_are_closed_and_lie_between_hollow_and_top() {
        let (top, layout, hollows) = step();
        let mut floor = top.clone();
        let slabs = Slabs::cut(&mut floor, &hollows);
        let cut = floor.data.iter().zip(&top.data).filter(|(f, t)| **f + 1.0 < **t).count();
        assert!(cut > 200, "{cut} posts overhang");
        let mut edges: BTreeMap<[[u32; 3]; 2], [u32; 2]> = BTreeMap::new();
        let mut volume_m3 = 0.0;
        for tile in 0..2 {
            let mesh = slabs.tile(&layout, tile);
            assert!(mesh.triangles.len() > 200);
            for (t, n) in mesh.triangles.iter().zip(0..) {
                let [a, b, c] = mesh.corners(n);
                assert!((b - a).cross(c - a).length() > 1e-6, "no area at {a}");
                volume_m3 += a.dot(b.cross(c)) / 6.0;
                for k in 0..3 {
                    let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| mesh.positions_m[v as usize].map(f32::to_bits));
                    edges.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
                }
            }
        }
        assert!(edges.values().all(|uses| *uses == [1, 1]));
        assert!(volume_m3 > 100.0, "turned inside out: {volume_m3}");
    }

    #[test]
    fn a_tile_by_itself_is_as_in_the_whole() {
        let (mut top, layout, hollows) = step();
        let whole = Slabs::cut(&mut top.clone(), &hollows).tile(&layout, 0);
        // The western half and a post more.
        let data = top.data.chunks(81).flat_map(|row| row[..42].to_vec()).collect();
        top = Raster { width: 42, data, ..top };
        assert_eq!(Slabs::cut(&mut top, &hollows).tile(&layout, 0), whole);
    }
}
