//! What is asked of a ray: the closest surface, or whether there is any.

use crate::surface::{Hit, Origin, tie_tolerance_m};
use crate::triangle::{Crossing, ShearedRay};
use glam::DVec3;
use satseed_scene::Ray;

/// A ray under way: what it still wants, and what it makes of a crossing.
pub(crate) trait Query {
    /// The ray.
    fn ray(&self) -> &Ray;
    /// Crossings beyond this distance are of no interest; below 0 once none is.
    fn limit(&self) -> f64;
    /// Whether a triangle is the one that the ray starts on.
    fn starts_on(&self, instance: u32, triangle: u32) -> bool;
    /// Takes a crossing with `t` in (0, limit].
    fn offer(&mut self, instance: u32, triangle: u32, corners: &[DVec3; 3], crossing: &Crossing);

    /// Decides in f64 whether the ray meets a triangle, and takes the crossing.
    #[inline]
    fn decide(&mut self, sheared: &ShearedRay, instance: u32, triangle: u32, corners: &[DVec3; 3]) {
        if let Some(crossing) = sheared.cross(corners)
            && crossing.t > 0.0
            && crossing.t <= self.limit()
        {
            self.offer(instance, triangle, corners, &crossing);
        }
    }
}

struct Found {
    t: f64,
    instance: u32,
    triangle: u32,
    weights: [f64; 3],
    corners: [DVec3; 3],
}

/// The closest crossing.
pub(crate) struct Closest {
    ray: Ray,
    own: Option<Origin>,
    t_max: f64,
    nearest: f64,
    found: Option<Found>,
    /// Other hits that are, or once were, within the tolerance of the nearest.
    ties: Vec<Found>,
}

impl Closest {
    pub(crate) fn new(ray: Ray, own: Option<Origin>, t_max: f64) -> Self {
        Self { ray, own, t_max, nearest: t_max, found: None, ties: Vec::new() }
    }

    /// The hit: of all within the tolerance of the nearest, the one of the lowest (instance, triangle).
    pub(crate) fn answer(self) -> Option<Hit> {
        let nearest = self.found?;
        let last = nearest.t + tie_tolerance_m(nearest.t);
        let winner = self
            .ties
            .into_iter()
            .filter(|tie| tie.t <= last)
            .fold(nearest, |a, b| if (b.instance, b.triangle) < (a.instance, a.triangle) { b } else { a });
        let [a, b, c] = winner.corners;
        let normal = (b - a).cross(c - a).normalize();
        let w = winner.weights;
        Some(Hit {
            t: winner.t,
            instance: winner.instance,
            triangle: winner.triangle,
            weights: w,
            point: a * w[0] + b * w[1] + c * w[2],
            normal: if normal.dot(self.ray.direction) > 0.0 { -normal } else { normal },
            corners: winner.corners,
        })
    }
}

impl Query for Closest {
    #[inline]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline]
    fn limit(&self) -> f64 {
        (self.nearest + tie_tolerance_m(self.nearest)).min(self.t_max)
    }

    #[inline]
    fn starts_on(&self, instance: u32, triangle: u32) -> bool {
        self.own.as_ref().is_some_and(|own| own.is_on(instance, triangle))
    }

    fn offer(&mut self, instance: u32, triangle: u32, corners: &[DVec3; 3], crossing: &Crossing) {
        let t = crossing.t;
        if let Some(own) = &self.own
            && own.is_own_surface(instance, triangle, corners, t, self.ray.origin + self.ray.direction * t)
        {
            return;
        }
        let new = Found { t, instance, triangle, weights: crossing.weights, corners: *corners };
        if let Some(old) = self.found.take() {
            let (nearer, farther) = if (new.t, new.instance, new.triangle) < (old.t, old.instance, old.triangle) {
                (new, old)
            } else {
                (old, new)
            };
            if farther.t <= nearer.t + tie_tolerance_m(nearer.t) {
                self.ties.push(farther);
            }
            self.nearest = nearer.t;
            self.found = Some(nearer);
        } else {
            self.nearest = t;
            self.found = Some(new);
        }
    }
}

/// Whether there is any crossing.
pub(crate) struct Any {
    ray: Ray,
    own: Origin,
    t_max: f64,
}

impl Any {
    /// From a start on a surface in a direction (unit).
    pub(crate) fn towards(own: &Origin, direction: DVec3, t_max: f64) -> Self {
        Self { ray: Ray { origin: own.point(), direction }, own: *own, t_max }
    }

    /// From a start on a surface to a point.
    pub(crate) fn up_to(own: &Origin, target: DVec3) -> Self {
        let (ray, t_max) = segment(own, target);
        Self { ray, own: *own, t_max }
    }

    /// Whether there was one.
    pub(crate) fn found(&self) -> bool {
        self.t_max < 0.0
    }
}

impl Query for Any {
    #[inline]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline]
    fn limit(&self) -> f64 {
        self.t_max
    }

    #[inline]
    fn starts_on(&self, instance: u32, triangle: u32) -> bool {
        self.own.is_on(instance, triangle)
    }

    fn offer(&mut self, instance: u32, triangle: u32, corners: &[DVec3; 3], crossing: &Crossing) {
        let t = crossing.t;
        if !self.own.is_own_surface(instance, triangle, corners, t, self.ray.origin + self.ray.direction * t) {
            self.t_max = -1.0;
        }
    }
}

/// The ray from a start on a surface to a point, and its length.
pub(crate) fn segment(from: &Origin, target: DVec3) -> (Ray, f64) {
    let way = target - from.point();
    let length = way.length();
    (Ray { origin: from.point(), direction: way / length }, length)
}
