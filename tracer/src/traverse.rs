//! The tracer's questions.

use crate::query::{Any, Closest, Placed, Query, segment};
use crate::simd::InstructionSet;
use crate::surface::{Hit, Origin};
use crate::tree::Trees;
use crate::{bundle, single};
use glam::DVec3;
use satseed_scene::{Ray, Scene};
use std::ops::{Add, Sub};
use std::sync::atomic::{AtomicU64, Ordering};

/// A scene ready for rays.
pub struct Tracer<'s> {
    scene: &'s Scene,
    trees: Trees,
    set: InstructionSet,
    /// As in [`RayCounts`].
    rays: [AtomicU64; 4],
}

/// How many rays were traced, by what was asked of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// What a ray meets first: [`Tracer::closest`].
    pub first: u64,
    /// What stands between a surface and a point: [`Tracer::occluder`], [`Tracer::occluded`].
    pub line: u64,
    /// Whether a direction from a surface is open: [`Tracer::blocked`].
    pub open: u64,
    /// What a direction from a surface meets first: [`Tracer::closest_from`].
    pub onward: u64,
}

impl RayCounts {
    /// All of them.
    pub fn sum(&self) -> u64 {
        self.first + self.line + self.open + self.onward
    }

    fn with(self, other: Self, of: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            first: of(self.first, other.first),
            line: of(self.line, other.line),
            open: of(self.open, other.open),
            onward: of(self.onward, other.onward),
        }
    }
}

impl Add for RayCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl Sub for RayCounts {
    type Output = Self;

    /// What was traced since an earlier count.
    fn sub(self, earlier: Self) -> Self {
        self.with(earlier, |a, b| a - b)
    }
}

/// Place of a kind in [`Tracer::rays`].
#[derive(Clone, Copy)]
enum Kind {
    First,
    Line,
    Open,
    Onward,
}

impl<'s> Tracer<'s> {
    /// Builds the trees. The scene must pass [`Scene::validate`].
    pub fn new(scene: &'s Scene) -> Self {
        Self { scene, trees: Trees::new(scene), set: InstructionSet::widest(), rays: Default::default() }
    }

    /// The same tracer with another instruction set: the same answers in another time.
    ///
    /// # Panics
    /// Panics where this processor does not have it; see [`InstructionSet::is_available`].
    #[must_use]
    pub fn with_instructions(self, set: InstructionSet) -> Self {
        assert!(set.is_available(), "this processor has no {set:?}");
        Self { set, ..self }
    }

