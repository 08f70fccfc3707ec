//! The stack of beds: thickness, hardness, colour, and the slope on which each bed stands.

use satseed_scene::{Bands, Beds, Rng, SeedPath};

/// Height of the rim above the datum where the fold is zero, m: the top of the cap bed.
pub(super) const RIM_M: f64 = 14.0;
/// How far the plateau may rise above the rim, m.
pub(super) const PLATEAU_RISE_M: f64 = 22.0;
/// How far below the rim less the relief the stack still has beds, m.
const BELOW_FLOOR_M: f64 = 40.0;

/// What a bed does to the wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Habit {
    /// Stands as a cliff.
    Cliff,
    /// Weathers to a slope of scree and soil.
    Slope,
    /// Weathers back and leaves a platform on the bed below.
    Bench,
    /// What lies above the rim.
    Plateau,
}

/// A bed of one habit and colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bed {
    /// Stratigraphic height of its top, m.
    pub(super) top_m: f64,
    pub(super) habit: Habit,
    pub(super) color: Bands,
}

/// The stack, and the wall's profile through it: how far from a channel (m on the plane) a wall has climbed to a height.
pub(super) struct Strata {
    /// From the lowest up; beds touch.
    pub(super) beds: Vec<Bed>,
    /// Knees of the profile: distance and height, both ascending.
    knees: Vec<(f64, f64)>,
    /// Where in the profile each bed begins, m.
    starts_m: Vec<f64>,
    /// The lowest bed of the cliff that each bed is part of.
    cliff_feet: Vec<usize>,
    /// Thin layers of colour within the beds, for the material.
    laminae: Vec<(f32, Bands)>,
}

const RED_SANDSTONE: Bands = Bands::new(0.085, 0.135, 0.255, 0.34);
const BUFF_SANDSTONE: Bands = Bands::new(0.175, 0.235, 0.32, 0.40);
const LIMESTONE: Bands = Bands::new(0.215, 0.265, 0.32, 0.37);
const SHALE: Bands = Bands::new(0.125, 0.145, 0.175, 0.22);
const GREEN_SHALE: Bands = Bands::new(0.13, 0.155, 0.172, 0.22);
/// What soft beds weather to, whatever they are.
const WEATHERED: Bands = Bands::new(0.115, 0.15, 0.198, 0.26);
const RED_MUDSTONE: Bands = Bands::new(0.07, 0.10, 0.175, 0.25);
const PALE_SILTSTONE: Bands = Bands::new(0.17, 0.205, 0.25, 0.30);

impl Strata {
    /// A stack for a relief: the first of the path's draws with 12 to 30 beds in the wall and about three quarters
    /// of it cliff.
    pub(super) fn new(relief_m: f64, path: &SeedPath) -> Self {
        let draw = |k| Self::draw(relief_m, &path.index(k));
        (0..64).map(draw).find(|s| s.is_typical(relief_m)).unwrap_or_else(|| draw(0))
    }

    fn is_typical(&self, relief_m: f64) -> bool {
        let (first, last) = (self.bed_at(RIM_M - relief_m), self.bed_at(RIM_M - 0.01));
        let thick = |b: usize| self.beds[b].top_m - self.base_m(b);
        let cliff: f64 = (first..=last).filter(|b| self.beds[*b].habit == Habit::Cliff).map(thick).sum();
        (12..=30).contains(&(last + 1 - first)) && (0.69..0.775).contains(&(cliff / relief_m))
    }

    fn draw(relief_m: f64, path: &SeedPath) -> Self {
        let mut rng = path.child("beds").rng();
        let floor = RIM_M - relief_m;
        // From the rim down: a cap that holds the rim, then soft and hard in turn; one bed near the middle may be a bench.
        let mut beds = Vec::new();
        let mut top = RIM_M;
        let mut habit = Habit::Cliff;
        // Beds without a soft one between stand as great cliffs: at the rim, and once below it.
        let cap_bottom = RIM_M - relief_m * rng.range(0.09, 0.19);
        let great_top = RIM_M - relief_m * rng.range(0.26, 0.54);
        let great_bottom = great_top - relief_m * rng.range(0.36, 0.47);
        let bench_at = RIM_M - relief_m * rng.range(0.45, 0.75);
        let mut bench_left = rng.chance(0.7);
        while top > floor - BELOW_FLOOR_M {
            let thick = if beds.is_empty() {
                rng.range(9.0, 17.0)
            } else if habit == Habit::Bench {
                rng.range(3.0, 6.0)
            } else {
                rng.lognormal(if habit == Habit::Cliff { 8.0 } else { 4.5 }, 0.6).clamp(1.0, 25.0)
            };
            beds.push(Bed { top_m: top, habit, color: bed_color(habit, &mut rng) });
            top -= thick;
            habit = match habit {
                Habit::Cliff if bench_left && top < bench_at => {
                    bench_left = false;
                    Habit::Bench
                }
                Habit::Cliff | Habit::Slope if top > cap_bottom || top < great_top && top > great_bottom => {
                    Habit::Cliff
                }
                Habit::Cliff => {
                    if rng.chance(0.75) {
                        Habit::Slope
                    } else {
                        Habit::Cliff
                    }
                }
                Habit::Slope => {
                    if rng.chance(0.5) {
                        Habit::Cliff
                    } else {
                        Habit::Slope
                    }
                }
                Habit::Bench | Habit::Plateau => Habit::Cliff,
            };
        }
        beds.reverse();
        let bottom = top;
        // Above the rim, thin beds that the plateau's low scarps cut.
        let mut above = RIM_M;
        while above < RIM_M + PLATEAU_RISE_M {
            above = (above + rng.range(2.0, 6.0)).min(RIM_M + PLATEAU_RISE_M);
            beds.push(Bed { top_m: above, habit: Habit::Plateau, color: bed_color(Habit::Plateau, &mut rng) });
        }
        let knees = profile(bottom, &beds, &mut path.child("profile").rng());
        let laminae = laminate(bottom, &beds, &mut path.child("laminae").rng());
        let is_one = |b: usize| b > 0 && beds[b].habit == Habit::Cliff && beds[b - 1].habit == Habit::Cliff;
        let cliff_feet = (0..beds.len()).map(|b| (0..=b).rev().find(|c| !is_one(*c)).unwrap_or(0)).collect();
        let mut strata = Self { beds, knees, starts_m: Vec::new(), cliff_feet, laminae };
        strata.starts_m = (0..strata.beds.len()).map(|b| strata.distance_of(strata.base_m(b))).collect();
        strata
    }

