//! A tessellated sphere: every label within what its tessellation allows.
//!
//! The surface lies between two concentric spheres. Its vertices are on the outer one but for the lattice (half a
//! diagonal of a lattice cell, q); a triangle with circumradius c comes as near to the centre as sqrt(R^2 - c^2), and
//! moving its corners by q moves each of its points by q at most. So it lies in [sqrt(R^2 - c^2) - q, R + q].

use crate::analytic::boxes::{PLACEMENTS, ground, rigs};
use crate::analytic::closed_form::{Form, VIEWS};
use crate::support::solids::sphere;
use crate::support::stage::{RigCase, Stage};
use glam::DVec3;
use satseed::labels::{Validity, View, explain};
use satseed_scene::{Class, Mesh, QUANTUM_M};
use satseed_tracer::Tracer;

const CENTRE: DVec3 = DVec3::new(3.75, -2.5, 45.0);
const RADIUS: f64 = 18.75;
const LEVELS: u32 = 6;

fn largest_circumradius(m: &Mesh) -> f64 {
    (0..m.triangles.len())
        .map(|t| {
            let [a, b, c] = m.corners(t);
            let (ab, bc, ca) = ((b - a).length(), (c - b).length(), (a - c).length());
            ab * bc * ca / (2.0 * (b - a).cross(c - a).length())
        })
        .fold(0.0, f64::max)
}

/// Depths at which a ray enters a sphere.
fn enters(centre: DVec3, way: DVec3, radius: f64) -> Option<f64> {
    let to = CENTRE - centre;
    let (a, b, c) = (way.dot(way), to.dot(way), to.dot(to) - radius * radius);
    let root = b * b - a * c;
    (root > 0.0).then(|| c / (b + root.sqrt()))
}

/// Distance of the sphere's centre from the line between two points, and whether the line first comes nearer to it.
fn passes(from: DVec3, to: DVec3) -> (f64, bool) {
    let way = (to - from).normalize();
    let inward = (CENTRE - from).dot(way);
    ((CENTRE - from - way * inward).length(), inward > 0.0)
}

#[test]
fn sphere_within_its_tessellation() {
    let unit = sphere(CENTRE, RADIUS, LEVELS);
    let q = QUANTUM_M * 3.0_f64.sqrt() / 2.0;
    let circumradius = largest_circumradius(&unit) + 2.0 * q;
    let (inner, outer) = ((RADIUS * RADIUS - circumradius * circumradius).sqrt() - q, RADIUS + q);
    assert!(outer - inner < 0.012, "{inner} {outer}: this tessellation proves little");
    // A facet leans away from the sphere's tangent plane by no more than this.
    let lean = 1.5 * (circumradius / RADIUS + 4.0 * q / circumradius);
    let (mut asked, mut open, mut hidden) = (0_u64, 0_u64, 0_u64);
    for placement in PLACEMENTS {
        let mut stage = Stage::new();
        placement.add(&mut stage, ground(0.0, 3200.0), Class::Ground);
        placement.add(&mut stage, unit.clone(), Class::Tree);
        let scene = stage.finish();
        let tracer = Tracer::new(&scene);
        for case in rigs(placement, [-100.0, 100.0], [-61_700.0, 61_700.0]).into_iter().skip(2).step_by(2) {
            let case = RigCase { size_px: [230, 170], ..case };
            let (form, rig) = (Form::new(&case), case.rig());
            for view in VIEWS {
                let other = form.centre(if view == View::Left { View::Right } else { View::Left });
                for (u, v) in (0..case.size_px[1]).flat_map(|v| (0..case.size_px[0]).map(move |u| (u, v))) {
                    let told = explain(&tracer, &rig, view, [u, v]);
                    let (eye, way) = (form.centre(view), form.slopes(view, u.into(), v.into()).extend(-1.0));
                    let d = told.disparity_px.expect("hit");
                    let place = || format!("{view:?} ({u}, {v}) {case:?}: {told:?}");
                    asked += 1;
                    let (near, far) = (enters(eye, way, outer), enters(eye, way, inner));
                    let seen = told.seen.as_ref().expect("hit");
                    let on_sphere = seen.object == 1;
                    match (near, far) {
                        (None, _) => assert!(!on_sphere, "{}", place()),
                        (Some(_), Some(_)) => assert!(on_sphere, "{}", place()),
                        // Between the two spheres' outlines: either.
                        (Some(_), None) => open += 1,
                    }
                    let (low, high) = if on_sphere {
                        let near = near.expect("the outer sphere holds all");
                        // A ray between the outlines leaves the outer sphere as deep as the tangent's length.
                        let far = far.unwrap_or(near + 2.0 * (outer * outer - inner * inner).sqrt() * way.length());
                        (form.disparity_px(far), form.disparity_px(near))
                    } else {
                        (form.disparity_px(form.altitude_m), form.disparity_px(form.altitude_m))
                    };
                    assert!(d >= low - 1e-9 && d <= high + 1e-9, "{d} not in {low}..{high}: {}", place());
                    if !form.in_other_frame(view, u.into(), d) {
                        assert_eq!(told.validity, Validity::OutOfFrame, "{}", place());
                        continue;
                    }
                    let point = eye + way * (case.altitude_m - seen.point_m.z);
                    let (distance, inward) = passes(point, other);
                    let verdict = if on_sphere {
                        let up = (point - CENTRE).normalize().dot((other - point).normalize());
                        if up > lean {
                            Some(Validity::Valid)
                        } else if inward && distance < inner - 1e-6 && up < -1e-3 {
                            Some(Validity::Occluded)
                        } else {
                            None
                        }
                    } else if distance > outer + 1e-6 {
                        Some(Validity::Valid)
                    } else if distance < inner - 1e-6 {
                        Some(Validity::Occluded)
                    } else {
                        None
                    };
                    if let Some(verdict) = verdict {
                        assert_eq!(told.validity, verdict, "{}", place());
                        hidden += u64::from(verdict == Validity::Occluded);
                    } else {
                        open += 1;
                    }
                }
            }
        }
    }
    assert!(hidden > 10_000, "{hidden} occluded");
    assert!(open * 50 < asked, "{open} of {asked} pixels are left open by the bound");
}
