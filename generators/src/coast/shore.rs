//! Where land ends: a contour of noise, distances from it, and how open each place of it is.

use super::{HALF_M, Variant};
use crate::kit::terrain::contour::{contours, resampled};
use crate::kit::terrain::front::{Source, rise};
use crate::kit::terrain::noise::{fractal, warp};
use crate::kit::terrain::sampling::{bicubic, smoothstep};
use glam::DVec2;
use satseed_scene::{Raster, Rng, SeedPath};

/// Distance of posts, m.
const CELL_M: f64 = 4.0;
/// Half the side of the square whose share of land is drawn, m: a frame of 2048 pixels of 0.3 m.
const FRAME_HALF_M: f64 = 307.0;
/// Distances from the shore beyond this are all told as this, m.
const FAR_M: f64 = 1500.0;

/// The shore of one coast.
pub(super) struct Shore {
    /// Unit direction from land to sea.
    pub(super) out: DVec2,
    /// Distance from the shore, m, positive on land.
    inland: Raster<f32>,
    /// How sandy the nearest shore is, 0 rock to 1 beach.
    sandy: Raster<f32>,
    /// Distance along the shore, m.
    along: Raster<f32>,
}

/// A place as the shore sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Distance from the shore, m, positive on land.
    pub(super) inland_m: f64,
    /// 0 where the nearest shore is rock, 1 where it is a beach.
    pub(super) sandy: f64,
    /// Distance along the shore, m; of use near it alone, since it jumps where two shores are equally near.
    pub(super) along_m: f64,
}

/// The plan of a beach.
enum Bow {
    /// Nearly straight.
    Straight,
    /// One bay, or one bulge, as wide as the frame; how deep, m, positive for a bay, and where its middle lies.
    Bay { deep_m: f64, middle_m: f64 },
    /// Bays in a row with horns between them.
    Cuspate { deep_m: f64, apart_m: f64, shift: f64 },
}

impl Bow {
    fn drawn(rng: &mut Rng) -> Self {
        match rng.below(3) {
            0 => Self::Straight,
            1 => Self::Bay {
                deep_m: rng.range(25.0, 70.0) * if rng.chance(0.7) { 1.0 } else { -0.7 },
                middle_m: rng.signed() * 160.0,
            },
            _ => Self::Cuspate { deep_m: rng.range(11.0, 20.0), apart_m: rng.range(170.0, 320.0), shift: rng.unit() },
        }
    }

    /// How far the shore lies landward at a place along it, m.
    fn landward_m(&self, along_m: f64) -> f64 {
        match *self {
            Self::Straight => 0.0,
            Self::Bay { deep_m, middle_m } => {
                let t = (along_m - middle_m) / 300.0;
                -deep_m * t * t / (1.0 + 0.25 * t * t)
            }
            Self::Cuspate { deep_m, apart_m, shift } => {
                let s = libm::sin(core::f64::consts::PI * (along_m / apart_m + shift));
                deep_m * f64::sqrt(s * s + 0.04)
            }
        }
    }
}

fn grid() -> Raster<()> {
    let n = (2.0 * HALF_M / CELL_M) as usize + 1;
    Raster::filled(DVec2::splat(-HALF_M), CELL_M, n, n, ())
}

/// Values at every post.
pub(super) fn filled(f: impl Fn(DVec2) -> f64 + Sync) -> Raster<f32> {
    use rayon::prelude::*;
    let shape = grid();
    let rows: Vec<Vec<f32>> = (0..shape.height)
        .into_par_iter()
        .map(|j| (0..shape.width).map(|i| f(shape.position(i, j)) as f32).collect())
        .collect();
    Raster {
        origin_m: shape.origin_m,
        cell_m: shape.cell_m,
        width: shape.width,
        height: shape.height,
        data: rows.concat(),
    }
}

