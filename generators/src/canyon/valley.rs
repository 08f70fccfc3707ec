//! The river's course, and the channels that water cut into the plateau around it.

use super::strata::{Habit, RIM_M, Strata};
use crate::kit::terrain::erosion::stream_power;
use crate::kit::terrain::flow::{Drainage, fill_and_drain};
use crate::kit::terrain::front::Source;
use crate::kit::terrain::noise::{fractal, warp};
use glam::DVec2;
use satseed_scene::{Raster, SeedPath};

/// Half the side of the square in which water is followed, m: catchments must be larger than what is seen of them.
const DOMAIN_M: f64 = 2048.0;
/// Distance of the course's points, m.
const STEP_M: f64 = 6.0;
/// Area that makes a channel, m2.
const CHANNEL_AREA_M2: f32 = 5000.0;
/// Passes of a three-point mean over the river's way from side to side of its floor: bends of some tens of metres.
const BEND_PASSES: usize = 40;
/// Fall of the river, m per m.
const RIVER_GRADIENT: f64 = 0.004;
/// Area whose water saws through a cliff 12 m high, m2.
const SAWING_AREA_M2: f64 = 45_000.0;
/// Channels of larger areas are no wider, m2.
const MAX_WIDTH_AREA_M2: f64 = 4e5;

/// How much farther than a mean bed a channel's step cuts into a bed of each kind in the same time.
fn erodibility(habit: Habit) -> f32 {
    match habit {
        Habit::Cliff => 0.5,
        Habit::Slope => 1.6,
        Habit::Bench => 2.0,
        Habit::Plateau => 0.9,
    }
}

/// The main valley's axis with its floor, and the river or dry wash on it.
pub(super) struct Trunk {
    /// The axis's points, `STEP_M` apart, from upstream down.
    pub(super) axis_m: Vec<DVec2>,
    /// The river's centre line, a point for each of the axis.
    pub(super) thread_m: Vec<DVec2>,
    /// Half the floor's width at each point, m.
    pub(super) floor_half_m: Vec<f64>,
    /// Distance of the left and the right bank from the centre line at each point, m.
    pub(super) river_half_m: [Vec<f64>; 2],
    /// Height of the river's surface, or the wash's bed, at each point, m.
    pub(super) level_m: Vec<f64>,
    /// Whether the wash is dry.
    pub(super) is_dry: bool,
}

/// The gentle fold and dip of all beds: a height to add to the stratigraphic one, m.
pub(super) struct Fold {
    seed: u32,
    wavelength_m: f64,
    amplitude_m: f64,
    dip: DVec2,
}

/// The fold never lifts or lowers a bed by more, m.
pub(super) const FOLD_LIMIT_M: f64 = 12.0;

impl Fold {
    pub(super) fn new(path: &SeedPath) -> Self {
        let mut rng = path.rng();
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        Self {
            seed: path.hash_u32(),
            wavelength_m: rng.range(1000.0, 2400.0),
            amplitude_m: rng.range(8.0, 22.0),
            dip: DVec2::new(c, s) * rng.range(0.003, 0.02),
        }
    }

    pub(super) fn at(&self, p_m: DVec2) -> f64 {
        let x = self.dip.dot(p_m) + fractal(p_m, self.seed, self.wavelength_m, 2, 0.3) * self.amplitude_m;
        // Far from the pivot the dip levels out.
        x / f64::sqrt(1.0 + (x / FOLD_LIMIT_M) * (x / FOLD_LIMIT_M))
    }
}

