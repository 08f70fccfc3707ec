//! Swell: a wave from the open sea whose crests bend over the shallows, rise, break and run up the beach.

use super::shore::{blurred, filled};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::{bicubic, smoothstep};
use glam::DVec2;
use satseed_scene::{Raster, SeedPath};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

const GRAVITY: f64 = 9.81;
/// Where the sea counts as deep for the swell's height, m.
const OFFING_M: f64 = 10.0;
/// Height over depth at which a wave breaks.
const BREAKS: f64 = 0.78;

/// One swell.
pub(super) struct Swell {
    period_s: f64,
    height_m: f64,
    /// Time since an arbitrary crest passed an arbitrary line, s.
    travel_s: Raster<f32>,
    jitter: u32,
    groups: u32,
    /// Direction in which it runs off the shore.
    pub(super) towards: DVec2,
}

/// The swell at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    /// Height of the water over its mean level, m.
    pub(super) rise_m: f64,
    /// Place within the wave: 0 on a crest, rising shoreward to 1 on the next.
    pub(super) phase: f64,
    /// 0 unbroken to 1 broken.
    pub(super) broken: f64,
    /// Height it would have over the height at which it breaks.
    pub(super) over: f64,
    /// Height that it has, crest to trough, m.
    pub(super) height_m: f64,
    /// Distance to the next crest, m, about.
    pub(super) length_m: f64,
}

impl Swell {
    /// A swell towards `towards` over a sea of a depth, m (negative on land).
    pub(super) fn new(towards: DVec2, height_m: f64, depth_m: impl Fn(DVec2) -> f64 + Sync, path: &SeedPath) -> Self {
        let mut rng = path.rng();
        let period_s = rng.range(5.5, 8.5);
        // Small bumps of the bottom do not steer a wave much longer than they are.
        let depth = blurred(filled(|p| depth_m(p).clamp(0.25, 40.0)), 2);
        let travel_s = travel(&depth, towards, period_s);
        let seed = |name: &str| path.child(name).hash_u32();
        Self { period_s, height_m, travel_s, jitter: seed("jitter"), groups: seed("groups"), towards }
    }

    pub(super) fn at(&self, p: DVec2, depth_m: f64) -> Wave {
        let travel_s = bicubic(&self.travel_s, p);
        // Crests are long but not endless, and come in groups: noise over time of travel and place along the crest.
        let across = self.towards.perp_dot(p);
        let q = DVec2::new(travel_s * 9.0, across * 0.55);
        let jitter = 0.21 * fractal(q, self.jitter, 75.0, 3, 0.55);
        let group = (0.62 + 1.15 * fractal(q, self.groups, 60.0, 3, 0.55)).clamp(0.12, 1.5);
        let turns = travel_s / self.period_s + jitter;
        let phase = turns - libm::floor(turns);
        let depth = depth_m.max(0.05);
        let shoaled = self.height_m * group * libm::pow((OFFING_M / depth).clamp(0.6, 60.0), 0.25);
        let limit = BREAKS * depth;
        let broken = smoothstep(0.80, 1.05, shoaled / limit);
        let height_m = shoaled.min(limit * (1.0 - 0.35 * broken));
        // Shallow water sharpens crests and steepens their shoreward side.
        let shallow = smoothstep(0.08, 0.7, shoaled / limit);
        let front = 0.5 - 0.17 * shallow - 0.17 * broken;
        let skewed = if phase < front { phase / (2.0 * front) } else { 0.5 + (phase - front) / (2.0 * (1.0 - front)) };
        let raised = 0.5 + 0.5 * libm::cos(core::f64::consts::TAU * skewed);
        let sharp = 1.0 + 2.2 * shallow;
        let crest = libm::pow(raised, sharp);
        // Its mean over a wave, about.
        let mean = 0.5 / (1.0 + 0.36 * (sharp - 1.0));
        let deep = core::f64::consts::TAU / self.period_s;
        let speed = f64::sqrt(GRAVITY * depth.max(0.25) / (1.0 + deep * deep * depth / GRAVITY));
        Wave {
            rise_m: height_m * (crest - mean),
            phase,
            broken,
            over: shoaled / limit,
            height_m,
            length_m: speed * self.period_s,
        }
    }
}

#[cfg(test)]
impl Swell {
    pub(super) fn travel_s(&self, p: DVec2) -> f64 {
        bicubic(&self.travel_s, p)
    }
}

/// Speed of a wave's crest over a depth, m/s (Fenton and `McKee` 1990).
fn speed(depth_m: f64, period_s: f64) -> f64 {
    let deep = GRAVITY * period_s / core::f64::consts::TAU;
    let x = core::f64::consts::TAU / period_s * f64::sqrt(depth_m / GRAVITY);
    deep * libm::pow(libm::tanh(x * f64::sqrt(x)), 2.0 / 3.0)
}

/// Least time from a straight front off the shore to every post, s: the eikonal equation by fast marching (Sethian 1996).
fn travel(depth: &Raster<f32>, towards: DVec2, period_s: f64) -> Raster<f32> {
    let slowness: Vec<f64> = depth.data.iter().map(|d| depth.cell_m / speed(f64::from(*d), period_s)).collect();
    let (w, h) = (depth.width, depth.height);
    let mut time = vec![f64::INFINITY; w * h];
    let mut done = vec![false; w * h];
    let mut heap = BinaryHeap::new();
    let deepest = f64::from(depth.data.iter().copied().fold(0.0, f32::max));
    let offing = speed(deepest, period_s);
    for j in 0..h {
        for i in 0..w {
            let post = j * w + i;
            let on_rim = i == 0 || j == 0 || i + 1 == w || j + 1 == h;
            if on_rim && f64::from(depth.data[post]) > 0.6 * deepest {
                // Positive everywhere, so that bits order as values do.
                time[post] = (depth.position(i, j).dot(towards) + 4000.0) / offing;
                heap.push(Reverse((time[post].to_bits(), post)));
            }
        }
    }
    while let Some(Reverse((_, post))) = heap.pop() {
        if core::mem::replace(&mut done[post], true) {
            continue;
        }
        let (i, j) = ((post % w) as i64, (post / w) as i64);
        for (di, dj) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let (ni, nj) = (i + di, j + dj);
            if ni < 0 || nj < 0 || ni >= w as i64 || nj >= h as i64 {
                continue;
            }
            let next = nj as usize * w + ni as usize;
            if done[next] {
                continue;
            }
            let at = |i: i64, j: i64| {
                if i < 0 || j < 0 || i >= w as i64 || j >= h as i64 {
                    f64::INFINITY
                } else {
                    time[j as usize * w + i as usize]
                }
            };
            let (a, b) = (at(ni - 1, nj).min(at(ni + 1, nj)), at(ni, nj - 1).min(at(ni, nj + 1)));
            let f = slowness[next];
            let t = if (a - b).abs() < f {
                (a + b + f64::sqrt(2.0 * f * f - (a - b) * (a - b))) / 2.0
            } else {
                a.min(b) + f
            };
            if t < time[next] {
                time[next] = t;
                heap.push(Reverse((t.to_bits(), next)));
            }
        }
    }
    Raster { data: time.iter().map(|t| *t as f32).collect(), ..depth.clone() }
}
