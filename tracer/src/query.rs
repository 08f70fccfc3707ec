//! What is asked of a ray: the closest surface, or whether there is any.

use crate::surface::{Hit, Origin, tie_tolerance_m};
use crate::tree::Trees;
use crate::triangle::{Crossing, ShearedRay};
use glam::DVec3;
use satseed_scene::Ray;

/// A placed triangle that a ray is held against.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) instance: u32,
    pub(crate) triangle: u32,
    /// Where it stands in the trees: its placement, and its lane among all lanes of its mesh's blocks.
    pub(crate) place: u32,
    pub(crate) slot: u32,
}

/// A ray under way: what it still wants, and what it makes of a crossing.
pub(crate) trait Query {
    /// The ray's start, m.
    fn origin(&self) -> DVec3;
    /// The ray's unit direction.
    fn direction(&self) -> DVec3;
    /// Crossings beyond this distance are of no interest; below 0 once none is.
    fn limit(&self) -> f64;
    /// Whether a triangle is the one that the ray starts on.
    fn starts_on(&self, instance: u32, triangle: u32) -> bool;
    /// Takes a crossing with `t` in (0, limit].
    fn offer(&mut self, with: &Candidate, corners: &[DVec3; 3], crossing: &Crossing);

    /// Decides in f64 whether the ray meets a triangle, and takes the crossing.
    #[inline(always)]
    fn decide(&mut self, sheared: &ShearedRay, with: &Candidate, corners: &[DVec3; 3]) {
        if let Some(crossing) = sheared.cross(corners) {
            self.take(with, corners, &crossing);
        }
    }

    /// Takes a crossing if it is where it is of interest.
    #[inline(always)]
    fn take(&mut self, with: &Candidate, corners: &[DVec3; 3], crossing: &Crossing) {
        if crossing.t > 0.0 && crossing.t <= self.limit() {
            self.offer(with, corners, crossing);
        }
    }
}

/// Where a closest query starts: anywhere, or on a surface.
pub(crate) trait Start {
    fn origin(&self) -> DVec3;
    fn starts_on(&self, instance: u32, triangle: u32) -> bool;
    fn is_own_surface(&self, with: &Candidate, corners: &[DVec3; 3], t: f64, direction: DVec3) -> bool;
}

impl Start for DVec3 {
    #[inline(always)]
    fn origin(&self) -> DVec3 {
        *self
    }

    #[inline(always)]
    fn starts_on(&self, _: u32, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn is_own_surface(&self, _: &Candidate, _: &[DVec3; 3], _: f64, _: DVec3) -> bool {
        false
    }
}

impl Start for &Origin {
    #[inline(always)]
    fn origin(&self) -> DVec3 {
        self.point()
    }

    #[inline(always)]
    fn starts_on(&self, instance: u32, triangle: u32) -> bool {
        self.is_on(instance, triangle)
    }

    #[inline(always)]
    fn is_own_surface(&self, with: &Candidate, corners: &[DVec3; 3], t: f64, direction: DVec3) -> bool {
        Origin::is_own_surface(self, with.instance, with.triangle, corners, t, self.point() + direction * t)
    }
}

#[derive(Clone, Copy)]
struct Found {
    t: f64,
    weights: [f64; 3],
    with: Candidate,
}

impl Found {
    fn key(&self) -> (u32, u32) {
        (self.with.instance, self.with.triangle)
    }
}

/// A placed triangle: what all hits on it share.
pub(crate) struct Placed {
    place: u32,
    slot: u32,
    corners: [DVec3; 3],
    /// Its unit normal on one of its sides.
    normal: DVec3,
}

impl Placed {
    /// None.
    pub(crate) fn none() -> Self {
        Self { place: u32::MAX, slot: u32::MAX, corners: [DVec3::ZERO; 3], normal: DVec3::ZERO }
    }

    fn new(trees: &Trees, with: &Candidate) -> Self {
        let corners = trees.corners(with);
        let [a, b, c] = corners;
        Self { place: with.place, slot: with.slot, corners, normal: (b - a).cross(c - a).normalize() }
    }
}

/// The closest crossing.
pub(crate) struct Closest<S> {
    start: S,
    direction: DVec3,
    t_max: f64,
    limit: f64,
    found: Option<Found>,
    /// Other hits that are, or once were, within the tolerance of the nearest. Hardly any ray has any.
    #[allow(clippy::box_collection, reason = "a query is small, and there are many")]
    ties: Option<Box<Vec<Found>>>,
}

impl<S: Start> Closest<S> {
    pub(crate) fn new(start: S, direction: DVec3, t_max: f64) -> Self {
        let limit = (t_max + tie_tolerance_m(t_max)).min(t_max);
        Self { start, direction, t_max, limit, found: None, ties: None }
    }

