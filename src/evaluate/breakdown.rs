//! By what errors are broken down, and the bins of each.

use super::score::{Both, ByVisibility, Scores};
use crate::dataset::CLASS_NAMES;
use crate::dataset::texture;
use serde::Serialize;
use std::collections::BTreeMap;

/// The bin of a pixel that has none.
pub(super) const NO_BIN: u16 = u16::MAX;

/// Bins of disparity, between the lowest and the highest of the samples.
const DISPARITY_BINS: usize = 16;
/// Where bins of slope begin, degrees; the last ends at 180.
const SLOPES_DEG: [f64; 7] = [0.0, 5.0, 15.0, 30.0, 45.0, 60.0, 75.0];
/// Where bins of height above ground end, m; the first begins and the last ends nowhere. What stands 2.5 m or more above the
/// ground is raised, as in `info`.
const HEIGHTS_M: [f64; 4] = [2.5, 10.0, 30.0, 60.0];
/// Where bins of distance to the next boundary end, px, the end included.
const DISTANCES_PX: [u32; 6] = [0, 2, 5, 10, 20, 50];
/// Bins of the shadow label.
const SHADOWS: [&str; 3] = ["shadow", "penumbra", "lit"];

/// By what a pixel's errors are broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum By {
    Texture,
    Disparity,
    Slope,
    Height,
    Class,
    Shadow,
    Boundary,
}

impl By {
    pub(super) const ALL: [Self; 7] =
        [Self::Texture, Self::Disparity, Self::Slope, Self::Height, Self::Class, Self::Shadow, Self::Boundary];

    /// Its name in reports.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Texture => "texture",
            Self::Disparity => "disparity",
            Self::Slope => "slope",
            Self::Height => "height",
            Self::Class => "class",
            Self::Shadow => "shadow",
            Self::Boundary => "boundary_distance",
        }
    }

    /// What its bins are bins of.
    fn of(self) -> &'static str {
        match self {
            Self::Texture => "tenths of the pixels by local contrast of the left image, grey levels",
            Self::Disparity => "true disparity, px",
            Self::Slope => "slope of the surface, degrees",
            Self::Height => "height above the bare ground, m",
            Self::Class => "semantic class",
            Self::Shadow => "direct sun",
            Self::Boundary => "distance to the next disparity jump above 3 px, px, the upper end included",
        }
    }

    /// The recipe's label that it needs.
    pub(super) fn label(self) -> Option<&'static str> {
        match self {
            Self::Slope => Some("normal"),
            Self::Class => Some("class"),
            Self::Shadow => Some("shadow"),
            _ => None,
        }
    }

    /// How many bins there are.
    pub(super) fn bins(self) -> usize {
        match self {
            Self::Texture => texture::STEPS,
            Self::Disparity => DISPARITY_BINS,
            Self::Slope => SLOPES_DEG.len(),
            Self::Height => HEIGHTS_M.len() + 1,
            Self::Class => CLASS_NAMES.len(),
            Self::Shadow => SHADOWS.len(),
            Self::Boundary => DISTANCES_PX.len() + 1,
        }
    }
}

/// Equal bins from the lowest disparity to the highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DisparityBins {
    low_px: f64,
    step_px: f64,
}

impl DisparityBins {
    pub(super) fn new(low_px: f64, high_px: f64) -> Self {
        Self { low_px, step_px: ((high_px - low_px) / DISPARITY_BINS as f64).max(f64::MIN_POSITIVE) }
    }

    pub(super) fn bin(self, disparity_px: f32) -> u16 {
        if !disparity_px.is_finite() {
            return NO_BIN;
        }
        (((f64::from(disparity_px) - self.low_px) / self.step_px) as u16).min(DISPARITY_BINS as u16 - 1)
    }

    fn begin_px(self, bin: usize) -> f64 {
        self.low_px + self.step_px * bin as f64
    }
}

