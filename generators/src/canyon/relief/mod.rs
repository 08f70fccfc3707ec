//! The height field: walls that climb from channels through the beds, the valley's floor.
//!
//! A wall's plan is made in the space of distances (how far rock has been worn back from a channel) and turned into
//! heights last, through the strata's profile. So every cliff stands at its bed's slope, beds run unbroken around each
//! bend, and a gully notches the cliffs that it crosses.

mod wear;

use super::strata::{Habit, RIM_M, Strata};
use super::undercuts::{Undercuts, Wall};
use super::valley::{Channels, Fold, Trunk};
use crate::kit::terrain::flow::fill;
use crate::kit::terrain::front::rise;
use crate::kit::terrain::noise::{blocks, fractal, ridged};
use crate::kit::terrain::overhang::{Hollow, Slabs};
use crate::kit::terrain::sampling::{bicubic, gradient, smoothstep};
use crate::kit::terrain::tin::Ground;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath, hash_cell, unit_from_hash};
use wear::Worn;

/// Distance of the window's posts, m.
pub(super) const POST_M: f64 = 0.5;
/// Distance of the posts on which walls are worn, m.
const WORN_M: f64 = 2.0;
/// Distance of the posts of the whole scene's plan, m.
const FAR_M: f64 = 4.0;
/// Posts beyond the full-detail tiles, m.
pub(super) const MARGIN_M: f64 = 64.0;

/// Seeds of the noises.
struct Seeds {
    plan: u32,
    joints: u32,
    ground: u32,
    scree: u32,
    floor: u32,
}

/// The finished ground.
pub(super) struct Relief<'a> {
    strata: &'a Strata,
    fold: &'a Fold,
    trunk: &'a Trunk,
    channels: &'a Channels,
    seeds: Seeds,
    roughness: f64,
    /// For the whole scene, which channel each post's wall climbs from.
    far_source: Raster<u32>,
    /// What is seen from above: the unsmoothed height field of the full-detail part, `POST_M` apart.
    top: Raster<f32>,
    /// The same below overhangs: the ground.
    pub(super) window: Raster<f32>,
    /// The rock over hollows.
    pub(super) slabs: Slabs,
    /// Rasters of the full-detail part, `WORN_M` apart.
    pub(super) worn: Worn,
}

/// What covers a place of the full-detail part.
pub(super) struct Cover {
    /// Distance beyond the river's bank, m; negative in the river.
    pub(super) bank_m: f64,
    /// Thickness of scree, m.
    pub(super) scree_m: f64,
    /// Area that drains through it, m2.
    pub(super) area_m2: f64,
    /// How far from its channel the wall has climbed, m on the plane.
    pub(super) climb_m: f64,
}

/// How far a scene reaches, m.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_field_names, reason = "the unit stands in the name")]
pub(super) struct Extent {
    /// Radius of full detail.
    pub(super) radius_m: f64,
    /// Half the side of the square of all full-detail tiles.
    pub(super) window_half_m: f64,
    /// Half the side of all tiles.
    pub(super) scene_half_m: f64,
}

/// How far a bed's face may stand before or behind its mean line, m.
pub(super) const FACE_M: f64 = 5.0;
/// The largest distance from the river that is kept, m.
const RIVER_REACH_M: f64 = 120.0;

impl<'a> Relief<'a> {
    pub(super) fn new(
        strata: &'a Strata,
        fold: &'a Fold,
        trunk: &'a Trunk,
        channels: &'a Channels,
        Extent { radius_m, window_half_m, scene_half_m }: Extent,
        roughness: f64,
        path: &SeedPath,
    ) -> Self {
        let seed = |name: &str| path.child(name).hash_u32();
        let seeds = Seeds {
            plan: seed("plan"),
            joints: seed("joints"),
            ground: seed("ground"),
            scree: seed("scree"),
            floor: seed("floor"),
        };
        let far_shape = square(scene_half_m + 2.0 * FAR_M, FAR_M);
        let far_source = rise(&far_shape, &channels.sources, 4000.0).1;
        let worn = Worn::empty(&square(window_half_m + MARGIN_M, WORN_M));
        let window = square(window_half_m + MARGIN_M, POST_M);
        let (top, slabs) = (window.clone(), Slabs::none(&window));
        let mut relief = Self { strata, fold, trunk, channels, seeds, roughness, far_source, top, window, slabs, worn };
        relief.wear();
        relief.follow_river();
        relief.drop_scree();
        relief.raise();
        relief.undercut(&Undercuts::new(strata, roughness, radius_m, &path.child("undercuts")));
        relief
    }

