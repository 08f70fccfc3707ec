//! The one ray-triangle test: watertight, two-sided, f64.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). The triangle is moved to the ray's origin and
//! sheared so that the ray becomes the z axis; the signs of three edge functions decide. Two triangles that share an
//! edge compute its function from the same two sheared vertices, with opposite signs to the last bit, so a ray is inside
//! at least one of them. An edge function of exactly 0 counts as inside: then both are hit and the tie rule decides.

use glam::DVec3;
use satseed_scene::Ray;

/// The axis that a direction goes along most.
#[inline(always)]
pub(crate) fn main_axis(direction: DVec3) -> usize {
    let a = direction.abs();
    if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    }
}

/// A ray prepared for the test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: DVec3,
    kx: usize,
    ky: usize,
    kz: usize,
    shear: DVec3,
}

/// Where a ray meets a triangle's plane inside the triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Distance along the (unit) direction.
    pub(crate) t: f64,
    /// Weights of the three corners; they sum to 1.
    pub(crate) weights: [f64; 3],
}

impl ShearedRay {
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let kz = main_axis(d);
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        if d[kz] < 0.0 {
            core::mem::swap(&mut kx, &mut ky);
        }
        let shear = DVec3::new(d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]);
        Self { origin: ray.origin, kx, ky, kz, shear }
    }

    /// The crossing with a triangle at any `t`, also behind the origin.
    #[inline]
    pub(crate) fn cross(&self, corners: &[DVec3; 3]) -> Option<Crossing> {
        let sheared = |p: DVec3| {
            let q = p - self.origin;
            let z = q[self.kz];
            (q[self.kx] - self.shear.x * z, q[self.ky] - self.shear.y * z, z)
        };
        let (ax, ay, az) = sheared(corners[0]);
        let (bx, by, bz) = sheared(corners[1]);
        let (cx, cy, cz) = sheared(corners[2]);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let weights = [u * inverse, v * inverse, w * inverse];
        let t = (weights[0] * az + weights[1] * bz + weights[2] * cz) * self.shear.z;
        Some(Crossing { t, weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], towards: [f64; 3]) -> Ray {
        let origin = DVec3::from(origin);
        Ray { origin, direction: (DVec3::from(towards) - origin).normalize() }
    }

    #[test]
    fn a_ray_through_a_shared_edge_or_vertex_never_slips_through() {
        // A fan of triangles around a vertex, seen from random points, aimed at points of its edges and its centre.
        let mut rng = satseed_scene::SeedPath::root("fan", 1).rng();
        for _ in 0..2_000 {
            let centre = DVec3::new(rng.signed(), rng.signed(), 0.1 * rng.signed());
            let rim: Vec<DVec3> = (0..7)
                .map(|k| {
                    let (s, c) = libm_sincos(f64::from(k) * core::f64::consts::TAU / 7.0);
                    centre + DVec3::new(c, s, 0.2 * rng.signed())
                })
                .collect();
            let origin = DVec3::new(rng.signed(), rng.signed(), 3.0 + rng.unit());
            let along = rng.unit() * 0.9;
            let aim = centre.lerp(rim[rng.below(7) as usize], along);
            let sheared = ShearedRay::new(&Ray { origin, direction: (aim - origin).normalize() });
            let hits = (0..7).filter(|k| sheared.cross(&[centre, rim[*k], rim[(k + 1) % 7]]).is_some()).count();
            assert!(hits >= 1, "slipped through at {aim}");
        }
    }

    fn libm_sincos(x: f64) -> (f64, f64) {
        // Any angle will do here; the platform's own is fine in a test of geometry.
        let d = satseed_scene::direction_from_angles(x, 0.0);
        (d.x, d.y)
    }

    #[test]
    fn both_sides_and_distances() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for z in [2.0, -2.0] {
            let c = ShearedRay::new(&ray([0.2, 0.3, z], [0.2, 0.3, 0.0])).cross(&t).expect("hit");
            assert!((c.t - 2.0).abs() < 1e-15);
            assert!((c.weights[1] - 0.2).abs() < 1e-15 && (c.weights[2] - 0.3).abs() < 1e-15);
        }
        assert!(ShearedRay::new(&ray([0.7, 0.7, 1.0], [0.7, 0.7, 0.0])).cross(&t).is_none());
    }
}
