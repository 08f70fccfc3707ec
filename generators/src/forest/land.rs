//! The ground: eroded hills, streams, a track along the slopes.

use super::HALF_M;
use super::lines::{Lines, Near, Part, parts};
use crate::kit::terrain::erosion::{diffuse, stream_power};
use crate::kit::terrain::flow::fill_and_drain;
use crate::kit::terrain::noise::{fractal, warp};
use crate::kit::terrain::sampling::{bicubic, smoothstep};
use crate::kit::terrain::tin::Ground;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Distance of the full detail's posts, m.
pub(super) const POST_M: f64 = 0.5;
/// Distance of the posts on which water works, m.
const WORN_M: f64 = 8.0;
/// Distance of the posts over which the track looks for its way, m.
const WAY_M: f64 = 16.0;
/// Area that makes a stream, m2.
const STREAM_AREA_M2: f32 = 70_000.0;
/// Within this distance of the pivot the relief is the stated one, m.
const STATED_WITHIN_M: f64 = 700.0;
/// Heights reach at most so many times the relief above and below its middle.
pub(super) const REACH: f64 = 0.8;
/// What hummocks, banks, ruts and cuts add or take at most, m.
pub(super) const DETAIL_M: f64 = 6.0;
/// Half the width of the track, m.
pub(super) const TRACK_HALF_M: f64 = 1.9;
/// Half the width of a ride, m.
const RIDE_HALF_M: f64 = 2.3;

/// The finished ground.
pub(super) struct Land {
    /// Hills, [`WORN_M`] apart, over the whole domain.
    hills: Raster<f32>,
    /// How wet the soil is by its place alone, 0 to 1, on the same posts.
    wet: Raster<f32>,
    pub(super) streams: Lines,
    pub(super) track: Lines,
    pub(super) rides: Lines,
    relief_m: f64,
    roughness: f64,
    seed: u32,
    window: Raster<f32>,
}

impl Land {
    /// `window_half_m` is half the side of the full-detail tiles.
    pub(super) fn new(relief_m: f64, roughness: f64, window_half_m: f64, path: &SeedPath) -> Self {
        let seed = path.hash_u32();
        let (hills, wet, streams) = worn(relief_m, path);
        let mut land = Self {
            hills,
            wet,
            streams: Lines::new(streams, 30.0),
            track: Lines::new(Vec::new(), 24.0),
            rides: Lines::new(Vec::new(), 12.0),
            relief_m,
            roughness,
            seed,
            window: Raster::filled(DVec2::splat(-window_half_m), POST_M, 1, 1, 0.0),
        };
        land.track = Lines::new(parts(&land.way(&path.child("track")), TRACK_HALF_M), 24.0);
        land.rides = Lines::new(rides(&path.child("rides")), 12.0);
        // Slopes at the tiles' border ask beyond it.
        let half_m = window_half_m + 4.0 * POST_M;
        let n = libm::round(2.0 * half_m / POST_M) as usize + 1;
        let shape = Raster::filled(DVec2::splat(-half_m), POST_M, n, n, ());
        let rows: Vec<Vec<f32>> = (0..n)
            .into_par_iter()
            .map(|j| (0..n).map(|i| land.exact_m(shape.position(i, j)) as f32).collect())
            .collect();
        land.window = Raster { origin_m: shape.origin_m, cell_m: POST_M, width: n, height: n, data: rows.concat() };
        land
    }

    /// The hills alone, m.
    pub(super) fn hills_m(&self, p: DVec2) -> f64 {
        bicubic(&self.hills, p)
    }

    /// Height within the relief, 0 to 1.
    pub(super) fn elevation(&self, p: DVec2) -> f64 {
        (self.hills.bilinear(p) / self.relief_m + 0.5).clamp(0.0, 1.0)
    }

    /// How wet the soil is, 0 to 1.
    pub(super) fn wetness(&self, p: DVec2) -> f64 {
        let near = smoothstep(20.0, 3.0, self.streams.beyond_m(p));
        self.wet.bilinear(p).max(near)
    }

    /// Height without looking it up, m.
    pub(super) fn exact_m(&self, p: DVec2) -> f64 {
        let rough = self.roughness;
        let hills = self.hills_m(p);
        // Pits and mounds of fallen trees, and what is smaller.
        let swell = fractal(p, self.seed ^ 0x51, 34.0, 3, 0.5) * 0.9;
        let mounds = fractal(p, self.seed ^ 0x52, 8.5, 3, 0.5) * 0.24;
        let mut z = hills + rough * (swell + mounds);
        if let Some(stream) = self.streams.near(p) {
            z = self.with_stream(p, z, &stream);
        }
        if let Some(ride) = self.rides.near(p) {
            let on = smoothstep(1.5, -0.5, ride.offset_m.abs() - ride.half_m);
            z -= on * rough * 0.8 * mounds;
        }
        if let Some(track) = self.track.near(p) {
            z = self.with_track(p, z, &track);
        }
        z
    }