    /// Distance in the profile and climb above the channel at a place, without gullies.
    fn plan(&self, p: DVec2) -> (f64, f64) {
        let g = self.far_source.grid_from_world(p).floor();
        let (i, j) = (g.x as i64, g.y as i64);
        let mut best = (f64::MAX, 0.0);
        let mut last = u32::MAX;
        for (di, dj) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let s = self.far_source.get_clamped(i + di, j + dj);
            if s == last || s == u32::MAX {
                continue;
            }
            last = s;
            let source = &self.channels.sources[s as usize];
            let (d, t) = source.reach(p);
            if d < best.0 {
                best = (d, d - source.values_m[0] - (source.values_m[1] - source.values_m[0]) * t);
            }
        }
        let (d, climb) = best;
        // Walls are not parallel to their channels: rock is uneven at every scale.
        let uneven =
            fractal(p, self.seeds.plan, 110.0, 5, 0.55) * 16.0 + ridged(p, self.seeds.plan ^ 0x3c, 46.0, 2, 0.5) * 2.5;
        // Bays and buttresses no farther apart than a wall is thick, so that brows cast no straight shadows.
        let brows = fractal(p, self.seeds.plan ^ 0x91, 21.0, 3, 0.45) * 5.5 * smoothstep(2.0, 16.0, climb);
        let keep = smoothstep(0.0, 30.0, climb);
        ((d + uneven * keep + brows).max(d - climb), climb)
    }

    /// The full-detail heights, then a way down for every post.
    fn raise(&mut self) {
        let shape = &self.window;
        let width = shape.width;
        let rows: Vec<Vec<f32>> = (0..shape.height)
            .into_par_iter()
            .map(|j| (0..width).map(|i| self.detailed(shape.position(i, j)) as f32).collect())
            .collect();
        let mut z = shape.clone();
        z.data = rows.concat();
        let height = z.height;
        fill(&mut z, |p| on_border(p, width, height));
        self.top = z;
    }

    /// The ground below what overhangs: the same with hollows cut into it.
    fn undercut(&mut self, undercuts: &Undercuts) {
        let mut z = self.top.clone();
        let (width, height) = (z.width, z.height);
        self.slabs = Slabs::cut(&mut z, |p| self.hollows(undercuts, p));
        fill(&mut z, |p| on_border(p, width, height));
        self.window = z;
    }

    fn hollows(&self, undercuts: &Undercuts, p: DVec2) -> Vec<Hollow> {
        let worn = &self.worn;
        if worn.bank_m.bilinear(p) < 2.0 {
            return Vec::new();
        }
        let (d, climb) = (bicubic(&worn.distance_m, p), worn.climb_m.bilinear(p));
        // Hollows follow the bays of a wall, not each of its joints.
        let keep = self.roughness * smoothstep(0.0, 6.0, climb);
        let (fold, scree) = (self.fold.at(p), worn.scree_m.bilinear(p));
        let wall = Wall { distance_m: d, climb_m: climb, height_m: self.top_m(p) - fold };
        let mut hollows =
            undercuts.at(p, wall, |bed| (self.bays(p, self.strata.cliff_foot(bed)) + self.course(p, bed)) * keep);
        for hollow in &mut hollows {
            hollow.roof_m += fold;
            let mut floor = hollow.floor_m + fold;
            if scree > 0.02 {
                floor = floor.max(self.scree_top_m(p, d, scree));
            }
            hollow.floor_m = self.with_floor(p, floor);
        }
        hollows
    }

    /// How far the bays of the cliff of a lowest bed stand before its mean line, m.
    fn bays(&self, p: DVec2, foot: usize) -> f64 {
        let salt = (foot as u32).wrapping_mul(0x9e37);
        3.8 * fractal(p, self.seeds.joints ^ salt ^ 0x55, 26.0, 4, 0.5)
    }

    /// Bare rock at a distance in the profile: cliffs with joints, slopes with rills, domes on the plateau.
    fn rock(&self, p: DVec2, distance_m: f64, climb_m: f64) -> f64 {
        let seeds = &self.seeds;
        let rough = self.roughness;
        let keep = smoothstep(0.0, 6.0, climb_m);
        // Joints and bays run through all beds of a cliff, and each of them stands a little before or behind the others.
        let mut cliff = (usize::MAX, 0.0);
        let face = |bed: usize| {
            let line = match self.strata.beds[bed].habit {
                Habit::Cliff => {
                    let foot = self.strata.cliff_foot(bed);
                    if cliff.0 != foot {
                        let salt = (foot as u32).wrapping_mul(0x9e37);
                        let cell = 3.5 + f64::from(unit_from_hash(hash_cell(foot as i32, 3, 0, seeds.joints))) * 6.0;
                        let (block, _) = blocks(p, seeds.joints ^ salt, cell);
                        cliff = (foot, 0.75 * block + self.bays(p, foot));
                    }
                    cliff.1 + self.course(p, bed) - self.notch(p, bed)
                }
                Habit::Slope | Habit::Bench => fractal(p, seeds.joints ^ 0x99, 15.0, 4, 0.5) * 1.4,
                Habit::Plateau => 0.0,
            };
            (line * rough * keep).clamp(-FACE_M, FACE_M)
        };
        let (h, bed) = self.strata.wall_at(distance_m, FACE_M, face);
        let habit = self.strata.beds[bed].habit;
        let detail = match habit {
            Habit::Cliff => fractal(p, seeds.ground, 3.0, 3, 0.6) * 0.25,
            Habit::Slope | Habit::Bench => fractal(p, seeds.ground, 9.0, 5, 0.55) * 0.35,
            Habit::Plateau => {
                let swell = fractal(p, seeds.ground ^ 7, 46.0, 5, 0.5) * 2.6 * smoothstep(RIM_M, RIM_M + 4.0, h);
                // Courses of the cap weather into steps of half a metre or so.
                let step = 0.7;
                let courses =
                    libm::floor(swell / step) + smoothstep(0.72, 1.0, swell / step - libm::floor(swell / step));
                0.45 * swell + 0.55 * courses * step + fractal(p, seeds.ground, 5.0, 4, 0.55) * 0.16
            }
        };
        h + self.fold.at(p) + detail * rough * keep
    }

    /// How far a bed stands before the bays of its cliff, m: no two beds of a wall have the same plan.
    fn course(&self, p: DVec2, bed: usize) -> f64 {
        1.7 * fractal(p, self.seeds.joints ^ (bed as u32).wrapping_mul(0x85eb), 13.0, 4, 0.5)
    }

    /// How far the brow of a cliff is notched where joints have opened, m; 0 below its uppermost bed.
    fn notch(&self, p: DVec2, bed: usize) -> f64 {
        let beds = &self.strata.beds;
        if beds.get(bed + 1).is_some_and(|over| over.habit == Habit::Cliff) {
            return 0.0;
        }
        smoothstep(0.45, 0.95, ridged(p, self.seeds.joints ^ 0x707, 8.5, 2, 0.5))
    }

    /// Height of the ribs between the rills of slopes of soil and scree, m, negative in the rills, about -0.4..0.45: noise
    /// smeared along the fall line, so that their spacing is as uneven as the noise.
    fn rills(&self, p: DVec2, distance_m: f64, scree_m: f64) -> f64 {
        const REACH_M: f64 = 1.5;
        let of = |d: f64| self.strata.height_at(d);
        let fall = (of(distance_m + REACH_M) - of(distance_m - REACH_M)) / (2.0 * REACH_M);
        let loose = (smoothstep(0.25, 0.45, fall) * smoothstep(1.3, 0.9, fall)).max(smoothstep(0.3, 1.0, scree_m));
        if loose < 0.02 {
            return 0.0;
        }
        let d = &self.worn.distance_m;
        let side = |dx: f64, dy: f64| d.bilinear(p + DVec2::new(dx, dy));
        let uphill = DVec2::new(side(3.0, 0.0) - side(-3.0, 0.0), side(0.0, 3.0) - side(0.0, -3.0));
        let along = uphill / uphill.length().max(1e-3);
        let noise = |k: i32| fractal(p + along * (2.8 * f64::from(k)), self.seeds.scree ^ 0x5a5a, 9.0, 3, 0.6);
        let smeared = (-2..=2).map(noise).sum::<f64>() / 5.0;
        // Sharp in their beds, rounded between.
        let rill = (smeared.abs() / 0.16).min(1.5) - 0.7;
        // Some stretches are hardly rilled at all.
        let vigour = smoothstep(-0.35, 0.45, fractal(p, self.seeds.scree ^ 0x77, 45.0, 2, 0.5));
        0.55 * rill * loose * (0.25 + 0.75 * vigour)
    }

    fn detailed(&self, p: DVec2) -> f64 {
        let worn = &self.worn;
        let d = bicubic(&worn.distance_m, p);
        let climb = worn.climb_m.bilinear(p);
        let rough = self.roughness;
        let mut z = self.rock(p, d, climb);
        let scree = worn.scree_m.bilinear(p);
        if scree > 0.02 {
            let rubble = fractal(p, self.seeds.ground ^ 0x1234, 4.0, 4, 0.65) * 0.22 * rough;
            z = z.max(self.scree_top_m(p, d, scree) + rubble * smoothstep(0.0, 0.5, scree));
        }
        z += self.rills(p, d, scree) * rough * smoothstep(2.0, 8.0, climb);
        self.with_floor(p, z)
    }

    /// Height of scree's surface, m. It lies on the smooth rock, not on its joints, and the river takes away what comes
    /// near its banks.
    fn scree_top_m(&self, p: DVec2, distance_m: f64, scree_m: f64) -> f64 {
        let base = self.strata.height_at(distance_m) + self.fold.at(p);
        let bank = self.worn.bank_m.bilinear(p);
        let kept = self.worn.level_m.bilinear(p) + 0.3 + 0.40 * bank.max(0.0);
        if bank < 60.0 { (base + scree_m).min(kept.max(base)) } else { base + scree_m }
    }

    /// Alluvium of the main valley: river or wash, bars, terraces.
    fn with_floor(&self, p: DVec2, z: f64) -> f64 {
        let worn = &self.worn;
        let bank = bicubic(&worn.bank_m, p);
        if bank > 110.0 {
            return z;
        }
        let level = worn.level_m.bilinear(p);
        let seed = self.seeds.floor;
        let n = |salt: u32, wavelength: f64| fractal(p, seed ^ salt, wavelength, 3, 0.5);
        let rough = self.roughness;
        if bank < 0.0 {
            if self.trunk.is_dry {
                let braids = ridged(p, seed ^ 5, 9.0, 2, 0.5) * 0.12 + n(6, 2.0) * 0.05 * rough;
                return level - 0.5 * (1.0 - smoothstep(-4.0, 0.0, bank)) + braids * smoothstep(0.0, -1.0, bank);
            }
            return level;
        }
        let bar = 0.9 * smoothstep(0.0, 8.0, bank + 9.0 * n(1, 26.0));
        let low_terrace = 0.7 * smoothstep(10.0, 15.0, bank + 26.0 * n(2, 52.0));
        let high_terrace = 1.2 * smoothstep(20.0, 29.0, bank + 34.0 * n(3, 90.0));
        let ground = (n(4, 6.0) * 0.16 + n(7, 1.6) * 0.07) * rough * smoothstep(0.0, 1.5, bank);
        let floor = level
            + 0.12 * smoothstep(0.0, 0.6, bank)
            + bar * smoothstep(0.0, 2.0, bank)
            + low_terrace
            + high_terrace
            + 0.03 * bank
            + ground;
        // Alluvium laps onto the walls' feet, and ends there.
        z.max(floor - 9.0 * smoothstep(60.0, 110.0, bank))
    }

    /// The banks of the river, or of the dry wash, as lines from upstream down, left and right.
    pub(super) fn banks(&self, half_m: f64) -> [Vec<DVec3>; 2] {
        let trunk = self.trunk;
        [(0, 1.0), (1, -1.0)].map(|(bank, side)| {
            trunk
                .range(half_m)
                .map(|k| {
                    let last = trunk.thread_m.len() - 1;
                    let along = trunk.thread_m[(k + 1).min(last)] - trunk.thread_m[k.saturating_sub(1)];
                    let p = trunk.thread_m[k] + along.normalize().perp() * (side * trunk.river_half_m[bank][k]);
                    p.extend(trunk.level_m[k])
                })
                .collect()
        })
    }

    /// Where the ground is hollow (positive) or a rib (negative), about -0.5..0.5: the mean height over a few metres
    /// against that close by.
    pub(super) fn hollow(&self, p: DVec2) -> f64 {
        let g = (self.top.grid_from_world(p) + 0.5).floor();
        let (i, j) = (g.x as i64, g.y as i64);
        let ring = |r: i64| {
            let d = (r * 7 + 5) / 10;
            let around = [(r, 0), (d, d), (0, r), (-d, d), (-r, 0), (-d, -d), (0, -r), (d, -d)];
            around.iter().map(|(di, dj)| self.top.get_clamped(i + di, j + dj)).sum::<f32>() / 8.0
        };
        (0.25 * f64::from((ring(10) + ring(6)) * 0.5 - (ring(2) + self.top.get_clamped(i, j)) * 0.5)).clamp(-0.6, 0.6)
    }

    /// Height of what is seen from above at a place of the full-detail part, m.
    pub(super) fn top_m(&self, p: DVec2) -> f64 {
        self.top.bilinear(p)
    }

    /// Whether nothing overhangs within a radius of a place.
    pub(super) fn is_open(&self, p: DVec2, radius_m: f64) -> bool {
        let over = |q: DVec2| self.top_m(q) - self.window.bilinear(q);
        let around = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        around.iter().all(|side| over(p + *side * radius_m) < 0.1)
    }

    /// How far on the plane a place lies from the foot of the next cliff above it, m, and that cliff's height, m.
    pub(super) fn below_cliff_m(&self, p: DVec2) -> Option<[f64; 2]> {
        let d = self.worn.distance_m.bilinear(p);
        let [foot_m, top_m] = self.strata.cliff_over(self.strata.height_at(d))?;
        Some([(self.strata.distance_of(foot_m) - d).max(0.0), top_m - foot_m])
    }

    /// What covers a place.
    pub(super) fn cover(&self, p: DVec2) -> Cover {
        let worn = &self.worn;
        Cover {
            bank_m: worn.bank_m.bilinear(p),
            scree_m: worn.scree_m.bilinear(p),
            area_m2: worn.area_m2.bilinear(p),
            climb_m: worn.climb_m.bilinear(p),
        }
    }

    /// Upward normal of the window at a place; straight up outside it.
    pub(super) fn slope(&self, p: DVec2) -> DVec2 {
        let g = (self.window.grid_from_world(p) + 0.5).floor();
        let inside = g.x >= 0.0 && g.y >= 0.0 && g.x < self.window.width as f64 && g.y < self.window.height as f64;
        if inside {
            return gradient(&self.window, g.x as usize, g.y as usize);
        }
        let e = FAR_M;
        let z = |dx: f64, dy: f64| self.height_m(p + DVec2::new(dx, dy));
        DVec2::new(z(e, 0.0) - z(-e, 0.0), z(0.0, e) - z(0.0, -e)) / (2.0 * e)
    }
}

impl Ground for Relief<'_> {
    fn height_m(&self, p: DVec2) -> f64 {
        let g = self.window.grid_from_world(p);
        let last = (self.window.width - 1) as f64;
        if g.x >= 0.0 && g.y >= 0.0 && g.x <= last && g.y <= last {
            return self.window.bilinear(p);
        }
        let (d, climb) = self.plan(p);
        self.rock(p, d, climb)
    }
}

fn on_border(post: usize, width: usize, height: usize) -> bool {
    let (i, j) = (post % width, post / width);
    i == 0 || j == 0 || i == width - 1 || j == height - 1
}

fn square(half_m: f64, cell_m: f64) -> Raster<f32> {
    let n = libm::round(2.0 * half_m / cell_m) as usize + 1;
    Raster::filled(DVec2::splat(-half_m), cell_m, n, n, 0.0)
}
