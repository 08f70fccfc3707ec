//! What water and falling rock do to walls before they have heights: small streams wear them, the river cuts their feet,
//! scree lies below cliffs.

use super::{RIVER_REACH_M, Relief, WORN_M, on_border};
use crate::canyon::strata::Habit;
use crate::kit::terrain::erosion::{diffuse, settle, stream_power};
use crate::kit::terrain::flow::fill_and_drain;
use crate::kit::terrain::front::{Apex, cones};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Raster, hash_cell, unit_from_hash};

/// The highest head of a fan above the river, m.
const FAN_HEAD_M: f64 = 15.0;
/// Fans lean on walls up to this far from the floor, m.
const FAN_CLIMB_M: f32 = 12.0;
/// About how thick alluvium lies on the floor's edge, m.
const ALLUVIUM_M: f64 = 4.0;

/// What the making of the window leaves behind for materials and plants.
pub(in super::super) struct Worn {
    /// Distance in the strata's profile.
    pub(super) distance_m: Raster<f32>,
    /// How far above its channel, in the same measure.
    pub(super) climb_m: Raster<f32>,
    /// Thickness of scree, m.
    pub(in super::super) scree_m: Raster<f32>,
    /// Area that drains through each post, m2.
    pub(in super::super) area_m2: Raster<f32>,
    /// Distance from the river's centre line, signed, m; beyond 120 m that.
    pub(in super::super) river_offset_m: Raster<f32>,
    /// Distance beyond the river's bank, m; negative in the river.
    pub(in super::super) bank_m: Raster<f32>,
    /// The river's level, m.
    pub(super) level_m: Raster<f32>,
}

impl Relief<'_> {
    /// Walls of the window, worn by the small streams that run down them.
    pub(super) fn wear(&mut self) {
        let shape = &self.worn.distance_m;
        let (width, height) = (shape.width, shape.height);
        let plan: Vec<(f64, f64)> =
            (0..width * height).into_par_iter().map(|p| self.plan(shape.position(p % width, p / width))).collect();
        let mut d = shape.clone();
        for (p, v) in plan.iter().enumerate() {
            d.data[p] = v.0 as f32;
            self.worn.climb_m.data[p] = v.1 as f32;
        }
        let smooth = d.clone();
        let outlet = |p: usize| plan[p].1 < 0.5 * WORN_M || on_border(p, width, height);
        let ease = |habit: Habit| match habit {
            Habit::Cliff => 0.3_f32,
            Habit::Slope => 1.3,
            Habit::Bench => 1.0,
            Habit::Plateau => 0.25,
        };
        let ease: Vec<f32> = self.strata.beds.iter().map(|b| ease(b.habit)).collect();
        // Some stretches of wall are gullied deeply and others hardly, or the gullies would keep one distance.
        let vigour: Vec<f32> = (0..width * height)
            .into_par_iter()
            .map(|p| {
                let at = shape.position(p % width, p / width);
                let share = smoothstep(-0.30, 0.55, fractal(at, self.seeds.plan ^ 0x2b, 75.0, 3, 0.55));
                (0.2 + 3.4 * share * share) as f32
            })
            .collect();
        let steps = 10;
        let total = 0.42_f32;
        let mut area = vec![0.0; width * height];
        for _ in 0..steps {
            let drainage = fill_and_drain(&mut d, self.seeds.plan, outlet);
            area = drainage.area_m2(WORN_M);
            stream_power(&mut d, &drainage, &area, |p, v| {
                vigour[p] * total / steps as f32 * ease[self.strata.bed_at(self.strata.height_at(f64::from(v)))]
            });
            diffuse(&mut d, 0.12, outlet);
        }
        // Towards the window's border the worn plan goes over into the plain one that the rest of the scene has.
        for p in 0..width * height {
            let (i, j) = (p % width, p / width);
            let inward = i.min(j).min(width - 1 - i).min(height - 1 - j) as f64 * WORN_M;
            let w = smoothstep(4.0, 50.0, inward) as f32;
            d.data[p] = smooth.data[p] + (d.data[p] - smooth.data[p]) * w;
        }
        self.worn.distance_m = d;
        self.worn.area_m2.data = area;
    }

    /// Where the river runs, relative to each post near it.
    pub(super) fn follow_river(&mut self) {
        let Worn { river_offset_m: offset, bank_m: bank, level_m: level, .. } = &mut self.worn;
        let half = -offset.origin_m.x + RIVER_REACH_M;
        let range = self.trunk.range(half);
        for k in range {
            let (a, b) = (self.trunk.thread_m[k], self.trunk.thread_m[k + 1]);
            let low = offset.grid_from_world(a.min(b) - RIVER_REACH_M).ceil().max(DVec2::ZERO);
            let high = offset.grid_from_world(a.max(b) + RIVER_REACH_M).floor();
            for j in low.y as usize..=high.y.clamp(-1.0, offset.height as f64 - 1.0) as usize {
                for i in low.x as usize..=high.x.clamp(-1.0, offset.width as f64 - 1.0) as usize {
                    if high.x < 0.0 || high.y < 0.0 {
                        continue;
                    }
                    let p = offset.position(i, j);
                    let along = b - a;
                    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                    let away = p - a - along * t;
                    let side = if along.perp_dot(away) < 0.0 { -1.0 } else { 1.0 };
                    let d = away.length();
                    let post = j * offset.width + i;
                    if d < f64::from(offset.data[post].abs()) {
                        let lerp = |v: &[f64]| v[k] + (v[k + 1] - v[k]) * t;
                        let half = &self.trunk.river_half_m[usize::from(side < 0.0)];
                        offset.data[post] = (d * side) as f32;
                        bank.data[post] = (d - lerp(half)) as f32;
                        level.data[post] = lerp(&self.trunk.level_m) as f32;
                    }
                }
            }
        }
    }

    /// Cones of scree below the cliffs, highest below chutes.
    pub(super) fn drop_scree(&mut self) {
        let d = &self.worn.distance_m;
        let (width, height) = (d.width, d.height);
        let mut rock = d.clone();
        rock.data = (0..width * height)
            .into_par_iter()
            .map(|p| {
                let at = d.position(p % width, p / width);
                (self.strata.height_at(f64::from(d.data[p])) + self.fold.at(at)) as f32
            })
            .collect();
        let mut apexes = Vec::new();
        for p in 0..width * height {
            let (i, j) = (p % width, p / width);
            let draw = |k: i32| f64::from(unit_from_hash(hash_cell(i as i32, j as i32, k, self.seeds.scree)));
            let at = d.position(i, j);
            let inward = i.min(j).min(width - 1 - i).min(height - 1 - j) as f64 * WORN_M;
            let height = self.strata.height_at(f64::from(d.data[p]));
            let bed = self.strata.bed_at(height);
            let is_foot = self.strata.beds[bed].habit == Habit::Cliff && self.strata.cliff_foot(bed) == bed;
            if !is_foot || draw(0) > 0.3 || inward < 30.0 {
                continue;
            }
            let base = self.strata.base_m(bed);
            let above = (height - base) / (self.strata.beds[bed].top_m - base);
            let chute = libm::log10(f64::from(self.worn.area_m2.data[p]) / 8.0).clamp(0.0, 2.0) * 0.22;
            let supply = 0.22 + 0.9 * fractal(at, self.seeds.scree, 70.0, 3, 0.5) + chute;
            if above < supply {
                apexes.push(Apex {
                    at_m: at,
                    height_m: f64::from(rock.data[p]) + 0.3,
                    tangent: 0.66 + 0.1 * draw(1),
                    max_cover_m: 2.0 + 3.5 * draw(2),
                });
            }
        }
        apexes.extend(self.fans(&rock));
        let mut scree = cones(&rock, &apexes);
        settle(&rock, &mut scree, 0.74, 8);
        self.worn.scree_m = scree;
    }
}

