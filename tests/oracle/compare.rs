//! Holding a labeller's answers against the oracle's.

use super::brute::{Answer, Candidates, answer, in_band};
use glam::DVec3;
use rayon::prelude::*;
use satseed::camera::StereoRig;
use satseed::labels::{Validity, View, explain};
use satseed_tracer::Tracer;

pub(crate) const VIEWS: [View; 2] = [View::Left, View::Right];

/// A labeller's answer for one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told {
    pub(crate) hit: Option<(u32, u32)>,
    pub(crate) disparity_px: f64,
    pub(crate) validity: Validity,
    pub(crate) point: DVec3,
}

impl Told {
    pub(crate) const MISS: Self =
        Self { hit: None, disparity_px: f64::NAN, validity: Validity::Miss, point: DVec3::NAN };
}

/// What is on trial: satseed's labels, or a faulty copy of them.
pub(crate) trait Labeller: Sync {
    fn told(&self, rig: &StereoRig, view: View, pixel: [u32; 2]) -> Told;
}

impl Labeller for Tracer<'_> {
    fn told(&self, rig: &StereoRig, view: View, pixel: [u32; 2]) -> Told {
        let e = explain(self, rig, view, pixel);
        assert_eq!(e.occluder.is_some(), e.validity == Validity::Occluded, "an occluded pixel has an occluder");
        match e.seen {
            None => Told { validity: e.validity, ..Told::MISS },
            Some(seen) => Told {
                hit: Some((seen.instance_triangle[0], seen.instance_triangle[1])),
                disparity_px: e.disparity_px.expect("a hit has a disparity"),
                validity: e.validity,
                point: seen.point_m,
            },
        }
    }
}

/// The outcome of a comparison.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) pixels: u64,
    pub(crate) by_validity: [u64; 4],
    /// Pixels that differ and pass within 1e-9 of the ray's length of an edge.
    pub(crate) in_band: u64,
    /// Those of them that name another triangle but the same place: a shared edge's other side.
    pub(crate) same_place: u64,
    /// Pixels that differ without that excuse.
    pub(crate) wrong: u64,
    /// The first of them, in words.
    pub(crate) first: Option<String>,
    /// Largest error of disparity, as a share of what is allowed.
    pub(crate) worst: f64,
}

impl Outcome {
    pub(crate) fn add(&mut self, other: Self) {
        self.pixels += other.pixels;
        for k in 0..4 {
            self.by_validity[k] += other.by_validity[k];
        }
        self.in_band += other.in_band;
        self.same_place += other.same_place;
        self.wrong += other.wrong;
        self.first = self.first.take().or(other.first);
        self.worst = self.worst.max(other.worst);
    }

    #[allow(clippy::print_stderr, reason = "the counts are part of the proof")]
    pub(crate) fn print(&self, what: &str) {
        let [miss, valid, occluded, out] = self.by_validity;
        eprintln!(
            "{what}: {} pixels ({valid} valid, {occluded} occluded, {out} out of frame, {miss} miss), {} differ beside an \
             edge ({} of them name the neighbour at the same place), {} differ; disparity within {:.2} of what is allowed",
            self.pixels, self.in_band, self.same_place, self.wrong, self.worst
        );
    }

    /// No disagreement, and hardly any excuse.
    pub(crate) fn demand(&self, most_in_band: f64) {
        assert_eq!(self.wrong, 0, "{}", self.first.as_deref().unwrap_or(""));
        assert!(self.in_band as f64 <= most_in_band * self.pixels as f64, "{} of {}", self.in_band, self.pixels);
    }
}

/// What f64 may be wrong by in disparity, px: 1e-9 px of the nominal 0.3 m, and more only where a ray meets the surface
/// at a flat angle, which magnifies the rounding of the ray itself.
fn allowed_px(rig: &StereoRig, a: &Answer) -> f64 {
    let pixels_of_nominal = 0.3 / rig.spec.gsd_m;
    // f64 knows places along a ray to some 2^-50 of its length, 0.6 nm at 617 km; a flat angle turns that into height.
    let steep = 1e-15 * a.t * rig.spec.baseline_m / rig.spec.altitude_m / a.facing / rig.spec.gsd_m;
    (1e-9 * pixels_of_nominal).max(steep)
}

/// Compares all pixels of the given rows in both views.
pub(crate) fn compare<C: Candidates + Sync>(
    candidates: &C,
    labeller: &impl Labeller,
    rig: &StereoRig,
    rows: core::ops::Range<u32>,
) -> Outcome {
    let mut total = Outcome::default();
    for view in VIEWS {
        let camera = view.cameras(rig).0;
        let outcomes: Vec<Outcome> = rows
            .clone()
            .into_par_iter()
            .map(|v| {
                let mut row = Outcome::default();
                for u in 0..camera.width_px {
                    one(candidates, labeller, rig, view, [u, v], &mut row);
                }
                row
            })
            .collect();
        for outcome in outcomes {
            total.add(outcome);
        }
    }
    total
}

fn one<C: Candidates + Sync>(
    candidates: &C,
    labeller: &impl Labeller,
    rig: &StereoRig,
    view: View,
    pixel: [u32; 2],
    outcome: &mut Outcome,
) {
    let want = answer(candidates, rig, view, pixel);
    let told = labeller.told(rig, view, pixel);
    outcome.pixels += 1;
    outcome.by_validity[want.validity as usize] += 1;
    let same = told.hit == want.hit.map(|t| t.id()) && told.validity == want.validity;
    if same && want.hit.is_none() {
        return;
    }
    if same {
        let share = (told.disparity_px - want.disparity_px).abs() / allowed_px(rig, &want);
        outcome.worst = outcome.worst.max(share);
        if share <= 1.0 {
            return;
        }
    } else {
        let points: Vec<DVec3> = [told.point, want.point].into_iter().filter(|p| p.is_finite()).collect();
        if in_band(candidates, rig, view, pixel, &points) {
            outcome.in_band += 1;
            let near = (told.disparity_px - want.disparity_px).abs() <= 2.0 * allowed_px(rig, &want);
            outcome.same_place += u64::from(near && told.validity == want.validity);
            return;
        }
    }
    outcome.wrong += 1;
    outcome.first.get_or_insert_with(|| format!("{view:?} {pixel:?} {rig:?}: told {told:?}, but {want:?}"));
}
