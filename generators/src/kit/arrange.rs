//! Outlines made to meet only in corners: an arrangement of polygons on the lattice of vertices.
//!
//! A ground's plan may then lay drives over walks over lawns without asking where their borders cross. Crossings become
//! corners of both outlines, rounded to the lattice; rounding can make new crossings a lattice step away, so this is
//! repeated until none is left (iterated snap rounding; Guibas and Marimont 1998 give the idea).

use glam::DVec2;
use satseed_scene::{QUANTUM_M, quantise_m};

type Point = [i64; 2];

/// Side of a look-up cell, lattice steps: 8 m.
const CELL: i64 = 8 << 10;

/// Rounds at most. Three or four are usual; two edges that part at a sharp angle may be closed a lattice step at a time, as
/// by a zip, which takes dozens. What crosses after them stays as it is.
const ROUNDS: usize = 96;

/// The outlines with a corner wherever two of them, or one and itself, cross. Corners lie on the lattice of
/// [`QUANTUM_M`]; every corner that was given is kept, moved to the lattice.
pub fn arranged(outlines: &[Vec<DVec2>]) -> Vec<Vec<DVec2>> {
    let on_lattice = |x: f64| (f64::from(quantise_m(x)) / QUANTUM_M) as i64;
    let mut rings: Vec<Vec<Point>> = outlines
        .iter()
        .map(|o| {
            let mut ring: Vec<Point> = o.iter().map(|p| [on_lattice(p.x), on_lattice(p.y)]).collect();
            tidy(&mut ring);
            ring
        })
        .collect();
    for _ in 0..ROUNDS {
        let splits = crossings(&rings);
        if splits.is_empty() {
            break;
        }
        insert(&mut rings, &splits);
    }
    rings
        .into_iter()
        .map(|r| r.into_iter().map(|[x, y]| DVec2::new(x as f64, y as f64) * QUANTUM_M).collect())
        .collect()
}

/// Drops repeated corners.
fn tidy(ring: &mut Vec<Point>) {
    ring.dedup();
    while ring.len() > 1 && ring[0] == ring[ring.len() - 1] {
        ring.pop();
    }
}

/// An edge: its ring, its number in it, and its ends.
#[derive(Clone, Copy)]
struct Edge {
    ring: u32,
    number: u32,
    from: Point,
    to: Point,
}

/// A corner to come: ring, edge, distance from the edge's begin (a scalar product), place.
type Split = (u32, u32, i64, Point);

fn crossings(rings: &[Vec<Point>]) -> Vec<Split> {
    let mut edges = Vec::new();
    let mut cells: Vec<(Point, u32)> = Vec::new();
    for (r, ring) in rings.iter().enumerate() {
        for k in 0..ring.len() {
            let (from, to) = (ring[k], ring[(k + 1) % ring.len()]);
            let index = edges.len() as u32;
            edges.push(Edge { ring: r as u32, number: k as u32, from, to });
            let cell = |x: i64| x.div_euclid(CELL);
            let span = |axis: usize| cell(from[axis].min(to[axis]))..=cell(from[axis].max(to[axis]));
            for j in span(1) {
                cells.extend(span(0).map(|i| ([i, j], index)));
            }
        }
    }
    cells.sort_unstable();
    let mut splits = Vec::new();
    for group in cells.chunk_by(|a, b| a.0 == b.0) {
        for (n, (_, a)) in group.iter().enumerate() {
            for (_, b) in &group[n + 1..] {
                meet(&edges[*a as usize], &edges[*b as usize], &mut splits);
            }
        }
    }
    splits.sort_unstable();
    splits.dedup();
    splits
}

fn cross(o: Point, a: Point, b: Point) -> i64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

fn meet(a: &Edge, b: &Edge, splits: &mut Vec<Split>) {
    for axis in 0..2 {
        if a.from[axis].max(a.to[axis]) < b.from[axis].min(b.to[axis])
            || b.from[axis].max(b.to[axis]) < a.from[axis].min(a.to[axis])
        {
            return;
        }
    }
    let (s0, s1) = (cross(b.from, b.to, a.from), cross(b.from, b.to, a.to));
    let (t0, t1) = (cross(a.from, a.to, b.from), cross(a.from, a.to, b.to));
    let opposite = |u: i64, v: i64| (u > 0 && v < 0) || (u < 0 && v > 0);
    if !opposite(s0, s1) || !opposite(t0, t1) {
        return;
    }
    let share = s0 as f64 / (s0 - s1) as f64;
    let at = |axis: usize| libm::floor(a.from[axis] as f64 + (a.to[axis] - a.from[axis]) as f64 * share + 0.5) as i64;
    let p = [at(0), at(1)];
    for e in [a, b] {
        if p != e.from && p != e.to {
            let along = (p[0] - e.from[0]) * (e.to[0] - e.from[0]) + (p[1] - e.from[1]) * (e.to[1] - e.from[1]);
            splits.push((e.ring, e.number, along, p));
        }
    }
}

fn insert(rings: &mut [Vec<Point>], splits: &[Split]) {
    for group in splits.chunk_by(|a, b| a.0 == b.0) {
        let ring = &mut rings[group[0].0 as usize];
        let mut out = Vec::with_capacity(ring.len() + group.len());
        let mut rest = group.iter().peekable();
        for (k, p) in ring.iter().enumerate() {
            out.push(*p);
            while let Some(split) = rest.next_if(|s| s.1 as usize == k) {
                out.push(split.3);
            }
        }
        tidy(&mut out);
        *ring = out;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::polygon;
    use satseed_scene::SeedPath;

    #[test]
    fn crossing_squares_share_their_crossings() {
        let square = |x: f64| polygon::rectangle(DVec2::new(x, x), DVec2::new(x + 2.0, x + 2.0));
        let out = arranged(&[square(0.0), square(1.0)]);
        for (ring, other) in [(0, 1), (1, 0)] {
            assert_eq!(out[ring].len(), 6);
            let shared = out[ring].iter().filter(|p| out[other].contains(p)).count();
            assert_eq!(shared, 2);
        }
    }

    #[test]
    fn nothing_crosses_in_a_heap_of_strips() {
        let mut rng = SeedPath::root("arrange", 1).rng();
        let strips: Vec<Vec<DVec2>> = (0..400)
            .map(|_| {
                let (s, c) = libm::sincos(rng.range(0.0, 6.3));
                let centre = DVec2::new(rng.signed(), rng.signed()) * 40.0;
                polygon::oriented_rectangle(
                    centre,
                    DVec2::new(c, s),
                    DVec2::new(rng.range(1.0, 30.0), rng.range(0.1, 3.0)),
                )
            })
            .collect();
        let out = arranged(&strips);
        let lattice = |o: &Vec<DVec2>| -> Vec<Point> {
            o.iter().map(|p| [(p.x / QUANTUM_M) as i64, (p.y / QUANTUM_M) as i64]).collect()
        };
        assert!(crossings(&out.iter().map(lattice).collect::<Vec<_>>()).is_empty());
        for (a, b) in strips.iter().zip(&out) {
            assert!((polygon::area(a) - polygon::area(b)).abs() < 0.1);
        }
    }
}
