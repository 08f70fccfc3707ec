//! Smooth dunes with sharp brinks, from the slabs of the model.
//!
//! Slabs say where sand lies and which way it faces; their steps say nothing. The body of the dunes is what the wind
//! shapes, smoothed over the windward side alone, and the floor of their lee, smoothed without the slip faces. Between
//! the two runs the brink, a contour line of the depth below the wind, and from it sand falls at its angle of repose:
//! exact cones from the brink's segments, so that neither brink nor slip face knows of any grid.

use super::grid::Grid;
use super::werner::{Regime, SLAB, blow, shadow_lines};
use crate::kit::terrain::contour::{contours, resampled};
use crate::kit::terrain::front::{Source, rise};
use crate::kit::terrain::noise::warp;
use crate::kit::terrain::sampling::smoothstep;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath};

/// Tangent of the slip faces' slope: 33 degrees.
const REPOSE: f64 = 0.6494;
/// The same of the depth below the wind, whose contour is the brink.
const BRINK_CELLS: f64 = 2.0;
/// Tangents of the steepest windward side and of the steepest floor: 12.5 and 14 degrees. A steeper foot would turn from
/// the sun as if it were stained.
const BODY_LIMIT: f64 = 0.222;
const FLOOR_LIMIT: f64 = 0.25;
/// The same of what is guessed of the body beyond a brink: 24 degrees.
const GUESS_LIMIT: f64 = 0.445;
/// Depth below the wind at the brink after smoothing, cells: what a straight brink has there.
const BRINK_DEPTH: f64 = 0.38 * BRINK_CELLS * 0.4;
/// Further depth over which the body ends and the floor begins, cells: at a brink, and where the lee ends at its sides.
const BODY_END: [f64; 2] = [0.30, 1.6];
/// Shorter brinks carry no slip face, m: sand slides in sheets, not in splinters.
const LEAST_BRINK_M: f64 = 12.0;
/// Sources before and after the nearest one that may reach a place higher up.
const ALONG: usize = 3;

/// What the sand is like at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sand {
    /// Height of the windward body or of the lee's floor, m above the bare ground: what stands without slip faces.
    pub(super) body_m: f64,
    /// Depth below the wind relative to that at a brink: 0 in the wind, 1 at a brink, more in the lee.
    pub(super) lee: f64,
    /// Thickness of the sand as the model has it, smoothed, m.
    pub(super) thick_m: f64,
}

/// Where the wind blows. Neither length depends on the radius that a scene asks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Domain {
    /// After so many metres along the wind and across it the model's sand begins anew, differently bent.
    pub(super) period_m: f64,
    /// Half the side of the square around the pivot that any scene lies in, m.
    pub(super) half_m: f64,
}

/// Where a slip face stands at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slip {
    /// Its height above the bare ground, m; far below all where no brink is near.
    pub(super) height_m: f64,
    /// How far it has fallen from its brink, m.
    pub(super) fallen_m: f64,
}

/// A field of dunes.
pub(super) struct Dunes {
    /// Unit direction of the mean wind: the grid's first axis.
    pub(super) along: DVec2,
    /// Unit direction of the wind that shaped the slip faces.
    pub(super) last_wind: DVec2,
    cell_m: f64,
    n: usize,
    /// Seed of what bends all lines.
    bend: u32,
    /// Windward body, floor, depth below the wind, thickness, width of the body's end; with a border that repeats the
    /// other end.
    cells: Vec<[f32; 5]>,
    /// Segments of the brinks for slip faces.
    sources: Vec<Source>,
    nearest: Raster<u32>,
    /// Brinks at which a slip face begins, world, with heights above the bare ground.
    pub(super) brinks: Vec<Vec<DVec3>>,
}

/// Cells of the border around the periodic square.
const PAD: usize = 2;