    /// Stratigraphic height of a wall at a distance, m.
    pub(super) fn height_at(&self, distance_m: f64) -> f64 {
        interpolate(&self.knees, distance_m, |k| (k.0, k.1))
    }

    /// Distance at which a wall reaches a stratigraphic height, m.
    pub(super) fn distance_of(&self, height_m: f64) -> f64 {
        interpolate(&self.knees, height_m, |k| (k.1, k.0))
    }

    /// Height of a wall whose beds' faces stand before (positive) or behind their mean line by what `face_m` tells of
    /// each, `reach_m` at most, and the bed that is found there. Where a bed stands before those below it the wall is
    /// plumb; where it stands behind them, they end in a ledge.
    pub(super) fn wall_at(&self, distance_m: f64, reach_m: f64, mut face_m: impl FnMut(usize) -> f64) -> (f64, usize) {
        let mut bed = self.starts_m.partition_point(|s| *s < distance_m + reach_m).saturating_sub(1);
        loop {
            let d = distance_m + face_m(bed);
            if d >= self.starts_m[bed] || bed == 0 {
                return (self.height_at(d).clamp(self.base_m(bed), self.beds[bed].top_m), bed);
            }
            bed -= 1;
        }
    }

    /// The lowest bed of the cliff that a bed is part of, by number.
    pub(super) fn cliff_foot(&self, bed: usize) -> usize {
        self.cliff_feet[bed]
    }

    /// Foot and top (stratigraphic, m) of the cliff that a height lies in, or of the next one above it.
    pub(super) fn cliff_over(&self, height_m: f64) -> Option<[f64; 2]> {
        let is_cliff = |b: &usize| self.beds[*b].habit == Habit::Cliff;
        let first = (self.bed_at(height_m)..self.beds.len()).find(is_cliff)?;
        let last = (first..self.beds.len()).take_while(is_cliff).last()?;
        Some([self.base_m(self.cliff_feet[first]), self.beds[last].top_m])
    }

    /// Where in the profile a bed begins, m.
    pub(super) fn start_m(&self, bed: usize) -> f64 {
        self.starts_m[bed]
    }

    /// The bed at a stratigraphic height, by number.
    pub(super) fn bed_at(&self, height_m: f64) -> usize {
        self.beds.partition_point(|b| b.top_m < height_m).min(self.beds.len() - 1)
    }

    /// Lower border of a bed, m.
    pub(super) fn base_m(&self, bed: usize) -> f64 {
        if bed == 0 { self.knees[0].1 } else { self.beds[bed - 1].top_m }
    }

    /// Mean colour of the laminae.
    pub(super) fn mean_color(&self) -> Bands {
        let sum = self.laminae.iter().fold(Bands::ZERO, |sum, l| sum + l.1);
        sum * (1.0 / self.laminae.len() as f32)
    }

    /// Colours of the beds that break into blocks.
    pub(super) fn cliff_colors(&self) -> Vec<Bands> {
        let wall = self.beds.iter().filter(|b| b.habit == Habit::Cliff && b.top_m > self.knees[0].1 + BELOW_FLOOR_M);
        wall.map(|b| b.color).collect()
    }

    /// Colours over stratigraphic height.
    pub(super) fn colors(&self) -> Beds {
        Beds::new(&self.laminae)
    }
}

fn interpolate(knees: &[(f64, f64)], x: f64, pick: impl Fn(&(f64, f64)) -> (f64, f64)) -> f64 {
    let i = knees.partition_point(|k| pick(k).0 < x).clamp(1, knees.len() - 1);
    let ((x0, y0), (x1, y1)) = (pick(&knees[i - 1]), pick(&knees[i]));
    y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
}

