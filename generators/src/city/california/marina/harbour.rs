//! The shape of a harbour: a channel with basins between moles on one side and a bank with beaches on the other, and the
//! ground that follows from it.
//!
//! Everything is on the sheet, which lies straight here: x along the channel, y across it. The shore is a list of edges,
//! each with the width of the bank that rises from the water's line to the land: a wall, a slope of stones, a beach.

use super::super::layout::{Grid, Line};
use crate::kit::polygon;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Height of the water; land beside it lies at 0, m.
pub(in super::super) const WATER_M: f64 = -2.3;

/// Widths of banks, m: a wall leans a little, stones lie 1 in 1.6.
pub(super) const WALL_M: f64 = 0.35;
pub(super) const STONES_M: f64 = 3.6;
pub(super) const BEACH_M: f64 = 27.0;

/// From the property line of the northern street to the heads of basins, m.
const HEAD_M: f64 = 74.0;
/// From the property line of the southern street to the water, m.
const BANK_M: f64 = 100.0;
/// Inland from the harbour the land's own relief comes up over this distance, m.
const LEVEL_M: f64 = 160.0;
/// Basins are known out to this distance from the pivot, m: the corners of the ground.
const REACH_M: f64 = 3500.0;
/// Depths of basins and of the channel, m.
const BASIN_DEPTH_M: f64 = 4.2;
const CHANNEL_DEPTH_M: f64 = 6.5;

/// What lies nearer to a water's line is on it: corners on the lattice of vertices lie off by half a step, m.
const LATTICE_M: f64 = 0.004;

/// What a piece of shore is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shore {
    /// A concrete wall.
    Wall,
    /// Tipped stones.
    Stones,
    /// Sand.
    Beach,
}

/// A piece of shore: the water lies on the right of its way.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    pub(super) shore: Shore,
    /// Its water's line.
    pub(super) line: Vec<DVec2>,
    /// Width of the bank at each of its points, m.
    pub(super) widths_m: Vec<f64>,
}

/// The land and water between two lines of the first axis.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Number of the line at its begin.
    pub(super) k: i64,
    /// Where its lines lie.
    pub(super) x: [f64; 2],
    /// Half widths of the moles at its begin and end, m.
    pub(super) mole_m: [f64; 2],
    /// Tips of these moles.
    pub(super) tip: [f64; 2],
    /// Where the basin ends.
    pub(super) head: f64,
    /// The head is a beach.
    pub(super) sandy_head: bool,
    /// The southern bank is a beach.
    pub(super) sandy_bank: bool,
    pub(super) north: Vec<Reach>,
    pub(super) south: Vec<Reach>,
    /// The water's outline, counter-clockwise.
    pub(super) water: Vec<DVec2>,
}

/// A harbour.
#[derive(Clone, Debug)]
pub(in super::super) struct Harbour {
    pub(super) cells: Vec<Cell>,
    /// Middle of the street on either side.
    pub(super) streets: [f64; 2],
    /// Where the channel's southern and northern side are.
    pub(super) channel: [f64; 2],
}

/// A polyline with the bank widths that its corners have.
fn reach(shore: Shore, points: &[(DVec2, f64)]) -> Reach {
    Reach { shore, line: points.iter().map(|p| p.0).collect(), widths_m: points.iter().map(|p| p.1).collect() }
}

impl Harbour {
    pub(in super::super) fn new(grid: &Grid, city: &SeedPath) -> Self {
        let path = city.child("harbour");
        let mut rng = path.rng();
        let streets = [grid.position(1, -1), grid.position(1, 0)];
        let south = streets[0] + Line::Collector.half_row_m() + BANK_M;
        let channel = [south, south + rng.range(94.0, 118.0)];
        let head = streets[1] - Line::Arterial.half_row_m() - HEAD_M;
        // A mole and the head of the basin after it, by the number of its line.
        let mole = |k: i64| {
            let mut rng = path.child("mole").index(k as u64).rng();
            (grid.position(0, k), rng.range(52.0, 61.0), channel[1] + rng.range(0.0, 16.0))
        };
        let numbers = grid.numbers(0, REACH_M);
        let cells = (*numbers.start()..*numbers.end())
            .map(|k| {
                let mut rng = path.child("cell").index(k as u64).rng();
                let ((x0, m0, t0), (x1, m1, t1)) = (mole(k), mole(k + 1));
                let head = head - rng.range(0.0, 12.0);
                let mut cell = Cell {
                    k,
                    x: [x0, x1],
                    mole_m: [m0, m1],
                    tip: [t0, t1],
                    head,
                    sandy_head: rng.chance(0.28),
                    sandy_bank: rng.chance(0.5),
                    north: Vec::new(),
                    south: Vec::new(),
                    water: Vec::new(),
                };
                cell.north = northern(&cell);
                cell.south = southern(&cell, channel[0]);
                cell.water = water(&cell);
                cell
            })
            .collect();
        Self { cells, streets, channel }
    }