impl Dunes {
    /// Dunes of a domain, the highest about `height_m` high.
    pub(super) fn new(
        domain: Domain,
        cell_m: f64,
        height_m: f64,
        along: DVec2,
        regime: &Regime,
        path: &SeedPath,
    ) -> Self {
        let n = libm::round(domain.period_m / cell_m) as usize;
        let cell_m = domain.period_m / n as f64;
        let slabs = blow(n, regime, path);
        let grid = Grid { n };
        let mut sorted = slabs.clone();
        sorted.sort_unstable();
        let spread = sorted[(sorted.len() - 1) * 995 / 1000] - sorted[sorted.len() / 50];
        // Slabs are as thick as the stated height asks for.
        let slab_m = height_m / f64::from(spread.max(4));
        let height: Vec<f32> = slabs.iter().map(|s| (f64::from(*s) * slab_m) as f32).collect();

        let hop = regime.last_hop();
        let hop_length = f64::from(hop[0] * hop[0] + hop[1] * hop[1]).sqrt();
        let wind = DVec2::new(f64::from(hop[0]), f64::from(hop[1])) / hop_length;
        // All depths below are measured in cells of unscaled sand, as if slabs had their own thickness.
        let own = SLAB * cell_m / slab_m;
        let still = grid.blurred(&height, 0.7);
        let mut line = still.clone();
        shadow_lines(&mut line, n, hop, (0.2679 * cell_m / own) as f32);
        let depth: Vec<f32> = line.iter().zip(&still).map(|(l, z)| ((l - z) as f64 * own / cell_m) as f32).collect();
        let steep = |p: usize| grid.gradient(&still, p).length() * own / cell_m;
        let windward: Vec<f32> = depth.iter().map(|d| if *d < 0.05 { 1.0 } else { 0.0 }).collect();
        let floor: Vec<f32> = (0..n * n)
            .into_par_iter()
            .map(|p| {
                if depth[p] >= 0.05 {
                    return smoothstep(0.30, 0.18, steep(p)) as f32;
                }
                // Not the windward side that a slip face belongs to.
                let ahead = (1..=8).any(|k| depth[grid.moved(p, wind * f64::from(k))] > 0.25);
                f32::from(u8::from(!ahead))
            })
            .collect();
        let mut body = grid.smoothed_where(&height, &windward);
        let mut floor = grid.smoothed_where(&height, &floor);
        // Far from where they are known both are guesses, which may jump: what rests there is never steep.
        grid.no_steeper(&mut body, (GUESS_LIMIT * cell_m) as f32, |_| true);
        // Measured from windward ground alone: what is guessed beyond a brink lies lower, and would plane the brink off.
        grid.no_steeper(&mut body, (BODY_LIMIT * cell_m) as f32, |p| windward[p] > 0.5);
        // What was cut off ends in edges: windward sides are rounded.
        let body = grid.blurred(&body, 1.0);
        grid.no_steeper(&mut floor, (FLOOR_LIMIT * cell_m) as f32, |_| true);
        let depth = grid.blurred(&depth, BRINK_CELLS);
        let thick = grid.blurred(&height, 2.0);
        let end: Vec<f32> = (0..n * n)
            .map(|p| {
                let slope = grid.gradient(&depth, p);
                let facing = slope.dot(wind) / slope.length().max(1e-3);
                (BODY_END[0] + (BODY_END[1] - BODY_END[0]) * smoothstep(-0.25, -0.7, facing)) as f32
            })
            .collect();
        let end = grid.blurred(&end, 1.0);
        let side = n + 2 * PAD;
        let cells = (0..side * side)
            .map(|p| {
                let wrap = |k: usize| (k + n - PAD) % n;
                let q = wrap(p / side) * n + wrap(p % side);
                [body[q], floor[q], depth[q], thick[q], end[q]]
            })
            .collect();
        let last_wind = DVec2::new(along.x * wind.x - along.y * wind.y, along.y * wind.x + along.x * wind.y);
        let bend = path.child("bend").hash_u32();
        let empty = Raster::filled(DVec2::ZERO, 1.0, 1, 1, u32::MAX);
        let mut dunes =
            Self { along, last_wind, cell_m, n, bend, cells, sources: Vec::new(), nearest: empty, brinks: Vec::new() };
        dunes.find_brinks(domain.half_m);
        dunes
    }

