//! Heights: beach, dunes, cliffs, the bottom of the sea, and the water over it.

use super::chop::Chop;
use super::shore::{Place, Shore};
use super::swell::{Swell, Wave};
use super::{Params, Variant, dress};
use crate::kit::scatter::Cell;
use crate::kit::terrain::noise::{blocks, fractal, ridged};
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath};

/// Distance of the posts within the full detail, m.
pub(super) const POST_M: f64 = 0.5;
/// The most that anything reaches below the water's troughs, m.
pub(super) const ROOT_M: f64 = 6.0;
/// Higher ground than this is never under water, m.
const DRY_M: f64 = 2.5;
/// Depth of the sea off the shore, m.
const DEEPEST_M: f64 = 14.0;
/// Side of the cells in which at most one stack stands, m.
const STACK_CELL_M: f64 = 46.0;
/// How much breaking waves raise the water's mean level, m.
const SETUP_M: f64 = 0.06;

/// The numbers of one coast.
struct Form {
    /// Slope of the foreshore.
    foreshore: f64,
    /// Height of the berm, m.
    berm_m: f64,
    /// Dean's factor, m^(1/3).
    dean: f64,
    /// Distances of the bars from the shore, m, and their heights, m.
    bars: [[f64; 2]; 2],
    /// Where the dunes begin, m inland.
    toe_m: f64,
    /// Height of the dunes over the back of the beach, m.
    dune_m: f64,
    /// Where the track behind the shore runs, m inland.
    track_m: f64,
    /// Thickness of the rock's beds, m, and how they dip.
    bed_m: f64,
    dip: DVec2,
    /// Significant height of the wind's waves, m.
    chop_m: f64,
    /// Mean square slope of waves too short for mesh and bump: most of the whole (Cox and Munk 1954).
    slope_variance: f64,
    /// Distance of paths to the beach, m.
    paths_m: f64,
}

