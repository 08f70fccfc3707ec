//! Heights: beach, dunes, cliffs, the bottom of the sea, and the water over it.

mod beach;
mod foam;
mod form;
mod rock;
mod ways;

use super::chop::Chop;
use super::notch::notch;
use super::shore::{Place, Shore};
use super::swell::{Swell, Wave};
use super::{Params, Variant, cover};
use crate::kit::terrain::noise::{fractal, ridged};
use crate::kit::terrain::overhang::{Hollow, Slabs};
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
pub(super) use form::Hinterland;
use form::{Form, Spur, spurs};
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath};

/// Distance of the posts within the full detail, m.
pub(super) const POST_M: f64 = 0.5;
/// The most that anything reaches below the water's troughs, m.
pub(super) const ROOT_M: f64 = 6.0;
/// Higher ground than this is never under water, m.
const DRY_M: f64 = 2.5;
/// Posts beyond the full-detail tiles, m, and where among them notches fade: what a crop has in full detail does not depend on
/// its size.
const MARGIN_M: f64 = 16.0;
const FADE_M: [f64; 2] = [2.0, 12.0];
/// Depth of the sea off the shore, m.
const DEEPEST_M: f64 = 14.0;
/// How much breaking waves raise the water's mean level, m.
const SETUP_M: f64 = 0.06;

struct Seeds {
    edge: u32,
    dunes: u32,
    hummocks: u32,
    damp: u32,
    blowouts: u32,
    bars: u32,
    rips: u32,
    hills: u32,
    rolling: u32,
    face: u32,
    joints: u32,
    reefs: u32,
    platform: u32,
    fine: u32,
    cusps: u32,
    track: u32,
    paths: u32,
    streaks: u32,
    patches: u32,
}

/// The finished coast.
pub(super) struct Relief {
    pub(super) shore: Shore,
    pub(super) swell: Swell,
    pub(super) cliffs: bool,
    chop: Chop,
    /// Direction in which the wind blows.
    pub(super) wind: DVec2,
    spurs: Vec<Spur>,
    form: Form,
    seeds: Seeds,
    stacks: SeedPath,
    /// Seeds of what covers the ground, which materials and plants share.
    pub(super) cover_seeds: [u32; cover::NOISES.len()],
    land_height_m: f64,
    roughness: f64,
    swell_m: f64,
    /// Heights within the full-detail tiles and a margin, [`POST_M`] apart: below overhangs, the ground.
    window: Raster<f32>,
    /// The rock over notches.
    pub(super) slabs: Slabs,
    /// Half the side of the square of full-detail tiles, m.
    detail_half_m: f64,
}

/// What stands at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) place: Place,
    /// Height of the land or of the bottom, m.
    pub(super) land_m: f64,
    /// Height of the water, m; far down where there is none.
    pub(super) water_m: f64,
    /// The swell, where there is water.
    pub(super) wave: Option<Wave>,
}

