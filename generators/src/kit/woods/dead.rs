//! Wood without leaves, and what grows at its foot: snags, logs, stumps, heaps of brush, ferns.

use super::solid::{Ball, Solids, direction, level};
use super::{BARK, LEAVES};
use glam::DVec3;
use satseed_scene::{Mesh, Rng, SeedPath};

fn turn(rng: &mut Rng) -> DVec3 {
    level(rng.range(0.0, core::f64::consts::TAU))
}

/// A standing dead tree with bare limbs, some of them broken.
pub fn snag(height_m: f64, crown_m: f64, path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    let lean = turn(&mut rng) * (0.05 * height_m * rng.unit());
    let at = |z: f64| lean * (z / height_m) + DVec3::Z * z;
    let thick = 0.013 * height_m;
    let broken = rng.chance(0.4);
    let top = height_m * if broken { rng.range(0.55, 0.85) } else { 1.0 };
    b.limb(BARK, at(0.0) - DVec3::Z * 1.2, at(0.5 * top), [thick * 1.2, thick * 0.8], 6);
    b.limb(BARK, at(0.5 * top), at(top), [thick * 0.8, if broken { thick * 0.5 } else { 0.03 }], 5);
    let limbs = 9 + rng.below(9);
    for k in 0..limbs {
        let z = top * rng.range(0.35, 0.97);
        let d = level(k as f64 * 2.4 + rng.signed() * 0.5);
        let long = crown_m * rng.range(0.3, 1.05) * (1.25 - 0.8 * z / top);
        let from = at(z);
        let tip = from + d * long + DVec3::Z * (long * rng.range(0.1, 0.8));
        let r = (0.035 * long + 0.02).min(thick * 0.5);
        b.limb(BARK, from, tip, [r, 0.02], 4);
        for _ in 0..2 + rng.below(4) {
            let s = rng.range(0.35, 0.95);
            let at = from.lerp(tip, s);
            let away = (d + turn(&mut rng) * 0.9 + DVec3::Z * rng.range(-0.1, 0.7)).normalize_or(DVec3::Z);
            b.limb(BARK, at, at + away * (long * rng.range(0.2, 0.5)), [r * 0.5, 0.012], 3);
        }
    }
    b.finish()
}

/// A fallen stem along +x of a length of 1 and a radius of 1 at its thick end, which lies at the origin; instances scale
/// it. Stubs of limbs stand out.
pub fn log(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    let sway = [rng.signed() * 1.2, rng.signed() * 1.2];
    b.limb(BARK, DVec3::ZERO, DVec3::new(0.45, sway[0], 0.1), [1.0, 0.8], 7);
    b.limb(BARK, DVec3::new(0.45, sway[0], 0.1), DVec3::new(1.0, sway[1], 0.0), [0.8, 0.3], 6);
    for _ in 0..4 + rng.below(7) {
        let x = rng.range(0.3, 0.97);
        let d = DVec3::new(0.0, rng.signed(), rng.range(0.0, 1.0)).normalize_or(DVec3::Z);
        let from = DVec3::new(x, sway[0] * (x / 0.45).min(1.0), 0.0);
        b.limb(BARK, from, from + d * rng.range(1.5, 9.0) + DVec3::X * rng.range(0.0, 0.12), [0.25, 0.06], 3);
    }
    b.finish()
}

/// A stump 1 m wide with a level cut 0.7 m above the ground.
pub fn stump(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    b.limb(BARK, DVec3::new(0.0, 0.0, -0.8), DVec3::new(0.0, 0.0, 0.12), [0.72, 0.52], 8);
    let tilt = DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.06;
    b.limb(BARK, DVec3::ZERO, tilt + DVec3::Z * rng.range(0.5, 0.8), [0.5, 0.44], 8);
    for _ in 0..4 + rng.below(3) {
        let d = turn(&mut rng);
        b.limb(BARK, DVec3::Z * 0.2 + d * 0.2, d * rng.range(0.8, 1.2) - DVec3::Z * 0.25, [0.17, 0.06], 4);
    }
    b.finish()
}