/// Mean over a square of `2 half + 1` posts a side, three times: about a bell.
pub(super) fn blurred(mut values: Raster<f32>, half: usize) -> Raster<f32> {
    for _ in 0..3 {
        for axis in 0..2 {
            let (n, lines) = if axis == 0 { (values.width, values.height) } else { (values.height, values.width) };
            for line in 0..lines {
                let at = |k: i64| {
                    let k = k.clamp(0, n as i64 - 1) as usize;
                    if axis == 0 { line * n + k } else { k * values.width + line }
                };
                let old: Vec<f64> = (0..n as i64).map(|k| f64::from(values.data[at(k)])).collect();
                let from = |k: i64| old[k.clamp(0, n as i64 - 1) as usize];
                let half = half as i64;
                let mut sum: f64 = (-half..=half).map(from).sum();
                for k in 0..n as i64 {
                    values.data[at(k)] = (sum / (2 * half + 1) as f64) as f32;
                    sum += from(k + half + 1) - from(k - half);
                }
            }
        }
    }
    values
}

impl Shore {
    pub(super) fn new(variant: Variant, path: &SeedPath) -> Self {
        let mut rng = match variant {
            Variant::Beach => path.child("front").rng(),
            Variant::Cliff => path.rng(),
        };
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let out = DVec2::new(c, s);
        let seed = |name: &str| path.child(name).hash_u32();
        let (bays, bends, coves) = (seed("bays"), seed("bends"), seed("coves"));
        let bow = Bow::drawn(&mut path.child("bow").rng());
        // Above 0 at sea.
        let level = |p: DVec2| {
            p.dot(out)
                + match variant {
                    Variant::Beach => {
                        let along_m = p.dot(out.perp()) + 60.0 * fractal(p, bays, 480.0, 2, 0.5);
                        bow.landward_m(along_m)
                            + 45.0 * fractal(p, bays, 1400.0, 2, 0.5)
                            + 12.0 * fractal(p, bends, 260.0, 3, 0.45)
                    }
                    Variant::Cliff => {
                        let q = warp(p, bends, 330.0, 60.0);
                        330.0 * fractal(q, bays, 760.0, 2, 0.5) + 95.0 * fractal(q, coves, 190.0, 5, 0.48)
                    }
                }
        };
        let mut sea = filled(level);
        // Below cliffs the sea takes what the noise calls land: platforms, inlets, the cliffs' feet.
        let washed = if variant == Variant::Cliff { 0.06 } else { 0.0 };
        let share = rng.range(0.40, 0.58) + washed;
        // What the filled lakes took from the sea, a second cut gives back to it.
        for _ in 0..2 {
            let cut = quantile(&sea, share);
            for v in &mut sea.data {
                *v -= cut;
            }
            fill_lakes(&mut sea);
        }
        let lines: Vec<Vec<DVec2>> =
            contours(&sea).iter().filter(|l| length(l) > 90.0).map(|l| smoothed(&resampled(l, 3.5))).collect();
        let open = blurred(Raster { data: sea.data.iter().map(|v| f32::from(*v > 0.0)).collect(), ..sea.clone() }, 13);
        let mut sources = Vec::new();
        let mut arc_m = Vec::new();
        let mut sand = Vec::new();
        for line in &lines {
            let mut done = 0.0;
            for pair in line.windows(2) {
                sources.push(Source { ends_m: [pair[0], pair[1]], values_m: [0.0; 2], half_widths_m: [0.0; 2] });
                arc_m.push([done, done + pair[0].distance(pair[1])]);
                done += pair[0].distance(pair[1]);
                sand.push(match variant {
                    Variant::Beach => 1.0,
                    // Sand stays in bays, where less than half of what lies around is sea.
                    Variant::Cliff => smoothstep(0.48, 0.34, bicubic(&open, pair[0])),
                });
            }
        }
        let (distance, nearest) = rise(&sea, &sources, FAR_M);
        // What a source says, at the post nearest to which it stands.
        let told = |f: &dyn Fn(DVec2, usize) -> f64, else_what: f64| -> Raster<f32> {
            let of = |post: usize| {
                let s = nearest.data[post] as usize;
                let p = sea.position(post % sea.width, post / sea.width);
                if s < sources.len() { f(p, s) } else { else_what }
            };
            Raster { data: (0..sea.data.len()).map(|post| of(post) as f32).collect(), ..sea.clone() }
        };
        let sandy = blurred(told(&|_, s| sand[s], 1.0), 9);
        let along = told(
            &|p, s| {
                let t = sources[s].reach(p).1;
                arc_m[s][0] + (arc_m[s][1] - arc_m[s][0]) * t
            },
            0.0,
        );
        // Small islands were left out of the contour, so the sign is that of the side of the nearest segment: the sea lies on
        // its left.
        let side = told(
            &|p, s| {
                let [a, b] = sources[s].ends_m;
                -(b - a).perp_dot(p - a).signum()
            },
            1.0,
        );
        let inland = Raster { data: distance.data.iter().zip(&side.data).map(|(d, s)| d * s).collect(), ..sea.clone() };
        Self { out, inland, sandy, along }
    }