    /// The hit: of all within the tolerance of the nearest, the one of the lowest (instance, triangle). `last` is the
    /// triangle of the hit before, which neighbours often share.
    #[inline(always)]
    pub(crate) fn answer(&self, trees: &Trees, last: &mut Placed) -> Option<Hit> {
        let nearest = self.found.as_ref()?;
        let mut winner = nearest;
        if let Some(ties) = &self.ties {
            let end = nearest.t + tie_tolerance_m(nearest.t);
            for tie in ties.iter().filter(|tie| tie.t <= end) {
                winner = if tie.key() < winner.key() { tie } else { winner };
            }
        }
        let with = &winner.with;
        if (last.place, last.slot) != (with.place, with.slot) {
            *last = Placed::new(trees, with);
        }
        let Placed { corners, normal, .. } = *last;
        let [a, b, c] = corners;
        let w = winner.weights;
        Some(Hit {
            t: winner.t,
            instance: with.instance,
            triangle: with.triangle,
            weights: w,
            point: a * w[0] + b * w[1] + c * w[2],
            normal: if normal.dot(self.direction) > 0.0 { -normal } else { normal },
            corners,
        })
    }

    /// Of a hit within reach of the last nearest one, both are kept.
    #[cold]
    fn tie(&mut self, farther: Found) {
        self.ties.get_or_insert_default().push(farther);
    }
}

impl<S: Start> Query for Closest<S> {
    #[inline(always)]
    fn origin(&self) -> DVec3 {
        self.start.origin()
    }

    #[inline(always)]
    fn direction(&self) -> DVec3 {
        self.direction
    }

    #[inline(always)]
    fn limit(&self) -> f64 {
        self.limit
    }

    #[inline(always)]
    fn starts_on(&self, instance: u32, triangle: u32) -> bool {
        self.start.starts_on(instance, triangle)
    }

    #[inline(always)]
    fn offer(&mut self, with: &Candidate, corners: &[DVec3; 3], crossing: &Crossing) {
        if self.start.is_own_surface(with, corners, crossing.t, self.direction) {
            return;
        }
        let mut nearer = Found { t: crossing.t, weights: crossing.weights, with: *with };
        if let Some(old) = self.found {
            let mut farther = old;
            if (old.t, old.key()) <= (nearer.t, nearer.key()) {
                (nearer, farther) = (old, nearer);
            }
            if farther.t <= nearer.t + tie_tolerance_m(nearer.t) {
                self.tie(farther);
            }
        }
        self.limit = (nearer.t + tie_tolerance_m(nearer.t)).min(self.t_max);
        self.found = Some(nearer);
    }
}

/// Whether there is any crossing.
pub(crate) struct Any<'a> {
    own: &'a Origin,
    direction: DVec3,
    t_max: f64,
}

impl<'a> Any<'a> {
    /// From a start on a surface in a direction (unit).
    pub(crate) fn towards(own: &'a Origin, direction: DVec3, t_max: f64) -> Self {
        Self { own, direction, t_max }
    }

    /// From a start on a surface to a point.
    pub(crate) fn up_to(own: &'a Origin, target: DVec3) -> Self {
        let (ray, t_max) = segment(own, target);
        Self { own, direction: ray.direction, t_max }
    }

    /// Whether there was one.
    pub(crate) fn found(&self) -> bool {
        self.t_max < 0.0
    }
}

impl Query for Any<'_> {
    #[inline(always)]
    fn origin(&self) -> DVec3 {
        self.own.point()
    }

    #[inline(always)]
    fn direction(&self) -> DVec3 {
        self.direction
    }

    #[inline(always)]
    fn limit(&self) -> f64 {
        self.t_max
    }

    #[inline(always)]
    fn starts_on(&self, instance: u32, triangle: u32) -> bool {
        self.own.is_on(instance, triangle)
    }

    #[inline(always)]
    fn offer(&mut self, with: &Candidate, corners: &[DVec3; 3], crossing: &Crossing) {
        if !Start::is_own_surface(&self.own, with, corners, crossing.t, self.direction) {
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
