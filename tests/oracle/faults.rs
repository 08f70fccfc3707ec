//! Planted faults: each must be caught, and the same labeller without one must pass.

use super::brute::{Everything, Tri, expand};
use super::compare::{Labeller, Outcome, Told, compare};
use super::scenes::{ALTITUDES_M, gaps, member, town};
use super::scenes::{FAMILIES, pair};
use glam::{DVec3, Vec3};
use satseed::camera::StereoRig;
use satseed::labels::{Validity, View};
use satseed_scene::{Scene, SeedPath};
use satseed_tracer::Tracer;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    HalfPixel,
    PointInF32,
    RayInF32,
    NoOwnRule,
    HighestOfTies,
    OffsetStart,
}

/// A labeller of plain loops that can be told to do one thing wrong.
struct Faulty {
    triangles: Vec<Tri>,
    fault: Fault,
}

impl Labeller for Faulty {
    fn told(&self, rig: &StereoRig, view: View, pixel: [u32; 2]) -> Told {
        let (camera, other) = view.cameras(rig);
        let shift = if self.fault == Fault::HalfPixel { 0.5 } else { 0.0 };
        let ray = camera.ray(f64::from(pixel[0]) + shift, f64::from(pixel[1]) + shift);
        let mut hits: Vec<(f64, &Tri)> = self
            .triangles
            .iter()
            .filter_map(|tri| {
                let t = if self.fault == Fault::RayInF32 {
                    meets_f32(tri, ray.origin, ray.direction)
                } else {
                    tri.meets(ray.origin, ray.direction)
                };
                t.filter(|t| *t > 0.0).map(|t| (t, tri))
            })
            .collect();
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(&(nearest, _)) = hits.first() else { return Told::MISS };
        hits.retain(|h| h.0 <= nearest * (1.0 + 1e-12));
        hits.sort_by_key(|h| h.1.id());
        let (t, tri) = if self.fault == Fault::HighestOfTies { hits[hits.len() - 1] } else { hits[0] };
        let mut point = ray.origin + ray.direction * t;
        if self.fault == Fault::PointInF32 {
            point = point.as_vec3().as_dvec3();
        }
        let disparity_px = rig.left.project(point).expect("below").x - rig.right.project(point).expect("below").x;
        let in_frame = other.project(point).is_some_and(|p| other.in_frame(p));
        let validity = if !in_frame {
            Validity::OutOfFrame
        } else if self.blocked(tri, point, other.position_m, 2e-12 * t) {
            Validity::Occluded
        } else {
            Validity::Valid
        };
        Told { hit: Some(tri.id()), disparity_px, validity, point }
    }
}

impl Faulty {
    fn blocked(&self, own: &Tri, point: DVec3, centre: DVec3, bound_m: f64) -> bool {
        let length = (centre - point).length();
        let way = (centre - point) / length;
        let [a, b, c] = own.corners;
        let normal = (b - a).cross(c - a).normalize();
        self.triangles.iter().any(|tri| match self.fault {
            Fault::NoOwnRule => tri.meets(point, way).is_some_and(|t| t > 0.0),
            Fault::OffsetStart => tri.meets(point + way * 1e-4, way).is_some_and(|t| t > 0.0),
            _ => tri.meets(point, way).is_some_and(|t| {
                let touches = tri.corners.iter().any(|p| own.corners.contains(p));
                t > bound_m && tri.id() != own.id() && !(touches && (way * t).dot(normal).abs() <= bound_m)
            }),
        })
    }
}

/// Moeller and Trumbore's test (1997) in f32, as a picture's tracer would do it.
fn meets_f32(tri: &Tri, eye: DVec3, way: DVec3) -> Option<f64> {
    let [a, b, c] = tri.corners.map(DVec3::as_vec3);
    let (eye, way): (Vec3, Vec3) = (eye.as_vec3(), way.as_vec3());
    let (ab, ac) = (b - a, c - a);
    let p = way.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = eye - a;
    let (u, q) = (s.dot(p) / determinant, s.cross(ab));
    let v = way.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| f64::from(ac.dot(q) / determinant))
}

fn outcome(scene: &Scene, rig: &StereoRig, fault: Fault) -> Outcome {
    let faulty = Faulty { triangles: expand(scene), fault };
    compare(&Everything(expand(scene)), &faulty, rig, 0..rig.left.height_px)
}

#[test]
fn every_planted_fault_is_caught() {
    let all = [
        Fault::None,
        Fault::HalfPixel,
        Fault::PointInF32,
        Fault::RayInF32,
        Fault::NoOwnRule,
        Fault::HighestOfTies,
        Fault::OffsetStart,
    ];
    for fault in all {
        let mut total = Outcome::default();
        for altitude_m in ALTITUDES_M {
            for name in ["height fields", "closed solids", "same surface twice", "thin gaps"] {
                let family = FAMILIES.iter().find(|f| f.name == name).expect("a family");
                let (scene, rig) = member(family, 5, altitude_m);
                total.add(outcome(&scene, &rig, fault));
            }
        }
        total.print(&format!("planted {fault:?}"));
        if fault == Fault::None {
            total.demand(1e-4);
        } else {
            assert!(total.wrong > 0, "{fault:?} went unnoticed");
        }
    }
}

/// The two faults that only some scenes show, on those scenes alone.
#[test]
fn ties_and_offsets_are_caught_where_they_show() {
    let mut rng = SeedPath::root("gap", 1).rng();
    let (scene, rig) = gaps(&mut rng, 1000.0);
    assert!(outcome(&scene, &rig, Fault::OffsetStart).wrong > 50, "a sheet 5e-5 m above hides more pixels than that");
    let mut rng = SeedPath::root("tie", 1).rng();
    let (scene, rig) = super::scenes::twice(&mut rng, 1000.0);
    assert!(outcome(&scene, &rig, Fault::HighestOfTies).wrong > 50);
}

/// satseed's own labels from cameras half a pixel off.
struct Shifted<'s>(Tracer<'s>);

impl Labeller for Shifted<'_> {
    fn told(&self, rig: &StereoRig, view: View, pixel: [u32; 2]) -> Told {
        let mut rig = *rig;
        rig.left.cx_px += 0.5;
        rig.right.cx_px += 0.5;
        self.0.told(&rig, view, pixel)
    }
}

#[test]
fn half_a_pixel_in_the_camera_is_caught() {
    let scene = town(3, 32, 1.0, 6);
    let rig = pair(1000.0, [32, 32], 0.3);
    let all = Everything(expand(&scene));
    compare(&all, &Tracer::new(&scene), &rig, 0..32).demand(0.0);
    let shifted = compare(&all, &Shifted(Tracer::new(&scene)), &rig, 0..32);
    assert!(shifted.wrong > 1000, "only {} of 2048 pixels show half a pixel", shifted.wrong);
}
