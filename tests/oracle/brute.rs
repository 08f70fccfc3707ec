//! The oracle: plane and edge tests in f64, written from the definitions and from nothing of the tracer.

use super::double;
use glam::{DVec2, DVec3};
use satseed::camera::{Camera, StereoRig};
use satseed::labels::{Validity, View};
use satseed_scene::Scene;

/// A triangle in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tri {
    pub(crate) corners: [DVec3; 3],
    pub(crate) instance: u32,
    pub(crate) triangle: u32,
}

impl Tri {
    pub(crate) fn id(&self) -> (u32, u32) {
        (self.instance, self.triangle)
    }

    /// Where the line from `eye` along unit `way` meets the triangle, borders included.
    pub(crate) fn meets(&self, eye: DVec3, way: DVec3) -> Option<f64> {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let against = normal.dot(way);
        if against == 0.0 {
            return None;
        }
        let t = normal.dot(a - eye) / against;
        let p = eye + way * t;
        let inside = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
        (inside(a, b) && inside(b, c) && inside(c, a)).then_some(t)
    }

    /// The smallest distance between one of the edges and a segment.
    fn edge_distance(&self, from: DVec3, to: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        segment_distance(a, b, from, to).min(segment_distance(b, c, from, to)).min(segment_distance(c, a, from, to))
    }
}

/// Distance of two segments: of the lines where their feet lie inside, else of an end and a segment.
fn segment_distance(a: DVec3, b: DVec3, from: DVec3, to: DVec3) -> f64 {
    let to_segment = |p: DVec3, q: DVec3, r: DVec3| {
        let d = r - q;
        let s = ((p - q).dot(d) / d.length_squared()).clamp(0.0, 1.0);
        (p - q - d * s).length()
    };
    let mut best =
        to_segment(a, from, to).min(to_segment(b, from, to)).min(to_segment(from, a, b)).min(to_segment(to, a, b));
    let (e, f) = (b - a, to - from);
    let across = e.cross(f);
    let size = across.length_squared();
    if size > 0.0 {
        let way = from - a;
        let (s, t) = (way.cross(f).dot(across) / size, way.cross(e).dot(across) / size);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            best = best.min((way.dot(across) / size.sqrt()).abs());
        }
    }
    best
}

/// All triangles of a scene, instance by instance.
pub(crate) fn expand(scene: &Scene) -> Vec<Tri> {
    let mut out = Vec::new();
    for (instance, i) in scene.instances.iter().enumerate() {
        for triangle in 0..scene.meshes[i.mesh as usize].triangles.len() {
            let (instance, triangle) = (instance as u32, triangle as u32);
            out.push(Tri { corners: scene.corners(instance, triangle), instance, triangle });
        }
    }
    out
}

/// Which triangles a segment through a camera's centre can meet.
pub(crate) trait Candidates {
    fn triangles(&self) -> &[Tri];
    /// Indices of those that lie behind an image point of a view; `None` for all.
    fn behind(&self, view: View, image_px: DVec2) -> Option<&[u32]>;
}

/// Every triangle, always.
pub(crate) struct Everything(pub(crate) Vec<Tri>);

impl Candidates for Everything {
    fn triangles(&self) -> &[Tri] {
        &self.0
    }

    fn behind(&self, _view: View, _image_px: DVec2) -> Option<&[u32]> {
        None
    }
}

fn each<C: Candidates + ?Sized>(candidates: &C, view: View, image_px: DVec2, mut f: impl FnMut(&Tri) -> bool) {
    let all = candidates.triangles();
    match candidates.behind(view, image_px) {
        None => {
            for t in all {
                if f(t) {
                    return;
                }
            }
        }
        Some(some) => {
            for t in some {
                if f(&all[*t as usize]) {
                    return;
                }
            }
        }
    }
}

/// What the oracle says of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    pub(crate) hit: Option<Tri>,
    pub(crate) validity: Validity,
    /// In double-double arithmetic, rounded once.
    pub(crate) disparity_px: f64,
    pub(crate) point: DVec3,
    /// Distance from the camera.
    pub(crate) t: f64,
    /// Cosine of ray and normal.
    pub(crate) facing: f64,
}

/// Hits this much of the ray's length apart are one place.
const ONE_PLACE: f64 = 1e-12;

/// How far f64 may misplace a hit's point, as a share of its ray's length.
const POINT_ERROR: f64 = 2e-12;