    fn with_stream(&self, p: DVec2, z: f64, stream: &Near) -> f64 {
        let beyond = stream.offset_m.abs() - stream.half_m;
        let water = stream.level_m - 0.75;
        if beyond < 0.0 {
            return water;
        }
        let uneven = fractal(p, self.seed ^ 0x53, 11.0, 3, 0.5);
        let bank = water + 0.06 + 0.6 * smoothstep(0.0, 1.1 + 0.8 * uneven, beyond) + 0.03 * beyond + 0.15 * uneven;
        let bank = bank.max(water + 0.05);
        let flood = 3.0 + 1.8 * stream.half_m + 3.0 * uneven;
        bank + (z - bank) * smoothstep(flood, flood + 11.0, beyond)
    }

    /// Cut and fill: a level track with two ruts, a ditch on both sides.
    fn with_track(&self, p: DVec2, z: f64, track: &Near) -> f64 {
        let d = track.offset_m.abs();
        let grain = fractal(p, self.seed ^ 0x54, 3.1, 2, 0.6);
        let rut = 0.11 * smoothstep(0.38, 0.12, (d - 0.82).abs()) * (0.8 + grain);
        let ditch = 0.28 * smoothstep(0.7, 0.1, (d - 2.7).abs());
        let road = track.level_m - rut - ditch + 0.05 * grain * self.roughness;
        road + (z - road) * smoothstep(2.6, 6.5, d)
    }

    /// The track's way: past the pivot from border to border, as level as the hills let it be.
    fn way(&self, path: &SeedPath) -> Vec<DVec3> {
        let mut rng = path.rng();
        let n = libm::round(2.0 * HALF_M / WAY_M) as usize + 1;
        let shape = Raster::filled(DVec2::splat(-HALF_M), WAY_M, n, n, 0.0_f32);
        let posts: Vec<f64> = (0..n * n).map(|k| self.hills.bilinear(shape.position(k % n, k / n))).collect();
        let wander: Vec<f64> =
            (0..n * n).map(|k| fractal(shape.position(k % n, k / n), path.hash_u32(), 160.0, 3, 0.5)).collect();
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let across = DVec2::new(c, s);
        let rim = |d: DVec2| {
            let q = d / d.abs().max_element() * (HALF_M - 2.0 * WAY_M);
            let g = shape.grid_from_world(q + d.perp() * rng_offset(path, d.x)).round();
            (g.y.clamp(0.0, n as f64 - 1.0) as usize) * n + g.x.clamp(0.0, n as f64 - 1.0) as usize
        };
        let middle = {
            let off = DVec2::new(rng.range(-70.0, 70.0), rng.range(-70.0, 70.0));
            let g = shape.grid_from_world(off).round();
            g.y as usize * n + g.x as usize
        };
        let mut nodes = shortest(n, &posts, &wander, middle, rim(across));
        let other = shortest(n, &posts, &wander, middle, rim(-across));
        nodes.reverse();
        nodes.extend_from_slice(&other[1..]);
        nodes.reverse();
        let mut points: Vec<DVec2> = nodes.iter().map(|k| shape.position(k % n, k / n)).collect();
        for _ in 0..3 {
            points = smoothed(&points);
        }
        // Corners cut twice, so that bends are round.
        for _ in 0..2 {
            let cut = points.windows(2).flat_map(|w| [w[0].lerp(w[1], 0.25), w[0].lerp(w[1], 0.75)]);
            points = cut.collect();
        }
        let mut heights: Vec<f64> = points.iter().map(|p| self.hills_m(*p)).collect();
        for _ in 0..40 {
            let old = heights.clone();
            for k in 1..heights.len() - 1 {
                heights[k] = 0.5 * old[k] + 0.25 * (old[k - 1] + old[k + 1]);
            }
        }
        // Neither cut nor fill is deeper than two metres.
        points
            .iter()
            .zip(heights)
            .map(|(p, z)| p.extend(z.clamp(self.hills_m(*p) - 2.0, self.hills_m(*p) + 2.0)))
            .collect()
    }

    /// Eastward and northward slope at a place.
    pub(super) fn slope(&self, p: DVec2) -> DVec2 {
        let e = POST_M;
        let z = |x: f64, y: f64| self.height_m(p + DVec2::new(x, y));
        DVec2::new(z(e, 0.0) - z(-e, 0.0), z(0.0, e) - z(0.0, -e)) / (2.0 * e)
    }

    /// The posts of the full-detail tiles.
    #[cfg(test)]
    pub(super) fn window(&self) -> &Raster<f32> {
        &self.window
    }
}