impl Trunk {
    /// A meandering course past the pivot. Its direction, not its place, is the random function of the way along it
    /// (Langbein and Leopold 1966), so that bends are tight where they turn and the course never meets itself.
    pub(super) fn new(relief_m: f64, path: &SeedPath) -> Self {
        let mut rng = path.rng();
        let seed = path.hash_u32();
        let main = rng.range(0.0, core::f64::consts::TAU);
        let swing = rng.range(0.9, 1.25);
        let wavelength = rng.range(520.0, 900.0);
        let reach = DOMAIN_M * 2.2;
        let heading = |s: f64| {
            let turn = fractal(DVec2::new(s, 0.5 * wavelength), seed, wavelength, 3, 0.35) * 2.4;
            main + swing * turn.clamp(-1.15, 1.15)
        };
        // From the pivot's neighbourhood both ways.
        let start = DVec2::new(rng.range(-25.0, 25.0), rng.range(-25.0, 25.0));
        let count = libm::ceil(reach / STEP_M) as i64;
        let walk = |sign: i64| {
            let mut p = start;
            let mut points = Vec::new();
            for k in 0..count {
                let s = (k as f64 + 0.5) * STEP_M * sign as f64;
                let (sin, cos) = libm::sincos(heading(s));
                p += DVec2::new(cos, sin) * (STEP_M * sign as f64);
                points.push(p);
            }
            points
        };
        let mut axis_m = walk(-1);
        axis_m.reverse();
        axis_m.push(start);
        axis_m.extend(walk(1));
        let is_dry = rng.chance(0.35);
        let width = if is_dry { rng.range(8.0, 20.0) } else { rng.range(10.0, 26.0) };
        let floor = rng.range(16.0, 38.0).max(width * 0.8 + 6.0);
        let along = |k: usize| (k as f64 - count as f64) * STEP_M;
        let noise = |k: usize, salt: u32, wavelength: f64| {
            fractal(DVec2::new(along(k), 0.37 * wavelength), seed ^ salt, wavelength, 3, 0.45)
        };
        let n = axis_m.len();
        let river_half_m = [11, 12].map(|salt| {
            let uneven = |k| 0.4 * noise(k, 1, 140.0) + 0.42 * noise(k, salt, 48.0);
            (0..n).map(|k| width * 0.5 * (1.0 + uneven(k)).max(0.45)).collect::<Vec<f64>>()
        });
        let widest = |k: usize| river_half_m[0][k].max(river_half_m[1][k]);
        let floor_half_m: Vec<f64> =
            (0..n).map(|k| (floor * (1.0 + 0.9 * noise(k, 2, 220.0))).clamp(widest(k) + 4.0, 60.0)).collect();
        let normals: Vec<DVec2> =
            (0..n).map(|k| (axis_m[(k + 1).min(n - 1)] - axis_m[k.saturating_sub(1)]).normalize().perp()).collect();
        // Alluvial rivers have no elbows: where the floor narrows the thread is eased from afar.
        let aside: Vec<f64> =
            (0..n).map(|k| (floor_half_m[k] - widest(k) - 1.0) * (1.9 * noise(k, 3, 260.0)).clamp(-1.0, 1.0)).collect();
        let aside = eased(aside, BEND_PASSES);
        let axis_of_thread_m = eased(axis_m.clone(), BEND_PASSES / 4);
        let thread_m = (0..n).map(|k| axis_of_thread_m[k] + normals[k] * aside[k]).collect();
        let level_m = (0..n).map(|k| RIM_M - relief_m - along(k) * RIVER_GRADIENT * 0.8).collect();
        Self { axis_m, thread_m, floor_half_m, river_half_m, level_m, is_dry }
    }

    /// The axis's points within the square of half side `half_m`, with a margin.
    pub(super) fn range(&self, half_m: f64) -> core::ops::Range<usize> {
        let near = |p: &DVec2| p.x.abs() < half_m && p.y.abs() < half_m;
        let first = self.axis_m.iter().position(near).unwrap_or(0);
        let last = self.axis_m.iter().rposition(near).unwrap_or(0);
        first.saturating_sub(20)..(last + 20).min(self.axis_m.len() - 1)
    }
}

/// A row of values after passes of a three-point mean; the ends stay.
fn eased<T>(mut values: Vec<T>, passes: usize) -> Vec<T>
where
    T: Copy + core::ops::Add<Output = T> + core::ops::Mul<f64, Output = T>,
{
    for _ in 0..passes {
        let old = values.clone();
        for k in 1..old.len() - 1 {
            values[k] = old[k] * 0.5 + (old[k - 1] + old[k + 1]) * 0.25;
        }
    }
    values
}

/// What water cut: channels as sources of walls.
pub(super) struct Channels {
    /// The trunk's floor first, then each channel's links; values are distances in the strata's profile.
    pub(super) sources: Vec<Source>,
}

impl Channels {
    pub(super) fn new(strata: &Strata, fold: &Fold, trunk: &Trunk, path: &SeedPath) -> Self {
        let eroded = erode(strata, fold, trunk, path);
        let mut sources = trunk_sources(strata, fold, trunk);
        sources.extend(tributaries(strata, fold, trunk, &eroded, path.child("wiggle").hash_u32()));
        Self { sources }
    }
}

