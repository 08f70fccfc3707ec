//! Cameras: projection in f64, and nothing else.
//!
//! Image coordinates: u right, v down, pixels, pixel centres at integers; the centre of a frame W wide is (W - 1) / 2.

mod rig;

pub use rig::{Datum, RigSpec, StereoRig};

use glam::{DMat3, DVec2, DVec3};
use satseed_scene::Ray;

/// A central projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Focal length along u, px.
    pub fx_px: f64,
    /// Focal length along v, px.
    pub fy_px: f64,
    /// Principal point, u, px. A lens shift moves it out of the frame's centre.
    pub cx_px: f64,
    /// Principal point, v, px.
    pub cy_px: f64,
    /// Optical centre, world frame, m.
    pub position_m: DVec3,
    /// Columns: the world directions of image right, image down, and the optical axis. A rotation.
    pub world_from_camera: DMat3,
}

impl Camera {
    /// The viewing ray through image point (u, v), px.
    #[inline]
    pub fn ray(&self, u: f64, v: f64) -> Ray {
        let in_camera = DVec3::new((u - self.cx_px) / self.fx_px, (v - self.cy_px) / self.fy_px, 1.0);
        Ray { origin: self.position_m, direction: (self.world_from_camera * in_camera).normalize() }
    }

    /// The image point of a world point, px; `None` behind the camera.
    #[inline]
    pub fn project(&self, world_m: DVec3) -> Option<DVec2> {
        let way = world_m - self.position_m;
        let m = &self.world_from_camera;
        let depth = way.dot(m.z_axis);
        (depth > 0.0).then(|| {
            DVec2::new(
                self.cx_px + self.fx_px * way.dot(m.x_axis) / depth,
                self.cy_px + self.fy_px * way.dot(m.y_axis) / depth,
            )
        })
    }

    /// The optical centre that sees a world point. One for a central projection; a push-broom has one for each line.
    #[inline]
    pub fn centre_for(&self, _world_m: DVec3) -> DVec3 {
        self.position_m
    }

    /// Whether an image point lies in the frame: [-0.5, W - 0.5) x [-0.5, H - 0.5).
    #[inline]
    pub fn in_frame(&self, image_px: DVec2) -> bool {
        image_px.x >= -0.5
            && image_px.y >= -0.5
            && image_px.x < f64::from(self.width_px) - 0.5
            && image_px.y < f64::from(self.height_px) - 0.5
    }

    /// The 3 x 4 matrix that takes homogeneous world points (m) to homogeneous image points (px), row by row.
    pub fn projection(&self) -> [[f64; 4]; 3] {
        let camera_from_world = self.world_from_camera.transpose();
        let k = DMat3::from_cols(
            DVec3::new(self.fx_px, 0.0, 0.0),
            DVec3::new(0.0, self.fy_px, 0.0),
            DVec3::new(self.cx_px, self.cy_px, 1.0),
        );
        let m = k * camera_from_world;
        let shift = m * -self.position_m;
        core::array::from_fn(|r| [m.col(0)[r], m.col(1)[r], m.col(2)[r], shift[r]])
    }

    /// Length of ground that one pixel covers at distance `t` along its ray, seen square on, m.
    #[inline]
    pub fn footprint_m(&self, t: f64) -> f64 {
        t / self.fx_px
    }

    /// A camera at `position_m` that looks at `target_m` with image down pointing to the ground; for previews.
    pub fn looking_at(position_m: DVec3, target_m: DVec3, size_px: [u32; 2], focal_px: f64) -> Self {
        let forward = (target_m - position_m).normalize();
        let right = forward.cross(DVec3::Z).try_normalize().unwrap_or(DVec3::X);
        Self {
            width_px: size_px[0],
            height_px: size_px[1],
            fx_px: focal_px,
            fy_px: focal_px,
            cx_px: (f64::from(size_px[0]) - 1.0) / 2.0,
            cy_px: (f64::from(size_px[1]) - 1.0) / 2.0,
            position_m,
            world_from_camera: DMat3::from_cols(right, forward.cross(right), forward),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_project_back_to_their_pixel() {
        let oblique = Camera::looking_at(DVec3::new(90.0, -400.0, 310.0), DVec3::ZERO, [640, 480], 700.0);
        for (u, v) in [(0.0, 0.0), (639.0, 479.0), (100.25, 401.5)] {
            let ray = oblique.ray(u, v);
            let back = oblique.project(ray.origin + ray.direction * 523.0).expect("in front");
            assert!((back - DVec2::new(u, v)).length() < 1e-9);
        }
        assert!(oblique.project(oblique.position_m - oblique.world_from_camera.z_axis).is_none());
    }

    #[test]
    fn image_down_is_ground_down() {
        let c = Camera::looking_at(DVec3::new(0.0, -400.0, 310.0), DVec3::ZERO, [640, 480], 700.0);
        let near = c.project(DVec3::new(0.0, -50.0, 0.0)).expect("in front");
        assert!(near.y > 240.0, "the nearer ground lies lower in the picture");
        assert!((c.world_from_camera.determinant() - 1.0).abs() < 1e-12);
        let east = c.project(DVec3::new(30.0, 0.0, 0.0)).expect("in front");
        assert!(east.x > 320.0);
    }

    #[test]
    fn the_projection_matrix_agrees_with_project() {
        let c = Camera::looking_at(DVec3::new(90.0, -400.0, 310.0), DVec3::ZERO, [640, 480], 700.0);
        let p = DVec3::new(12.0, 31.0, 4.0);
        let m = c.projection();
        let h: Vec<f64> = m.iter().map(|r| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]).collect();
        let back = c.project(p).expect("in front");
        assert!((back.x - h[0] / h[2]).abs() < 1e-9 && (back.y - h[1] / h[2]).abs() < 1e-9);
    }
}
