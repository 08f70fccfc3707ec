//! What a rig sees of bodies given by formulas, and the comparison with the labels.

use crate::analytic::bodies::{Bodies, Surface};
use crate::support::stage::{RigCase, noon, world_from_baseline};
use glam::{DVec2, DVec3};
use satseed::camera::Datum;
use satseed::labels::{Extra, Validity, View, explain, extract};
use satseed_scene::Scene;
use satseed_tracer::Tracer;

pub(crate) const VIEWS: [View; 2] = [View::Left, View::Right];

/// The rig in numbers, from its definition and not from the camera's code. The frame is (along the baseline, image up,
/// up), so image down is -y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    pub(crate) focal_px: f64,
    pub(crate) altitude_m: f64,
    pub(crate) feet_m: [f64; 2],
    pub(crate) doffs_px: f64,
    pub(crate) cx_px: [f64; 2],
    pub(crate) cy_px: f64,
    pub(crate) size_px: [u32; 2],
}

/// What a pixel must say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    pub(crate) surface: Surface,
    pub(crate) disparity_px: f64,
    pub(crate) validity: Validity,
}

impl Form {
    pub(crate) fn new(case: &RigCase) -> Self {
        let focal_px = case.altitude_m / case.gsd_m;
        let baseline = case.feet_m[1] - case.feet_m[0];
        let doffs_px = match case.datum {
            Datum::None => 0.0,
            Datum::Height(z) => focal_px * baseline / (case.altitude_m - z),
        };
        let middle = (f64::from(case.size_px[0]) - 1.0) / 2.0 + case.shift_px[0];
        Self {
            focal_px,
            altitude_m: case.altitude_m,
            feet_m: case.feet_m,
            doffs_px,
            cx_px: [middle - doffs_px / 2.0, middle + doffs_px / 2.0],
            cy_px: (f64::from(case.size_px[1]) - 1.0) / 2.0 + case.shift_px[1],
            size_px: case.size_px,
        }
    }

    pub(crate) fn disparity_px(&self, depth_m: f64) -> f64 {
        self.focal_px * (self.feet_m[1] - self.feet_m[0]) / depth_m - self.doffs_px
    }

    /// Metres along x and y for each metre of depth.
    pub(crate) fn slopes(&self, view: View, u: f64, v: f64) -> DVec2 {
        DVec2::new(u - self.cx_px[view as usize], self.cy_px - v) / self.focal_px
    }

    /// The camera's place.
    pub(crate) fn centre(&self, view: View) -> DVec3 {
        DVec3::new(self.feet_m[view as usize], 0.0, self.altitude_m)
    }

    /// Whether a point that is seen at column `u` lies in the other image.
    pub(crate) fn in_other_frame(&self, view: View, u: f64, disparity_px: f64) -> bool {
        let other = if view == View::Left { u - disparity_px } else { u + disparity_px };
        (-0.5..f64::from(self.size_px[0]) - 0.5).contains(&other)
    }

    /// What the ray through (u, v) must meet, and what that point's validity must be.
    pub(crate) fn expected(&self, bodies: &dyn Bodies, view: View, u: f64, v: f64) -> Option<Expected> {
        let other = if view == View::Left { View::Right } else { View::Left };
        let surface = bodies.first(self.centre(view), self.slopes(view, u, v))?;
        let disparity_px = self.disparity_px(surface.depth_m);
        let validity = if !self.in_other_frame(view, u, disparity_px) {
            Validity::OutOfFrame
        } else if bodies.blocked(&surface, self.centre(other)) {
            Validity::Occluded
        } else {
            Validity::Valid
        };
        Some(Expected { surface, disparity_px, validity })
    }
}

/// How often each validity was seen, and how far disparity was off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) pixels: [u64; 4],
    pub(crate) worst_px: f64,
}

impl Tally {
    pub(crate) fn add(&mut self, other: &Self) {
        for k in 0..4 {
            self.pixels[k] += other.pixels[k];
        }
        self.worst_px = self.worst_px.max(other.worst_px);
    }
}