    /// Cells that come within a distance of an interval of x.
    fn near(&self, x: f64, within_m: f64) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |c| x > c.x[0] - within_m && x < c.x[1] + within_m)
    }

    /// Whether a place lies in the water.
    pub(super) fn is_water(&self, p: DVec2) -> bool {
        if p.y < self.streets[0] || p.y > self.streets[1] {
            return false;
        }
        // Where two cells meet, their common border is neither's.
        let between = |c: &Cell| (p.x - c.x[0]).abs() < 0.01 && p.y < c.tip[0] && p.y > self.channel[0];
        self.near(p.x, 0.02).any(|c| between(c) || polygon::contains(&c.water, p))
    }

    /// Height of the ground, m, over an inland relief.
    pub(in super::super) fn height_m(&self, p: DVec2, relief_m: f64) -> f64 {
        let inland = (self.streets[0] - p.y).max(p.y - self.streets[1]);
        if inland > 0.0 {
            return relief_m * smoothstep(0.0, LEVEL_M, inland);
        }
        if self.is_water(p) {
            return WATER_M;
        }
        let mut share: f64 = 1.0;
        for reach in self.near(p.x, 1.2 * BEACH_M).flat_map(|c| c.north.iter().chain(&c.south)) {
            for (l, w) in reach.line.windows(2).zip(reach.widths_m.windows(2)) {
                let widest = w[0].max(w[1]);
                if p.cmpge(l[0].min(l[1]) - widest).all() && p.cmple(l[0].max(l[1]) + widest).all() {
                    let (distance, t) = to_segment(l[0], l[1], p);
                    let above = (distance - LATTICE_M).max(0.0);
                    share = share.min(above / (w[0] + (w[1] - w[0]) * t));
                }
            }
        }
        WATER_M * (1.0 - share)
    }

    /// Depth of the water at a place, m; 0 on land.
    pub(super) fn depth_m(&self, p: DVec2) -> f64 {
        if !self.is_water(p) {
            return 0.0;
        }
        let middle = f64::midpoint(self.channel[0], self.channel[1]);
        let dredged = smoothstep(self.channel[1] + 30.0, middle, p.y) * smoothstep(self.channel[0], middle, p.y);
        let mut depth = BASIN_DEPTH_M + (CHANNEL_DEPTH_M - BASIN_DEPTH_M) * dredged;
        for cell in self.near(p.x, 60.0) {
            for reach in cell.north.iter().chain(&cell.south) {
                let (foot, slope) = match reach.shore {
                    Shore::Wall => (1.8, 0.25),
                    Shore::Stones => (0.0, 0.5),
                    Shore::Beach => (0.0, 0.075),
                };
                for l in reach.line.windows(2) {
                    depth = depth.min(foot + slope * to_segment(l[0], l[1], p).0);
                }
            }
        }
        depth
    }
}

/// Distance of a place from a segment, and where along it the nearest point lies, 0 to 1.
fn to_segment(a: DVec2, b: DVec2, p: DVec2) -> (f64, f64) {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    ((p - a - d * t).length(), t)
}