fn rng_offset(path: &SeedPath, key: f64) -> f64 {
    path.child(if key < 0.0 { "west" } else { "east" }).rng().range(-0.3, 0.3) * HALF_M
}

fn smoothed(points: &[DVec2]) -> Vec<DVec2> {
    let last = points.len() - 1;
    let at = |k: usize| {
        if k == 0 || k == last { points[k] } else { points[k] * 0.5 + (points[k - 1] + points[k + 1]) * 0.25 }
    };
    (0..=last).map(at).collect()
}

/// The cheapest way over a grid, from the last node back to the first (Dijkstra 1959); steep steps cost more by the
/// square of their grade.
fn shortest(n: usize, heights: &[f64], wander: &[f64], from: usize, to: usize) -> Vec<usize> {
    const STEPS: [(i64, i64); 16] = [
        (1, 0),
        (2, 1),
        (1, 1),
        (1, 2),
        (0, 1),
        (-1, 2),
        (-1, 1),
        (-2, 1),
        (-1, 0),
        (-2, -1),
        (-1, -1),
        (-1, -2),
        (0, -1),
        (1, -2),
        (1, -1),
        (2, -1),
    ];
    let mut cost = vec![u64::MAX; n * n];
    let mut before = vec![usize::MAX; n * n];
    let mut heap = BinaryHeap::from([Reverse((0_u64, from))]);
    cost[from] = 0;
    while let Some(Reverse((c, node))) = heap.pop() {
        if node == to {
            break;
        }
        if c > cost[node] {
            continue;
        }
        let (i, j) = ((node % n) as i64, (node / n) as i64);
        for (di, dj) in STEPS {
            let (ni, nj) = (i + di, j + dj);
            if ni < 0 || nj < 0 || ni >= n as i64 || nj >= n as i64 {
                continue;
            }
            let next = nj as usize * n + ni as usize;
            let run = f64::sqrt((di * di + dj * dj) as f64) * WAY_M;
            let grade = (heights[next] - heights[node]) / run / 0.06;
            let price = run * (1.0 + grade * grade) * (1.0 + 1.2 * (wander[next] + 0.4).max(0.0));
            // In whole millimetres, so that ties and order do not hang on rounding.
            let total = c + (price * 1000.0) as u64 + 1;
            if total < cost[next] {
                cost[next] = total;
                before[next] = node;
                heap.push(Reverse((total, next)));
            }
        }
    }
    let mut way = vec![to];
    while let Some(&node) = way.last().filter(|k| before[**k] != usize::MAX) {
        way.push(before[node]);
    }
    way.reverse();
    way
}

/// One or two straight rides that part compartments; the second square to the first.
fn rides(path: &SeedPath) -> Vec<Part> {
    let mut rng = path.rng();
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let mut all = Vec::new();
    let count = 1 + rng.below(2);
    for k in 0..count {
        let along = if k == 0 { DVec2::new(c, s) } else { DVec2::new(-s, c) };
        let off = along.perp() * rng.range(60.0, 240.0) * if rng.chance(0.5) { -1.0 } else { 1.0 };
        let step = 12.0;
        let n = libm::floor(HALF_M * 1.4 / step) as i64;
        let inside = |p: &DVec3| p.truncate().abs().max_element() < HALF_M - 2.0;
        // Set out with a line, worn and overgrown since: it sways by a few metres, and its width changes.
        let seed = path.index(k).hash_u32();
        let at = |i: i64| off + along * (i as f64 * step);
        let sway = |i: i64| along.perp() * (7.0 * fractal(at(i), seed, 190.0, 3, 0.5));
        let points: Vec<DVec3> = (-n..=n).map(|i| (at(i) + sway(i)).extend(0.0)).filter(inside).collect();
        let wide = RIDE_HALF_M * rng.range(0.85, 1.3);
        let half_m = |p: DVec3| wide * (1.0 + 0.75 * fractal(p.truncate(), seed ^ 1, 75.0, 2, 0.5));
        let ways = parts(&points, wide);
        all.extend(ways.into_iter().map(|part| Part { half_m: part.ends_m.map(half_m), ..part }));
    }
    all
}

