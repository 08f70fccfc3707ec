//! Tracks of vehicles: two ruts that keep to the low ground.

use super::dunes::Dunes;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Distance of a track's points, m.
const STEP_M: f64 = 4.0;
/// How far ahead the driver looks, m.
const AHEAD_M: f64 = 26.0;
/// A track passes within so far of the pivot on each axis, m.
const START_M: f64 = 220.0;
/// Distances from a track beyond this are not told apart, m.
pub(super) const REACH_M: f64 = 3.0;

/// Centre lines of tracks.
pub(super) struct Tracks {
    /// The points of each.
    pub(super) lines: Vec<Vec<DVec2>>,
}

/// Most tracks in a scene: each has a raster channel.
pub(super) const MOST: usize = 3;

impl Tracks {
    /// One to three tracks across a square of half side `half_m`.
    pub(super) fn new(dunes: &Dunes, half_m: f64, path: &SeedPath) -> Self {
        let mut rng = path.rng();
        let count = 1 + rng.below(MOST as u64) as usize;
        let lines = (0..count)
            .map(|k| {
                let mut rng = path.index(k as u64).rng();
                let start = DVec2::new(rng.signed(), rng.signed()) * START_M;
                let heading = rng.range(0.0, core::f64::consts::TAU);
                let mut back = drive(dunes, half_m, start, heading + core::f64::consts::PI);
                back.reverse();
                back.pop();
                back.extend(drive(dunes, half_m, start, heading));
                smoothed(back)
            })
            .collect();
        Self { lines }
    }

    /// Signed distances from one track on the posts near it: calls `set(i, j, distance)` for posts of a grid.
    pub(super) fn distances(
        line: &[DVec2],
        origin_m: DVec2,
        cell_m: f64,
        posts: usize,
        mut set: impl FnMut(usize, usize, f64),
    ) {
        for pair in line.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let along = b - a;
            let low = ((a.min(b) - REACH_M - origin_m) / cell_m).ceil().max(DVec2::ZERO);
            let high = ((a.max(b) + REACH_M - origin_m) / cell_m).floor().min(DVec2::splat(posts as f64 - 1.0));
            if high.x < low.x || high.y < low.y {
                continue;
            }
            for j in low.y as usize..=high.y as usize {
                for i in low.x as usize..=high.x as usize {
                    let p = origin_m + DVec2::new(i as f64, j as f64) * cell_m;
                    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                    let away = p - a - along * t;
                    let side = if along.perp_dot(away) < 0.0 { -1.0 } else { 1.0 };
                    set(i, j, away.length() * side);
                }
            }
        }
    }
}

/// Drives from a place until the square's border, always to where the sand is thinnest ahead.
fn drive(dunes: &Dunes, half_m: f64, start: DVec2, heading: f64) -> Vec<DVec2> {
    let mut p = start;
    let mut heading = heading;
    let mut line = vec![p];
    let most = libm::ceil(6.0 * half_m / STEP_M) as usize;
    while p.abs().max_element() < half_m && line.len() < most {
        let cost = |turn: f64| {
            let (s, c) = libm::sincos(heading + turn);
            let at = |reach: f64| {
                let sand = dunes.sand(p + DVec2::new(c, s) * reach);
                sand.thick_m + 4.0 * (sand.lee - 0.5).clamp(0.0, 2.0)
            };
            at(0.35 * AHEAD_M) + at(AHEAD_M) + at(2.0 * AHEAD_M) + 9.0 * turn * turn
        };
        let turns = [0.0, 0.12, -0.12, 0.3, -0.3, 0.55, -0.55];
        let best = turns.into_iter().min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0.0);
        // A wheel turns slowly.
        heading += (0.35 * best).clamp(-0.11, 0.11);
        let (s, c) = libm::sincos(heading);
        p += DVec2::new(c, s) * STEP_M;
        line.push(p);
    }
    line
}

fn smoothed(mut line: Vec<DVec2>) -> Vec<DVec2> {
    for _ in 0..3 {
        let old = line.clone();
        for k in 1..old.len() - 1 {
            line[k] = old[k] * 0.5 + (old[k - 1] + old[k + 1]) * 0.25;
        }
    }
    line
}
