//! Who grows where: stands of one age and mixture, gaps and clearings in them.

use super::land::Land;
use super::{HALF_M, Params, Variant};
use crate::kit::terrain::noise::{fractal, warp};
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use satseed_scene::{SeedPath, hash_cell, unit_from_hash};

/// Mean side of a stand, m.
const STAND_M: f64 = 165.0;
/// Side of the cells with at most one gap, and with at most one clearing, m.
const GAP_CELL_M: f64 = 31.0;
const CLEARING_CELL_M: f64 = 290.0;
/// Openings are known from as far as this, m.
const OPEN_REACH_M: f64 = 12.0;

/// What a stand is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Grown trees.
    Grown,
    /// A dense young stand.
    Young,
    /// Felled some years ago.
    Cut,
}

/// One stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub(super) kind: Kind,
    /// Shares of the species, in their order.
    pub(super) mix: [f64; 6],
    /// Height that its trees would reach, m.
    pub(super) tallest_m: f64,
    /// Scale of the Weibull distribution of stem diameters, cm.
    pub(super) stem_cm: f64,
    /// Factor on the distance of trees.
    pub(super) apart: f64,
    /// Direction of felling lines and of plantation rows.
    pub(super) along: DVec2,
    /// Share of trees that bark beetles or drought have killed or browned.
    pub(super) sick: f64,
}

impl Stand {
    /// Share of conifers.
    pub(super) fn conifers(&self) -> f64 {
        let sum: f64 = self.mix.iter().sum();
        self.mix[3..].iter().sum::<f64>() / sum
    }
}

/// All stands.
pub(super) struct Stands {
    seed: u32,
    gap_seed: u32,
    across: i32,
    all: Vec<Stand>,
    density: f64,
}

impl Stands {
    pub(super) fn new(land: &Land, params: &Params, path: &SeedPath) -> Self {
        let seed = path.hash_u32();
        let half = libm::ceil(HALF_M / STAND_M) as i32 + 1;
        let across = 2 * half;
        let mut all = Vec::with_capacity((across * across) as usize);
        for j in -half..half {
            for i in -half..half {
                let at = nucleus(i, j, seed) * STAND_M;
                let key = path.index((u64::from(i as u32) << 32) | u64::from(j as u32));
                all.push(stand(land, params, at, &key));
            }
        }
        Self { seed, gap_seed: path.child("gaps").hash_u32(), across, all, density: params.density }
    }

    /// The stand of a place. Borders are ragged.
    pub(super) fn at(&self, p: DVec2) -> &Stand {
        let q = warp(p, self.seed, 70.0, 22.0) / STAND_M;
        let (ci, cj) = (libm::floor(q.x) as i32, libm::floor(q.y) as i32);
        let (mut best, mut found) = (f64::MAX, (ci, cj));
        for dj in -1..=1 {
            for di in -1..=1 {
                let d = nucleus(ci + di, cj + dj, self.seed).distance_squared(q);
                if d < best {
                    (best, found) = (d, (ci + di, cj + dj));
                }
            }
        }
        let index = |k: i32| (k + self.across / 2).clamp(0, self.across - 1);
        &self.all[(index(found.1) * self.across + index(found.0)) as usize]
    }

    /// How far a place lies outside the nearest gap or clearing, m; negative inside.
    pub(super) fn outside_m(&self, p: DVec2) -> f64 {
        let q = warp(p, self.gap_seed, 15.0, 4.0);
        // Clearings have followed the ground and what was felled, and are no discs.
        let wide = warp(q, self.gap_seed ^ 0x3c, 52.0, 17.0);
        let rare = 1.0 / self.density;
        let gaps = self.discs(q, GAP_CELL_M, 0, |draw, size| (draw < 0.36 * rare).then_some(2.2 + 6.2 * size * size));
        let clearings =
            self.discs(wide, CLEARING_CELL_M, 1, |draw, size| (draw < 0.5 * rare).then_some(11.0 + 26.0 * size * size));
        gaps.min(clearings)
    }