/// Hills worn by water, how wet they are, and the streams on them.
fn worn(relief_m: f64, path: &SeedPath) -> (Raster<f32>, Raster<f32>, Vec<Part>) {
    let seed = path.child("hills").hash_u32();
    let grid = |cell: f64| {
        let n = libm::round(2.0 * HALF_M / cell) as usize + 1;
        Raster::filled(DVec2::splat(-HALF_M), cell, n, n, 0.0_f32)
    };
    // For a relief of 100 m first: stream power is linear in height, and so is what follows.
    let mut z = grid(2.0 * WORN_M);
    let n = z.width;
    z.data = (0..n * n)
        .into_par_iter()
        .map(|k| {
            let q = warp(z.position(k % n, k / n), seed ^ 0x21, 700.0, 220.0);
            (fractal(q, seed, 1150.0, 7, 0.46) * 75.0) as f32
        })
        .collect();
    let mut last = None;
    for (cell, steps, strength) in [(2.0 * WORN_M, 14, 0.034_f32), (WORN_M, 6, 0.016)] {
        if z.cell_m > cell {
            let mut fine = grid(cell);
            for k in 0..fine.data.len() {
                let p = fine.position(k % fine.width, k / fine.width);
                fine.data[k] = (bicubic(&z, p) + fractal(p, seed ^ 0x22, 60.0, 3, 0.6) * 1.3) as f32;
            }
            z = fine;
        }
        let (width, height) = (z.width, z.height);
        let outlet = |p: usize| {
            let (i, j) = (p % width, p / width);
            i == 0 || j == 0 || i == width - 1 || j == height - 1
        };
        for _ in 0..steps {
            let drainage = fill_and_drain(&mut z, seed, outlet);
            let area = drainage.area_m2(cell);
            stream_power(&mut z, &drainage, &area, |_, _| strength);
            diffuse(&mut z, 0.16, outlet);
        }
        let drainage = fill_and_drain(&mut z, seed, outlet);
        let area = drainage.area_m2(cell);
        last = Some((drainage, area));
    }
    let (drainage, area) = last.expect("the list of resolutions is not empty");
    let width = z.width;
    // The stated relief within the stated distance; beyond it hills cannot grow out of bounds.
    let (mut low, mut high) = (f32::MAX, f32::MIN);
    for k in 0..z.data.len() {
        if z.position(k % width, k / width).length() < STATED_WITHIN_M {
            (low, high) = (low.min(z.data[k]), high.max(z.data[k]));
        }
    }
    let (middle, span) = (f64::midpoint(low.into(), high.into()), f64::from(high - low).max(1.0));
    let limit = REACH - 0.5;
    for v in &mut z.data {
        let x = (f64::from(*v) - middle) / span;
        let over = (x.abs() - 0.5).max(0.0);
        let x = x.clamp(-0.5, 0.5) + over / (1.0 + over / limit) * x.signum();
        *v = (x * relief_m) as f32;
    }
    let wet: Vec<f32> = (0..z.data.len())
        .map(|k| {
            let to = drainage.receiver[k] as usize;
            let fall = f64::from(z.data[k] - z.data[to]) / (WORN_M * 1.2) * (60.0 / relief_m);
            let index = libm::log(f64::from(area[k]) / WORN_M / (fall + 0.02));
            smoothstep(6.0, 11.5, index) as f32
        })
        .collect();
    let mut wet = Raster { data: wet, ..z.clone() };
    diffuse(&mut wet, 0.2, |_| false);
    diffuse(&mut wet, 0.2, |_| false);

    let is_stream = |p: usize| area[p] > STREAM_AREA_M2;
    let mut at: Vec<DVec2> = (0..z.data.len()).map(|p| z.position(p % width, p / width)).collect();
    let mut donor = vec![u32::MAX; z.data.len()];
    for &p in drainage.order.iter().rev() {
        let (p, to) = (p as usize, drainage.receiver[p as usize] as usize);
        if to != p && is_stream(p) && (donor[to] == u32::MAX || area[donor[to] as usize] < area[p]) {
            donor[to] = p as u32;
        }
    }
    for _ in 0..6 {
        let old = at.clone();
        for &p in &drainage.order {
            let p = p as usize;
            let to = drainage.receiver[p] as usize;
            if is_stream(p) && to != p && donor[p] != u32::MAX {
                at[p] = old[p] * 0.5 + (old[to] + old[donor[p] as usize]) * 0.25;
            }
        }
    }
    let place = |p: usize| warp(at[p], seed ^ 0x23, 27.0, 6.0).extend(f64::from(z.data[p]));
    let half = |p: usize| (0.25 + 0.0011 * f64::from(area[p]).sqrt()).min(2.6);
    let streams = drainage
        .order
        .iter()
        .map(|p| *p as usize)
        .filter(|p| is_stream(*p) && drainage.receiver[*p] as usize != *p)
        .map(|p| {
            let to = drainage.receiver[p] as usize;
            Part { ends_m: [place(p), place(to)], half_m: [half(p), half(to)] }
        })
        .filter(|s| s.ends_m[0].truncate().distance(s.ends_m[1].truncate()) > 0.05)
        .collect();
    (z, wet, streams)
}

impl Ground for Land {
    fn height_m(&self, p: DVec2) -> f64 {
        let g = self.window.grid_from_world(p);
        let last = (self.window.width - 1) as f64;
        if g.x >= 0.0 && g.y >= 0.0 && g.x <= last && g.y <= last {
            return self.window.bilinear(p);
        }
        self.exact_m(p)
    }
}
