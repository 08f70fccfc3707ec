//! Rays against boxes in f32, on the safe side.
//!
//! A box test may say yes to a box that is missed, never no to one that is met. All that f32 does wrong (rounding the
//! origin, the direction, the differences) displaces the ray by less than `slack`, so boxes are grown by it, and the
//! distances are compared with a relative allowance.

use crate::simd::Wide;
use glam::DVec3;

/// Relative allowance of f32 distances: eight units in the last place.
const RELATIVE: f32 = 8.0 * f32::EPSILON;

/// A ray inside one tree's frame, started where it enters the tree's box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay {
    /// Origin plus and minus the slack: subtracted from lower and upper borders.
    low_from: [f32; 3],
    high_from: [f32; 3],
    inverse: [f32; 3],
    /// Distance along the ray at which this part starts; f32 distances count from here.
    pub(crate) start_t: f64,
}

/// Bounds of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

/// Eight boxes, a lane each. Unused lanes are inside out and never met.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Boxes8 {
    pub(crate) low: [[f32; 8]; 3],
    pub(crate) high: [[f32; 8]; 3],
}

/// One over a direction's components. Where one is missing: so large that a border lies far beyond any box on its side, and
/// never 0 times infinity.
#[inline(always)]
pub(crate) fn inverse(direction: DVec3) -> DVec3 {
    let one = |d: f64| 1.0 / if d.abs() < 1e-18 { 1e-18_f64.copysign(d) } else { d };
    DVec3::new(one(direction.x), one(direction.y), one(direction.z))
}

impl Bounds {
    /// The part of `origin + t * direction`, t in `[t_min, t_max]`, inside these bounds grown by `slack`, for the direction's
    /// [`inverse`].
    #[inline(always)]
    pub(crate) fn clip(&self, origin: DVec3, inverse: DVec3, t_min: f64, t_max: f64, slack: f64) -> Option<(f64, f64)> {
        let a = (self.low - slack - origin) * inverse;
        let b = (self.high + slack - origin) * inverse;
        let (near, far) = (a.min(b).max_element().max(t_min), a.max(b).min_element().min(t_max));
        (near <= far).then_some((near, far))
    }

    /// What f32 may displace a ray by inside these bounds, m: 2^-21 of all lengths that occur.
    pub(crate) fn slack(&self) -> f64 {
        let reach = self.low.abs().max(self.high.abs()).max_element();
        (reach + (self.high - self.low).length()) * (1.0 / (1_u32 << 21) as f64)
    }
}

impl SlabRay {
    /// A ray in the tree's frame; `start_t` must be where it enters the tree's bounds.
    #[inline(always)]
    pub(crate) fn new(origin: DVec3, direction: DVec3, inverse: DVec3, start_t: f64, slack: f64) -> Self {
        let from = origin + direction * start_t;
        let e = slack as f32;
        Self {
            low_from: [from.x as f32 + e, from.y as f32 + e, from.z as f32 + e],
            high_from: [from.x as f32 - e, from.y as f32 - e, from.z as f32 - e],
            inverse: inverse.as_vec3().to_array(),
            start_t,
        }
    }

    /// The f32 limit for a distance `t` along the whole ray.
    #[inline]
    pub(crate) fn limit(&self, t: f64) -> f32 {
        let local = (t - self.start_t) as f32;
        local + local.abs() * RELATIVE + f32::MIN_POSITIVE
    }

    /// Entry distances of the eight boxes, and a bit for each that is met before `limit`.
    #[inline(always)]
    pub(crate) fn meet<X: Wide<8>>(&self, boxes: &Boxes8, limit: f32) -> ([f32; 8], u32) {
        let mut near = X::splat(0.0);
        let mut far = X::splat(limit);
        for axis in 0..3 {
            let (lo, hi, inv) = (self.low_from[axis], self.high_from[axis], self.inverse[axis]);
            // The nearer border is the lower one where the ray goes up.
            let (first, second, a, b) = if inv >= 0.0 {
                (&boxes.low[axis], &boxes.high[axis], lo, hi)
            } else {
                (&boxes.high[axis], &boxes.low[axis], hi, lo)
            };
            let inv = X::splat(inv);
            near = X::load(first).sub(X::splat(a)).mul(inv).max(near);
            far = X::load(second).sub(X::splat(b)).mul(inv).min(far);
        }
        let met = near.le(far.add(far.abs().mul(X::splat(RELATIVE))));
        (near.store(), met)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Lanes, Portable};

    #[test]
    fn a_box_that_is_met_in_f64_is_never_missed_in_f32() {
        let mut rng = satseed_scene::SeedPath::root("boxes", 1).rng();
        let root = Bounds { low: DVec3::splat(-1000.0), high: DVec3::splat(1000.0) };
        let slack = root.slack();
        let mut met = 0;
        for _ in 0..50_000 {
            let point = |r: &mut satseed_scene::Rng| DVec3::new(r.signed(), r.signed(), r.signed());
            let corner = point(&mut rng) * 990.0;
            let size = point(&mut rng).abs() * 10.0 * rng.unit() * rng.unit() * rng.unit();
            let f = |x: f64| f64::from(x as f32);
            let one = Bounds {
                low: DVec3::new(f(corner.x), f(corner.y), f(corner.z)),
                high: DVec3::new(f(corner.x + size.x), f(corner.y + size.y), f(corner.z + size.z)),
            };
            let origin = point(&mut rng) * 3000.0;
            // Aimed at a corner or an edge of the box: the hard cases.
            let aim = one.low + (one.high - one.low) * DVec3::new(rng.below(2) as f64, rng.unit(), rng.below(2) as f64);
            let direction = (aim - origin).normalize();
            let Some((near, _)) = root.clip(origin, inverse(direction), 0.0, 1e9, slack) else { continue };
            let Some(_) = one.clip(origin, inverse(direction), 0.0, 1e9, 0.0) else { continue };
            let mut boxes = Boxes8 { low: [[f32::INFINITY; 8]; 3], high: [[f32::NEG_INFINITY; 8]; 3] };
            for axis in 0..3 {
                boxes.low[axis][3] = one.low[axis] as f32;
                boxes.high[axis][3] = one.high[axis] as f32;
            }
            let ray = SlabRay::new(origin, direction, inverse(direction), near, slack);
            assert_eq!(ray.meet::<<Portable as Lanes>::X8>(&boxes, f32::MAX).1, 1 << 3, "{one:?} from {origin}");
            met += 1;
        }
        assert!(met > 10_000, "only {met} cases tested anything");
    }
}