impl Relief<'_> {
    /// Fans and aprons against the feet of the main valley's walls: as the noise along the valley has it they bury the
    /// lowest cliff, reach some way up it, or are missing.
    fn fans(&self, rock: &Raster<f32>) -> Vec<Apex> {
        let (width, height) = (rock.width, rock.height);
        let mut apexes = Vec::new();
        for p in 0..width * height {
            let (i, j) = (p % width, p / width);
            let inward = i.min(j).min(width - 1 - i).min(height - 1 - j) as f64 * WORN_M;
            let (bank, climb) = (self.worn.bank_m.data[p], self.worn.climb_m.data[p]);
            if inward < 30.0 || !(2.0..100.0).contains(&bank) || !(0.5..FAN_CLIMB_M).contains(&climb) {
                continue;
            }
            let at = rock.position(i, j);
            let level = f64::from(self.worn.level_m.data[p]);
            let fold = self.fold.at(at);
            let brow_m = self.strata.cliff_over(level - fold + ALLUVIUM_M).map_or(0.0, |c| c[1] + fold - level);
            let highest_m = (brow_m + 3.0).clamp(8.0, FAN_HEAD_M);
            let head_m = highest_m * smoothstep(-0.06, 0.24, fractal(at, self.seeds.scree ^ 0xfa, 85.0, 3, 0.5));
            let height_m = (f64::from(rock.data[p]) + 0.4).min(level + head_m);
            if height_m > level + 2.0 {
                let uneven = f64::from(unit_from_hash(hash_cell(i as i32, j as i32, 7, self.seeds.scree)));
                apexes.push(Apex { at_m: at, height_m, tangent: 0.36 + 0.22 * uneven, max_cover_m: FAN_HEAD_M });
            }
        }
        apexes
    }
}

impl Worn {
    pub(super) fn empty(shape: &Raster<f32>) -> Self {
        let of = |value: f32| Raster { data: vec![value; shape.data.len()], ..shape.clone() };
        Self {
            distance_m: of(0.0),
            climb_m: of(0.0),
            scree_m: of(0.0),
            area_m2: of(0.0),
            river_offset_m: of(RIVER_REACH_M as f32),
            bank_m: of(RIVER_REACH_M as f32),
            level_m: of(0.0),
        }
    }
}
