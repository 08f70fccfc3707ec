//! Error-bounded triangulation of a ground in tiles that fit without cracks.
//!
//! Greedy insertion (Garland and Heckbert 1995) on a constrained Delaunay triangulation: the post that lies farthest
//! from the triangles becomes a vertex until every post lies within the bound. Tiles share their borders' vertices
//! because a border is simplified by itself, from its own posts and the breaklines that cross it, and from nothing
//! within either tile. So tiles are built in parallel, and one tile can be built alone, with the same bytes.

mod border;
mod breakline;
mod refine;

pub use breakline::Breakline;

use border::{Border, Side};
use glam::DVec2;
use rayon::prelude::*;

/// A ground with a height everywhere.
pub trait Ground: Sync {
    /// Height at a place, m. It must be a pure function.
    fn height_m(&self, p_m: DVec2) -> f64;
}

impl<F: Fn(DVec2) -> f64 + Sync> Ground for F {
    fn height_m(&self, p_m: DVec2) -> f64 {
        self(p_m)
    }
}

/// How finely a tile follows its ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Distance of posts, m: the tile's side divided by a whole number.
    pub post_m: f64,
    /// Greatest vertical distance of a post from the triangles, m; at least two lattice steps (1/512 m).
    pub max_error_m: f64,
}

impl Grain {
    fn finer(self, other: Self) -> Self {
        Self { post_m: self.post_m.min(other.post_m), max_error_m: self.max_error_m.min(other.max_error_m) }
    }
}

/// A grid of square tiles with the grain of each.
#[derive(Clone, Debug)]
pub struct Layout {
    /// South-western corner, m, on the vertex lattice.
    pub origin_m: DVec2,
    /// Side of a tile, m, on the vertex lattice.
    pub tile_m: f64,
    /// Tiles eastward.
    pub columns: usize,
    /// Tiles northward.
    pub rows: usize,
    /// Grain of each tile, row by row from the south.
    pub grains: Vec<Grain>,
}

impl Layout {
    /// South-western corner of a tile, m.
    pub fn corner_m(&self, column: usize, row: usize) -> DVec2 {
        self.origin_m + DVec2::new(column as f64, row as f64) * self.tile_m
    }

    /// The finer grain of the tiles on both sides of a border; a border of the layout has one side only.
    fn border_grain(&self, side: Side, column: usize, row: usize) -> Grain {
        let own = self.grains[row * self.columns + column];
        let other = match side {
            Side::South => row.checked_sub(1).map(|r| (column, r)),
            Side::North => Some((column, row + 1)).filter(|t| t.1 < self.rows),
            Side::West => column.checked_sub(1).map(|c| (c, row)),
            Side::East => Some((column + 1, row)).filter(|t| t.0 < self.columns),
        };
        other.map_or(own, |(c, r)| own.finer(self.grains[r * self.columns + c]))
    }
}

/// The triangles of one tile, in world coordinates on the vertex lattice, counter-clockwise from above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileMesh {
    /// Vertices, m.
    pub positions_m: Vec<[f32; 3]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
}

/// Triangulates every tile, in the layout's order, tiles in parallel.
///
/// Breaklines become edges. They must not cross one another; they may touch in common points.
pub fn triangulate(layout: &Layout, ground: &impl Ground, breaklines: &[Breakline]) -> Vec<TileMesh> {
    let pieces = breakline::cut(layout, breaklines);
    (0..layout.columns * layout.rows)
        .into_par_iter()
        .map(|tile| {
            let (column, row) = (tile % layout.columns, tile / layout.columns);
            let borders = Side::ALL.map(|side| {
                let grain = layout.border_grain(side, column, row);
                Border::new(layout, side, column, row, grain, ground, &pieces)
            });
            refine::tile(layout, column, row, ground, &borders, &pieces[tile])
        })
        .collect()
}

#[cfg(test)]
mod tests;