/// Holds every label of both views against the closed form.
pub(crate) fn check(what: &str, scene: &Scene, case: &RigCase, bodies: &dyn Bodies) -> Tally {
    let form = Form::new(case);
    let tracer = Tracer::new(scene);
    let rig = case.rig();
    let world = world_from_baseline(case.azimuth_rad);
    let all = Extra { elevation: true, class: true, instance: true, normal: true, shadow: false, edge: true };
    let mut tally = Tally::default();
    for view in VIEWS {
        let labels = extract(&tracer, &rig, view, &noon(), all);
        let (elevation, class) = (labels.elevation_m.expect("asked"), labels.class.expect("asked"));
        let (instance, normal) = (labels.instance.expect("asked"), labels.normal.expect("asked"));
        let edge = labels.edge.expect("asked");
        for (at, pixel) in (0..case.size_px[1]).flat_map(|v| (0..case.size_px[0]).map(move |u| [u, v])).enumerate() {
            let (u, v) = (f64::from(pixel[0]), f64::from(pixel[1]));
            let told = explain(&tracer, &rig, view, pixel);
            let place = || format!("{what}, {view:?} {pixel:?}, {case:?}");
            assert_eq!(told.validity as u8, labels.validity[at], "explain and the map differ: {}", place());
            let (wanted, corners) = expected_edge(&form, bodies, view, u, v);
            assert_eq!(edge[at], wanted, "edge {corners:?}: {}", place());
            let Some(want) = form.expected(bodies, view, u, v) else {
                assert_eq!(told.validity, Validity::Miss, "{}", place());
                assert_eq!(labels.disparity_px[at].to_bits(), 0x7fc0_0000, "{}", place());
                assert_eq!((class[at], instance[at], normal[at]), (0, 0, [0.0; 3]), "{}", place());
                tally.pixels[0] += 1;
                continue;
            };
            let seen = told.seen.as_ref().unwrap_or_else(|| panic!("nothing seen: {}", place()));
            let d = told.disparity_px.expect("a hit has a disparity");
            let off = (d - want.disparity_px).abs();
            assert!(off <= 1e-9, "disparity {d} instead of {} ({off:e}): {}", want.disparity_px, place());
            assert_eq!(told.validity, want.validity, "{want:?}: {}", place());
            assert_eq!(labels.disparity_px[at], d as f32, "not the nearest f32: {}", place());
            let z = case.altitude_m - want.surface.depth_m;
            assert!((f64::from(elevation[at]) - z).abs() <= 8e-6 + 1e-8, "elevation: {}", place());
            assert_eq!(instance[at], want.surface.part, "object: {}", place());
            assert_eq!(class[at], scene.objects[want.surface.part as usize].class as u8, "class: {}", place());
            let n = world * want.surface.normal;
            assert!((DVec3::from(normal[at].map(f64::from)) - n).length() < 1e-6, "normal: {}", place());
            assert!((seen.normal - n).length() < 1e-9, "normal: {}", place());
            tally.pixels[told.validity as usize] += 1;
            tally.worst_px = tally.worst_px.max(off);
        }
    }
    tally
}

/// 1 where the closed form's disparities at the pixel's corners span more than 1 px, or only some of them exist.
fn expected_edge(form: &Form, bodies: &dyn Bodies, view: View, u: f64, v: f64) -> (u8, [Option<f64>; 4]) {
    let corners = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)].map(|(du, dv)| {
        bodies.first(form.centre(view), form.slopes(view, u + du, v + dv)).map(|s| form.disparity_px(s.depth_m))
    });
    let hits: Vec<f64> = corners.into_iter().flatten().collect();
    let span =
        hits.iter().copied().fold(f64::NEG_INFINITY, f64::max) - hits.iter().copied().fold(f64::INFINITY, f64::min);
    (u8::from(matches!(hits.len(), 1..=3) || span > 1.0), corners)
}
