//! Lots along the streets of hills, each with its level pad.

use super::super::layout::{Lot, Rear};
use super::skeleton::{BUILT_M, Crest, Ridge};
use crate::city::california::land::Land;
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::SeedPath;

/// From the middle of a street to a lot's front and to its pad, m.
const FRONT_M: f64 = 8.3;
const PAD_M: f64 = 10.6;
/// Between two pads, m.
const GAP_M: f64 = 4.2;

/// A pad that a street would have, were there room.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) outline: Vec<DVec2>,
    pub(super) height_m: f64,
    /// Middle of its front on the street's middle line, and the direction along the front; the lot lies to its left.
    foot: DVec2,
    axis: DVec2,
    width_m: f64,
    depth_m: f64,
    name: String,
}

/// A place along a ridge: where, along which direction, how high.
fn at(points: &[DVec3], s: f64) -> (DVec2, DVec2, f64) {
    let mut left = s;
    for k in 1..points.len() {
        let (a, b) = (points[k - 1], points[k]);
        let length = a.truncate().distance(b.truncate());
        if left <= length || k + 1 == points.len() {
            let p = a.lerp(b, left / length);
            return (p.truncate(), ((b - a).truncate() / length), p.z);
        }
        left -= length;
    }
    (points[0].truncate(), DVec2::X, points[0].z)
}

/// All pads along a ridge, whether they fit or not. Their numbers count from the ridge's begin.
pub(super) fn candidates(ridge: &Ridge, path: &SeedPath) -> Vec<Candidate> {
    let mut out = Vec::new();
    let key = ridge.index.iter().fold(path.child("lots"), |k, i| k.index(*i as u64));
    let length: f64 = ridge.points.windows(2).map(|p| p[0].truncate().distance(p[1].truncate())).sum();
    let spur = ridge.crest == Crest::Spur;
    for side in [1.0, -1.0] {
        let side_key = key.child(if side > 0.0 { "left" } else { "right" });
        let mut s = if spur { 16.0 } else { 0.0 };
        let mut k = 0;
        while s < length - if spur { 24.0 } else { 30.0 } {
            let mut rng = side_key.index(k).rng();
            let width_m = rng.range(17.5, 22.5);
            let depth_m = rng.range(24.0, 29.0);
            let name =
                format!("{}/{}/{}/{}/{k}", ridge.index[0], ridge.index[1], ridge.index[2], i32::from(side < 0.0));
            // On the inner side of a bend lots are as far apart as their rears need.
            let bend = at(&ridge.points, s).1.perp_dot(at(&ridge.points, s + 24.0).1) / 24.0 * side;
            let share = (1.0 - bend.max(0.0) * (PAD_M + depth_m)).max(0.5);
            let front_m = (width_m + GAP_M) / share;
            out.extend(candidate(ridge, s + front_m / 2.0, side, [width_m, depth_m], name));
            s += front_m;
            k += 1;
        }
    }
    if spur {
        // Around the end: straight ahead, and to both sides of it.
        let end = ridge.points[ridge.points.len() - 1];
        let (_, along, _) = at(&ridge.points, length);
        for (n, turn) in [0.0, 1.2, -1.2].into_iter().enumerate() {
            let mut rng = key.child("end").index(n as u64).rng();
            let (s, c) = libm::sincos(turn);
            let out_of = DVec2::new(c, s).rotate(along);
            let name = format!("{}/{}/{}/end/{n}", ridge.index[0], ridge.index[1], ridge.index[2]);
            let size = [rng.range(15.5, 18.5), rng.range(23.0, 26.0)];
            // The bulb's edge takes the place of the street's.
            let foot = end.truncate() + out_of * 7.6;
            out.push(made(foot, -out_of.perp(), end.z, size, name));
        }
    }
    // Those that no scene looks at are not made.
    out.retain(|c| c.foot.length() < BUILT_M);
    out
}

fn candidate(ridge: &Ridge, s: f64, side: f64, size: [f64; 2], name: String) -> Option<Candidate> {
    let (foot, along, z) = at(&ridge.points, s);
    (foot.length() < BUILT_M + 100.0).then(|| made(foot, along * side, z, size, name))
}

fn made(foot: DVec2, axis: DVec2, height_m: f64, [width_m, depth_m]: [f64; 2], name: String) -> Candidate {
    let middle = foot + axis.perp() * (PAD_M + depth_m / 2.0);
    let outline = polygon::oriented_rectangle(middle, axis, DVec2::new(width_m, depth_m) / 2.0);
    Candidate { outline, height_m, foot, axis, width_m, depth_m, name }
}

/// The lot of a pad that was accepted.
pub(super) fn lot(c: &Candidate, land: &Land, city: &SeedPath) -> Lot {
    let corner = |x: f64, y: f64| land.world(c.foot + c.axis * x + c.axis.perp() * y);
    let (half, far) = (c.width_m / 2.0, PAD_M + c.depth_m);
    let outline = vec![corner(-half, FRONT_M), corner(half, FRONT_M), corner(half, far), corner(-half, far)];
    let name = format!("hill/lot/{}", c.name);
    let key = city.child("hill lot").child(&name);
    Lot { name, key, outline, bulge_m: 0.0, rear: Rear::Fence, hillside: true }
}
