//! A grid of streets turned by the pivot, and the blocks between them: most of four sides, some cut by a diagonal, some of
//! two blocks' size.

use crate::kit::polygon;
use crate::kit::streets::{Block, CrossSection, Family, Segment, Street, StreetPlan, family};
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// Every so many lines of a family one is an avenue.
const AVENUE_EVERY: i64 = 7;

/// Of each square of so many blocks one is cut by a diagonal, and one is joined with its neighbour.
const IRREGULAR_EVERY: i64 = 5;

/// What a grid is drawn from.
pub(super) struct Style {
    /// Greatest turn of the grid against north, radians.
    pub(super) turn_rad: f64,
    /// Depth of blocks, m: between the streets of the first family, and of the second.
    pub(super) block_m: [[f64; 2]; 2],
    /// Weights of the kinds of streets: one way, two ways, four lanes.
    pub(super) weights: [f64; 3],
}

/// The land between streets.
#[derive(Clone, Debug)]
pub(super) struct CityBlock {
    pub(super) name: String,
    pub(super) key: SeedPath,
    /// Numbers of its place in the grid.
    pub(super) index: [i64; 2],
    /// Kerb line.
    pub(super) kerb: Vec<DVec2>,
    /// Property line.
    pub(super) property: Vec<DVec2>,
    /// It is a part of a block that a diagonal cut, or two blocks in one.
    pub(super) irregular: bool,
    /// An avenue or a street of four lanes runs along it.
    pub(super) busy: bool,
}

/// A diagonal street within a block: a point, its direction, the block's kerb line.
pub(super) struct Diagonal {
    pub(super) through: DVec2,
    pub(super) along: DVec2,
    pub(super) kerb: Vec<DVec2>,
}

/// Half the roadway and half the right of way of a diagonal, m.
pub(super) const DIAGONAL_M: [f64; 2] = [5.3, 9.5];

/// The streets and blocks near the pivot.
pub(super) struct Grid {
    /// Blocks grown to the middle of their streets, and a little more.
    pub(super) cells: Vec<Vec<DVec2>>,
    pub(super) blocks: Vec<CityBlock>,
    pub(super) diagonals: Vec<Diagonal>,
    pub(super) segments: Vec<Segment>,
}

fn section(kind: u16) -> CrossSection {
    let (roadway_m, sidewalk_m) = [(10.4, 3.9), (10.6, 4.0), (16.6, 4.4), (22.6, 5.6)][usize::from(kind)];
    CrossSection { kind, roadway_m, sidewalk_m }
}

fn streets(style: &Style, path: &SeedPath, reach_m: f64) -> StreetPlan {
    let mut rng = path.rng();
    let (s, c) = libm::sincos(rng.signed() * style.turn_rad);
    let north = DVec2::new(s, c);
    let directions = [north, DVec2::new(north.y, -north.x)];
    let mut first = [0; 2];
    let mut lines = [Vec::new(), Vec::new()];
    for f in 0..2 {
        let what = Family {
            direction: directions[f],
            block_m: style.block_m[f],
            turn_rad: 0.005,
            sections: style.weights.iter().zip(0..).map(|(w, k)| (*w, section(k))).collect(),
        };
        (first[f], lines[f]) = family(&what, &path.child("family").index(f as u64), reach_m);
    }
    // One avenue within every frame, in one of the two families.
    let own = usize::from(rng.chance(0.5));
    let start = rng.below(2) as i64;
    for (f, avenue) in [(own, start), (1 - own, start + 3)] {
        for (i, line) in lines[f].iter_mut().enumerate() {
            if (first[f] + i as i64 - avenue).rem_euclid(AVENUE_EVERY) == 0 {
                line.section = section(3);
            }
        }
    }
    StreetPlan { first, streets: lines }
}

/// What a place of the grid is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Odd {
    No,
    /// A diagonal cuts it.
    Cut,
    /// It is one block with the next one.
    Joined,
    /// It belongs to the block before.
    Taken,
}

fn odd(path: &SeedPath, index: [i64; 2]) -> Odd {
    let square = index.map(|k| k.div_euclid(IRREGULAR_EVERY));
    let mut rng = path.child("irregular").index(square[0] as u64).index(square[1] as u64).rng();
    // The last of a square joins no neighbour of the next square.
    let draw = |rng: &mut Rng| [0, 1].map(|_| rng.below(IRREGULAR_EVERY as u64 - 1) as i64);
    let own = index.map(|k| k.rem_euclid(IRREGULAR_EVERY));
    let cut = draw(&mut rng);
    let mut joined = draw(&mut rng);
    if joined[1] == cut[1] {
        joined[1] += 1;
    }
    match own {
        _ if own == cut => Odd::Cut,
        _ if own == joined => Odd::Joined,
        _ if own == [joined[0] + 1, joined[1]] => Odd::Taken,
        _ => Odd::No,
    }
}

