//! The one ray-triangle test: watertight, two-sided, f64.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). The triangle is moved to the ray's origin and
//! sheared so that the ray becomes the z axis; the signs of three edge functions decide. Two triangles that share an
//! edge compute its function from the same two sheared vertices, with opposite signs to the last bit, so a ray is inside
//! at least one of them. An edge function of exactly 0 counts as inside: then both are hit and the tie rule decides.

use crate::simd::Doubles;
use glam::DVec3;

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

/// The axes of x, y and depth of a ray in this direction.
#[inline(always)]
fn axes(d: DVec3) -> [usize; 3] {
    let kz = main_axis(d);
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    if d[kz] < 0.0 { [ky, kx, kz] } else { [kx, ky, kz] }
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
    pub(crate) fn new(origin: DVec3, d: DVec3) -> Self {
        let [kx, ky, kz] = axes(d);
        let shear = DVec3::new(d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]);
        Self { origin, kx, ky, kz, shear }
    }

    /// The crossing with a triangle at any `t`, also behind the origin.
    #[inline(always)]
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

/// Sixteen rays prepared for the test: side by side where they have their axes in common, else one by one. Each gets the
/// operations of [`ShearedRay::cross`] in the same order, and so the same bits.
#[derive(Clone)]
pub(crate) struct ShearedPacket {
    /// Of each ray: the axes of x, y and depth.
    axes: [[u8; 3]; 16],
    are_alike: bool,
    /// Along these axes.
    origin: [[f64; 16]; 3],
    shear: [[f64; 16]; 3],
}

/// Numbers without their signs.
#[inline(always)]
pub(crate) fn sizes<D: Doubles>(of: &[f64; 16]) -> D {
    let x = D::load(of);
    let zero = D::splat(0.0);
    x.max(zero.sub(x))
}

/// Crossings of sixteen rays with a triangle.
pub(crate) struct Crossings {
    /// A bit for each ray that has one.
    pub(crate) met: u32,
    t: [f64; 16],
    weights: [[f64; 16]; 3],
}

impl Crossings {
    #[inline(always)]
    pub(crate) fn of(&self, ray: usize) -> Crossing {
        Crossing { t: self.t[ray], weights: [self.weights[0][ray], self.weights[1][ray], self.weights[2][ray]] }
    }
}

impl ShearedPacket {
    /// Rays from their starts and directions, axis by axis.
    #[inline(always)]
    pub(crate) fn new<D: Doubles>(origin: &[[f64; 16]; 3], direction: &[[f64; 16]; 3]) -> Self {
        let [kx, ky, kz] = axes(DVec3::new(direction[0][0], direction[1][0], direction[2][0]));
        let mut packet = Self {
            axes: [[kx as u8, ky as u8, kz as u8]; 16],
            are_alike: true,
            origin: [origin[kx], origin[ky], origin[kz]],
            shear: [[0.0; 16]; 3],
        };
        let [x, y, z] = [sizes::<D>(&direction[0]), sizes::<D>(&direction[1]), sizes::<D>(&direction[2])];
        let x_is_main = y.le(x) & z.le(x);
        let is_main = [x_is_main, !x_is_main & z.le(y), !x_is_main & !z.le(y)];
        let is_down = D::load(&direction[kz]).lt(D::splat(0.0));
        packet.are_alike = is_main[kz] & 0xffff == 0xffff && (is_down == 0 || is_down == 0xffff);
        if packet.are_alike {
            let ahead = D::load(&direction[kz]);
            packet.shear = [
                D::load(&direction[kx]).div(ahead).store(),
                D::load(&direction[ky]).div(ahead).store(),
                D::splat(1.0).div(ahead).store(),
            ];
            return packet;
        }
        for lane in 0..16 {
            let d = DVec3::new(direction[0][lane], direction[1][lane], direction[2][lane]);
            let ray = ShearedRay::new(DVec3::new(origin[0][lane], origin[1][lane], origin[2][lane]), d);
            for (k, axis) in [ray.kx, ray.ky, ray.kz].into_iter().enumerate() {
                packet.axes[lane][k] = axis as u8;
                packet.origin[k][lane] = ray.origin[axis];
                packet.shear[k][lane] = ray.shear[k];
            }
        }
        packet
    }