/// A heap of cut tops and limbs, about 1 m high and 2.4 m wide, with some leaves left.
pub fn brush(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    for k in 0..46 {
        let out = turn(&mut rng) * (0.85 * rng.unit());
        let high = 0.75 * (1.0 - out.length() / 1.1) * rng.unit();
        let along = (turn(&mut rng) + DVec3::Z * rng.range(-0.25, 0.25)).normalize_or(DVec3::X);
        let half = along * rng.range(0.35, 1.0);
        let middle = out + DVec3::Z * (high + 0.08);
        let r = rng.range(0.018, 0.06);
        b.limb(BARK, middle - half, middle + half, [r, r * 0.6], 3);
        if k % 3 == 0 {
            let up = (DVec3::Z + turn(&mut rng) * 0.8).normalize_or(DVec3::Z);
            b.spray(LEAVES, middle + half * 0.8, up, 0.26, &mut rng);
            b.spray(LEAVES, middle + half * 0.4, up, 0.22, &mut rng);
        }
    }
    b.finish()
}

/// A clump of ferns 1 m wide: fronds that rise and bend over.
pub fn fern(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    let crowns = 1 + rng.below(3);
    for _ in 0..crowns {
        let root = if crowns == 1 { DVec3::ZERO } else { turn(&mut rng) * 0.25 } - DVec3::Z * 0.25;
        let start = rng.range(0.0, core::f64::consts::TAU);
        let fronds = 8 - crowns;
        for k in 0..fronds {
            let d = level(start + core::f64::consts::TAU * (k as f64 + 0.3 * rng.signed()) / fronds as f64);
            let side = DVec3::new(-d.y, d.x, 0.0);
            let long = rng.range(0.32, 0.52);
            let knee = root + d * (0.55 * long) + DVec3::Z * (0.25 + rng.range(0.3, 0.55));
            let tip = knee + d * (0.6 * long) - DVec3::Z * rng.range(0.02, 0.2);
            let half = side * rng.range(0.05, 0.10) - DVec3::Z * 0.03;
            let other = -half - DVec3::Z * 0.06;
            let shade = (DVec3::Z + d * 0.5).normalize();
            b.wedge(LEAVES, [root, knee + half, tip, knee + other], shade);
            b.wedge(LEAVES, [knee, knee + half * 2.0 + d * 0.06, tip, knee + other * 2.0 + d * 0.06], shade);
        }
    }
    b.finish()
}

/// A bush 1 m high and about 1.3 m wide.
pub fn bush(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    let ball = Ball::coarse();
    let lumps = 5 + rng.below(5);
    let start = rng.range(0.0, core::f64::consts::TAU);
    for k in 0..lumps {
        let share = (k as f64 + 0.3) / lumps as f64;
        let out = level(start + k as f64 * 2.4) * (0.48 * share.sqrt() * rng.range(0.8, 1.2));
        let r = rng.range(0.2, 0.31);
        let at = out + DVec3::Z * (0.76 - 0.42 * share + 0.1 * rng.signed()).clamp(0.75 * r, 1.0 - r);
        b.limb(BARK, DVec3::new(0.2 * out.x, 0.2 * out.y, -0.4), at, [0.03, 0.015], 3);
        b.lump(LEAVES, &ball, at, DVec3::new(r, r, 0.85 * r), 0.3, DVec3::Z * 0.3, &mut rng);
        for _ in 0..5 {
            let e = (direction(&mut rng) + out + DVec3::Z * 0.5).normalize_or(DVec3::Z);
            b.spray(LEAVES, at + e * r, e, 0.11, &mut rng);
        }
    }
    b.finish()
}

/// A tree seen from far away only: a few lumps, or cones, of a height and a crown radius.
pub fn far(height_m: f64, crown_m: f64, conical: bool, path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    b.limb(BARK, DVec3::Z * -1.2, DVec3::Z * (0.6 * height_m), [0.2, 0.12], 3);
    if conical {
        for k in 0..4 {
            let t = f64::from(k) / 4.0;
            let z = height_m * (0.28 + 0.66 * t);
            let r = crown_m * (1.0 - t) * rng.range(0.85, 1.1) + 0.15;
            let top = (z + 0.30 * height_m * (1.0 - 0.4 * t)).min(height_m);
            b.limb(LEAVES, DVec3::Z * z, DVec3::Z * top, [r, 0.05], 7);
        }
    } else {
        let ball = Ball::coarse();
        for k in 0..7 {
            let share = (f64::from(k) + 0.1) / 7.0;
            let d = level(f64::from(k) * 2.4 + rng.signed() * 0.4) * (0.66 * crown_m * share.sqrt());
            let r = crown_m * rng.range(0.42, 0.58);
            let at = d + DVec3::Z * (height_m - r - 0.28 * height_m * share * rng.range(0.6, 1.2));
            b.lump(LEAVES, &ball, at, DVec3::new(r, r, r * 1.1), 0.24, DVec3::Z * (0.6 * height_m), &mut rng);
        }
    }
    b.finish()
}