pub(crate) fn answer<C: Candidates + ?Sized>(candidates: &C, rig: &StereoRig, view: View, pixel: [u32; 2]) -> Answer {
    let (camera, other) = view.cameras(rig);
    let image = DVec2::new(pixel[0].into(), pixel[1].into());
    let ray = camera.ray(image.x, image.y);
    // The nearest, then the lowest id of all that are as near.
    let mut hits: Vec<(f64, Tri)> = Vec::new();
    each(candidates, view, image, |tri| {
        if let Some(t) = tri.meets(ray.origin, ray.direction)
            && t > 0.0
        {
            hits.push((t, *tri));
        }
        false
    });
    let nearest = hits.iter().fold(f64::INFINITY, |m, h| m.min(h.0));
    let winner = hits.into_iter().filter(|h| h.0 <= nearest * (1.0 + ONE_PLACE)).min_by_key(|h| h.1.id());
    let Some((t, tri)) = winner else {
        return Answer {
            hit: None,
            validity: Validity::Miss,
            disparity_px: f64::NAN,
            point: DVec3::NAN,
            t: f64::INFINITY,
            facing: 0.0,
        };
    };
    let [a, b, c] = tri.corners;
    let normal = (b - a).cross(c - a).normalize();
    let facing = normal.dot(ray.direction);
    let towards_camera = if facing > 0.0 { -normal } else { normal };
    let point = ray.origin + ray.direction * t;
    let mut found = Answer {
        hit: Some(tri),
        validity: Validity::OutOfFrame,
        disparity_px: double::disparity_px(rig, camera, pixel, &tri.corners),
        point,
        t,
        facing: facing.abs(),
    };
    let Some(there) = other.project(point) else { return found };
    if other.in_frame(there) {
        let view = if view == View::Left { View::Right } else { View::Left };
        let blocked = blocked(candidates, view, there, other, &tri, point, towards_camera, POINT_ERROR * t);
        found.validity = if blocked { Validity::Occluded } else { Validity::Valid };
    }
    found
}

/// Whether the segment from a point of `own` to the other camera meets anything but its own surface.
#[allow(clippy::too_many_arguments, reason = "the rule needs all of it, and stands in one place")]
fn blocked<C: Candidates + ?Sized>(
    candidates: &C,
    view: View,
    image_px: DVec2,
    other: &Camera,
    own: &Tri,
    point: DVec3,
    normal: DVec3,
    bound_m: f64,
) -> bool {
    let centre = other.centre_for(point);
    let length = (centre - point).length();
    let way = (centre - point) / length;
    let mut found = false;
    each(candidates, view, image_px, |tri| {
        if tri.id() == own.id() {
            return false;
        }
        let Some(t) = tri.meets(point, way) else { return false };
        if t <= bound_m || t > length {
            return false;
        }
        // What shares an edge or a vertex is the seam where it lies in or just behind the own plane.
        let touches = tri.corners.iter().any(|c| own.corners.contains(c));
        let off = (way * t).dot(normal);
        if touches && off <= 1e-15 * t && off >= -bound_m {
            return false;
        }
        found = true;
        true
    });
    found
}

/// Whether one of the pixel's segments passes within 1e-9 of its length of an edge.
pub(crate) fn in_band<C: Candidates + ?Sized>(
    candidates: &C,
    rig: &StereoRig,
    view: View,
    pixel: [u32; 2],
    points: &[DVec3],
) -> bool {
    let (camera, other) = view.cameras(rig);
    let image = DVec2::new(pixel[0].into(), pixel[1].into());
    let ray = camera.ray(image.x, image.y);
    let reach = points.iter().map(|p| (*p - ray.origin).length()).fold(0.0, f64::max);
    let close = |view: View, image: DVec2, from: DVec3, to: DVec3| {
        let limit = 1e-9 * (to - from).length();
        let mut found = false;
        each(candidates, view, image, |tri| {
            found |= tri.edge_distance(from, to) <= limit;
            found
        });
        found
    };
    if close(view, image, ray.origin, ray.origin + ray.direction * reach * (1.0 + 1e-9)) {
        return true;
    }
    let back = if view == View::Left { View::Right } else { View::Left };
    points.iter().any(|p| {
        other.project(*p).is_some_and(|there| other.in_frame(there) && close(back, there, *p, other.centre_for(*p)))
    })
}