fn trunk_sources(strata: &Strata, fold: &Fold, trunk: &Trunk) -> Vec<Source> {
    let value = |k: usize| strata.distance_of(trunk.level_m[k] - fold.at(trunk.axis_m[k]));
    trunk
        .range(DOMAIN_M)
        .map(|k| Source {
            ends_m: [trunk.axis_m[k], trunk.axis_m[k + 1]],
            values_m: [value(k), value(k + 1)],
            half_widths_m: [trunk.floor_half_m[k], trunk.floor_half_m[k + 1]],
        })
        .collect()
}

struct Eroded {
    z: Raster<f32>,
    drainage: Drainage,
    area_m2: Vec<f32>,
    is_trunk: Vec<bool>,
}

/// The plateau, cut by streams since the river sank below it: coarse, then on a grid of twice the resolution.
fn erode(strata: &Strata, fold: &Fold, trunk: &Trunk, path: &SeedPath) -> Eroded {
    let seed = path.hash_u32();
    let mut rng = path.rng();
    let reach = rng.range(2.3, 3.2);
    let grid = |cell: f64| {
        let n = (2.0 * DOMAIN_M / cell) as usize;
        Raster::filled(DVec2::splat(cell / 2.0 - DOMAIN_M), cell, n, n, 0.0_f32)
    };
    let mut z = grid(16.0);
    let lateral = lateral_distance(trunk, &z);
    for j in 0..z.height {
        for i in 0..z.width {
            let p = z.position(i, j);
            let hills = fractal(p, seed, 620.0, 6, 0.55) * 7.0;
            let away = f64::from(lateral.get(i, j)) * 0.004;
            z.set(i, j, (RIM_M + 2.0 + fold.at(p) + away + hills) as f32);
        }
    }
    let mut result = None;
    // (cell, steps, share of the whole incision)
    for (cell, steps, share) in [(16.0, 30, 0.8), (8.0, 9, 0.2)] {
        if z.cell_m != cell {
            let mut fine = grid(cell);
            for j in 0..fine.height {
                for i in 0..fine.width {
                    let p = fine.position(i, j);
                    let jitter = fractal(p, seed ^ 0x77, 40.0, 3, 0.6) * 1.2;
                    fine.set(i, j, (z.bilinear(p) + jitter) as f32);
                }
            }
            z = fine;
        }
        let levels = rasterise(trunk, &z);
        let is_trunk: Vec<bool> = levels.iter().map(|l| !l.is_nan()).collect();
        let beds: Vec<f32> = strata.beds.iter().map(|b| erodibility(b.habit)).collect();
        let folds: Vec<f32> = (0..z.data.len()).map(|p| fold.at(z.position(p % z.width, p / z.width)) as f32).collect();
        let per_step = (reach * share / f64::from(steps)) as f32;
        for step in 0..steps {
            // The river sinks during the first two thirds of the coarse time.
            let sunk = if cell > 8.0 { (f64::from(step + 1) / (f64::from(steps) * 0.6)).min(1.0) } else { 1.0 };
            for (p, level) in levels.iter().enumerate().filter(|l| !l.1.is_nan()) {
                let top = RIM_M as f32;
                z.data[p] = top + (level - top) * sunk as f32;
            }
            let drainage = fill_and_drain(&mut z, seed, |p| is_trunk[p]);
            let area = drainage.area_m2(cell);
            stream_power(&mut z, &drainage, &area, |p, height| {
                per_step * beds[strata.bed_at(f64::from(height - folds[p]))]
            });
        }
        let drainage = fill_and_drain(&mut z, seed, |p| is_trunk[p]);
        let area_m2 = drainage.area_m2(cell);
        result = Some((drainage, area_m2, is_trunk));
    }
    let (drainage, area_m2, is_trunk) = result.expect("the list of resolutions is not empty");
    Eroded { z, drainage, area_m2, is_trunk }
}

