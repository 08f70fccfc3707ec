//! The height field: rolling ground with what men cut and heaped along the borders.

use super::plan::{Edge, Nearest, Plan};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tiling::Tiling;
use crate::kit::terrain::tin::Ground;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath, quantise_m};

/// Distance of the posts within the full detail, m.
pub(super) const POST_M: f64 = 0.5;
/// Half the width of a lane's tarmac, m.
pub(super) const CARRIAGEWAY_M: f64 = 2.4;
/// Half the distance of a track's ruts, m.
pub(super) const RUT_M: f64 = 0.85;
/// The most that borders and unevenness add to the hills or take from them, m.
pub(super) const DETAIL_LIMIT_M: f64 = 2.0;

/// The finished ground, and what else all parts of a scene ask of a place.
pub(super) struct Relief {
    pub(super) plan: Plan,
    hills_m: f64,
    roughness: f64,
    seeds: Seeds,
    tiling: Tiling,
    radius_m: f64,
    window: Raster<f32>,
}

struct Seeds {
    hills: u32,
    swell: u32,
    rough: u32,
    vigour: u32,
    lodged: u32,
    thin: u32,
}

impl Relief {
    pub(super) fn new(
        plan: Plan,
        tiling: Tiling,
        radius_m: f64,
        hills_m: f64,
        roughness: f64,
        path: &SeedPath,
    ) -> Self {
        let seed = |name: &str| path.child(name).hash_u32();
        let seeds = Seeds {
            hills: seed("hills"),
            swell: seed("swell"),
            rough: seed("rough"),
            vigour: seed("vigour"),
            lodged: seed("lodged"),
            thin: seed("thin"),
        };
        let half_m = tiling.window_half_m;
        let n = libm::round(2.0 * half_m / POST_M) as usize + 1;
        let shape = Raster::filled(DVec2::splat(-half_m), POST_M, n, n, ());
        let empty = Raster::filled(shape.origin_m, POST_M, 1, 1, 0.0_f32);
        let mut relief = Self { plan, hills_m, roughness, seeds, tiling, radius_m, window: empty };
        let rows: Vec<Vec<f32>> = (0..n)
            .into_par_iter()
            .map(|j| (0..n).map(|i| relief.exact_m(shape.position(i, j)) as f32).collect())
            .collect();
        relief.window = Raster { origin_m: shape.origin_m, cell_m: POST_M, width: n, height: n, data: rows.concat() };
        relief
    }

    /// Hills alone: never higher or lower than half the stated relief.
    fn hills(&self, p: DVec2) -> f64 {
        let x = 2.6 * fractal(p, self.seeds.hills, 690.0, 4, 0.4);
        0.5 * self.hills_m * x / f64::sqrt(1.0 + x * x)
    }

    fn exact_m(&self, p: DVec2) -> f64 {
        let near = self.plan.nearest(self.plan.warp.plan(p));
        let (shape, open) = near.map_or((0.0, 1.0), |n| (self.along_border(&n), smoothstep(-0.5, 2.5, n.beyond_m)));
        let swell = fractal(p, self.seeds.swell, 38.0, 3, 0.5) * 0.22;
        let rough = fractal(p, self.seeds.rough, 6.5, 3, 0.6) * 0.10 * open;
        self.hills(p) + self.roughness * (swell + rough) + shape
    }

    /// What lies along a border: banks, ditches, ruts, a lane's camber.
    fn along_border(&self, n: &Nearest) -> f64 {
        let d = n.side_m.abs();
        let fade = smoothstep(0.5, 9.0, n.end_m);
        match self.plan.borders[n.border as usize].edge {
            Edge::Lane => 0.16 * smoothstep(3.2, 2.0, d) - 0.38 * smoothstep(0.9, 0.15, (d - 4.1).abs()) * fade,
            Edge::Track => {
                let rut = smoothstep(0.34, 0.08, (d - RUT_M).abs());
                0.06 * smoothstep(2.4, 1.6, d) - 0.11 * rut * self.roughness.min(1.2)
            }
            Edge::Hedge => 0.28 * smoothstep(2.0, 0.7, d) * fade,
            Edge::Ditch => (0.12 * smoothstep(2.6, 2.0, d) - 1.05 * smoothstep(1.45, 0.35, d)) * fade,
            Edge::Margin => 0.05 * smoothstep(1.1, 0.5, d),
            Edge::Furrow => -0.08 * smoothstep(0.5, 0.1, d) * fade,
        }
    }