struct Seeds {
    edge: u32,
    dunes: u32,
    hummocks: u32,
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
    form: Form,
    seeds: Seeds,
    stacks: SeedPath,
    /// Seeds of what covers the ground, which materials and plants share.
    pub(super) cover_seeds: [u32; dress::NOISES.len()],
    land_height_m: f64,
    roughness: f64,
    swell_m: f64,
    /// Heights within the full-detail tiles, [`POST_M`] apart.
    window: Raster<f32>,
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
        let (berm_m, foreshore) = (rng.range(1.7, 2.5), rng.range(0.065, 0.105));
        let toe_m = berm_m / foreshore + rng.range(16.0, 38.0);
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        // The wind, m/s, and the young sea that it makes.
        let wind_m_s = rng.range(4.0, 8.0);
        let peak_m = 2.0 + 0.85 * wind_m_s;
        let form = Form {
            foreshore,
            berm_m,
            dean: rng.range(0.09, 0.14),
            bars: [[rng.range(38.0, 62.0), rng.range(0.4, 0.8)], [rng.range(105.0, 150.0), rng.range(0.8, 1.4)]],
            toe_m,
            dune_m: (0.25 * params.relief_m).clamp(1.5, 9.0),
            track_m: toe_m + rng.range(110.0, 170.0),
            bed_m: rng.range(1.8, 3.6),
            dip: DVec2::new(c, s) * rng.range(0.02, 0.16),
            chop_m: 0.042 * wind_m_s,
            slope_variance: 0.7 * (0.003 + 0.00512 * wind_m_s),
            paths_m: rng.range(120.0, 210.0),
        };
        let turned = |d: DVec2, by: f64| {
            let (s, c) = libm::sincos(by);
            d.rotate(DVec2::new(c, s))
        };
        let towards = turned(-shore.out, rng.signed() * 0.42);
        let wind = turned(towards, rng.signed() * 0.8);
        let chop = Chop::new(wind, peak_m, &path.child("chop"));
        let empty = |n| Raster::filled(DVec2::splat(-window_half_m), POST_M, n, n, 0.0_f32);
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
            form,
            seeds,
            stacks: path.child("stacks"),
            cover_seeds: dress::NOISES.map(|name| path.child("cover").child(name).hash_u32()),
            land_height_m: params.relief_m,
            roughness: params.roughness,
            swell_m: params.swell_m,
            window: empty(1),
        };
        let n = libm::round(2.0 * window_half_m / POST_M) as usize + 1;
        let shape = Raster::filled(DVec2::splat(-window_half_m), POST_M, n, n, ());
        let rows: Vec<Vec<f32>> = (0..n)
            .into_par_iter()
            .map(|j| (0..n).map(|i| relief.exact_m(shape.position(i, j)) as f32).collect())
            .collect();
        relief.window = Raster { data: rows.concat(), ..empty(n) };
        relief
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

    /// Ragged distance inland: the shore itself is smooth.
    fn inland_m(&self, p: DVec2, place: &Place, wavelength_m: f64, by_m: f64) -> f64 {
        place.inland_m + by_m * fractal(p, self.seeds.edge, wavelength_m, 4, 0.55)
    }

    /// The beach from the bars to the back of the berm.
    fn beach_m(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        let d = self.inland_m(p, place, 90.0, 3.0);
        if d < 0.0 {
            let mut z = offing_m(f, false, &Place { inland_m: d, ..*place });
            let wander = 26.0 * fractal(p, self.seeds.bars, 240.0, 2, 0.5);
            for (k, [at_m, height_m]) in f.bars.iter().enumerate() {
                let gaps = smoothstep(-0.28, 0.05, fractal(p, self.seeds.rips ^ k as u32, 170.0, 2, 0.5));
                let t = (-d - at_m - wander * (0.5 + 0.7 * k as f64)) / (0.24 * at_m);
                z += height_m * gaps * libm::exp(-t * t);
            }
            return z + 0.06 * fractal(p, self.seeds.fine, 9.0, 3, 0.5) * smoothstep(0.0, 12.0, -d);
        }
        // Cusps: horns and bays on the upper foreshore.
        let turns = place.along_m / 24.0 + 1.2 * fractal(p, self.seeds.cusps, 130.0, 2, 0.5);
        let at_m = f.berm_m / f.foreshore;
        let cusps = 0.20
            * libm::cos(core::f64::consts::TAU * turns)
            * smoothstep(0.1, 0.55, d / at_m)
            * smoothstep(1.25, 0.8, d / at_m);
        let face = f.foreshore * d;
        let back = f.berm_m - 0.011 * (d - at_m);
        let rough = 0.05 * self.roughness * fractal(p, self.seeds.fine, 5.0, 3, 0.6) * smoothstep(0.6, 1.0, d / at_m);
        soft_min(face, back.max(0.6 * f.berm_m), 0.35) + cusps + rough
    }

    fn sandy_m(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        let beach = self.beach_m(p, place);
        let d = self.inland_m(p, place, 60.0, 7.0) - self.toe_m(p);
        if d < -6.0 {
            return beach;
        }
        let rough = self.roughness;
        // The foredune: a ridge of uneven height along the beach; behind it hummocks and hollows, then a plain that rises.
        let up = smoothstep(-4.0, 15.0, d);
        let ridge = 1.0 - 0.55 * smoothstep(16.0, 60.0, d);
        let uneven = 0.78 + 0.55 * fractal(p, self.seeds.dunes, 70.0, 3, 0.5);
        let hummocks = 0.24 * ridged(p, self.seeds.hummocks, 30.0, 3, 0.34);
        let fine = 0.10 * fractal(p, self.seeds.fine ^ 3, 9.0, 4, 0.55);
        let field = smoothstep(190.0, 110.0, d);
        let hollow = smoothstep(0.22, 0.42, fractal(p, self.seeds.blowouts, 58.0, 3, 0.5)) * smoothstep(2.0, 16.0, d);
        let mut dune = f.dune_m * up * (ridge * uneven + rough * (hummocks + fine));
        dune *= 1.0 - 0.75 * hollow;
        // Paths to the beach lie lower.
        dune *= 1.0 - 0.55 * self.path(p, place).1;
        let plain = 0.6
            + 0.10 * self.land_height_m * smoothstep(60.0, 420.0, d)
            + 0.16 * self.land_height_m * fractal(p, self.seeds.hills, 340.0, 4, 0.42) * smoothstep(90.0, 330.0, d)
            + 0.12 * rough * fractal(p, self.seeds.fine ^ 5, 11.0, 3, 0.5) * smoothstep(60.0, 120.0, d);
        let on_land = dune.max(-0.6) * field.max(0.04) + plain.max(-0.8) * smoothstep(0.0, 70.0, d);
        beach + on_land - 0.10 * self.track(p, place).1
    }

    fn toe_m(&self, p: DVec2) -> f64 {
        self.form.toe_m + 16.0 * fractal(p, self.seeds.dunes ^ 9, 150.0, 2, 0.5)
    }

    /// How much a path to the beach covers a place and how much it cuts into the dune, 0 to 1.
    pub(super) fn path(&self, p: DVec2, place: &Place) -> (f64, f64) {
        let d = place.inland_m;
        if self.cliffs || d < 0.3 * self.form.toe_m || d > self.form.track_m + 6.0 {
            return (0.0, 0.0);
        }
        let wander = 9.0 * fractal(p, self.seeds.paths, 60.0, 2, 0.5) + 0.12 * d;
        let t = (place.along_m + wander) / self.form.paths_m;
        let off = (t - libm::floor(t) - 0.5).abs() * self.form.paths_m;
        let begins = smoothstep(0.55 * self.form.toe_m, 0.9 * self.form.toe_m, d);
        (smoothstep(1.5, 0.7, off) * begins, smoothstep(7.0, 0.5, off) * begins)
    }

    /// The track behind the shore: its two ruts or its whole width, 0 to 1.
    pub(super) fn track(&self, p: DVec2, place: &Place) -> (f64, f64) {
        let wander = 16.0 * fractal(p, self.seeds.track, 260.0, 2, 0.5);
        let at_m = if self.cliffs { 46.0 + 1.1 * self.land_height_m } else { self.form.track_m };
        let off = (place.inland_m - at_m - wander).abs();
        let ruts = smoothstep(0.55, 0.25, (off - 0.85).abs());
        (ruts, smoothstep(2.3, 1.4, off))
    }

    /// Height of the cliff's top, m.
    pub(super) fn top_m(&self, p: DVec2) -> f64 {
        self.land_height_m * (0.80 + 0.62 * fractal(p, self.seeds.hills, 520.0, 2, 0.5)).clamp(0.35, 1.35)
    }

    fn rocky_m(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        let rough = self.roughness;
        let sandy = smoothstep(0.15, 0.85, place.sandy);
        // Joints set the face back in blocks; gullies in tens of metres.
        let (block, _) = blocks(p, self.seeds.joints, 5.5);
        let jag = rough * (6.0 * fractal(p, self.seeds.face, 46.0, 5, 0.55) + 0.9 * block);
        let d = place.inland_m + jag * (1.0 - 0.6 * sandy);
        let low = if sandy > 0.0 { self.beach_m(p, place) } else { 0.0 };
        let rock = self.bottom_m(p, place, d);
        let foot_m = 4.0
            + 6.0 * (fractal(p, self.seeds.platform ^ 1, 70.0, 2, 0.5) + 0.3).max(0.0)
            + sandy * (0.75 * f.berm_m / f.foreshore + 9.0 * fractal(p, self.seeds.platform ^ 2, 45.0, 4, 0.6));
        let base = rock + (low - rock) * sandy;
        let beyond = d - foot_m;
        if beyond < -1.0 {
            return base;
        }
        let top_m = self.top_m(p) * (1.0 - 0.45 * sandy);
        let wide_m = (0.34 + 0.10 * block + 1.15 * sandy) * top_m + 2.0;
        let climb = soft_min(beyond.max(0.0) / wide_m, 1.0, 0.06) * top_m;
        // Beds: a tread and a riser each.
        let bed = (climb + p.dot(f.dip)) / f.bed_m + 0.5 * fractal(p, self.seeds.face ^ 5, 30.0, 2, 0.5);
        let t = bed - libm::floor(bed);
        let stepped = (libm::floor(bed) + smoothstep(0.42, 0.92, t)) * f.bed_m
            - 0.5 * f.bed_m * fractal(p, self.seeds.face ^ 5, 30.0, 2, 0.5)
            - p.dot(f.dip);
        let on_face = smoothstep(0.02, 0.12, climb / top_m)
            * smoothstep(0.995, 0.90, climb / top_m)
            * (1.0 - sandy)
            * smoothstep(-0.35, 0.25, fractal(p, self.seeds.joints ^ 9, 24.0, 3, 0.6));
        let face =
            climb + (stepped - climb) * on_face + rough * on_face * 0.55 * fractal(p, self.seeds.fine, 3.2, 4, 0.6);
        let inland = (beyond - wide_m).max(0.0);
        let land = smoothstep(0.0, 30.0, inland)
            * (0.12 * self.land_height_m * fractal(p, self.seeds.rolling, 190.0, 4, 0.45)
                + 0.16 * rough * fractal(p, self.seeds.fine ^ 5, 9.0, 4, 0.5))
            + 0.035 * inland.min(420.0);
        base.max(0.3 * sandy) + face + land - 0.10 * self.track(p, place).1
    }

    /// Rock below and around the waterline: bottom, reefs, platform and stacks.
    fn bottom_m(&self, p: DVec2, place: &Place, d: f64) -> f64 {
        let rough = self.roughness.max(0.25);
        let y = (-d).max(0.0);
        let mut z = offing_m(&self.form, true, &Place { inland_m: d, ..*place });
        let near = smoothstep(120.0, 6.0, y);
        let reefs = ridged(p, self.seeds.reefs, 44.0, 5, 0.55);
        z += rough * near * (3.4 * (reefs - 0.1).max(-0.3) + 0.5 * fractal(p, self.seeds.fine, 7.0, 4, 0.6));
        // Platforms that the sea has planed, awash.
        let wide = 20.0 * smoothstep(-0.1, 0.4, fractal(p, self.seeds.platform, 120.0, 3, 0.5));
        let plane = 0.35 - 0.03 * y
            + rough
                * (0.42 * fractal(p, self.seeds.platform ^ 3, 8.0, 4, 0.6)
                    + 0.2 * blocks(p, self.seeds.joints ^ 3, 2.6).0);
        z += (plane.max(z) - z) * smoothstep(wide, wide - 5.0, y) * f64::from(wide > 1.0);
        // Boulders and shelves at the foot.
        if d > -6.0 {
            z = z.max(-1.1 + 0.28 * (d + 6.0) + rough * 0.5 * fractal(p, self.seeds.fine ^ 1, 4.0, 4, 0.6)).min(2.2);
        }
        let cell = |x: f64| libm::floor(x / STACK_CELL_M) as i32;
        for dj in -1..=1 {
            for di in -1..=1 {
                z = z.max(self.stack_m(p, Cell { at: (cell(p.x) + di, cell(p.y) + dj), side_m: STACK_CELL_M }));
            }
        }
        z
    }

    /// Height of a cell's stack at a place, far down where it has none.
    fn stack_m(&self, p: DVec2, cell: Cell) -> f64 {
        if cell.draw(self.seeds.joints ^ 0x4d) > 0.22 {
            return -1e3;
        }
        let mut rng = cell.key(&self.stacks).rng();
        let at = cell.point(rng.range(0.25, 0.75), rng.range(0.25, 0.75));
        let (radius, share) = (rng.range(2.5, 9.5), rng.range(0.1, 0.8));
        let apart = p.distance(at);
        if apart > radius + 16.0 {
            return -1e3;
        }
        let place = self.shore.at(at);
        if place.inland_m > -radius - 7.0 || place.inland_m < -75.0 || place.sandy > 0.35 {
            return -1e3;
        }
        let top = 1.0 + share * share * self.top_m(at);
        let (block, _) = blocks(p, self.seeds.joints, 3.7);
        let r = apart + self.roughness.max(0.3) * (3.0 * fractal(p, self.seeds.face ^ 2, 14.0, 4, 0.6) + 0.7 * block);
        let z = top - 0.18 * r - 3.2 * (r - 0.72 * radius).max(0.0);
        let bed = (z + p.dot(self.form.dip)) / self.form.bed_m;
        let stepped =
            (libm::floor(bed) + smoothstep(0.5, 0.95, bed - libm::floor(bed))) * self.form.bed_m - p.dot(self.form.dip);
        z + 0.7 * (stepped - z)
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

    /// How far up the last wave ran, m above the mean sea.
    pub(super) fn runup_m(&self, p: DVec2, place: &Place) -> f64 {
        let lobes = fractal(DVec2::new(place.along_m, 0.0) + p * 0.15, self.seeds.cusps ^ 5, 42.0, 3, 0.5);
        (0.30 + 0.34 * self.swell_m) * (0.75 + 1.1 * lobes).clamp(0.15, 1.5)
    }

    /// Foam on the water: fresh and dense, and old and loose, 0 to 1 each.
    pub(super) fn foam(&self, p: DVec2, s: &Surface) -> [f64; 2] {
        let Some(wave) = s.wave else { return [0.0; 2] };
        let depth = s.water_m - s.land_m;
        if depth <= 0.0 {
            return [0.0; 2];
        }
        let behind = 1.0 - wave.phase;
        // The crest's roller, its front, and what it leaves behind.
        let streaks = fractal(p, self.seeds.streaks, 5.0, 4, 0.65);
        let patches = fractal(p, self.seeds.patches, 26.0, 4, 0.6);
        let roller = smoothstep(0.10, 0.03, wave.phase).max(smoothstep(0.10, 0.02, behind));
        let trail = libm::exp(-behind / 0.20) * (0.75 + 1.3 * streaks);
        let mut fresh = wave.broken * roller.max(0.9 * trail);
        let mut loose =
            wave.broken * (0.25 + 0.55 * libm::exp(-behind / 0.5)) * smoothstep(-0.2, 0.3, patches + 0.3 * streaks);
        // Rock makes foam wherever it breaks the surface.
        let rocky = if self.cliffs { 1.0 - smoothstep(0.2, 0.8, s.place.sandy) } else { 0.0 };
        let washed = smoothstep(0.7, 0.05, depth) * rocky;
        fresh = fresh.max(washed * smoothstep(0.05, 0.45, 0.8 * streaks + 0.9 * patches + 0.12 * self.swell_m));
        loose = loose.max(smoothstep(3.2, 0.6, depth) * rocky * smoothstep(0.0, 0.4, patches) * 0.9);
        // The film that runs up the sand.
        fresh = fresh.max(smoothstep(0.12, 0.03, depth) * (1.0 - rocky) * smoothstep(-0.1, 0.3, streaks) * 0.8);
        [fresh.clamp(0.0, 1.0), loose.clamp(0.0, 1.0)]
    }

    /// Whether dry ground is rock: steep, or low before a rocky shore.
    pub(super) fn is_rock(&self, s: &Surface, up: f64) -> bool {
        self.cliffs && (up < 0.80 || (s.place.sandy < 0.5 && s.place.inland_m < 9.0))
    }

    /// How much marram covers a place, 0 to 1.
    pub(super) fn marram(&self, p: DVec2, s: &Surface) -> f64 {
        dress::plants(self, p, s, &self.cover_seeds)[0]
    }

    /// The shore on a line square to the coast, from the sea inland; none where there is only one of both.
    pub(super) fn shore_on(&self, line: DVec2) -> Option<DVec2> {
        let at = |k: i32| line + self.shore.out * (600.0 - 2.0 * f64::from(k));
        (0..600).map(at).find(|p| self.shore.at(*p).inland_m >= 0.0)
    }

    /// Mean square slope of waves too short for mesh and bump.
    pub(super) fn slope_variance(&self) -> f64 {
        self.form.slope_variance * self.roughness.max(0.2)
    }

    /// Where the dunes begin, m inland.
    pub(super) fn dune_toe_m(&self) -> f64 {
        self.form.toe_m
    }

    /// Whether a place lies within the full-detail tiles.
    pub(super) fn is_detailed(&self, p: DVec2) -> bool {
        let half_m = -self.window.origin_m.x;
        p.abs().max_element() <= half_m
    }

    /// The posts of the full-detail tiles.
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
