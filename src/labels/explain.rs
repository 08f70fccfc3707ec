//! What one pixel saw, told in full: for people who doubt a label.

use super::{Validity, View, closest, disparity_px, validity};
use crate::camera::StereoRig;
use glam::{DVec2, DVec3};
use satseed_scene::Class;
use satseed_tracer::{Hit, Origin, Tracer};

/// A surface that a ray met.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The point, world frame, m.
    pub point_m: DVec3,
    /// Its distance from where the ray started, m.
    pub distance_m: f64,
    /// Unit geometric normal towards where the ray came from.
    pub normal: DVec3,
    /// Index into the scene's objects.
    pub object: u32,
    /// That object's path in the scene's seed tree.
    pub object_path: String,
    /// Index into the scene's instances, and the triangle of its mesh.
    pub instance_triangle: [u32; 2],
    /// Material.
    pub material: String,
    /// Semantic class.
    pub class: Class,
}

/// What stands between a point and the other camera, and how far from the point.
pub type Occluder = Seen;

/// The two steps of the line trace for one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The verdict.
    pub validity: Validity,
    /// The surface seen, if any.
    pub seen: Option<Seen>,
    /// `u_L - u_R`, px, f64.
    pub disparity_px: Option<f64>,
    /// Where the point projects in the other view, px.
    pub in_other_px: Option<DVec2>,
    /// What occludes it there.
    pub occluder: Option<Occluder>,
}

/// Traces one pixel's centre ray and tells everything.
pub fn explain(tracer: &Tracer, rig: &StereoRig, view: View, pixel: [u32; 2]) -> Explanation {
    let (camera, other) = view.cameras(rig);
    let ray = camera.ray(f64::from(pixel[0]), f64::from(pixel[1]));
    let Some(hit) = closest(tracer, &ray) else {
        return Explanation {
            validity: Validity::Miss,
            seen: None,
            disparity_px: None,
            in_other_px: None,
            occluder: None,
        };
    };
    let validity = validity(tracer, other, &[Some(hit)])[0];
    let occluder = (validity == Validity::Occluded)
        .then(|| tracer.occluder(&Origin::on(&hit), other.centre_for(hit.point)))
        .flatten();
    Explanation {
        validity,
        seen: Some(seen(tracer, &hit)),
        disparity_px: disparity_px(rig, hit.point),
        in_other_px: other.project(hit.point),
        occluder: occluder.map(|h| seen(tracer, &h)),
    }
}

fn seen(tracer: &Tracer, hit: &Hit) -> Seen {
    let scene = tracer.scene();
    let object = scene.instances[hit.instance as usize].object;
    let material = scene.material(hit.instance, hit.triangle);
    Seen {
        point_m: hit.point,
        distance_m: hit.t,
        normal: hit.normal,
        object,
        object_path: scene.objects[object as usize].path.clone(),
        instance_triangle: [hit.instance, hit.triangle],
        material: material.name.clone(),
        class: material.class,
    }
}