impl Relief {
    /// `window_half_m` is half the side of the full-detail tiles.
    pub(super) fn new(params: &Params, window_half_m: f64, path: &SeedPath) -> Self {
        let cliffs = params.variant == Variant::Cliff;
        let shore = Shore::new(params.variant, &path.child("shore"));
        let seed = |name: &str| path.child(name).hash_u32();
        let seeds = Seeds {
            edge: seed("edge"),
            dunes: seed("dunes"),
            hummocks: seed("hummocks"),
            damp: seed("damp"),
            blowouts: seed("blowouts"),
            bars: seed("bars"),
            rips: seed("rips"),
            hills: seed("hills"),
            rolling: seed("rolling"),
            face: seed("face"),
            joints: seed("joints"),
            reefs: seed("reefs"),
            platform: seed("platform"),
            fine: seed("fine"),
            cusps: seed("cusps"),
            track: seed("track"),
            paths: seed("paths"),
            streaks: seed("streaks"),
            patches: seed("patches"),
        };
        let mut rng = path.child("form").rng();
        let form = Form::drawn(params, cliffs, &mut rng);
        let turned = |d: DVec2, by: f64| {
            let (s, c) = libm::sincos(by);
            d.rotate(DVec2::new(c, s))
        };
        // Swell that came far has turned towards the shore already.
        let towards = turned(-shore.out, rng.signed() * 0.13);
        let wind = turned(towards, rng.signed() * 0.8);
        let chop = Chop::new(wind, form.peak_m, &path.child("chop"));
        let half_m = window_half_m + MARGIN_M;
        let empty = |n| Raster::filled(DVec2::splat(-half_m), POST_M, n, n, 0.0_f32);
        let mut relief = Self {
            swell: Swell::new(
                towards,
                params.swell_m,
                |p| -offing_m(&form, cliffs, &shore.at(p)),
                &path.child("swell"),
            ),
            shore,
            cliffs,
            chop,
            wind,
            spurs: spurs(&path.child("spurs")),
            form,
            seeds,
            stacks: path.child("stacks"),
            cover_seeds: cover::NOISES.map(|name| path.child("cover").child(name).hash_u32()),
            land_height_m: params.relief_m,
            roughness: params.roughness,
            swell_m: params.swell_m,
            window: empty(1),
            slabs: Slabs::none(&empty(1)),
            detail_half_m: window_half_m,
        };
        let n = libm::round(2.0 * half_m / POST_M) as usize + 1;
        let shape = Raster::filled(DVec2::splat(-half_m), POST_M, n, n, ());
        let rows: Vec<Vec<f32>> = (0..n)
            .into_par_iter()
            .map(|j| (0..n).map(|i| relief.exact_m(shape.position(i, j)) as f32).collect())
            .collect();
        let mut window = Raster { data: rows.concat(), ..empty(n) };
        relief.slabs = Slabs::cut(&mut window, |p| relief.notch(p).into_iter().collect());
        relief.window = window;
        relief
    }

    /// The notch at a place.
    fn notch(&self, p: DVec2) -> Option<Hollow> {
        let place = self.shore.at(p);
        // Rock alone, and no farther from the sea than its waves throw stones.
        let strength = smoothstep(0.45, 0.15, place.sandy)
            * smoothstep(FADE_M[1], FADE_M[0], p.abs().max_element() - self.detail_half_m)
            * smoothstep(0.0, 0.3, self.roughness)
            * smoothstep(6.0, 10.0, self.top_m(p));
        if !self.cliffs || strength == 0.0 || place.inland_m.abs() > 40.0 {
            return None;
        }
        let cliff = self.cliff(p, &place);
        let mut notch = notch(p, self.seeds.face ^ 0x2f, cliff.beyond_m, cliff.platform_m, strength)?;
        if self.water(p, notch.floor_m).0 > notch.floor_m {
            // Water has one height a place.
            notch.roof_m = notch.floor_m - 0.5;
        }
        Some(notch)
    }

    /// Whether no notch is within a radius of a place.
    pub(super) fn is_open(&self, p: DVec2, radius_m: f64) -> bool {
        let closed = |q: DVec2| self.notch(q).is_none_or(|n| n.roof_m < n.floor_m);
        let around = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        around.iter().all(|side| closed(p + *side * radius_m))
    }

    /// Land and water at a place.
    pub(super) fn surface(&self, p: DVec2) -> Surface {
        let place = self.shore.at(p);
        let land_m = self.land_m(p, &place);
        let (water_m, wave) = self.water(p, land_m);
        Surface { place, land_m, water_m, wave }
    }

    fn exact_m(&self, p: DVec2) -> f64 {
        let s = self.surface(p);
        s.land_m.max(s.water_m)
    }

