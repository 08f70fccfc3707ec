//! Labels of a view: exact, from geometry alone.
//!
//! For each pixel's centre ray the two-step line trace: the closest surface point, then the way back from it to the other
//! camera. Disparity is the difference of the two projections of that point in f64; validity is a map of its own.

mod columns;
mod explain;
mod surface_models;
mod view;

pub use explain::{Explanation, Occluder, Seen, explain};
pub use surface_models::{SurfaceModels, surface_model_bytes, surface_models};
pub use view::{Extra, ViewLabels, extract};

use crate::camera::{Camera, StereoRig};
use glam::DVec3;
use satseed_scene::Ray;
use satseed_tracer::{Hit, Origin, Tracer};

/// What a pixel's label may be used for; the number is the value in the validity map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Validity {
    /// The ray met nothing.
    Miss = 0,
    /// The point is seen by both cameras.
    Valid = 1,
    /// The point lies in the other frame, but something stands before it.
    Occluded = 2,
    /// The point projects outside the other frame.
    OutOfFrame = 3,
}

/// Which of the two views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The left one.
    Left,
    /// The right one.
    Right,
}

impl View {
    /// This view's camera, and the other one.
    pub fn cameras(self, rig: &StereoRig) -> (&Camera, &Camera) {
        match self {
            Self::Left => (&rig.left, &rig.right),
            Self::Right => (&rig.right, &rig.left),
        }
    }
}

/// The closest surface along a camera's ray.
pub(crate) fn closest(tracer: &Tracer, ray: &Ray) -> Option<Hit> {
    tracer.closest(ray, tracer.reach_m(ray.origin))
}

/// `u_L - u_R` of a world point, px; the same sign in both views.
pub(crate) fn disparity_px(rig: &StereoRig, point: DVec3) -> Option<f64> {
    Some(rig.left.project(point)?.x - rig.right.project(point)?.x)
}

/// The second step for the points that one camera sees: may they be matched in `other`?
pub(crate) fn validity(tracer: &Tracer, other: &Camera, hits: &[Option<Hit>]) -> Vec<Validity> {
    let mut validity: Vec<Validity> =
        hits.iter().map(|hit| if hit.is_some() { Validity::OutOfFrame } else { Validity::Miss }).collect();
    let in_frame = |hit: &Hit| other.project(hit.point).is_some_and(|image| other.in_frame(image));
    let (asking, lines): (Vec<usize>, Vec<(Origin, DVec3)>) = hits
        .iter()
        .enumerate()
        .filter_map(|(i, hit)| {
            let hit = hit.as_ref().filter(|hit| in_frame(hit))?;
            Some((i, (Origin::on(hit), other.centre_for(hit.point))))
        })
        .unzip();
    for (i, occluded) in asking.into_iter().zip(tracer.occluded_all(&lines)) {
        validity[i] = if occluded { Validity::Occluded } else { Validity::Valid };
    }
    validity
}
