//! The rectified stereo rig of `SatUnreal` (Kim et al., CVPR-W EarthVision 2026), with a disparity datum.

use super::Camera;
use glam::{DMat3, DVec3};

/// At which height disparity is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Datum {
    /// Nowhere: centred frames, d = f B / depth.
    None,
    /// At a height above the region's ground datum, m: the lenses are shifted so that the frames overlap fully there.
    Height(f64),
}

/// What defines a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigSpec {
    /// Height of both cameras above z = 0, m, H in the equations.
    pub altitude_m: f64,
    /// Ground sample distance at z = 0, m; the focal length is altitude / GSD.
    pub gsd_m: f64,
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// Distance of the optical centres, m, B.
    pub baseline_m: f64,
    /// Direction from the left to the right camera, clockwise from north, radians.
    pub azimuth_rad: f64,
    /// Where the pivot's foot stands along the baseline: 0 under the left camera, 1 under the right one.
    pub pivot_along_baseline: f64,
    /// The acquisition's centre on the ground, m.
    pub pivot_m: DVec3,
    /// Disparity datum.
    pub datum: Datum,
}

/// Two cameras whose rows are epipolar lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoRig {
    /// What it was made of.
    pub spec: RigSpec,
    /// Left camera.
    pub left: Camera,
    /// Right camera.
    pub right: Camera,
}

impl StereoRig {
    /// Places the cameras: `C_L = P - t B e_u`, `C_R = C_L + B e_u`, both at the altitude, axes straight down.
    pub fn new(spec: RigSpec) -> Self {
        let (sin, cos) = libm::sincos(spec.azimuth_rad);
        let right = DVec3::new(sin, cos, 0.0);
        let down = DVec3::new(cos, -sin, 0.0);
        let focal_px = spec.altitude_m / spec.gsd_m;
        let doffs_px = match spec.datum {
            Datum::None => 0.0,
            Datum::Height(z0) => focal_px * spec.baseline_m / (spec.altitude_m - z0),
        };
        let foot = spec.pivot_m.with_z(spec.altitude_m);
        let camera = |along: f64, shift_px: f64| Camera {
            width_px: spec.size_px[0],
            height_px: spec.size_px[1],
            fx_px: focal_px,
            fy_px: focal_px,
            cx_px: (f64::from(spec.size_px[0]) - 1.0) / 2.0 + shift_px,
            cy_px: (f64::from(spec.size_px[1]) - 1.0) / 2.0,
            position_m: foot + right * along,
            world_from_camera: DMat3::from_cols(right, down, DVec3::NEG_Z),
        };
        let left_along = -spec.pivot_along_baseline * spec.baseline_m;
        Self {
            spec,
            left: camera(left_along, -doffs_px / 2.0),
            right: camera(left_along + spec.baseline_m, doffs_px / 2.0),
        }
    }

    /// `cx_R - cx_L`, px: what a parallel rig's disparity f B / depth exceeds this rig's by.
    pub fn doffs_px(&self) -> f64 {
        self.right.cx_px - self.left.cx_px
    }

    /// Disparity of a point at height `z_m`, px: `f B / (H - z) - doffs`.
    pub fn disparity_at_height_px(&self, z_m: f64) -> f64 {
        self.left.fx_px * self.spec.baseline_m / (self.spec.altitude_m - z_m) - self.doffs_px()
    }

    /// Convergence angle over z = 0, radians: 2 atan(B / 2H).
    pub fn convergence_rad(&self) -> f64 {
        convergence(self.spec.baseline_m, self.spec.altitude_m)
    }

    /// Convergence angle at the pivot's own height, radians.
    pub fn convergence_at_pivot_rad(&self) -> f64 {
        convergence(self.spec.baseline_m, self.spec.altitude_m - self.spec.pivot_m.z)
    }
}

fn convergence(baseline_m: f64, depth_m: f64) -> f64 {
    2.0 * libm::atan(baseline_m / (2.0 * depth_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(baseline_m: f64) -> RigSpec {
        RigSpec {
            altitude_m: 1000.0,
            gsd_m: 0.3,
            size_px: [2048, 2048],
            baseline_m,
            azimuth_rad: 0.7,
            pivot_along_baseline: 0.5,
            pivot_m: DVec3::ZERO,
            datum: Datum::None,
        }
    }

    /// The published facts: disparity on the ground, convergence, out-of-frame share.
    #[test]
    fn facts_of_the_paper() {
        for (baseline, disparity, convergence_deg, lost) in [
            (50.0, 166.7, 2.86, 8.1),
            (100.0, 333.3, 5.72, 16.3),
            (150.0, 500.0, 8.58, 24.4),
            (200.0, 666.7, 11.42, 32.6),
        ] {
            let rig = StereoRig::new(spec(baseline));
            assert!((rig.disparity_at_height_px(0.0) - disparity).abs() < 0.05);
            assert!((rig.convergence_rad().to_degrees() - convergence_deg).abs() < 0.005);
            assert!((rig.disparity_at_height_px(0.0) / 2048.0 * 100.0 - lost).abs() < 0.05);
        }
    }

    #[test]
    fn the_rig_is_rectified() {
        let rig = StereoRig::new(RigSpec { datum: Datum::Height(12.0), ..spec(137.0) });
        for p in [DVec3::new(10.0, -80.0, 33.0), DVec3::new(-200.0, 5.0, -150.0)] {
            let (l, r) = (rig.left.project(p).expect("seen"), rig.right.project(p).expect("seen"));
            assert!((l.y - r.y).abs() < 1e-9);
            assert!((l.x - r.x - rig.disparity_at_height_px(p.z)).abs() < 1e-9);
        }
        assert!(rig.disparity_at_height_px(12.0).abs() < 1e-12);
        assert!(rig.disparity_at_height_px(0.0) < 0.0, "below the datum disparity is negative");
    }

    #[test]
    fn the_datum_makes_frames_overlap_fully() {
        let rig = StereoRig::new(RigSpec { altitude_m: 617_000.0, datum: Datum::Height(0.0), ..spec(123_400.0) });
        let corner = |c: &Camera| {
            let ray = c.ray(0.0, 0.0);
            ray.origin + ray.direction * (-ray.origin.z / ray.direction.z)
        };
        assert!((corner(&rig.left) - corner(&rig.right)).length() < 1e-6);
    }
}