/// The bin of a normal, as the label stores it.
pub(super) fn slope_bin([x, y, z]: [i16; 3]) -> u16 {
    let [x, y, z] = [x, y, z].map(f64::from);
    let length = (x * x + y * y + z * z).sqrt();
    if length == 0.0 {
        return NO_BIN;
    }
    let slope_deg = libm::acos(z / length).to_degrees();
    SLOPES_DEG.iter().rposition(|from| slope_deg >= *from).unwrap_or(0) as u16
}

pub(super) fn height_bin(height_m: f64) -> u16 {
    HEIGHTS_M.iter().position(|to| height_m < *to).unwrap_or(HEIGHTS_M.len()) as u16
}

pub(super) fn boundary_bin(squared_distance: u32) -> u16 {
    DISTANCES_PX.iter().position(|to| squared_distance <= to * to).unwrap_or(DISTANCES_PX.len()) as u16
}

pub(super) fn shadow_bin(sun: u8) -> u16 {
    match sun {
        0 => 0,
        255 => 2,
        _ => 1,
    }
}

/// Scores by bins of one quantity. Bins without pixels are left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Breakdown {
    /// What the bins are bins of, with the unit.
    pub of: &'static str,
    /// The bins.
    pub rows: Vec<Row>,
}

/// One bin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name: `roof`, `30 to 45`.
    pub name: String,
    /// Where it begins, where it has a number; included unless said otherwise.
    pub from: Option<f64>,
    /// Where it ends.
    pub to: Option<f64>,
    /// Its scores.
    #[serde(flatten)]
    pub scores: ByVisibility<Scores>,
}

/// How bins become rows: fixed for all regions, so that a row means the same in each.
pub(super) struct Frames {
    pub(super) disparity: DisparityBins,
    /// The tenth of each step of contrast.
    pub(super) deciles: Vec<usize>,
}

impl Frames {
    /// The rows of one break-down; none where no pixel has a bin.
    pub(super) fn breakdown(&self, by: By, sums: &[Both]) -> Option<Breakdown> {
        let rows: Vec<Row> = if by == By::Texture {
            (0..10).filter_map(|decile| self.texture_row(decile, sums)).collect()
        } else {
            sums.iter().enumerate().filter_map(|(bin, s)| self.row(by, bin, s)).collect()
        };
        (!rows.is_empty()).then(|| Breakdown { of: by.of(), rows })
    }

    fn texture_row(&self, decile: usize, sums: &[Both]) -> Option<Row> {
        let mut sum = Both::default();
        let steps = || self.deciles.iter().enumerate().filter(|(_, d)| **d == decile).map(|(step, _)| step);
        steps().for_each(|step| sum.merge(&sums[step]));
        // Empty steps at a tenth's border belong to no pixel: the border is where the next tenth's first pixels are.
        let (from, to) = (steps().next()?, steps().next_back()? + 1);
        named(format!("{} of 10", decile + 1), Some(texture::levels(from)), Some(texture::levels(to)), &sum)
    }

    fn row(&self, by: By, bin: usize, sum: &Both) -> Option<Row> {
        let below = |ends: &[f64]| (bin.checked_sub(1).map(|i| ends[i]), ends.get(bin).copied());
        let (name, from, to) = match by {
            By::Class => (Some(CLASS_NAMES[bin].to_owned()), None, None),
            By::Shadow => (Some(SHADOWS[bin].to_owned()), None, None),
            By::Texture => (None, Some(texture::levels(bin)), Some(texture::levels(bin + 1))),
            By::Disparity => (None, Some(self.disparity.begin_px(bin)), Some(self.disparity.begin_px(bin + 1))),
            By::Slope => (None, Some(SLOPES_DEG[bin]), Some(SLOPES_DEG.get(bin + 1).copied().unwrap_or(180.0))),
            By::Height => {
                let (from, to) = below(&HEIGHTS_M);
                (None, from, to)
            }
            By::Boundary => {
                let (from, to) = below(&DISTANCES_PX.map(f64::from));
                (None, from, to)
            }
        };
        let name = name.unwrap_or_else(|| match (from, to) {
            (Some(a), Some(b)) => format!("{} to {}", short(a), short(b)),
            (None, Some(b)) if by == By::Boundary => short(b),
            (None, Some(b)) => format!("below {}", short(b)),
            (Some(a), None) => format!("above {}", short(a)),
            (None, None) => String::new(),
        });
        named(name, from, to, sum)
    }
}