    /// Eastward and northward slope, over half a metre.
    pub(super) fn slope(&self, p: DVec2) -> DVec2 {
        let e = 0.5;
        let z = |x: f64, y: f64| self.height_m(p + DVec2::new(x, y));
        DVec2::new(z(e, 0.0) - z(-e, 0.0), z(0.0, e) - z(0.0, -e)) / (2.0 * e)
    }

    /// A place on the lattice: there the ground of a crop is that of the whole, bit for bit.
    pub(super) fn on_lattice(p: DVec2) -> DVec2 {
        DVec2::new(quantise_m(p.x).into(), quantise_m(p.y).into())
    }

    /// A place of the lattice on the ground.
    pub(super) fn on_ground(&self, p: DVec2) -> DVec3 {
        let p = Self::on_lattice(p);
        p.extend(quantise_m(self.height_m(p)).into())
    }

    /// Whether any place within an outline, whose points lie a few metres apart, may lie on a tile of full detail.
    pub(super) fn may_be_detailed(&self, outline: &[DVec2]) -> bool {
        let nothing = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let [low, high] = outline.iter().fold(nothing, |[low, high], p| [low.min(*p), high.max(*p)]);
        let half = DVec2::splat(self.radius_m + self.tiling.layout.tile_m + 16.0);
        low.cmple(half).all() && high.cmpge(-half).all()
    }

    /// Whether a place lies on a tile of full detail.
    pub(super) fn is_detailed(&self, p: DVec2) -> bool {
        let side = self.tiling.layout.tile_m;
        let low = (p / side).floor() * side;
        DVec2::ZERO.clamp(low, low + side).length() <= self.radius_m
    }

    /// How well plants grow, about -1 to 1, in patches of 20 to 80 m.
    pub(super) fn vigour(&self, p: DVec2) -> f64 {
        2.0 * fractal(p, self.seeds.vigour, 72.0, 4, 0.55)
    }

    /// Where wind and rain laid cereals flat, 0 to 1.
    pub(super) fn lodged(&self, p: DVec2) -> f64 {
        smoothstep(0.38, 0.50, fractal(p, self.seeds.lodged, 34.0, 4, 0.55))
    }

    /// Where plants are missing, 0 to 1.
    pub(super) fn thin(&self, p: DVec2) -> f64 {
        smoothstep(0.36, 0.66, fractal(p, self.seeds.thin, 27.0, 4, 0.62))
    }

    /// Factor on roughness.
    pub(super) fn roughness(&self) -> f64 {
        self.roughness
    }

    pub(super) fn tiling(&self) -> &Tiling {
        &self.tiling
    }
}

impl Ground for Relief {
    fn height_m(&self, p: DVec2) -> f64 {
        let g = self.window.grid_from_world(p);
        let last = (self.window.width - 1) as f64;
        if g.x >= 0.0 && g.y >= 0.0 && g.x <= last && g.y <= last {
            return self.window.bilinear(p);
        }
        // Beyond it the same posts, so that no place knows where the window ends.
        let low = g.floor();
        let (u, v) = (g.x - low.x, g.y - low.y);
        let post = |i: f64, j: f64| {
            let p = self.window.origin_m + (low + DVec2::new(i, j)) * POST_M;
            f64::from(self.exact_m(p) as f32)
        };
        let south = post(0.0, 0.0) + (post(1.0, 0.0) - post(0.0, 0.0)) * u;
        let north = post(0.0, 1.0) + (post(1.0, 1.0) - post(0.0, 1.0)) * u;
        south + (north - south) * v
    }
}
