//! Breaklines, cut at the borders of tiles.

use super::Layout;
use glam::{DVec2, DVec3};
use satseed_scene::quantise_m;

/// A polyline that becomes edges of the triangulation: a bank, a kerb, a rim.
#[derive(Clone, Debug)]
pub struct Breakline {
    /// Its points, m; consecutive ones more than 0.1 m apart. Heights are the breakline's own.
    pub points_m: Vec<DVec3>,
}

/// A straight part of a breakline within one tile, both ends on the vertex lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) ends_m: [DVec3; 2],
}

fn on_lattice(p: DVec3) -> DVec3 {
    DVec3::new(quantise_m(p.x).into(), quantise_m(p.y).into(), quantise_m(p.z).into())
}

/// The pieces of each tile. A point where a breakline crosses a border is the same, bit for bit, on both sides; it
/// depends on the segment and the border alone.
pub(super) fn cut(layout: &Layout, breaklines: &[Breakline]) -> Vec<Vec<Piece>> {
    let mut pieces = vec![Vec::new(); layout.columns * layout.rows];
    for line in breaklines {
        for pair in line.points_m.windows(2) {
            let ends = [on_lattice(pair[0]), on_lattice(pair[1])];
            let mut stops = vec![(0.0, ends[0]), (1.0, ends[1])];
            for axis in 0..2 {
                crossings(layout, ends, axis, &mut stops);
            }
            stops.sort_by(|a, b| a.0.total_cmp(&b.0));
            for part in stops.windows(2) {
                let piece = Piece { ends_m: [part[0].1, part[1].1] };
                let is_point = piece.ends_m[0].truncate() == piece.ends_m[1].truncate();
                if let Some(tile) = tile_of(layout, piece).filter(|_| !is_point) {
                    pieces[tile].push(piece);
                }
            }
        }
    }
    pieces
}

/// Adds the points where a segment crosses the tile borders across one axis.
fn crossings(layout: &Layout, ends: [DVec3; 2], axis: usize, stops: &mut Vec<(f64, DVec3)>) {
    let origin = layout.origin_m[axis];
    let (a, b) = (ends[0][axis], ends[1][axis]);
    let (low, high) = (a.min(b), a.max(b));
    let first = libm::floor((low - origin) / layout.tile_m) as i64;
    let last = libm::ceil((high - origin) / layout.tile_m) as i64;
    for k in first..=last {
        let at = origin + k as f64 * layout.tile_m;
        if at > low && at < high {
            let t = (at - a) / (b - a);
            let mut p = on_lattice(ends[0] + (ends[1] - ends[0]) * t);
            p[axis] = at;
            stops.push((t, p));
        }
    }
}

/// The tile in which a piece lies; none outside the layout.
fn tile_of(layout: &Layout, piece: Piece) -> Option<usize> {
    let middle = (piece.ends_m[0] + piece.ends_m[1]).truncate() / 2.0;
    let g: DVec2 = ((middle - layout.origin_m) / layout.tile_m).floor();
    let inside = g.x >= 0.0 && g.y >= 0.0 && g.x < layout.columns as f64 && g.y < layout.rows as f64;
    inside.then(|| g.y as usize * layout.columns + g.x as usize)
}