/// Scores by baseline, given in whole millimetres.
pub(super) fn baselines(sums: &BTreeMap<i64, Both>) -> Option<Breakdown> {
    let rows: Vec<Row> = sums
        .iter()
        .filter_map(|(mm, sum)| {
            let baseline_m = *mm as f64 / 1000.0;
            named(short(baseline_m), Some(baseline_m), Some(baseline_m), sum)
        })
        .collect();
    (!rows.is_empty()).then_some(Breakdown { of: "baseline, m", rows })
}

fn named(name: String, from: Option<f64>, to: Option<f64>, sum: &Both) -> Option<Row> {
    (sum.all().pixels > 0).then(|| Row { name, from, to, scores: sum.scores() })
}

/// A border with at most one digit after the point.
fn short(x: f64) -> String {
    if x == x.round() { format!("{x:.0}") } else { format!("{x:.1}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_by_hand() {
        assert_eq!([-5.0, 2.4, 2.5, 59.9, 60.0].map(height_bin), [0, 0, 1, 3, 4]);
        assert_eq!([0, 1, 4, 5, 25, 26, 2500, 2501, u32::MAX].map(boundary_bin), [0, 1, 1, 2, 2, 3, 5, 6, 6]);
        assert_eq!([0, 1, 254, 255].map(shadow_bin), [0, 1, 1, 2]);
        // Flat, 45 degrees (a rounding below or above), upright, overhanging, nothing.
        assert_eq!(slope_bin([0, 0, 32767]), 0);
        assert_eq!(slope_bin([20000, 0, 20001]), 3);
        assert_eq!(slope_bin([20001, 0, 20000]), 4);
        assert_eq!(slope_bin([0, 32767, 0]), 6);
        assert_eq!(slope_bin([0, 0, -32767]), 6);
        assert_eq!(slope_bin([0, 0, 0]), NO_BIN);
        let bins = DisparityBins::new(-8.0, 8.0);
        assert_eq!([-8.0, -7.5, 0.0, 7.9, 8.0].map(|d| bins.bin(d)), [0, 0, 8, 15, 15]);
        assert_eq!([-100.0, 100.0, f32::NAN].map(|d| bins.bin(d)), [0, 15, NO_BIN]);
        assert_eq!(DisparityBins::new(3.0, 3.0).bin(3.0), 0, "a flat scene has one bin");
    }

    #[test]
    fn rows_are_named_and_empty_ones_left_out() {
        let frames =
            Frames { disparity: DisparityBins::new(0.0, 16.0), deciles: texture::deciles(&[1; texture::STEPS]) };
        let names = |by: By| {
            let mut sums = vec![Both::default(); by.bins()];
            assert_eq!(frames.breakdown(by, &sums), None);
            for s in &mut sums {
                s.add(false, 1.0, 1.0);
            }
            sums[1] = Both::default();
            let rows = frames.breakdown(by, &sums).unwrap().rows;
            rows.into_iter().map(|r| r.name).collect::<Vec<_>>()
        };
        assert_eq!(names(By::Height), ["below 2.5", "10 to 30", "30 to 60", "above 60"]);
        assert_eq!(names(By::Boundary)[..2], ["0", "2 to 5"]);
        assert_eq!(names(By::Shadow), ["shadow", "lit"]);
        assert_eq!(names(By::Disparity).len(), 15);
        assert_eq!(names(By::Class)[0], "none");
        assert_eq!(names(By::Texture).len(), 10);
        assert_eq!(names(By::Slope).last().unwrap(), "75 to 180");
    }
}