    fn water(&self, p: DVec2, land_m: f64) -> (f64, Option<Wave>) {
        if land_m > DRY_M {
            return (-1e3, None);
        }
        let depth = -land_m;
        let wave = self.swell.at(p, depth);
        let chop = self.form.chop_m * self.roughness * smoothstep(-0.1, 1.6, depth);
        // Broken water is rough at all lengths.
        let torn = 0.10
            * self.roughness
            * wave.broken
            * smoothstep(0.1, 0.6, depth)
            * fractal(p, self.seeds.fine ^ 7, 2.6, 3, 0.6);
        let chop = if chop > 0.0 { chop * self.chop.at(p) } else { 0.0 };
        (SETUP_M + wave.rise_m + chop + torn, Some(wave))
    }

    /// Height of the land, m, or of the bottom below the water.
    fn land_m(&self, p: DVec2, place: &Place) -> f64 {
        if self.cliffs { self.rocky_m(p, place) } else { self.sandy_m(p, place) }
    }

    /// Eastward and northward slope of the land or of the water at a place.
    pub(super) fn slope(&self, p: DVec2, water: bool) -> DVec2 {
        let e = 0.3;
        let z = |x: f64, y: f64| {
            let s = self.surface(p + DVec2::new(x, y));
            if water && s.wave.is_some() { s.water_m } else { s.land_m }
        };
        DVec2::new(z(e, 0.0) - z(-e, 0.0), z(0.0, e) - z(0.0, -e)) / (2.0 * e)
    }

    /// How much marram covers a place, 0 to 1.
    pub(super) fn marram(&self, p: DVec2, s: &Surface) -> f64 {
        cover::plants(self, p, s)[0]
    }

    /// How wet the land lies, 0 to 1: hollows that branch and drain.
    pub(super) fn damp(&self, p: DVec2) -> f64 {
        let line = ridged(p, self.seeds.damp, 150.0, 3, 0.42);
        smoothstep(0.10, 0.95, line) * smoothstep(-0.30, 0.25, fractal(p, self.seeds.damp ^ 1, 240.0, 2, 0.5))
    }

    /// The shore on a line square to the coast, from the sea inland; none where there is only one of both.
    pub(super) fn shore_on(&self, line: DVec2) -> Option<DVec2> {
        let at = |k: i32| line + self.shore.out * (600.0 - 2.0 * f64::from(k));
        (0..600).map(at).find(|p| self.shore.at(*p).inland_m >= 0.0)
    }

    /// What grows behind the shore.
    pub(super) fn hinterland(&self) -> Hinterland {
        self.form.hinterland
    }

    /// Mean square slope of waves too short for mesh and bump.
    pub(super) fn slope_variance(&self) -> f64 {
        self.form.slope_variance * self.roughness.max(0.2)
    }

    /// Whether a place lies within the full-detail tiles.
    pub(super) fn is_detailed(&self, p: DVec2) -> bool {
        p.abs().max_element() <= self.detail_half_m
    }

    /// The posts of the full-detail tiles and of a margin around them.
    #[cfg(test)]
    pub(super) fn window(&self) -> &Raster<f32> {
        &self.window
    }
}

/// The smooth bottom before the shore and a plane behind it, m: what steers the swell.
fn offing_m(f: &Form, cliffs: bool, place: &Place) -> f64 {
    let d = place.inland_m;
    if d >= 0.0 {
        return (0.08 * d).min(2.0);
    }
    let y = -d;
    let sand = {
        // Dean (1991), begun where its slope is the foreshore's.
        let begin = 2.0 * f.dean / (3.0 * f.foreshore);
        let begin = begin * begin * begin;
        let root = |x: f64| {
            let c = libm::cbrt(x);
            c * c
        };
        f.dean * (root(y + begin) - root(begin)) + 0.008 * y
    };
    let depth = if cliffs {
        let rock = 1.2 + 0.055 * y;
        rock + (sand - rock) * smoothstep(0.15, 0.85, place.sandy) * smoothstep(160.0, 60.0, y)
    } else {
        sand
    };
    -soft_min(depth, DEEPEST_M, 1.0)
}

/// The smaller of two, rounded where they are within about `k`.
fn soft_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
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