    /// World to the grid's frame: along the mean wind and to its left, m.
    pub(super) fn in_wind(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.along.dot(p), self.along.perp_dot(p))
    }

    /// The fields at a place: cubic B-splines, whose curvature is continuous. The place is moved a little first: the
    /// model's dunes like the directions of its grid, those of the world do not.
    fn fields(&self, p: DVec2) -> [f64; 5] {
        let bent = warp(p, self.bend, 34.0 * self.cell_m, 5.5 * self.cell_m);
        let g = self.in_wind(bent) / self.cell_m;
        let n = self.n as f64;
        let wrapped = |x: f64| x - libm::floor(x / n) * n;
        let (x, y) = (wrapped(g.x), wrapped(g.y));
        let (fi, fj) = (libm::floor(x), libm::floor(y));
        let (wx, wy) = (spline(x - fi), spline(y - fj));
        let side = self.n + 2 * PAD;
        let clamp = |f: f64| (f as usize).min(self.n - 1);
        let corner = (clamp(fj) + PAD - 1) * side + clamp(fi) + PAD - 1;
        let mut sum = [0.0_f64; 5];
        for (row, wy) in wy.iter().enumerate() {
            for (cell, wx) in self.cells[corner + row * side..][..4].iter().zip(wx) {
                let w = wx * wy;
                for k in 0..5 {
                    sum[k] += w * f64::from(cell[k]);
                }
            }
        }
        sum
    }

    /// The sand at a place, without slip faces.
    pub(super) fn sand(&self, p: DVec2) -> Sand {
        let [body, floor, depth, thick, end] = self.fields(p);
        let t = ((depth - BRINK_DEPTH) / end).clamp(0.0, 1.0);
        // Steepest at the brink: where a slip face is worth its name, it begins there and no lip stands over it.
        let share = 1.0 - (1.0 - t) * (1.0 - t) * (1.0 - t);
        Sand { body_m: body + (floor - body) * share, lee: depth / BRINK_DEPTH, thick_m: thick }
    }

    /// The windward body alone, as it goes on beyond the brink, m.
    pub(super) fn windward_m(&self, p: DVec2) -> f64 {
        self.fields(p)[0]
    }

    /// The direction in which the lee deepens: down the slip face where it leaves its brink.
    pub(super) fn toward_lee(&self, p: DVec2) -> DVec2 {
        let e = 0.25 * self.cell_m;
        let at = |x: f64, y: f64| self.fields(p + DVec2::new(x, y))[2];
        DVec2::new(at(e, 0.0) - at(-e, 0.0), at(0.0, e) - at(0.0, -e)).normalize_or_zero()
    }

    /// Height of the slip face that reaches a place, m above the bare ground; far below all where none does.
    pub(super) fn slip_m(&self, p: DVec2) -> f64 {
        self.slip(p).height_m
    }

    /// The highest slip face that reaches a place.
    pub(super) fn slip(&self, p: DVec2) -> Slip {
        let g = self.nearest.grid_from_world(p).floor();
        let (i, j) = (g.x as i64, g.y as i64);
        let (mut best, mut from, mut last) = (f64::MAX, 0.0, u32::MAX);
        for (di, dj) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let s = self.nearest.get_clamped(i + di, j + dj);
            if s == u32::MAX || s == last {
                continue;
            }
            last = s;
            let s = s as usize;
            for source in &self.sources[s.saturating_sub(ALONG)..(s + ALONG + 1).min(self.sources.len())] {
                let (reach, t) = source.reach(p);
                if reach < best {
                    best = reach;
                    from = source.values_m[0] + (source.values_m[1] - source.values_m[0]) * t;
                }
            }
        }
        if best == f64::MAX {
            return Slip { height_m: f64::MIN, fallen_m: 0.0 };
        }
        Slip { height_m: -best * REPOSE, fallen_m: (best - from) * REPOSE }
    }

    fn find_brinks(&mut self, half_m: f64) {
        let step = self.cell_m;
        let count = libm::round(2.0 * half_m / step) as usize + 5;
        let shape = Raster::filled(DVec2::splat(-half_m - 2.0 * step), step, count, count, 0.0_f32);
        let rows: Vec<Vec<f32>> = (0..count)
            .into_par_iter()
            .map(|j| (0..count).map(|i| (self.fields(shape.position(i, j))[2] - BRINK_DEPTH) as f32).collect())
            .collect();
        let depth = Raster { data: rows.concat(), ..shape.clone() };
        let lines: Vec<Vec<DVec2>> = contours(&depth)
            .into_par_iter()
            .flat_map_iter(|line| self.entering(&resampled(&line, step)))
            .filter(|line| line.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>() >= LEAST_BRINK_M)
            .collect();
        for line in &lines {
            for pair in line.windows(2) {
                let value = |p: DVec2| -self.windward_m(p) / REPOSE;
                self.sources.push(Source {
                    ends_m: [pair[0], pair[1]],
                    values_m: [value(pair[0]), value(pair[1])],
                    half_widths_m: [0.0; 2],
                });
            }
        }
        // No slip face goes below the bare ground.
        self.nearest = rise(&shape, &self.sources, 2.0 * step).1;
        self.brinks = lines.iter().flat_map(|line| self.sharp(line)).collect();
    }

    /// The parts of a contour over which the wind leaves the ground, moved onto the contour of the smooth field.
    fn entering(&self, line: &[DVec2]) -> Vec<Vec<DVec2>> {
        let exact: Vec<DVec2> = line.iter().map(|p| self.on_contour(*p)).collect();
        runs(&exact, |a, b| {
            // The lee lies on the left.
            let inward = (b - a).normalize_or_zero().perp();
            inward.dot(self.last_wind) > -0.4 && a.distance(b) > 0.2
        })
    }

    fn on_contour(&self, mut p: DVec2) -> DVec2 {
        let e = 0.25 * self.cell_m;
        for _ in 0..2 {
            let at = |x: f64, y: f64| self.fields(p + DVec2::new(x, y))[2];
            let slope = DVec2::new(at(e, 0.0) - at(-e, 0.0), at(0.0, e) - at(0.0, -e)) / (2.0 * e);
            let off = at(0.0, 0.0) - BRINK_DEPTH;
            let shift = slope * (off / slope.length_squared().max(1e-9));
            p -= shift.clamp_length_max(0.3 * self.cell_m);
        }
        p
    }

    /// The parts of a brink from which a slip face falls that is steeper than the ground beyond.
    fn sharp(&self, line: &[DVec2]) -> Vec<Vec<DVec3>> {
        let drops = |a: DVec2, b: DVec2| {
            let middle = (a + b) / 2.0;
            let inward = (b - a).normalize().perp();
            let beyond = middle + inward * (0.4 * self.cell_m);
            self.slip_m(beyond) > self.sand(beyond).body_m + 0.05
        };
        let parts = runs(line, drops);
        let with_height = |p: &DVec2| p.extend(self.windward_m(*p));
        parts.into_iter().map(|part| part.iter().map(with_height).collect()).collect()
    }
}

/// Runs of consecutive points between which a condition holds.
fn runs(line: &[DVec2], holds: impl Fn(DVec2, DVec2) -> bool) -> Vec<Vec<DVec2>> {
    let mut parts: Vec<Vec<DVec2>> = Vec::new();
    let mut open = false;
    for pair in line.windows(2) {
        if holds(pair[0], pair[1]) {
            if !open {
                parts.push(vec![pair[0]]);
            }
            parts.last_mut().expect("a run is open").push(pair[1]);
            open = true;
        } else {
            open = false;
        }
    }
    parts
}

/// Weights of the uniform cubic B-spline.
fn spline(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    let u = 1.0 - t;
    [u * u * u / 6.0, (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0, (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0, t3 / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splines_keep_planes_and_sum_to_one() {
        for t in [0.0, 0.3, 0.99] {
            let w = spline(t);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let x: f64 = w.iter().zip([-1.0, 0.0, 1.0, 2.0]).map(|(w, x)| w * x).sum();
            assert!((x - t).abs() < 1e-12);
        }
    }
}
