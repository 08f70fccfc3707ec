//! A hit, and the rule for rays that start on one.

use glam::DVec3;

/// A point of a surface that a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin, m.
    pub t: f64,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the instance's mesh.
    pub triangle: u32,
    /// Weights of the triangle's corners; they sum to 1.
    pub weights: [f64; 3],
    /// The point, world frame, m: the corners' weighted mean, so it lies in the triangle's plane to f64 rounding, however
    /// far the ray came from.
    pub point: DVec3,
    /// The triangle's unit normal on the side that the ray came from.
    pub normal: DVec3,
    /// Corners of the triangle, world frame, m.
    pub corners: [DVec3; 3],
}

/// Hits closer together than this along a ray of length `t` are one place, and the lowest (instance, triangle) answers:
/// 2^-40 of the ray, 1 nm at 1 km, several hundred times f64's rounding.
#[inline]
pub fn tie_tolerance_m(t: f64) -> f64 {
    t.abs() * (1.0 / (1_u64 << 40) as f64)
}

/// The start of a ray on a surface: the only place that knows which triangles such a ray cannot meet.
///
/// The point of a hit is known to `error_bound_m`, twice the tie tolerance of the ray that found it. A ray that starts
/// there does not meet
/// - the triangle itself (a straight line through a point of a plane does not come back to it),
/// - anything within the bound of the start (a coincident surface is the same place),
/// - a triangle that shares an edge or a vertex with it, by bit-equal world position, where it is met within the bound of
///   the own triangle's plane: that is the seam, not an obstacle. Beyond the bound, before or behind the plane, a
///   neighbour blocks as anything else does.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    point: DVec3,
    normal: DVec3,
    corners: [DVec3; 3],
    instance: u32,
    triangle: u32,
    error_bound_m: f64,
}

impl Origin {
    /// A start on a hit's surface.
    pub fn on(hit: &Hit) -> Self {
        Self {
            point: hit.point,
            normal: hit.normal,
            corners: hit.corners,
            instance: hit.instance,
            triangle: hit.triangle,
            error_bound_m: 2.0 * tie_tolerance_m(hit.t),
        }
    }

    /// The start, world frame, m.
    pub fn point(&self) -> DVec3 {
        self.point
    }

    /// The unit normal of the start's triangle, on the side that it was seen from.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Whether this is the triangle that the start lies on.
    #[inline]
    pub(crate) fn is_on(&self, instance: u32, triangle: u32) -> bool {
        (instance, triangle) == (self.instance, self.triangle)
    }

    /// Whether a crossing at distance `t` and point `at` with a triangle is the start's own surface.
    #[inline]
    pub(crate) fn is_own_surface(&self, instance: u32, triangle: u32, corners: &[DVec3; 3], t: f64, at: DVec3) -> bool {
        if t <= self.error_bound_m || self.is_on(instance, triangle) {
            return true;
        }
        let off_plane_m = (at - self.point).dot(self.normal).abs();
        off_plane_m <= self.error_bound_m && corners.iter().any(|c| self.corners.contains(c))
    }
}