    /// Whether it is faster to hold some of the rays against a triangle one by one.
    #[inline(always)]
    pub(crate) fn is_for_single(&self, rays: u32) -> bool {
        const FEW: u32 = 3;
        !self.are_alike || rays.count_ones() < FEW
    }

    /// The crossings of some of the rays, which are alike, with a triangle.
    #[inline(always)]
    pub(crate) fn cross<D: Doubles>(&self, rays: u32, corners: &[DVec3; 3]) -> Crossings {
        let [kx, ky, kz] = [self.axes[0][0] as usize, self.axes[0][1] as usize, self.axes[0][2] as usize];
        let zero = D::splat(0.0);
        let shear = [D::load(&self.shear[0]), D::load(&self.shear[1]), D::load(&self.shear[2])];
        let origin = [D::load(&self.origin[0]), D::load(&self.origin[1]), D::load(&self.origin[2])];
        let (mut x, mut y, mut z) = ([zero; 3], [zero; 3], [zero; 3]);
        for (k, p) in corners.iter().enumerate() {
            z[k] = D::splat(p[kz]).sub(origin[2]);
            x[k] = D::splat(p[kx]).sub(origin[0]).sub(shear[0].mul(z[k]));
            y[k] = D::splat(p[ky]).sub(origin[1]).sub(shear[1].mul(z[k]));
        }
        let u = x[2].mul(y[1]).sub(y[2].mul(x[1]));
        let v = x[0].mul(y[2]).sub(y[0].mul(x[2]));
        let w = x[1].mul(y[0]).sub(y[1].mul(x[0]));
        let negative = u.lt(zero) | v.lt(zero) | w.lt(zero);
        let positive = zero.lt(u) | zero.lt(v) | zero.lt(w);
        let determinant = u.add(v).add(w);
        let flat = determinant.le(zero) & zero.le(determinant);
        let met = rays & !(negative & positive) & !flat;
        if met == 0 {
            return Crossings { met, t: [0.0; 16], weights: [[0.0; 16]; 3] };
        }
        let inverse = D::splat(1.0).div(determinant);
        let weights = [u.mul(inverse), v.mul(inverse), w.mul(inverse)];
        let depth = weights[0].mul(z[0]).add(weights[1].mul(z[1])).add(weights[2].mul(z[2]));
        let t = depth.mul(shear[2]);
        Crossings { met, t: t.store(), weights: [weights[0].store(), weights[1].store(), weights[2].store()] }
    }

    /// One of the rays.
    #[inline(always)]
    pub(crate) fn ray(&self, lane: usize) -> ShearedRay {
        let [kx, ky, kz] = [self.axes[lane][0] as usize, self.axes[lane][1] as usize, self.axes[lane][2] as usize];
        let mut origin = DVec3::ZERO;
        origin[kx] = self.origin[0][lane];
        origin[ky] = self.origin[1][lane];
        origin[kz] = self.origin[2][lane];
        let shear = DVec3::new(self.shear[0][lane], self.shear[1][lane], self.shear[2][lane]);
        ShearedRay { origin, kx, ky, kz, shear }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], towards: [f64; 3]) -> ShearedRay {
        let origin = DVec3::from(origin);
        ShearedRay::new(origin, (DVec3::from(towards) - origin).normalize())
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
            let sheared = ShearedRay::new(origin, (aim - origin).normalize());
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
            let c = ray([0.2, 0.3, z], [0.2, 0.3, 0.0]).cross(&t).expect("hit");
            assert!((c.t - 2.0).abs() < 1e-15);
            assert!((c.weights[1] - 0.2).abs() < 1e-15 && (c.weights[2] - 0.3).abs() < 1e-15);
        }
        assert!(ray([0.7, 0.7, 1.0], [0.7, 0.7, 0.0]).cross(&t).is_none());
    }
}