    /// The scene it was built for.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// Lower and upper corner of everything, m.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        let bounds = self.trees.instances.bounds;
        [bounds.low, bounds.high]
    }

    /// A length that takes a ray from a point beyond the far side of everything, m.
    pub fn reach_m(&self, from: DVec3) -> f64 {
        let [low, high] = self.bounds_m();
        let far = (low - from).abs().max((high - from).abs());
        far.length() + 1.0
    }

    /// Bytes held by the trees and their copies of the triangles: at most [`crate::BYTES_PER_TRIANGLE`] (where leaves are
    /// wide, [`crate::BYTES_PER_WIDE_TRIANGLE`]) for each triangle of a mesh and [`crate::BYTES_PER_INSTANCE`] for each instance, and a few hundred for each mesh.
    pub fn bytes(&self) -> usize {
        self.trees.bytes()
    }

    /// How many rays it has traced.
    pub fn rays_traced(&self) -> RayCounts {
        let of = |kind: Kind| self.rays[kind as usize].load(Ordering::Relaxed);
        RayCounts { first: of(Kind::First), line: of(Kind::Line), open: of(Kind::Open), onward: of(Kind::Onward) }
    }

    /// The closest hit at a distance in (0, `t_max`]. Hits within [`crate::tie_tolerance_m`] of the closest are one
    /// place; the lowest (instance, triangle) of them answers.
    pub fn closest(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.one(Kind::First, Closest::new(ray.origin, ray.direction, t_max)).answer(&self.trees, &mut Placed::none())
    }

    /// [`Tracer::closest`] of many rays, as far as they reach. Neighbours that go nearly the same way cost least.
    pub fn closest_all(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        // A camera's rays start in one place.
        let (mut start, mut reach_m) = (DVec3::NAN, 0.0);
        let query = |r: &Ray| {
            if r.origin != start {
                (start, reach_m) = (r.origin, self.reach_m(r.origin));
            }
            Closest::new(r.origin, r.direction, reach_m)
        };
        let mut last = Placed::none();
        // They come as a camera's rays lie, narrow enough.
        self.all(Kind::First, rays, None, query, |q| q.answer(&self.trees, &mut last))
    }

    /// What a straight line from a surface point to `target` meets first, if anything.
    pub fn occluder(&self, from: &Origin, target: DVec3) -> Option<Hit> {
        let (ray, t_max) = segment(from, target);
        self.one(Kind::Line, Closest::new(from, ray.direction, t_max)).answer(&self.trees, &mut Placed::none())
    }

    /// Whether anything stands between a surface point and `target`.
    pub fn occluded(&self, from: &Origin, target: DVec3) -> bool {
        self.one(Kind::Line, Any::up_to(from, target)).found()
    }

    /// [`Tracer::occluded`] of many surface points and their targets.
    pub fn occluded_all(&self, lines: &[(Origin, DVec3)]) -> Vec<bool> {
        let order = bundle::narrower(lines.iter().map(|(from, target)| (from.point(), *target - from.point())));
        self.all(Kind::Line, lines, order, |(from, target)| Any::up_to(from, *target), Any::found)
    }

    /// Whether anything stands in a direction (unit) from a surface point within `t_max` metres.
    pub fn blocked(&self, from: &Origin, direction: DVec3, t_max: f64) -> bool {
        self.one(Kind::Open, Any::towards(from, direction, t_max)).found()
    }

    /// [`Tracer::blocked`] of many surface points and their directions (unit), as far as there is anything.
    pub fn blocked_all<'a>(&self, rays: &'a [(Origin, DVec3)]) -> Vec<bool> {
        let order = bundle::narrower(rays.iter().map(|(from, d)| (from.point(), *d)));
        let query = |(from, d): &'a (Origin, DVec3)| Any::towards(from, *d, self.reach_m(from.point()));
        self.all(Kind::Open, rays, order, query, Any::found)
    }

    /// The closest hit in a direction (unit) from a surface point.
    pub fn closest_from(&self, from: &Origin, direction: DVec3, t_max: f64) -> Option<Hit> {
        self.one(Kind::Onward, Closest::new(from, direction, t_max)).answer(&self.trees, &mut Placed::none())
    }

    /// [`Tracer::closest_from`] of many surface points and their directions (unit), as far as there is anything.
    pub fn closest_from_all<'a>(&self, rays: &'a [(Origin, DVec3)]) -> Vec<Option<Hit>> {
        let order = bundle::narrower(rays.iter().map(|(from, d)| (from.point(), *d)));
        let query = |(from, d): &'a (Origin, DVec3)| Closest::new(from, *d, self.reach_m(from.point()));
        let mut last = Placed::none();
        self.all(Kind::Onward, rays, order, query, |q| q.answer(&self.trees, &mut last))
    }

    fn one<Q: Query>(&self, kind: Kind, mut query: Q) -> Q {
        self.rays[kind as usize].fetch_add(1, Ordering::Relaxed);
        single::trace(self.set, &self.trees, &mut query, &mut Vec::with_capacity(96));
        query
    }

    /// Answers of all rays, traced in an order if one is given.
    fn all<'a, T, Q: Query, A: Clone + Default>(
        &self,
        kind: Kind,
        rays: &'a [T],
        order: Option<Vec<u32>>,
        mut query: impl FnMut(&'a T) -> Q,
        mut answer: impl FnMut(&Q) -> A,
    ) -> Vec<A> {
        self.rays[kind as usize].fetch_add(rays.len() as u64, Ordering::Relaxed);
        // A bundle at a time, which the caches hold.
        let mut queries = Vec::with_capacity(bundle::MOST.min(rays.len()));
        let Some(order) = order else {
            let mut answers = Vec::with_capacity(rays.len());
            for members in rays.chunks(bundle::MOST) {
                queries.clear();
                queries.extend(members.iter().map(&mut query));
                bundle::trace(self.set, &self.trees, &mut queries);
                answers.extend(queries.iter().map(&mut answer));
            }
            return answers;
        };
        let mut answers = vec![A::default(); rays.len()];
        for members in order.chunks(bundle::MOST) {
            queries.clear();
            queries.extend(members.iter().map(|k| query(&rays[*k as usize])));
            bundle::trace(self.set, &self.trees, &mut queries);
            for (query, k) in queries.iter().zip(members) {
                answers[*k as usize] = answer(query);
            }
        }
        answers
    }
}