    pub(super) fn at(&self, p: DVec2) -> Place {
        Place {
            inland_m: bicubic(&self.inland, p),
            sandy: self.sandy.bilinear(p).clamp(0.0, 1.0),
            along_m: self.along.bilinear(p),
        }
    }
}

/// The value that a share of the frame's posts is below.
fn quantile(values: &Raster<f32>, share: f64) -> f32 {
    let mut inside: Vec<f32> = (0..values.data.len())
        .filter(|k| values.position(k % values.width, k / values.width).abs().max_element() <= FRAME_HALF_M)
        .map(|k| values.data[k])
        .collect();
    inside.sort_by(f32::total_cmp);
    inside[(inside.len() as f64 * share) as usize]
}

/// Turns what lies above 0 and does not reach the rim, which is a lake and no sea, into land as high as it was deep.
fn fill_lakes(sea: &mut Raster<f32>) {
    let (w, h) = (sea.width, sea.height);
    let mut reached = vec![false; w * h];
    let mut open: Vec<usize> = (0..w * h)
        .filter(|k| k % w == 0 || k % w == w - 1 || k / w == 0 || k / w == h - 1)
        .filter(|k| sea.data[*k] > 0.0)
        .collect();
    while let Some(post) = open.pop() {
        if core::mem::replace(&mut reached[post], true) {
            continue;
        }
        let (i, j) = (post % w, post / w);
        let beside = [
            (i > 0).then(|| post - 1),
            (i + 1 < w).then(|| post + 1),
            (j > 0).then(|| post - w),
            (j + 1 < h).then(|| post + w),
        ];
        open.extend(beside.into_iter().flatten().filter(|next| sea.data[*next] > 0.0 && !reached[*next]));
    }
    for (value, reached) in sea.data.iter_mut().zip(&reached) {
        if *value > 0.0 && !reached {
            *value = -*value;
        }
    }
}

fn length(line: &[DVec2]) -> f64 {
    line.windows(2).map(|p| p[0].distance(p[1])).sum()
}

/// Corners cut twice (Chaikin 1974): no step of the grid is left.
fn smoothed(line: &[DVec2]) -> Vec<DVec2> {
    let closed = line[0] == line[line.len() - 1];
    let mut points = line.to_vec();
    for _ in 0..2 {
        let mut next = Vec::with_capacity(2 * points.len());
        if !closed {
            next.push(points[0]);
        }
        for pair in points.windows(2) {
            next.push(pair[0].lerp(pair[1], 0.25));
            next.push(pair[0].lerp(pair[1], 0.75));
        }
        next.push(if closed { next[0] } else { points[points.len() - 1] });
        points = next;
    }
    points
}
