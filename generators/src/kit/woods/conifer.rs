//! Crowns of whorls: spruces and larches.

use super::solid::{Ball, Solids, level};
use super::{BARK, LEAVES};
use glam::DVec3;
use satseed_scene::{Mesh, Rng, SeedPath};

/// How a crown of whorls is made.
pub(super) struct Form {
    /// Height of the lowest living branch as a share of the tree's.
    pub(super) base: f64,
    /// Whorls of a tree of the largest size.
    pub(super) whorls: u32,
    /// Branches of a whorl.
    pub(super) branches: u32,
    /// Side twigs on each side of a branch.
    pub(super) twigs: u32,
    /// Width of a branch's foliage as a share of its length.
    pub(super) width: f64,
    /// How far a branch's tip hangs below its root, as a share of its length.
    pub(super) droop: f64,
    /// Power of the crown's outline: below 1 it bulges.
    pub(super) taper: f64,
    /// Share of branches that are missing.
    pub(super) gaps: f64,
    /// Whether the stem is hidden in needles.
    pub(super) dense: bool,
}

/// A tree of a height and crown radius, m; `detail` 0 to 1 is how many whorls it has.
pub(super) fn tree(form: &Form, height_m: f64, crown_m: f64, detail: f64, path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = Solids::default();
    let lean = level(rng.range(0.0, core::f64::consts::TAU)) * (height_m * 0.012 * rng.unit());
    let at_height = |z: f64| lean * (z / height_m) + DVec3::Z * z;
    let base = height_m * (form.base + rng.signed() * 0.06);
    let thick = 0.011 * height_m + 0.01;
    b.limb(BARK, at_height(0.0) - DVec3::Z * 1.2, at_height(base), [thick * 1.2, thick * 0.9], 6);
    b.limb(BARK, at_height(base), at_height(height_m * 0.99), [thick * 0.9, 0.02], 4);
    let whorls = (f64::from(form.whorls) * (0.5 + 0.5 * detail)) as u32;
    let uneven = (level(rng.range(0.0, core::f64::consts::TAU)), rng.range(0.0, 0.25));
    let mut turn = rng.range(0.0, core::f64::consts::TAU);
    for w in 0..whorls {
        // Closer together towards the top.
        let t = (f64::from(w) + rng.range(0.0, 0.6)) / f64::from(whorls);
        let rise = 1.0 - (1.0 - t) * (1.0 - 0.25 * t);
        let z = base + (height_m * 0.985 - base) * rise;
        let length = crown_m * libm::pow(1.0 - rise, form.taper) + 0.12 * crown_m.min(1.5);
        // The lowest branches are shaded and shorter.
        let length = length * (0.75 + 0.25 * (6.0 * t).min(1.0));
        let count = form.branches - u32::from(t > 0.75) - u32::from(t > 0.9);
        turn += rng.range(0.3, 0.8);
        for k in 0..count {
            if rng.chance(form.gaps) {
                continue;
            }
            let a = turn + core::f64::consts::TAU * (f64::from(k) + 0.28 * rng.signed()) / f64::from(count);
            let out = level(a);
            let reach = length * rng.range(0.72, 1.12) * (1.0 + uneven.1 * uneven.0.dot(out));
            let root = at_height(z + rng.signed() * 0.15);
            // Young branches near the top rise, old ones hang.
            let droop = form.droop * (1.0 - 1.7 * t) + rng.signed() * 0.08;
            branch(&mut b, form, root, out, reach, droop, if detail < 0.3 { 1 } else { form.twigs }, &mut rng);
        }
    }
    if form.dense {
        let ball = Ball::coarse();
        for t in [0.15, 0.42, 0.68] {
            let z = base + (height_m - base) * t;
            let r = crown_m * (1.0 - t) * 0.42;
            b.lump(
                LEAVES,
                &ball,
                at_height(z),
                DVec3::new(r, r, (height_m - base) * 0.17),
                0.25,
                at_height(z),
                &mut rng,
            );
        }
    }
    let top = at_height(height_m);
    let side = |k: f64| top + level(k) * 0.1 - DVec3::Z * 0.5;
    b.wedge(LEAVES, [side(0.0), side(2.1), side(4.2), top + DVec3::Z * 0.25], DVec3::Z);
    b.finish()
}

/// A fan: a ridge of foliage along the branch, and side twigs that point forward.
#[allow(clippy::too_many_arguments, reason = "a branch has that many sizes")]
fn branch(b: &mut Solids, form: &Form, root: DVec3, out: DVec3, reach: f64, droop: f64, twigs: u32, rng: &mut Rng) {
    let side = DVec3::new(-out.y, out.x, 0.0);
    // Down in an arc, the tip level again.
    let along = |s: f64| root + out * (reach * s) - DVec3::Z * (reach * droop * s * (1.6 - 0.6 * s));
    let half = reach * form.width * 0.5;
    let down = DVec3::Z * (half * 0.55 + 0.04);
    let shade = |lean: f64| (DVec3::Z + out * 0.55 + side * lean).normalize();
    let m = along(0.5);
    b.wedge(LEAVES, [along(0.04), m + side * half - down, along(1.0), m - side * half - down], shade(0.0));
    for k in 0..twigs {
        let s = 0.22 + 0.6 * (f64::from(k) + 0.5 + 0.3 * rng.signed()) / f64::from(twigs);
        for sign in [-1.0, 1.0] {
            let at = along(s);
            let long = half * rng.range(1.1, 1.9) * (1.25 - 0.75 * s);
            let tip = at + (side * sign * 0.86 + out * 0.6) * long - DVec3::Z * (long * rng.range(0.15, 0.45));
            let wide = out * (long * rng.range(0.2, 0.32));
            b.wedge(LEAVES, [at - wide, tip, at + wide, at + (tip - at) * 0.45 - down * 0.9], shade(0.5 * sign));
        }
    }
}