/// The grid out to a distance.
pub(super) fn grid(style: &Style, city: &SeedPath, reach_m: f64) -> Grid {
    let path = city.child("grid");
    let plan = streets(style, &path, reach_m + 500.0);
    let mut segments = plan.segments(reach_m);
    let mut out = Grid { cells: Vec::new(), blocks: Vec::new(), diagonals: Vec::new(), segments: Vec::new() };
    let line = |f: usize, number: i64| -> &Street { &plan.streets[f][(number - plan.first[f]) as usize] };
    for block in plan.blocks(reach_m) {
        let [i, j] = block.index;
        let bounds = [line(0, i - 1), line(0, i), line(1, j - 1), line(1, j)];
        let busy = bounds.iter().any(|s| s.section.kind >= 2);
        out.cells.push(cell(bounds));
        let name = format!("block/{i}/{j}");
        let key = city.child("block").index(i as u64).index(j as u64);
        let whole = CityBlock {
            name: name.clone(),
            key,
            index: block.index,
            kerb: block.kerb.clone(),
            property: block.property.clone(),
            irregular: false,
            busy,
        };
        match odd(&path, block.index) {
            Odd::No => out.blocks.push(whole),
            Odd::Cut => split(&whole, &block, &path, &mut out),
            Odd::Taken => {}
            Odd::Joined => {
                let right = [line(0, i), line(0, i + 1), bounds[2], bounds[3]];
                let merged = |with_sidewalk: bool| outer(&quad(bounds, with_sidewalk), &quad(right, with_sidewalk));
                segments.retain(|s| s.index != [0, i, j]);
                out.blocks.push(CityBlock { kerb: merged(false), property: merged(true), irregular: true, ..whole });
            }
        }
    }
    out.segments = segments;
    out
}

/// Corners of the land between four streets.
fn quad([r, l, d, u]: [&Street; 4], with_sidewalk: bool) -> Vec<DVec2> {
    let h = |s: &Street| s.section.roadway_m / 2.0 + if with_sidewalk { s.section.sidewalk_m } else { 0.0 };
    let mut q = vec![
        r.crossing(h(r), d, h(d)),
        r.crossing(h(r), u, -h(u)),
        l.crossing(-h(l), u, -h(u)),
        l.crossing(-h(l), d, h(d)),
    ];
    if polygon::area(&q) < 0.0 {
        q.reverse();
    }
    q
}

fn cell([r, l, d, u]: [&Street; 4]) -> Vec<DVec2> {
    let mut q =
        vec![r.crossing(0.0, d, 0.0), r.crossing(0.0, u, 0.0), l.crossing(0.0, u, 0.0), l.crossing(0.0, d, 0.0)];
    if polygon::area(&q) < 0.0 {
        q.reverse();
    }
    polygon::mitred(&q, -0.37)
}

/// Two neighbours' common outline: of each the two corners that are farther from the other.
fn outer(a: &[DVec2], b: &[DVec2]) -> Vec<DVec2> {
    let far = |own: &[DVec2], other: &[DVec2]| -> Vec<DVec2> {
        let c = polygon::centroid(other);
        let mut sorted = own.to_vec();
        sorted.sort_by(|p, q| q.distance(c).total_cmp(&p.distance(c)));
        sorted.truncate(2);
        sorted
    };
    let (mut p, q) = (far(a, b), far(b, a));
    p.extend(q);
    // Convex position: the one order of positive area without a crossing.
    for order in [[0, 1, 2, 3], [0, 1, 3, 2], [1, 0, 2, 3], [1, 0, 3, 2]] {
        let ring: Vec<DVec2> = order.iter().map(|k| p[*k]).collect();
        let convex =
            (0..4).all(|k| (ring[(k + 1) % 4] - ring[k]).perp_dot(ring[(k + 2) % 4] - ring[(k + 1) % 4]) > 0.0);
        if convex {
            return ring;
        }
    }
    a.to_vec()
}

/// A block cut by a diagonal street through its middle.
fn split(whole: &CityBlock, block: &Block, path: &SeedPath, out: &mut Grid) {
    let mut rng = path.child("diagonal").index(block.index[0] as u64).index(block.index[1] as u64).rng();
    let through = polygon::centroid(&block.kerb);
    let corner = block.kerb[rng.below(4) as usize];
    let (s, c) = libm::sincos(rng.signed() * 0.12);
    let along = DVec2::new(c, s).rotate((corner - through).normalize());
    for (k, side) in [along.perp(), -along.perp()].into_iter().enumerate() {
        let half = |p: &[DVec2], by: f64| polygon::clip(p, through + side * by, side);
        if let (Some(kerb), Some(property)) = (half(&block.kerb, DIAGONAL_M[0]), half(&block.property, DIAGONAL_M[1])) {
            out.blocks.push(CityBlock {
                name: format!("{}/part/{k}", whole.name),
                key: whole.key.child("part").index(k as u64),
                kerb,
                property,
                irregular: true,
                ..whole.clone()
            });
        }
    }
    out.diagonals.push(Diagonal { through, along, kerb: block.kerb.clone() });
}