fn bed_color(habit: Habit, rng: &mut Rng) -> Bands {
    let palette: &[(Bands, f64)] = match habit {
        Habit::Cliff => &[(RED_SANDSTONE, 3.0), (BUFF_SANDSTONE, 2.0), (LIMESTONE, 1.6), (PALE_SILTSTONE, 0.6)],
        Habit::Plateau => &[(BUFF_SANDSTONE, 2.0), (RED_SANDSTONE, 1.5), (PALE_SILTSTONE, 1.5)],
        Habit::Slope | Habit::Bench => &[(RED_MUDSTONE, 2.5), (SHALE, 2.0), (GREEN_SHALE, 0.25), (PALE_SILTSTONE, 0.8)],
    };
    let weights: Vec<f64> = palette.iter().map(|p| p.1).collect();
    let fresh = palette[rng.weighted(&weights)].0;
    let weathered = if matches!(habit, Habit::Slope | Habit::Bench) { 0.5 } else { 0.0 };
    shifted(fresh.lerp(WEATHERED, weathered), rng, 0.14)
}

/// A colour a little brighter or darker and a little greyer or stronger.
fn shifted(color: Bands, rng: &mut Rng, amount: f64) -> Bands {
    let bright = (1.0 + rng.signed() * amount) as f32;
    let grey = Bands::grey((color[0] + color[1] + color[2]) / 3.0);
    color.lerp(grey, (0.05 + rng.signed() * 0.10) as f32) * bright
}

/// The wall through all beds: cliffs of steep courses with narrow ledges between, slopes with thin ribs.
fn profile(bottom_m: f64, beds: &[Bed], rng: &mut Rng) -> Vec<(f64, f64)> {
    let mut knees = vec![(0.0, bottom_m)];
    let mut d = 0.0;
    let mut h = bottom_m;
    let mut course = |rise: f64, tangent: f64, h: &mut f64| {
        d += rise / tangent;
        *h += rise;
        knees.push((d, *h));
    };
    for bed in beds {
        while h < bed.top_m - 1e-6 {
            let left = bed.top_m - h;
            // Nothing thinner than half a metre is left over for a next course.
            let take = |thick: f64| if left - thick < 0.5 { left } else { thick };
            match bed.habit {
                Habit::Cliff => {
                    // Massive courses and thin ones, each set back by a ledge of some decimetres.
                    let rise = take(rng.lognormal(4.2, 0.7).clamp(1.0, 17.0));
                    let ledge = (rise * 0.25).min(rng.lognormal(0.08, 0.6).clamp(0.04, 0.24));
                    course(rise - ledge, rng.lognormal(24.0, 0.4).clamp(8.0, 50.0), &mut h);
                    course(ledge, rng.range(0.5, 1.1), &mut h);
                }
                Habit::Slope if rng.chance(0.3) && left > 2.5 => {
                    course(rng.range(0.5, 1.6), rng.range(2.0, 4.0), &mut h);
                }
                Habit::Slope => course(take(rng.range(1.5, 5.0)), rng.range(0.58, 0.74), &mut h),
                Habit::Bench => course(take(rng.range(0.8, 2.0)), rng.range(0.10, 0.26), &mut h),
                Habit::Plateau if rng.chance(0.25) => course(take(rng.range(0.5, 1.5)), 1.2, &mut h),
                Habit::Plateau => course(take(rng.range(1.0, 3.0)), rng.range(0.05, 0.11), &mut h),
            }
        }
    }
    knees
}

/// Thin layers of slightly differing colour; cliffs weather darker than slopes dust over.
fn laminate(bottom_m: f64, beds: &[Bed], rng: &mut Rng) -> Vec<(f32, Bands)> {
    let mut laminae = Vec::new();
    let mut h = bottom_m;
    for bed in beds {
        while h < bed.top_m - 1e-6 {
            h = (h + rng.lognormal(1.1, 0.7).clamp(0.25, 5.0)).min(bed.top_m);
            laminae.push((h as f32, shifted(bed.color, rng, 0.13)));
        }
    }
    laminae
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beds_are_as_many_and_as_thick_as_stated() {
        for seed in 0..40 {
            for relief in [120.0, 170.0, 220.0] {
                let strata = Strata::new(relief, &SeedPath::root("strata", seed));
                assert!(strata.is_typical(relief), "seed {seed}, relief {relief}");
                assert!(strata.beds.windows(2).all(|b| b[1].top_m > b[0].top_m));
                assert!(strata.laminae.windows(2).all(|b| b[1].0 > b[0].0));
            }
        }
    }

    #[test]
    fn profile_and_distance_are_inverse() {
        let strata = Strata::new(170.0, &SeedPath::root("strata", 3));
        for i in 0..900 {
            let h = -160.0 + f64::from(i) * 0.2;
            assert!((strata.height_at(strata.distance_of(h)) - h).abs() < 1e-6);
        }
    }
}
