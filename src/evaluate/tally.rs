//! What is summed over a sample's pixels, and over samples.

use super::boundary::soft_edge_error_px;
use super::breakdown::{By, Frames};
use super::report::{BoundaryScores, Group};
use super::score::{Both, ByVisibility};
use super::truth::Truth;
use std::collections::BTreeMap;

/// Half-width of the zone around a boundary, squared, px^2.
const ZONE_SQUARED_PX: u32 = 25;

/// A mean in the making.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    count: u64,
    sum: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
    }

    fn merge(&mut self, other: Self) {
        self.count += other.count;
        self.sum += other.sum;
    }

    fn value(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// All sums of a sample or of many.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    samples: usize,
    pub(super) total: Both,
    /// By [`By::ALL`] and bin.
    pub(super) bins: [Vec<Both>; By::ALL.len()],
    /// By baseline in whole millimetres: floats have no order that a map could use.
    baselines: BTreeMap<i64, Both>,
    zone: Both,
    jump_pixels: u64,
    soft_edges: [Mean; 2],
    /// Means of the samples' own mean errors.
    images: ByVisibility<Mean>,
    out_of_frame: u64,
    nothing_hit: u64,
}

impl Tally {
    /// No sample yet.
    pub(super) fn new() -> Self {
        Self {
            samples: 0,
            total: Both::default(),
            bins: By::ALL.map(|by| vec![Both::default(); by.bins()]),
            baselines: BTreeMap::new(),
            zone: Both::default(),
            jump_pixels: 0,
            soft_edges: [Mean::default(); 2],
            images: ByVisibility::default(),
            out_of_frame: 0,
            nothing_hit: 0,
        }
    }

    /// The sums of one sample, pixel by pixel in the order of rows.
    pub(super) fn of(truth: &Truth, predicted: &[f64], baseline_m: Option<f64>) -> Self {
        let mut tally = Self::new();
        tally.samples = 1;
        for (i, predicted_px) in predicted.iter().enumerate() {
            let Some(occluded) = truth.occluded(i) else {
                let seen = truth.disparity_px[i].is_finite();
                *(if seen { &mut tally.out_of_frame } else { &mut tally.nothing_hit }) += 1;
                continue;
            };
            let truth_px = f64::from(truth.disparity_px[i]);
            tally.total.add(occluded, truth_px, *predicted_px);
            for (sums, bins) in tally.bins.iter_mut().zip(&truth.bins) {
                if let Some(sum) = bins.as_ref().and_then(|bins| sums.get_mut(usize::from(bins[i]))) {
                    sum.add(occluded, truth_px, *predicted_px);
                }
            }
            if truth.jump_distances[i] <= ZONE_SQUARED_PX {
                tally.zone.add(occluded, truth_px, *predicted_px);
            }
            if truth.jumps[i] {
                tally.jump_pixels += 1;
                if predicted_px.is_finite() {
                    for (mean, side) in tally.soft_edges.iter_mut().zip([3, 5]) {
                        let width = truth.size.width as usize;
                        mean.add(soft_edge_error_px(&truth.disparity_px, width, i, side, *predicted_px));
                    }
                }
            }
        }
        tally.baselines.extend(baseline_m.map(|m| ((m * 1000.0).round() as i64, tally.total)));
        let both = tally.total;
        for (mean, sums) in
            [(&mut tally.images.noc, both.noc), (&mut tally.images.occ, both.occ), (&mut tally.images.all, both.all())]
        {
            if let Some(epe_px) = sums.epe_px() {
                mean.add(epe_px);
            }
        }
        tally
    }

    /// Adds what another tally holds.
    pub(super) fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.total.merge(&other.total);
        for (own, others) in self.bins.iter_mut().flatten().zip(other.bins.iter().flatten()) {
            own.merge(others);
        }
        for (baseline, sums) in &other.baselines {
            self.baselines.entry(*baseline).or_default().merge(sums);
        }
        self.zone.merge(&other.zone);
        self.jump_pixels += other.jump_pixels;
        self.soft_edges.iter_mut().zip(other.soft_edges).for_each(|(a, b)| a.merge(b));
        self.images.noc.merge(other.images.noc);
        self.images.occ.merge(other.images.occ);
        self.images.all.merge(other.images.all);
        self.out_of_frame += other.out_of_frame;
        self.nothing_hit += other.nothing_hit;
    }

    /// The pixels of each step of contrast.
    pub(super) fn texture_counts(&self) -> Vec<u64> {
        let at = By::ALL.iter().position(|by| *by == By::Texture).unwrap_or_default();
        self.bins[at].iter().map(|s| s.noc.pixels + s.occ.pixels).collect()
    }

    /// The report of these sums.
    pub(super) fn group(&self, frames: &Frames) -> Group {
        let mut by: BTreeMap<&'static str, _> = BTreeMap::new();
        for (kind, sums) in By::ALL.iter().zip(&self.bins) {
            by.extend(frames.breakdown(*kind, sums).map(|b| (kind.name(), b)));
        }
        by.extend(super::breakdown::baselines(&self.baselines).map(|b| ("baseline", b)));
        Group {
            samples: self.samples,
            out_of_frame_pixels: self.out_of_frame,
            nothing_hit_pixels: self.nothing_hit,
            scores: self.total.scores(),
            epe_images_px: ByVisibility {
                noc: self.images.noc.value(),
                occ: self.images.occ.value(),
                all: self.images.all.value(),
            },
            boundary: BoundaryScores {
                within_5_px: self.zone.scores(),
                jump_pixels: self.jump_pixels,
                see_3_px: self.soft_edges[0].value(),
                see_5_px: self.soft_edges[1].value(),
            },
            by,
        }
    }
}
