//! What colour a surface has in a viewer that knows no textures of ours: its materials' mean reflectance.
//!
//! Blue, green and red reflectance stand for linear blue, green and red, as in a satellite's true-colour picture.

use super::parts::Part;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Bands, Brdf, Instance, Material, Mesh, Scene, SurfacePoint};

/// Linear red, green, blue reflectance.
pub(super) type Rgb = [f32; 3];

/// How a part of an instance is coloured.
#[derive(Clone, Debug)]
pub(super) enum Colour {
    /// The same all over: square roots of red, green and blue in steps of 1/[`STEPS`], so that instances that look alike
    /// share a material.
    Even([u8; 3]),
    /// One for each of the part's vertices.
    Vertices(Vec<Rgb>),
}

/// Levels of an even colour: a step is 8 % of a reflectance of a quarter.
const STEPS: f32 = 50.0;
/// Triangles of a part that an even colour is the mean of.
const SAMPLES: usize = 16;
/// Differences of a colour along a part that are worth colours at its vertices: so much of the mean, and so much on top.
const RELATIVE: f32 = 0.08;
const ABSOLUTE: f32 = 0.004;

impl Colour {
    /// A part that stands in the scene once: with colours at its vertices if they differ.
    pub(super) fn of_one(scene: &Scene, instance: &Instance, part: &Part) -> Self {
        let colours = at_vertices(&Surface::of(scene, instance, part), part);
        let (mut low, mut high, mut sum) = ([f32::MAX; 3], [0.0_f32; 3], [0.0_f64; 3]);
        for colour in &colours {
            for k in 0..3 {
                low[k] = low[k].min(colour[k]);
                high[k] = high[k].max(colour[k]);
                sum[k] += f64::from(colour[k]);
            }
        }
        let mean = sum.map(|s| (s / colours.len() as f64) as f32);
        if (0..3).any(|k| high[k] - low[k] > RELATIVE * mean[k] + ABSOLUTE) {
            Self::Vertices(colours)
        } else {
            Self::even(mean)
        }
    }

    /// A part of one of many: its mean over the whole of it.
    pub(super) fn of_many(scene: &Scene, instance: &Instance, part: &Part) -> Self {
        let surface = Surface::of(scene, instance, part);
        let chosen = part.triangles.iter().step_by(part.triangles.len().div_ceil(SAMPLES).max(1));
        let chosen: Vec<([u32; 3], DVec3)> =
            chosen.map(|t| t.map(|k| part.vertices[k as usize])).map(|t| (t, surface.area_m2(t))).collect();
        let sampled_m2: f64 = chosen.iter().map(|(_, area)| area.length()).sum();
        let whole_m2 = sampled_m2 * part.triangles.len() as f64 / chosen.len() as f64;
        let mut sum = [0.0_f64; 3];
        for (triangle, area) in &chosen {
            let middle = |of: [DVec3; 3]| (of[0] + of[1] + of[2]) / 3.0;
            let object_m = middle(triangle.map(|v| surface.object_m(v)));
            let uv_m = middle(triangle.map(|v| surface.uv_m(v).extend(0.0))).truncate();
            let normal = area.try_normalize().unwrap_or(DVec3::Z);
            let rgb = surface.shaded(object_m, uv_m, normal, whole_m2.sqrt());
            for k in 0..3 {
                sum[k] += f64::from(rgb[k]) * area.length();
            }
        }
        Self::even(sum.map(|s| (s / sampled_m2) as f32))
    }

    fn even(rgb: Rgb) -> Self {
        Self::Even(rgb.map(|x| (x.max(0.0).sqrt() * STEPS).round_ties_even() as u8))
    }

    /// The reflectance of an even colour.
    pub(super) fn linear(levels: [u8; 3]) -> Rgb {
        levels.map(|l| (f32::from(l) / STEPS) * (f32::from(l) / STEPS))
    }
}

/// The material of a part.
pub(super) fn material_of<'s>(scene: &'s Scene, instance: &Instance, part: &Part) -> &'s Material {
    &scene.materials[scene.material_sets[instance.material_set as usize][part.slot as usize] as usize]
}

/// The colour at each vertex of a part, over a footprint as wide as the triangles around it.
fn at_vertices(surface: &Surface<'_>, part: &Part) -> Vec<Rgb> {
    // The sum of the triangles around each vertex as vectors, that of their areas, and how many they are.
    let mut around = vec![(DVec3::ZERO, 0.0_f64, 0.0_f64); part.vertices.len()];
    for triangle in &part.triangles {
        let area = surface.area_m2(triangle.map(|k| part.vertices[k as usize]));
        for k in triangle {
            let (sum, length, count) = &mut around[*k as usize];
            *sum += area;
            *length += area.length();
            *count += 1.0;
        }
    }
    let turn = surface.instance.world_from_object.matrix3.inverse().transpose();
    let colour = |(v, (area, length, count)): (&u32, &(DVec3, f64, f64))| {
        let smooth = surface.mesh.normals.get(*v as usize).map(|n| turn * DVec3::from_array(n.map(f64::from)));
        let normal = smooth.unwrap_or(*area).try_normalize().unwrap_or(DVec3::Z);
        // Two right-angled triangles make a square.
        surface.shaded(surface.object_m(*v), surface.uv_m(*v), normal, (2.0 * length / count).sqrt())
    };
    part.vertices.par_iter().zip(&around).map(colour).collect()
}

/// A part's material on its instance.
struct Surface<'s> {
    scene: &'s Scene,
    instance: &'s Instance,
    mesh: &'s Mesh,
    material: &'s Material,
}

impl<'s> Surface<'s> {
    fn of(scene: &'s Scene, instance: &'s Instance, part: &Part) -> Self {
        let mesh = &scene.meshes[instance.mesh as usize];
        Self { scene, instance, mesh, material: material_of(scene, instance, part) }
    }

    fn object_m(&self, vertex: u32) -> DVec3 {
        DVec3::from_array(self.mesh.positions_m[vertex as usize].map(f64::from))
    }

    fn uv_m(&self, vertex: u32) -> DVec2 {
        self.mesh.uvs_m.get(vertex as usize).map_or(DVec2::ZERO, |[u, v]| DVec2::new((*u).into(), (*v).into()))
    }

    /// A triangle's area in the world along its normal.
    fn area_m2(&self, triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|v| self.instance.world_from_object.transform_point3(self.object_m(v)));
        (b - a).cross(c - a) * 0.5
    }

    fn shaded(&self, object_m: DVec3, uv_m: DVec2, normal: DVec3, footprint_m: f64) -> Rgb {
        // A leaf has no outside: it is looked at from above.
        let turned = matches!(self.material.brdf, Brdf::Leaf { .. }) && normal.z < 0.0;
        let point = SurfacePoint {
            world_m: self.instance.world_from_object.transform_point3(object_m),
            object_m,
            uv_m,
            normal: if turned { -normal } else { normal },
            footprint_m,
            variation: self.instance.variation,
        };
        let Bands([blue, green, red, _]) = self.material.shade(&point, &self.scene.rasters).albedo;
        [red, green, blue]
    }
}
