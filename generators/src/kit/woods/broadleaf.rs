//! Crowns of lobes: broad-leaved trees and pines.

use super::solid::{Ball, Solids, direction, level};
use super::{BARK, LEAVES};
use glam::DVec3;
use satseed_scene::{Mesh, SeedPath};

/// Turn between one lobe, cluster or limb and the next: the golden angle, radians.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// How a crown of lobes is made.
pub(super) struct Form {
    /// Crown's depth as a share of the height.
    pub(super) depth: f64,
    /// Lobes of a crown of the largest size.
    pub(super) lobes: u32,
    /// Radius of a lobe as a share of the crown's.
    pub(super) lobe: f64,
    /// Height of a lobe as a share of its width.
    pub(super) flat: f64,
    /// How much lower than the top the rim stands, as a share of the depth.
    pub(super) fall: f64,
    /// Clusters of a lobe.
    pub(super) clusters: u32,
    /// Radius of a cluster as a share of its lobe's.
    pub(super) cluster: f64,
    /// Share of clusters that are missing.
    pub(super) gaps: f64,
    /// How ragged clusters are.
    pub(super) jag: f64,
    /// Whether lobes have a dense inside.
    pub(super) dense: bool,
    /// Sprays that stand out of a cluster, and their size as a share of its radius.
    pub(super) sprays: (u32, f64),
}

struct Lobe {
    centre: DVec3,
    radius: f64,
}

/// A tree of a height and crown radius, m; `detail` 0 to 1 is how many lobes and clusters it has.
pub(super) fn tree(form: &Form, height_m: f64, crown_m: f64, detail: f64, path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    let (fine, coarse) = (Ball::fine(), Ball::coarse());
    let depth = height_m * form.depth;
    let lean = level(rng.range(0.0, core::f64::consts::TAU)) * (height_m * 0.02 * rng.unit());
    let at_height = |z: f64| lean * (z / height_m) + DVec3::Z * z;
    // An uneven outline: the crown reaches farther out to some sides.
    let sides: Vec<(DVec3, f64)> =
        (0..3).map(|_| (level(rng.range(0.0, core::f64::consts::TAU)), rng.range(-0.22, 0.16))).collect();
    let uneven = |d: DVec3| 1.0 + sides.iter().map(|(s, k)| k * s.dot(d).max(0.0)).sum::<f64>();

    let count = (f64::from(form.lobes) * (0.45 + 0.55 * detail) + rng.range(-1.0, 1.0)).max(2.0) as u32;
    let turn = rng.range(0.0, core::f64::consts::TAU);
    let lobes: Vec<Lobe> = (0..count)
        .map(|k| {
            let share = (f64::from(k) + 0.25) / (f64::from(count) - 0.75);
            let d = level(turn + f64::from(k) * GOLDEN + rng.signed() * 0.35);
            let radius = crown_m * form.lobe * rng.range(0.78, 1.2);
            let out = ((1.08 * crown_m - radius).max(0.1 * crown_m) * share.sqrt() * rng.range(0.85, 1.12) * uneven(d))
                .max(0.0);
            let rim = out / crown_m;
            let top = height_m - depth * form.fall * (rim * rim * 1.5 + rng.range(0.0, 0.22) * f64::from(k.min(1)));
            let z = (top - radius * form.flat).max(height_m - depth + radius * 0.5);
            Lobe { centre: at_height(z) + d * out, radius }
        })
        .collect();

    let fork = at_height(height_m - depth * 0.92);
    let thick = 0.012 * height_m + 0.022 * crown_m;
    b.limb(BARK, at_height(0.0) - DVec3::Z * 1.2, fork, [thick * 1.15, thick * 0.75], 6);
    let middle = at_height(height_m - depth * 0.75);
    for (k, lobe) in lobes.iter().enumerate() {
        let from = if k == 0 { fork - DVec3::Z * (0.2 * thick) } else { fork.lerp(lobes[0].centre, 0.3 * rng.unit()) };
        let to = lobe.centre;
        let bend = from.lerp(to, 0.55) + (to - from).with_z(0.0) * 0.12 - DVec3::Z * (0.05 * (to - from).length());
        b.limb(BARK, from, bend, [thick * if k == 0 { 0.7 } else { 0.42 }, thick * 0.28], 4);
        b.limb(BARK, bend, to, [thick * 0.28, 0.03], 3);
        if form.dense {
            let r = DVec3::new(1.0, 1.0, form.flat) * (lobe.radius * 0.80);
            b.lump(LEAVES, &coarse, lobe.centre, r, 0.25, middle, &mut rng);
        }
    }
    let per_lobe = (f64::from(form.clusters) * (0.6 + 0.4 * detail)) as u32;
    for (k, lobe) in lobes.iter().enumerate() {
        let turn = rng.range(0.0, core::f64::consts::TAU);
        let out = (lobe.centre - middle).normalize_or(DVec3::Z);
        for c in 0..per_lobe {
            // From the lobe's top down to somewhat below its equator, as evenly as a sunflower's seeds.
            let z = 1.0 - 1.45 * (f64::from(c) + 0.4) / f64::from(per_lobe);
            let r = f64::sqrt((1.0 - z * z).max(0.0));
            let d = (level(turn + f64::from(c) * GOLDEN) * r + DVec3::Z * z + direction(&mut rng) * 0.22 + out * 0.2)
                .normalize_or(DVec3::Z);
            let at = lobe.centre + d * DVec3::new(1.0, 1.0, form.flat) * (lobe.radius * rng.range(0.72, 1.0));
            let hidden = lobes.iter().enumerate().any(|(n, o)| {
                let q = (at - o.centre) / DVec3::new(1.0, 1.0, form.flat);
                n != k && q.length() < 0.62 * o.radius
            });
            let radius = (lobe.radius * form.cluster * rng.range(0.7, 1.3)).max(0.16);
            if hidden || rng.chance(form.gaps) {
                continue;
            }
            let ball = if radius > 0.3 { &fine } else { &coarse };
            let radii = DVec3::new(1.0, 1.0, rng.range(0.62, 0.9)) * radius;
            b.lump(LEAVES, ball, at, radii, form.jag, middle, &mut rng);
            let (sprays, size) = form.sprays;
            for _ in 0..sprays {
                let e = (direction(&mut rng) + d * 0.9).normalize_or(d);
                b.spray(LEAVES, at + e * radii * rng.range(0.85, 1.15), e, (radius * size).clamp(0.12, 0.3), &mut rng);
            }
        }
    }
    b.finish()
}
