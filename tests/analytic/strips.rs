//! The facts that are known as numbers: the paper's table, and the widths of what an edge hides.

use crate::analytic::bodies::Boxes;
use crate::analytic::boxes::{Placement, boxes_scene};
use crate::support::stage::{RigCase, noon};
use glam::DVec3;
use satseed::camera::Datum;
use satseed::labels::{Extra, Validity, View, ViewLabels, extract};
use satseed_scene::Class;
use satseed_tracer::Tracer;

const FOCAL_PX: f64 = 1000.0 / 0.3;
const CENTRE_PX: f64 = 1023.5;

fn paper_rig(feet_m: [f64; 2]) -> RigCase {
    RigCase {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [2048, 2],
        feet_m,
        azimuth_rad: Placement::Axis.azimuth_rad(),
        datum: Datum::None,
        shift_px: [0.0; 2],
    }
}

fn views(solids: Vec<[DVec3; 2]>, feet_m: [f64; 2]) -> [ViewLabels; 2] {
    let bodies = Boxes { ground_z: 0.0, ground_half: 3200.0, solids };
    let scene = boxes_scene(&bodies, Placement::Axis, &[Class::Ground, Class::Facade]);
    let tracer = Tracer::new(&scene);
    let rig = paper_rig(feet_m).rig();
    let extra = Extra { class: true, ..Extra::default() };
    [View::Left, View::Right].map(|view| extract(&tracer, &rig, view, &noon(), extra))
}

/// Columns of the first row whose pixel has this validity and class.
fn columns(labels: &ViewLabels, validity: Validity, class: Class) -> Vec<u32> {
    let classes = labels.class.as_ref().expect("asked");
    (0..labels.width)
        .filter(|u| labels.validity[*u as usize] == validity as u8 && classes[*u as usize] == class as u8)
        .collect()
}

/// All integers strictly between two image coordinates.
fn between(from: f64, to: f64) -> Vec<u32> {
    (0..2048).filter(|u| f64::from(*u) > from && f64::from(*u) < to).collect()
}

/// B = 50, 100, 150, 200 m: 166.7, 333.3, 500.0, 666.7 px, and 8.1, 16.3, 24.4, 32.6 % of columns are out of frame.
#[test]
fn out_of_frame_as_in_the_paper() {
    for (baseline, disparity, share) in
        [(50.0, 166.7, 8.1), (100.0, 333.3, 16.3), (150.0, 500.0, 24.4), (200.0, 666.7, 32.6)]
    {
        let d = FOCAL_PX * baseline / 1000.0;
        assert!((d - disparity).abs() < 0.05);
        let [left, right] = views(vec![], [-baseline / 2.0, baseline / 2.0]);
        let out = columns(&left, Validity::OutOfFrame, Class::Ground);
        let want: Vec<u32> = (0..2048).filter(|u| f64::from(*u) - d < -0.5).collect();
        assert_eq!(out, want, "exactly the pixels with u - d < -0.5");
        assert!((out.len() as f64 / 20.48 - share).abs() < 0.05 + 0.5 / 20.48, "{} columns", out.len());
        let want: Vec<u32> = (0..2048).filter(|u| f64::from(*u) + d >= 2047.5).collect();
        assert_eq!(columns(&right, Validity::OutOfFrame, Class::Ground), want);
        assert_eq!(left.disparity_px[0], d as f32, "the amodal value stays where it is out of frame");
    }
}