    fn discs(&self, p: DVec2, cell_m: f64, salt: i32, radius: impl Fn(f64, f64) -> Option<f64>) -> f64 {
        let c = (p / cell_m).floor();
        let mut nearest = OPEN_REACH_M;
        for dj in -1..=1 {
            for di in -1..=1 {
                let (i, j) = (c.x as i32 + di, c.y as i32 + dj);
                let draw = |k: i32| f64::from(unit_from_hash(hash_cell(i, j, 8 * salt + k, self.gap_seed)));
                if let Some(r) = radius(draw(0), draw(1)) {
                    let centre = DVec2::new(f64::from(i) + draw(2), f64::from(j) + draw(3)) * cell_m;
                    // Longer one way than the other.
                    let (s, c) = libm::sincos(core::f64::consts::PI * draw(4));
                    let d = p - centre;
                    let (u, v) = (d.x * c + d.y * s, d.y * c - d.x * s);
                    let long = 1.0 + 0.5 * draw(5);
                    nearest = nearest.min(DVec2::new(u / long, v * long.sqrt()).length() - r);
                }
            }
        }
        nearest
    }
}

fn nucleus(i: i32, j: i32, seed: u32) -> DVec2 {
    let h = hash_cell(i, j, 0, seed);
    DVec2::new(f64::from(i) + f64::from(h & 0xffff) / 65_536.0, f64::from(j) + f64::from(h >> 16) / 65_536.0)
}

fn stand(land: &Land, params: &Params, at: DVec2, key: &SeedPath) -> Stand {
    let mut rng = key.rng();
    let at = at.clamp(DVec2::splat(-HALF_M), DVec2::splat(HALF_M));
    let (wet, high) = (land.wetness(at), land.elevation(at));
    // Shares of conifer, mixed and broad-leaved stands, of young ones and of clear-cuts.
    let [conifer, mixed, broad, young, cut] = match params.variant {
        Variant::Mixed => [0.17, 0.25, 0.50, 0.05, 0.03],
        Variant::Conifer => [0.66, 0.17, 0.07, 0.06, 0.04],
        Variant::Logged => [0.22, 0.17, 0.25, 0.17, 0.19],
    };
    let more = params.conifers;
    let kind = rng.weighted(&[conifer * more * (0.7 + 0.6 * high), mixed * more.sqrt(), broad, young, cut]);
    let mut vary = |v: f64| v * rng.range(0.35, 1.9);
    let [oak, beech, birch] = [1.0 - 0.5 * wet, 0.5 + 0.7 * high, 0.22 + 0.9 * wet].map(&mut vary);
    let [spruce, pine, larch] = [0.9 + 0.4 * wet, 0.25 + 0.7 * high * (1.0 - wet), 0.16].map(&mut vary);
    let of = |broad: f64, conifer: f64| {
        [oak * broad, beech * broad, birch * broad, spruce * conifer, pine * conifer, larch * conifer]
    };
    let mix = match kind {
        // Planted: one species with a few others in it.
        0 => {
            let lead = rng.weighted(&[0.0, 0.0, 0.0, 0.62, 0.26, 0.12]);
            let mut mix = of(0.05, 0.05);
            mix[lead] += 1.0;
            mix
        }
        1 => of(1.0, 0.75 * more.min(1.5)),
        2 => of(1.0, 0.03 * more),
        _ => of(1.0, (conifer + 0.5 * mixed) * 1.6 * more),
    };
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::PI));
    let age = rng.range(0.0, 1.0);
    Stand {
        kind: match kind {
            3 => Kind::Young,
            4 => Kind::Cut,
            _ => Kind::Grown,
        },
        mix,
        tallest_m: rng.range(27.0, 34.0) + 2.0 * wet,
        stem_cm: 27.0 + 10.0 * age,
        apart: rng.range(0.94, 1.06),
        along: DVec2::new(c, s),
        sick: if rng.chance(0.3) { rng.range(0.05, 0.3) } else { 0.02 },
    }
}

/// Where sickness goes about, 0 to 1: groups of trees.
pub(super) fn sickness(p: DVec2, seed: u32) -> f64 {
    smoothstep(0.12, 0.5, fractal(p, seed, 46.0, 3, 0.6))
}
