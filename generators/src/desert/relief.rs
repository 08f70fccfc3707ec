//! The height field: bare ground, dunes, mounds around shrubs, ripples.

use super::dunes::{Dunes, Sand, Slip};
use super::mounds::Mounds;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath};

/// Distance of the posts within the full detail, m.
pub(super) const POST_M: f64 = 0.5;
/// Half the bare ground's rise and fall, m, about.
pub(super) const GROUND_M: f64 = 2.2;
/// Over so much difference in height a slip face and the ground at its toe pass into each other, m: sand that slid runs
/// out over a metre or two.
const TOE_M: f64 = 0.7;
/// The most that all which lies upon the dunes adds or takes, m.
pub(super) const DETAIL_LIMIT_M: f64 = 3.5;

struct Seeds {
    ground: u32,
    swell: u32,
    waves: u32,
    train: u32,
    field: u32,
    lobes: u32,
}

/// The finished ground.
pub(super) struct Relief {
    pub(super) dunes: Dunes,
    pub(super) mounds: Mounds,
    seeds: Seeds,
    roughness: f64,
    /// Height of the dunes' scale, m: what is secondary to them is measured by it.
    dune_m: f64,
    /// Heights within the full-detail tiles, [`POST_M`] apart.
    window: Raster<f32>,
}

/// On which of the two surfaces that meet in a brink.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Face {
    /// Shaped by the wind.
    Body,
    /// Shaped by sliding sand.
    Slip,
}

impl Relief {
    /// `window_half_m` is half the side of the full-detail tiles.
    pub(super) fn new(
        dunes: Dunes,
        window_half_m: f64,
        dune_m: f64,
        roughness: f64,
        plants: f64,
        path: &SeedPath,
    ) -> Self {
        let seed = |name: &str| path.child(name).hash_u32();
        let seeds = Seeds {
            ground: seed("ground"),
            swell: seed("swell"),
            waves: seed("waves"),
            train: seed("train"),
            field: seed("field"),
            lobes: seed("lobes"),
        };
        let mounds = Mounds::new(&dunes, window_half_m, plants, &path.child("mounds"));
        let n = libm::round(2.0 * window_half_m / POST_M) as usize + 1;
        let empty = Raster::filled(DVec2::splat(-window_half_m), POST_M, 1, 1, 0.0_f32);
        let mut relief = Self { dunes, mounds, seeds, roughness, dune_m, window: empty };
        let shape = Raster::filled(DVec2::splat(-window_half_m), POST_M, n, n, ());
        let rows: Vec<Vec<f32>> = (0..n)
            .into_par_iter()
            .map(|j| (0..n).map(|i| relief.exact_m(shape.position(i, j)) as f32).collect())
            .collect();
        relief.window = Raster { origin_m: shape.origin_m, cell_m: POST_M, width: n, height: n, data: rows.concat() };
        relief
    }

    /// The bare ground below the sand.
    pub(super) fn ground_m(&self, p: DVec2) -> f64 {
        fractal(p, self.seeds.ground, 520.0, 4, 0.4) * GROUND_M
    }

    /// Height and which surface is on top.
    pub(super) fn top_m(&self, p: DVec2) -> (f64, Face) {
        let sand = self.dunes.sand(p);
        let ground = self.ground_m(p);
        let body = ground + sand.body_m + self.detail_m(p, &sand);
        let slip = self.dunes.slip(p);
        if slip.height_m + ground <= body - TOE_M - 0.3 {
            return (body, Face::Body);
        }
        let slip_m = slip.height_m + ground + self.lobes_m(p, sand.lee);
        // Where the two meet within the blend, the joint is a curve.
        let blend = toe_blend_m(slip);
        let over = (blend - (slip_m - body).abs()).max(0.0);
        let joint = if over > 0.0 { over * over / (4.0 * blend) } else { 0.0 };
        if slip_m > body { (slip_m + joint, Face::Slip) } else { (body + joint, Face::Body) }
    }

    /// How much of the ground at a place is the slip face, 0 to 1: at a brink all or none, at the toe a part.
    fn slip_share(&self, p: DVec2, face: Face) -> f64 {
        let whole = if face == Face::Slip { 1.0 } else { 0.0 };
        let slip = self.dunes.slip(p);
        let blend = toe_blend_m(slip);
        if blend < 0.05 {
            return whole;
        }
        let sand = self.dunes.sand(p);
        let above = slip.height_m + self.lobes_m(p, sand.lee) - sand.body_m - self.detail_m(p, &sand);
        (0.5 + 0.5 * above / blend).clamp(0.0, 1.0)
    }

    /// How much of a place fresh sand from a slip face covers, 0 to 1: ragged where tongues of it run out.
    pub(super) fn fresh(&self, p: DVec2, sand: &Sand) -> f64 {
        let above = self.dunes.slip_m(p) - sand.body_m;
        if above < -0.3 {
            return 0.0;
        }
        let down = self.dunes.last_wind;
        let q = DVec2::new(down.dot(p) * 0.3, down.perp_dot(p));
        smoothstep(0.1, 1.0, above + 0.8 * fractal(q, self.seeds.lobes ^ 1, 3.6, 2, 0.6))
    }

    fn exact_m(&self, p: DVec2) -> f64 {
        self.top_m(p).0
    }