/// A cell's northern shore from the middle of one mole's tip to the next one's, land on the left.
fn northern(c: &Cell) -> Vec<Reach> {
    let [x0, x1] = [c.x[0] + c.mole_m[0], c.x[1] - c.mole_m[1]];
    let (cut, notch) = (13.0, 9.0);
    let p = DVec2::new;
    let west = [(p(c.x[0], c.tip[0]), STONES_M), (p(x0 - cut, c.tip[0]), STONES_M), (p(x0, c.tip[0] + cut), STONES_M)];
    let east = [(p(x1, c.tip[1] + cut), STONES_M), (p(x1 + cut, c.tip[1]), STONES_M), (p(c.x[1], c.tip[1]), STONES_M)];
    let side = |x: f64, y: f64, w: f64| (p(x, y), w);
    let mut out = vec![reach(Shore::Stones, &west)];
    // Stones give way to a wall within a few metres.
    let from = [(west[2].0, STONES_M), side(x0, c.tip[0] + cut + 4.0, WALL_M)];
    let to = [side(x1, c.tip[1] + cut + 4.0, WALL_M), (east[0].0, STONES_M)];
    out.push(reach(Shore::Stones, &from));
    if c.sandy_head {
        // The wall ends before the beach, whose sand fills the head between two short slopes of stones.
        let end = c.head - 30.0;
        out.push(reach(Shore::Wall, &[from[1], side(x0, end - 5.0, WALL_M)]));
        out.push(reach(Shore::Stones, &[side(x0, end - 5.0, WALL_M), side(x0, end, STONES_M)]));
        let n = 22;
        let arc: Vec<(DVec2, f64)> = (0..=n)
            .map(|k| {
                let t = f64::from(k) / f64::from(n);
                let (s, co) = libm::sincos(core::f64::consts::PI * t);
                let x = f64::midpoint(x0, x1) - co * (x1 - x0) / 2.0;
                let y = end + 9.0 * s.max(0.0).sqrt() + 3.0 * libm::sin(3.0 * core::f64::consts::PI * t) * s;
                (p(x, y), STONES_M + (BEACH_M - STONES_M) * smoothstep(0.0, 0.5, s))
            })
            .collect();
        out.push(reach(Shore::Beach, &arc));
        out.push(reach(Shore::Stones, &[side(x1, end, STONES_M), side(x1, end - 5.0, WALL_M)]));
        out.push(reach(Shore::Wall, &[side(x1, end - 5.0, WALL_M), to[0]]));
    } else {
        out.push(reach(
            Shore::Wall,
            &[
                from[1],
                side(x0, c.head - notch, WALL_M),
                side(x0 + notch, c.head, WALL_M),
                side(x1 - notch, c.head, WALL_M),
                side(x1, c.head - notch, WALL_M),
                to[0],
            ],
        ));
    }
    out.push(reach(Shore::Stones, &to));
    out.push(reach(Shore::Stones, &east));
    out
}

/// A cell's southern shore from its end to its begin, land on the left.
fn southern(c: &Cell, y: f64) -> Vec<Reach> {
    let p = |t: f64, out: f64| DVec2::new(c.x[1] + (c.x[0] - c.x[1]) * t, y - out);
    let (from, to) = (0.14, 0.86);
    if !c.sandy_bank {
        return vec![reach(
            Shore::Stones,
            &[(p(0.0, 0.0), STONES_M), (p(0.5, 0.0), STONES_M), (p(1.0, 0.0), STONES_M)],
        )];
    }
    let n = 24;
    let arc: Vec<(DVec2, f64)> = (0..=n)
        .map(|k| {
            let t = f64::from(k) / f64::from(n);
            let s = smoothstep(0.0, 0.3, t) * smoothstep(1.0, 0.7, t);
            let out = 14.0 * s + 2.5 * libm::sin(5.0 * core::f64::consts::PI * t) * s;
            (p(from + (to - from) * t, out), STONES_M + (BEACH_M - STONES_M) * s)
        })
        .collect();
    vec![
        reach(Shore::Stones, &[(p(0.0, 0.0), STONES_M), (p(from, 0.0), STONES_M)]),
        reach(Shore::Beach, &arc),
        reach(Shore::Stones, &[(p(to, 0.0), STONES_M), (p(1.0, 0.0), STONES_M)]),
    ]
}

/// The outline of a cell's water: its northern shore turned round and its southern one.
fn water(c: &Cell) -> Vec<DVec2> {
    let mut out: Vec<DVec2> = Vec::new();
    for p in c.north.iter().flat_map(|r| &r.line).chain(c.south.iter().flat_map(|r| &r.line)) {
        if out.last() != Some(p) {
            out.push(*p);
        }
    }
    if polygon::area(&out) < 0.0 {
        out.reverse();
    }
    out
}

impl Reach {
    /// The line moved inland by a share of the bank's width and a distance, m. Corners are mitred; where a beach bends, no
    /// point goes further than that.
    pub(super) fn inland(&self, share: f64, by_m: f64) -> Vec<DVec2> {
        let n = self.line.len();
        (0..n)
            .map(|i| {
                let p = self.line[i];
                let before = (p - self.line[i.max(1) - 1]).try_normalize();
                let after = (self.line[(i + 1).min(n - 1)] - p).try_normalize();
                let (u, v) = (before.or(after).unwrap_or(DVec2::X), after.or(before).unwrap_or(DVec2::X));
                let (a, b) = (u.perp(), v.perp());
                p + (a + b) * ((self.widths_m[i] * share + by_m) / (1.0 + a.dot(b)))
            })
            .collect()
    }
}
