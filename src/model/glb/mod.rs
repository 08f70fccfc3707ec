//! A scene as glTF 2.0, binary.
//!
//! Every mesh is held once and every instance is a node. A primitive is the part of a mesh that shares a material slot.
//! What stands in the scene once has colours at its vertices; what stands there often has, for each instance, the mean of
//! its materials in coarse steps: instances that look alike are one glTF mesh, and all glTF meshes of a mesh have the
//! same accessors.

mod buffers;
mod colours;
mod document;
mod lists;
mod parts;
#[cfg(test)]
mod tests;

use super::{About, ModelError};
use crate::dataset::CLASS_NAMES;
use colours::Colour;
use document::{Asset, Buffer, Document, Node, NodeExtras, SceneEntry, SceneExtras, container};
use lists::Lists;
use parts::{Part, parts};
use rayon::prelude::*;
use satseed_scene::{Class, Instance, Scene};

/// East, north, up to glTF's x, y up, z towards the viewer: columns.
const Y_UP: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// The bytes of a GLB file with a whole scene. Work is spread over the current rayon pool; the bytes do not depend on it.
///
/// # Errors
/// Where the scene has no triangle, or the file would have 4 GiB or more.
pub fn glb(scene: &Scene, about: &About) -> Result<Vec<u8>, ModelError> {
    let parts: Vec<Vec<Part>> = scene.meshes.par_iter().map(parts).collect();
    let colours = colours_of(scene, &parts);
    let mut lists = Lists::new(scene, &parts, &colours);
    let root = Node { name: &about.scene, matrix: Some(Y_UP), mesh: None, children: Vec::new(), extras: None };
    let mut nodes = vec![root];
    for (instance, colours) in scene.instances.iter().zip(&colours) {
        let object = &scene.objects[instance.object as usize];
        let mesh = lists.mesh(instance, &parts[instance.mesh as usize], colours);
        let extras = Some(NodeExtras { object: instance.object, class: class_name(object.class) });
        nodes.push(Node { name: &object.path, matrix: matrix(instance), mesh, children: Vec::new(), extras });
    }
    nodes[0].children = (1..nodes.len() as u32).collect();

    let Lists { meshes, materials, buffers, .. } = lists;
    if meshes.is_empty() {
        return Err(ModelError::Empty);
    }
    let (accessors, buffer_views, binary) = buffers.finish();
    let with_index = materials.iter().any(|m| m.extensions.is_some());
    let extras = SceneExtras {
        about,
        units: "m",
        frame: "under the root node: x east, y north, z up, the origin the pivot's foot at the region's datum",
        pivot_height_m: scene.pivot_height_m,
        full_detail_radius_m: scene.full_detail_radius_m,
    };
    let document = Document {
        asset: Asset { version: "2.0", generator: concat!("satseed ", env!("CARGO_PKG_VERSION")) },
        extensions_used: if with_index { vec!["KHR_materials_ior"] } else { Vec::new() },
        scene: 0,
        scenes: [SceneEntry { name: &about.scene, nodes: [0], extras }],
        nodes,
        meshes,
        materials,
        accessors,
        buffer_views,
        buffers: [Buffer { byte_length: binary.len() as u64 }],
    };
    container(&document, &binary)
}

/// The colours of every instance's parts.
fn colours_of(scene: &Scene, parts: &[Vec<Part>]) -> Vec<Vec<Colour>> {
    let mut placed = vec![0_u32; scene.meshes.len()];
    for instance in &scene.instances {
        placed[instance.mesh as usize] += 1;
    }
    let of = |instance: &Instance| {
        let colour = if placed[instance.mesh as usize] == 1 { Colour::of_one } else { Colour::of_many };
        parts[instance.mesh as usize].iter().map(|part| colour(scene, instance, part)).collect()
    };
    scene.instances.par_iter().map(of).collect()
}

fn class_name(class: Class) -> &'static str {
    CLASS_NAMES[class as usize]
}

/// An instance's place; none where it is the identity. Viewers reckon in f32 anyhow: 1 km away it is exact to 0.03 mm.
fn matrix(instance: &Instance) -> Option<[f32; 16]> {
    let m = &instance.world_from_object;
    if *m == glam::DAffine3::IDENTITY {
        return None;
    }
    // A negative zero says nothing to a reader.
    let column = |c: glam::DVec3, w: f32| [c.x as f32 + 0.0, c.y as f32 + 0.0, c.z as f32 + 0.0, w];
    let columns = [
        column(m.matrix3.x_axis, 0.0),
        column(m.matrix3.y_axis, 0.0),
        column(m.matrix3.z_axis, 0.0),
        column(m.translation, 1.0),
    ];
    Some(core::array::from_fn(|k| columns[k / 4][k % 4]))
}