/// The river's level on the posts it runs through; NaN elsewhere.
fn rasterise(trunk: &Trunk, shape: &Raster<f32>) -> Vec<f32> {
    let mut level = vec![f32::NAN; shape.data.len()];
    for k in 0..trunk.axis_m.len() - 1 {
        for part in 0..4 {
            let p = trunk.axis_m[k].lerp(trunk.axis_m[k + 1], f64::from(part) / 4.0);
            let g = shape.grid_from_world(p) + 0.5;
            if g.x >= 0.0 && g.y >= 0.0 && g.x < shape.width as f64 && g.y < shape.height as f64 {
                level[g.y as usize * shape.width + g.x as usize] = trunk.level_m[k] as f32;
            }
        }
    }
    level
}

fn lateral_distance(trunk: &Trunk, shape: &Raster<f32>) -> Raster<f32> {
    let sources: Vec<Source> = trunk
        .axis_m
        .windows(2)
        .map(|p| Source { ends_m: [p[0], p[1]], values_m: [0.0; 2], half_widths_m: [0.0; 2] })
        .collect();
    crate::kit::terrain::front::rise(shape, &sources, 4.0 * DOMAIN_M).0
}

/// Stratigraphic height of a channel's bed. A small stream does not saw through a cliff: it runs in a shallow groove on top
/// of it up to a fall, whose head stands back from the foot. The more water, the higher the cliff that it saws through.
fn hung(strata: &Strata, height_m: f64, area_m2: f64) -> f64 {
    let Some([foot_m, top_m]) = strata.cliff_over(height_m) else { return height_m };
    let cliff_m = top_m - foot_m;
    let head_m = (1.0 + 0.12 * cliff_m).min(6.0);
    if height_m < foot_m - head_m || area_m2 > SAWING_AREA_M2 * (cliff_m / 12.0).clamp(0.6, 4.0) {
        return height_m;
    }
    top_m
}

/// Channels as links between smoothed points: the grid's eight directions must not show.
fn tributaries(strata: &Strata, fold: &Fold, trunk: &Trunk, eroded: &Eroded, seed: u32) -> Vec<Source> {
    let Eroded { z, drainage, area_m2, is_trunk } = eroded;
    let is_channel = |p: usize| !is_trunk[p] && area_m2[p] > CHANNEL_AREA_M2;
    let mut at: Vec<DVec2> = (0..z.data.len()).map(|p| z.position(p % z.width, p / z.width)).collect();
    // The donor with the largest area is a channel's upstream continuation.
    let mut donor = vec![u32::MAX; z.data.len()];
    for &p in drainage.order.iter().rev() {
        let to = drainage.receiver[p as usize] as usize;
        if to != p as usize && is_channel(p as usize) {
            let best = donor[to];
            if best == u32::MAX || area_m2[best as usize] < area_m2[p as usize] {
                donor[to] = p;
            }
        }
    }
    // A mouth meets the river where it is, not at the centre of a cell.
    let mouths: Vec<usize> = (0..at.len()).filter(|p| is_trunk[*p]).collect();
    for p in mouths {
        let nearest =
            trunk.axis_m.iter().copied().min_by(|a, b| (*a - at[p]).length().total_cmp(&(*b - at[p]).length()));
        at[p] = nearest.unwrap_or(at[p]);
    }
    for _ in 0..5 {
        let old = at.clone();
        for &p in &drainage.order {
            let p = p as usize;
            if is_channel(p) && donor[p] != u32::MAX {
                let to = drainage.receiver[p] as usize;
                at[p] = old[p] * 0.5 + (old[to] + old[donor[p] as usize]) * 0.25;
            }
        }
    }
    let place = |p: usize| if is_trunk[p] { at[p] } else { warp(at[p], seed, 34.0, 5.0) };
    let value = |p: usize| {
        let height_m = f64::from(z.data[p]) - fold.at(at[p]);
        let height_m = if is_trunk[p] { height_m } else { hung(strata, height_m, f64::from(area_m2[p])) };
        strata.distance_of(height_m)
    };
    let half_width = |p: usize| 0.03 * libm::pow(f64::from(area_m2[p]).min(MAX_WIDTH_AREA_M2), 0.45);
    drainage
        .order
        .iter()
        .map(|p| *p as usize)
        .filter(|p| is_channel(*p))
        .map(|p| {
            let to = drainage.receiver[p] as usize;
            Source {
                ends_m: [place(to), place(p)],
                values_m: [value(to), value(p)],
                half_widths_m: [half_width(to), half_width(p)],
            }
        })
        .collect()
}
