//! Disparity in double-double arithmetic (about 32 digits), as a yardstick for f64.
//!
//! Sums and products without error: Knuth 1969 and Dekker 1971.

use core::ops::{Add, Div, Mul, Sub};
use glam::DVec3;
use satseed::camera::{Camera, StereoRig};

/// An unevaluated sum of two f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Double(f64, f64);

fn two_sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let t = s - a;
    Double(s, (a - (s - t)) + (b - t))
}

fn two_product(a: f64, b: f64) -> Double {
    let split = |x: f64| {
        let big = x * 134_217_729.0;
        let high = big - (big - x);
        (high, x - high)
    };
    let p = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Double(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl From<f64> for Double {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Double {
    pub(crate) fn value(self) -> f64 {
        self.0 + self.1
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let s = two_sum(self.0, o.0);
        let t = two_sum(self.1, o.1);
        let u = two_sum(s.0, s.1 + t.0);
        two_sum(u.0, u.1 + t.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + Self(-o.0, -o.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = two_product(self.0, o.0);
        two_sum(p.0, p.1 + (self.0 * o.1 + self.1 * o.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let a = Self::from(self.0 / o.0);
        let rest = self - a * o;
        let b = Self::from(rest.0 / o.0);
        let rest = rest - b * o;
        a + b + Self::from(rest.0 / o.0)
    }
}

type Triple = [Double; 3];

fn triple(v: DVec3) -> Triple {
    v.to_array().map(Double::from)
}

fn minus(a: Triple, b: Triple) -> Triple {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Triple, b: Triple) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Triple, b: Triple) -> Triple {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn along(a: Triple, s: Double, b: Triple) -> Triple {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn column(camera: &Camera, point: Triple) -> Double {
    let way = minus(point, triple(camera.position_m));
    let axes = &camera.world_from_camera;
    Double::from(camera.cx_px)
        + Double::from(camera.fx_px) * dot(way, triple(axes.x_axis)) / dot(way, triple(axes.z_axis))
}

/// `u_L - u_R` of the point where a pixel's ray meets a triangle's plane.
pub(crate) fn disparity_px(rig: &StereoRig, camera: &Camera, pixel: [u32; 2], corners: &[DVec3; 3]) -> f64 {
    let axes = &camera.world_from_camera;
    let right = (Double::from(f64::from(pixel[0])) - Double::from(camera.cx_px)) / Double::from(camera.fx_px);
    let down = (Double::from(f64::from(pixel[1])) - Double::from(camera.cy_px)) / Double::from(camera.fy_px);
    let way = along(along(triple(axes.z_axis), right, triple(axes.x_axis)), down, triple(axes.y_axis));
    let [a, b, c] = corners.map(triple);
    let normal = cross(minus(b, a), minus(c, a));
    let eye = triple(camera.position_m);
    let s = dot(normal, minus(a, eye)) / dot(normal, way);
    let point = along(eye, s, way);
    (column(&rig.left, point) - column(&rig.right, point)).value()
}

#[test]
fn thirty_digits() {
    let third = Double::from(1.0) / Double::from(3.0);
    let back = third * Double::from(3.0) - Double::from(1.0);
    assert!(back.value().abs() < 1e-31);
    let tiny = Double::from(1e17) + Double::from(1.0) - Double::from(1e17);
    assert_eq!(tiny.value(), 1.0);
}
