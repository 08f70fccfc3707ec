//! Errors summed over pixels, and the scores that they give.

use serde::Serialize;

/// Error up to which a pixel counts as within: the three thresholds of `within` and `bad`, px.
const THRESHOLDS_PX: [f64; 3] = [1.0, 2.0, 3.0];
/// KITTI's outlier: more than this, px ...
const OUTLIER_PX: f64 = 3.0;
/// ... and more than this share of the truth.
const OUTLIER_SHARE: f64 = 0.05;

/// Sums over pixels, in the order in which they were added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sums {
    /// Pixels with truth.
    pub(super) pixels: u64,
    /// Those with a finite prediction.
    predicted: u64,
    error_px: f64,
    signed_px: f64,
    within: [u64; 3],
    outliers: u64,
}

impl Sums {
    /// Adds a pixel. A prediction that is not finite is none: it is as wrong as can be for shares, and outside means.
    pub(super) fn add(&mut self, truth_px: f64, predicted_px: f64) {
        self.pixels += 1;
        if !predicted_px.is_finite() {
            self.outliers += 1;
            return;
        }
        let signed_px = predicted_px - truth_px;
        let error_px = signed_px.abs();
        self.predicted += 1;
        self.error_px += error_px;
        self.signed_px += signed_px;
        for (count, threshold) in self.within.iter_mut().zip(THRESHOLDS_PX) {
            *count += u64::from(error_px <= threshold);
        }
        self.outliers += u64::from(error_px > OUTLIER_PX && error_px > OUTLIER_SHARE * truth_px.abs());
    }

    /// Adds what another sum holds.
    pub(super) fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.predicted += other.predicted;
        self.error_px += other.error_px;
        self.signed_px += other.signed_px;
        self.within.iter_mut().zip(other.within).for_each(|(a, b)| *a += b);
        self.outliers += other.outliers;
    }

    /// Mean error of the predicted pixels, px.
    pub(super) fn epe_px(&self) -> Option<f64> {
        (self.predicted > 0).then(|| self.error_px / self.predicted as f64)
    }

    /// The scores.
    pub(super) fn scores(&self) -> Scores {
        let share = |n: u64| (self.pixels > 0).then(|| n as f64 / self.pixels as f64);
        let [within_1, within_2, within_3] = self.within.map(share);
        let [bad_1, bad_2, bad_3] = self.within.map(|n| share(self.pixels - n));
        Scores {
            pixels: self.pixels,
            unpredicted: share(self.pixels - self.predicted),
            epe_px: self.epe_px(),
            bias_px: (self.predicted > 0).then(|| self.signed_px / self.predicted as f64),
            within_1,
            within_2,
            within_3,
            bad_1,
            bad_2,
            bad_3,
            d1: share(self.outliers),
        }
    }
}

/// Scores over pixels of one kind. None where no pixel counts.
///
/// Shares are of all pixels, 0 to 1; a pixel without a prediction is within nothing, bad and an outlier, so that leaving
/// holes gains nothing. Means are over the predicted pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Scores {
    /// Pixels with truth.
    pub pixels: u64,
    /// Share of them without a finite prediction.
    pub unpredicted: Option<f64>,
    /// End-point error: mean |predicted - truth|, px.
    pub epe_px: Option<f64>,
    /// Mean of predicted - truth, px.
    pub bias_px: Option<f64>,
    /// Share with an error of at most 1 px.
    pub within_1: Option<f64>,
    /// Share with an error of at most 2 px.
    pub within_2: Option<f64>,
    /// Share with an error of at most 3 px.
    pub within_3: Option<f64>,
    /// Share with an error above 1 px: 1 - `within_1`.
    pub bad_1: Option<f64>,
    /// Share with an error above 2 px.
    pub bad_2: Option<f64>,
    /// Share with an error above 3 px.
    pub bad_3: Option<f64>,
    /// KITTI's D1: share with an error above 3 px and above 5 % of the truth.
    pub d1: Option<f64>,
}

/// Sums over the pixels that both cameras see, and over the occluded ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Both {
    /// Valid pixels.
    pub(super) noc: Sums,
    /// Occluded pixels, against the amodal truth.
    pub(super) occ: Sums,
}

impl Both {
    /// Adds a pixel.
    pub(super) fn add(&mut self, occluded: bool, truth_px: f64, predicted_px: f64) {
        if occluded { &mut self.occ } else { &mut self.noc }.add(truth_px, predicted_px);
    }

    /// Adds what other sums hold.
    pub(super) fn merge(&mut self, other: &Self) {
        self.noc.merge(&other.noc);
        self.occ.merge(&other.occ);
    }

    /// Sums over both.
    pub(super) fn all(&self) -> Sums {
        let mut all = self.noc;
        all.merge(&self.occ);
        all
    }

    /// The scores.
    pub(super) fn scores(&self) -> ByVisibility<Scores> {
        ByVisibility { noc: self.noc.scores(), occ: self.occ.scores(), all: self.all().scores() }
    }
}

/// Something of the pixels that both cameras see, of the occluded ones, and of both. Out-of-frame pixels never count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ByVisibility<T> {
    /// Pixels that both cameras see (validity 1).
    pub noc: T,
    /// Pixels that only the left camera sees, although they lie in the right frame (validity 2): amodal truth.
    pub occ: T,
    /// Both.
    pub all: T,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out by hand: errors 0, 1, 1.5, 3.5, 4 and two holes.
    #[test]
    fn scores_by_hand() {
        let mut sums = Sums::default();
        assert_eq!(sums.scores(), Scores::default());
        for (truth, predicted) in [
            (10.0, 10.0),
            (10.0, 11.0),
            (10.0, 8.5),
            (10.0, 6.5),
            // 4 px of 100 px are 4 %: no outlier, though above 3 px.
            (100.0, 104.0),
            (5.0, f64::NAN),
            (5.0, f64::INFINITY),
        ] {
            sums.add(truth, predicted);
        }
        let s = sums.scores();
        assert_eq!(s.pixels, 7);
        assert_eq!(s.unpredicted, Some(2.0 / 7.0));
        assert_eq!(s.epe_px, Some(10.0 / 5.0));
        assert_eq!(s.bias_px, Some((1.0 - 1.5 - 3.5 + 4.0) / 5.0));
        assert_eq!((s.within_1, s.within_2, s.within_3), (Some(2.0 / 7.0), Some(3.0 / 7.0), Some(3.0 / 7.0)));
        assert_eq!((s.bad_1, s.bad_2, s.bad_3), (Some(5.0 / 7.0), Some(4.0 / 7.0), Some(4.0 / 7.0)));
        assert_eq!(s.d1, Some(3.0 / 7.0));
    }

    /// The share is of the truth's size: a negative disparity is no outlier for its sign.
    #[test]
    fn outliers_of_negative_disparities() {
        let mut sums = Sums::default();
        sums.add(-100.0, -104.0);
        assert_eq!(sums.scores().d1, Some(0.0));
        sums.add(-100.0, -106.0);
        assert_eq!(sums.scores().d1, Some(0.5));
    }

    #[test]
    fn both_are_summed() {
        let mut both = Both::default();
        both.add(false, 1.0, 2.0);
        both.add(true, 1.0, 4.0);
        let s = both.scores();
        assert_eq!((s.noc.epe_px, s.occ.epe_px, s.all.epe_px), (Some(1.0), Some(3.0), Some(2.0)));
    }
}
