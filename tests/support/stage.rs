//! Scenes from parts, and rigs with any lens shift.

use glam::{DAffine3, DMat3, DVec3};
use satseed::camera::{Datum, RigSpec, StereoRig};
use satseed_scene::{Bands, Class, Environment, Instance, Material, Mesh, Object, Scene};

/// A scene whose instances are objects of their own, each of one class.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
}

impl Stage {
    pub(crate) fn new() -> Self {
        Self { scene: Scene { full_detail_radius_m: 1000.0, ..Scene::default() } }
    }

    pub(crate) fn mesh(&mut self, mesh: Mesh) -> u32 {
        mesh.validate().expect("a legal mesh");
        self.scene.meshes.push(mesh);
        self.scene.meshes.len() as u32 - 1
    }

    /// Places a mesh as a new object; gives the instance.
    pub(crate) fn place(&mut self, mesh: u32, world_from_object: DAffine3, class: Class) -> u32 {
        let index = self.scene.instances.len() as u32;
        self.scene.materials.push(Material::diffuse(&format!("m{index}"), class, Bands::grey(0.3)));
        self.scene.material_sets.push(vec![index]);
        self.scene.objects.push(Object { path: format!("part/{index}"), class });
        self.scene.instances.push(Instance {
            mesh,
            world_from_object,
            object: index,
            material_set: index,
            variation: [0.0; 4],
        });
        index
    }

    /// A mesh that is placed once.
    pub(crate) fn add(&mut self, mesh: Mesh, world_from_object: DAffine3, class: Class) -> u32 {
        let mesh = self.mesh(mesh);
        self.place(mesh, world_from_object, class)
    }

    pub(crate) fn finish(self) -> Scene {
        self.scene.validate().expect("a legal scene");
        self.scene
    }
}

/// The columns `e_u`, `-e_v`, up: takes (along the baseline, image up, up) to the world.
pub(crate) fn world_from_baseline(azimuth_rad: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(azimuth_rad);
    DMat3::from_cols(DVec3::new(sin, cos, 0.0), DVec3::new(-cos, sin, 0.0), DVec3::Z)
}

/// A rig by what the closed forms need: feet of the cameras, and where the frame's centre looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigCase {
    pub(crate) altitude_m: f64,
    pub(crate) gsd_m: f64,
    pub(crate) size_px: [u32; 2],
    /// Place of both optical centres along the baseline's direction, from the world's origin, m.
    pub(crate) feet_m: [f64; 2],
    pub(crate) azimuth_rad: f64,
    pub(crate) datum: Datum,
    /// Further lens shift of both cameras, px.
    pub(crate) shift_px: [f64; 2],
}

impl RigCase {
    pub(crate) fn rig(&self) -> StereoRig {
        let baseline_m = self.feet_m[1] - self.feet_m[0];
        let mut rig = StereoRig::new(RigSpec {
            altitude_m: self.altitude_m,
            gsd_m: self.gsd_m,
            size_px: self.size_px,
            baseline_m,
            azimuth_rad: self.azimuth_rad,
            pivot_along_baseline: -self.feet_m[0] / baseline_m,
            pivot_m: DVec3::ZERO,
            datum: self.datum,
        });
        for camera in [&mut rig.left, &mut rig.right] {
            camera.cx_px += self.shift_px[0];
            camera.cy_px += self.shift_px[1];
        }
        rig
    }
}

/// A clear day.
pub(crate) fn noon() -> Environment {
    Environment { sun_elevation_rad: 0.9, sun_azimuth_rad: 2.4, aerosol_optical_depth: 0.1 }
}