/// A 60 m box right below or beyond both cameras: the strip on the ground is f B h / (H (H - h)) px wide, 42.55 px at
/// 200 m and 10.64 px at 50 m; both views, both edges.
#[test]
fn strip_beside_an_edge_outside_the_feet() {
    let h = 60.0;
    for (baseline, known) in [(200.0, 42.55), (50.0, 10.64)] {
        let width = FOCAL_PX * baseline * h / (1000.0 * (1000.0 - h));
        assert!((width - known).abs() < 0.005);
        let (c_l, c_r) = (-baseline / 2.0, baseline / 2.0);
        // Where a camera's line of sight over a roof's edge meets the ground.
        let cast = |edge: f64, foot: f64| foot + (edge - foot) * 1000.0 / (1000.0 - h);
        let u_of = |x: f64, foot: f64| CENTRE_PX + FOCAL_PX * (x - foot) / 1000.0;
        // Its left edge stands left of the left foot: the left view loses ground left of the box.
        let edge = c_l - 7.5;
        let block = [DVec3::new(edge, -520.0, -1.25), DVec3::new(edge + 61.25, 520.0, h)];
        let [left, _] = views(vec![block], [c_l, c_r]);
        let (from, to) = (u_of(cast(edge, c_r), c_l), u_of(cast(edge, c_l), c_l));
        assert!((to - from - width).abs() < 1e-9);
        let mut hidden = columns(&left, Validity::Occluded, Class::Ground);
        hidden.retain(|u| f64::from(*u) < u_of(edge, c_l));
        assert_eq!(hidden, between(from, to));
        assert!((hidden.len() as f64 - width).abs() < 1.0);
        // Its right edge stands right of the right foot: the mirror in the right view.
        let edge = c_r + 7.5;
        let block = [DVec3::new(edge - 61.25, -520.0, -1.25), DVec3::new(edge, 520.0, h)];
        let [_, right] = views(vec![block], [c_l, c_r]);
        let (from, to) = (u_of(cast(edge, c_r), c_r), u_of(cast(edge, c_l), c_r));
        assert!((to - from - width).abs() < 1e-9);
        let mut hidden = columns(&right, Validity::Occluded, Class::Ground);
        hidden.retain(|u| f64::from(*u) > u_of(edge, c_r));
        assert_eq!(hidden, between(from, to));
    }
}

/// A box from -30 to 30 m between the feet: 27.7 px of ground and 14.9 px of wall, in both views; and none at an edge
/// beyond the other camera.
#[test]
fn strips_of_a_box_between_the_feet() {
    let block = [DVec3::new(-30.0, -520.0, -1.25), DVec3::new(30.0, 520.0, 60.0)];
    let [left, right] = views(vec![block], [-100.0, 100.0]);
    let roof_edge = CENTRE_PX + FOCAL_PX * 70.0 / 940.0;
    let base = CENTRE_PX + FOCAL_PX * 70.0 / 1000.0;
    let cast = CENTRE_PX + FOCAL_PX * (100.0 - 130.0 * 1000.0 / 940.0 + 100.0) / 1000.0;
    assert!((base - cast - 27.7).abs() < 0.05 && (roof_edge - base - 14.9).abs() < 0.05);
    let mut ground = columns(&left, Validity::Occluded, Class::Ground);
    ground.retain(|u| f64::from(*u) < roof_edge);
    assert_eq!(ground, between(cast, base));
    assert_eq!(columns(&left, Validity::Occluded, Class::Facade), between(base, roof_edge));
    // The right view is the mirror image: column 2047 - u.
    let mirrored = |columns: Vec<u32>| columns.into_iter().rev().map(|u| 2047 - u).collect::<Vec<_>>();
    let mut ground = columns(&right, Validity::Occluded, Class::Ground);
    ground.retain(|u| f64::from(*u) > 2047.0 - roof_edge);
    assert_eq!(mirrored(ground), between(cast, base));
    assert_eq!(mirrored(columns(&right, Validity::Occluded, Class::Facade)), between(base, roof_edge));

    // Left edge right of both feet: nothing is lost left of it in the left view.
    let block = [DVec3::new(-60.0, -520.0, -1.25), DVec3::new(-5.0, 520.0, 60.0)];
    let [left, _] = views(vec![block], [-150.0, -70.0]);
    let edge = CENTRE_PX + FOCAL_PX * 90.0 / 1000.0;
    let hidden = columns(&left, Validity::Occluded, Class::Ground);
    assert!(hidden.iter().all(|u| f64::from(*u) > edge), "{hidden:?}");
}