    /// Ripples, hummocks and mounds; nothing of them near a brink and in the lee.
    fn detail_m(&self, p: DVec2, sand: &Sand) -> f64 {
        let open = smoothstep(0.9, 0.25, sand.lee).max(smoothstep(2.5, 5.0, sand.lee));
        if open == 0.0 {
            return 0.0;
        }
        let rough = self.roughness;
        let on_dunes = smoothstep(0.12, 0.45, sand.thick_m / self.dune_m);
        let q = self.dunes.in_wind(p);
        // Low waves across the wind on the backs of large dunes.
        let swell = fractal(DVec2::new(q.x, q.y * 0.3), self.seeds.swell, 1.9 * self.dune_m.max(6.0), 2, 0.45)
            * (0.032 * self.dune_m)
            * on_dunes;
        let waves = fractal(p, self.seeds.waves, 7.0, 4, 0.55) * (0.10 - 0.05 * on_dunes);
        let (share, height) = self.ripples(p, q, sand);
        (rough * (swell + waves + height * share) + self.mounds.height_m(p)) * open
    }

    /// How much of the ground megaripples cover here, 0 to 1, and their height, m.
    fn ripples(&self, p: DVec2, q: DVec2, sand: &Sand) -> (f64, f64) {
        let share = self.ripple_field(p, sand);
        if share == 0.0 {
            return (0.0, 0.0);
        }
        // Trains of nearly even length whose phases wander: where two trains meet, crests fork.
        let length_m = 3.3;
        let wander = |salt: u32| fractal(DVec2::new(q.x, q.y * 0.6), self.seeds.train ^ salt, 26.0, 2, 0.5) * 0.9;
        let wave = |salt: u32| {
            let turns = q.x / length_m + wander(salt);
            let t = turns - libm::floor(turns);
            // Rising over two thirds, falling over one.
            if t < 0.64 { smoothstep(0.0, 0.64, t) } else { smoothstep(1.0, 0.64, t) }
        };
        let blend = smoothstep(-0.15, 0.15, fractal(p, self.seeds.train ^ 2, 22.0, 2, 0.5));
        let (a, b) = (wave(0x11), wave(0x22));
        (share, 0.24 * (a + (b - a) * blend - 0.5))
    }

    /// Fields of megaripples: on sheets of sand and at the dunes' feet, in patches.
    pub(super) fn ripple_field(&self, p: DVec2, sand: &Sand) -> f64 {
        let thin = smoothstep(0.30, 0.12, sand.thick_m / self.dune_m) * smoothstep(0.8, 0.3, sand.lee);
        if thin == 0.0 {
            return 0.0;
        }
        thin * smoothstep(0.02, 0.22, fractal(p, self.seeds.field, 95.0, 4, 0.55))
    }

    /// Tongues of sand that slid last.
    fn lobes_m(&self, p: DVec2, lee: f64) -> f64 {
        let down = self.dunes.last_wind;
        let q = DVec2::new(down.dot(p) * 0.2, down.perp_dot(p));
        fractal(q, self.seeds.lobes, 2.6, 2, 0.5) * (0.07 * self.roughness) * smoothstep(1.2, 3.0, lee)
    }

    /// Eastward and northward slope of the ground at a place, on one of the two surfaces where it is an edge.
    pub(super) fn slope(&self, p: DVec2, face: Face) -> DVec2 {
        let share = self.slip_share(p, face);
        let part = |face: Face, share: f64| if share > 0.0 { self.slope_of(p, face) * share } else { DVec2::ZERO };
        part(Face::Body, 1.0 - share) + part(Face::Slip, share)
    }

    fn slope_of(&self, p: DVec2, face: Face) -> DVec2 {
        let e = match face {
            Face::Body => 0.35,
            Face::Slip => 0.8,
        };
        let lee = self.dunes.sand(p).lee;
        let in_wind = lee < 1.12;
        // The cones of a brink fall on both sides of it: the slip face is asked for where only one of them is near.
        let p = if face == Face::Slip && lee < 2.2 { p + self.dunes.toward_lee(p) * (1.5 * e) } else { p };
        let z = |x: f64, y: f64| {
            let p = p + DVec2::new(x, y);
            let ground = self.ground_m(p);
            match face {
                Face::Slip => ground + self.dunes.slip_m(p) + self.lobes_m(p, self.dunes.sand(p).lee),
                // At a brink the windward side goes on beyond it.
                Face::Body if in_wind => {
                    let sand = self.dunes.sand(p);
                    ground + self.dunes.windward_m(p) + self.detail_m(p, &sand)
                }
                Face::Body => {
                    let sand = self.dunes.sand(p);
                    ground + sand.body_m + self.detail_m(p, &sand)
                }
            }
        };
        DVec2::new(z(e, 0.0) - z(-e, 0.0), z(0.0, e) - z(0.0, -e)) / (2.0 * e)
    }

    /// The stated height of the dunes, m.
    #[cfg(test)]
    pub(super) fn dune_m(&self) -> f64 {
        self.dune_m
    }

    /// The posts of the full-detail tiles.
    #[cfg(test)]
    pub(super) fn window(&self) -> &Raster<f32> {
        &self.window
    }
}

/// Difference in height over which a slip face passes into the ground below it, m: none at its brink.
fn toe_blend_m(slip: Slip) -> f64 {
    TOE_M * smoothstep(0.3, 2.2, slip.fallen_m)
}

impl Ground for Relief {
    fn height_m(&self, p: DVec2) -> f64 {
        let g = self.window.grid_from_world(p);
        let last = (self.window.width - 1) as f64;
        if g.x >= 0.0 && g.y >= 0.0 && g.x <= last && g.y <= last {
            return self.window.bilinear(p);
        }
        self.exact_m(p)
    }
}
