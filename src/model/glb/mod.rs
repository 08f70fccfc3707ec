//! A scene as glTF 2.0, binary.
//!
//! Every mesh is held once and every instance is a node. A primitive is the part of a mesh that shares a material slot.
//! What stands in the scene once has colours at its vertices; what stands there often has, for each instance, the mean of
//! its materials in coarse steps: instances that look alike are one glTF mesh, and all glTF meshes of a mesh have the
//! same accessors.

mod buffers;
mod colours;
mod document;
mod parts;
#[cfg(test)]
mod tests;

use super::{About, ModelError};
use crate::dataset::CLASS_NAMES;
use buffers::Buffers;
use colours::{Colour, Rgb, material_of};
use document::{
    Asset, Attributes, Buffer, Document, Ior, MaterialEntry, MaterialExtensions, MaterialExtras, MeshEntry,
    MetallicRoughness, Node, NodeExtras, Primitive, SceneEntry, SceneExtras, container,
};
use parts::{Part, parts};
use rayon::prelude::*;
use satseed_scene::{Brdf, Class, Instance, Material, Mesh, Scene};
use std::collections::BTreeMap;

/// A coat mirrors: this rough, so that a viewer's lamps show on it.
const COAT_ROUGHNESS: f32 = 0.05;
/// East, north, up to glTF's x, y up, z towards the viewer: columns.
const Y_UP: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// The accessors of a part of a mesh.
#[derive(Clone, Copy, Debug)]
struct Geometry {
    position: u32,
    normal: Option<u32>,
    indices: u32,
}

/// What makes two glTF materials one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MaterialKey {
    material: u32,
    /// The even colour's levels; none where vertices have colours.
    even: Option<[u8; 3]>,
}

/// The bytes of a GLB file with a whole scene. Work is spread over the current rayon pool; the bytes do not depend on it.
///
/// # Errors
/// Where the scene has no triangle, or the file would have 4 GiB or more.
pub fn glb(scene: &Scene, about: &About) -> Result<Vec<u8>, ModelError> {
    let parts: Vec<Vec<Part>> = scene.meshes.par_iter().map(parts).collect();
    let colours = colours_of(scene, &parts);
    let brightest = brightest(scene, &parts, &colours);
    let mut buffers = Buffers::default();
    let geometry = geometry(scene, &parts, &mut buffers);

    let mut nodes =
        vec![Node { name: &about.scene, matrix: Some(Y_UP), mesh: None, children: Vec::new(), extras: None }];
    let mut meshes: Vec<MeshEntry> = Vec::new();
    let mut materials: Vec<MaterialEntry> = Vec::new();
    let mut material_numbers: BTreeMap<MaterialKey, u32> = BTreeMap::new();
    let mut mesh_numbers: BTreeMap<(u32, Vec<MaterialKey>), u32> = BTreeMap::new();
    for (instance, colours) in scene.instances.iter().zip(&colours) {
        let object = &scene.objects[instance.object as usize];
        let parts = &parts[instance.mesh as usize];
        let keys: Vec<MaterialKey> =
            parts.iter().zip(colours).map(|(p, c)| material_key(scene, instance, p, c)).collect();
        // A mesh that stands once has keys of its own, and so have its vertices' colours.
        let mesh = (!parts.is_empty()).then(|| {
            *mesh_numbers.entry((instance.mesh, keys.clone())).or_insert_with(|| {
                let primitives = parts
                    .iter()
                    .zip(&geometry[instance.mesh as usize])
                    .zip(keys.iter().zip(colours))
                    .map(|((part, geometry), (key, colour))| {
                        let most = brightest.get(&key.material).copied();
                        let material = *material_numbers.entry(*key).or_insert_with(|| {
                            let rgb = key.even.map_or_else(|| most.unwrap_or([1.0; 3]), Colour::linear);
                            materials.push(entry(material_of(scene, instance, part), rgb));
                            materials.len() as u32 - 1
                        });
                        let color = match (colour, most) {
                            (Colour::Vertices(rgb), Some(most)) => Some(buffers.colours(&in_255ths(rgb, most))),
                            _ => None,
                        };
                        let Geometry { position, normal, indices } = *geometry;
                        Primitive { attributes: Attributes { position, normal, color }, indices, material }
                    })
                    .collect();
                meshes.push(MeshEntry { name: &object.path, primitives });
                meshes.len() as u32 - 1
            })
        });
        let extras = Some(NodeExtras { object: instance.object, class: class_name(object.class) });
        nodes.push(Node { name: &object.path, matrix: matrix(instance), mesh, children: Vec::new(), extras });
    }
    if meshes.is_empty() {
        return Err(ModelError::Empty);
    }
    nodes[0].children = (1..nodes.len() as u32).collect();

    let (accessors, buffer_views, binary) = buffers.finish();
    let extensions_used =
        if materials.iter().any(|m| m.extensions.is_some()) { vec!["KHR_materials_ior"] } else { vec![] };
    let extras = SceneExtras {
        about,
        units: "m",
        frame: "under the root node: x east, y north, z up, the origin the pivot's foot at the region's datum",
        pivot_height_m: scene.pivot_height_m,
        full_detail_radius_m: scene.full_detail_radius_m,
    };
    let document = Document {
        asset: Asset { version: "2.0", generator: concat!("satseed ", env!("CARGO_PKG_VERSION")) },
        extensions_used,
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

/// For each material that is coloured at vertices, the largest red, green and blue: colours are stored as shares of it, and
/// a viewer that knows no colours at vertices shows it.
fn brightest(scene: &Scene, parts: &[Vec<Part>], colours: &[Vec<Colour>]) -> BTreeMap<u32, Rgb> {
    let mut brightest: BTreeMap<u32, Rgb> = BTreeMap::new();
    for (instance, colours) in scene.instances.iter().zip(colours) {
        for (part, colour) in parts[instance.mesh as usize].iter().zip(colours) {
            let Colour::Vertices(rgb) = colour else { continue };
            let key = material_key(scene, instance, part, colour);
            let most = brightest.entry(key.material).or_insert([1.0 / 255.0; 3]);
            for colour in rgb {
                for k in 0..3 {
                    most[k] = most[k].max(colour[k]);
                }
            }
        }
    }
    brightest
}

/// All meshes into the buffers, those that no instance places left out.
fn geometry(scene: &Scene, parts: &[Vec<Part>], buffers: &mut Buffers) -> Vec<Vec<Geometry>> {
    let mut used = vec![false; scene.meshes.len()];
    for instance in &scene.instances {
        used[instance.mesh as usize] = true;
    }
    let part_of = |mesh: &Mesh, part: &Part, buffers: &mut Buffers| {
        let of = |list: &[[f32; 3]]| -> Vec<[f32; 3]> { part.vertices.iter().map(|v| list[*v as usize]).collect() };
        Geometry {
            position: buffers.positions(&of(&mesh.positions_m)),
            normal: (!mesh.normals.is_empty()).then(|| buffers.normals(&of(&mesh.normals))),
            indices: buffers.indices(part.triangles.as_flattened(), part.vertices.len()),
        }
    };
    let mesh_of = |(mesh, parts): (usize, &Vec<Part>), buffers: &mut Buffers| {
        let parts = if used[mesh] { parts.as_slice() } else { &[] };
        parts.iter().map(|part| part_of(&scene.meshes[mesh], part, buffers)).collect()
    };
    parts.iter().enumerate().map(|mesh| mesh_of(mesh, buffers)).collect()
}

fn material_key(scene: &Scene, instance: &Instance, part: &Part, colour: &Colour) -> MaterialKey {
    let material = scene.material_sets[instance.material_set as usize][part.slot as usize];
    let even = match colour {
        Colour::Even(levels) => Some(*levels),
        Colour::Vertices(_) => None,
    };
    MaterialKey { material, even }
}

fn entry(material: &Material, [red, green, blue]: Rgb) -> MaterialEntry<'_> {
    let (roughness, index) = match material.brdf {
        Brdf::Coated { index } => (COAT_ROUGHNESS, Some(index)),
        Brdf::Diffuse { .. } | Brdf::Leaf { .. } => (1.0, None),
    };
    MaterialEntry {
        name: &material.name,
        pbr_metallic_roughness: MetallicRoughness { base_color: [red, green, blue, 1.0], metallic: 0.0, roughness },
        double_sided: matches!(material.brdf, Brdf::Leaf { .. }),
        extensions: index.map(|ior| MaterialExtensions { ior: Ior { ior } }),
        extras: MaterialExtras { class: class_name(material.class) },
    }
}

fn class_name(class: Class) -> &'static str {
    CLASS_NAMES[class as usize]
}

/// Colours as 255ths of the brightest one.
fn in_255ths(colours: &[Rgb], most: Rgb) -> Vec<[u8; 4]> {
    let share = |x: f32, most: f32| (x / most * 255.0).clamp(0.0, 255.0).round_ties_even() as u8;
    colours.iter().map(|c| [share(c[0], most[0]), share(c[1], most[1]), share(c[2], most[2]), u8::MAX]).collect()
}

/// An instance's place; none where it is the identity. Viewers reckon in f32 anyhow: 1 km away it is exact to 0.03 mm.
fn matrix(instance: &Instance) -> Option<[f32; 16]> {
    let m = &instance.world_from_object;
    if *m == glam::DAffine3::IDENTITY {
        return None;
    }
    let column = |c: glam::DVec3, w: f32| [c.x as f32 + 0.0, c.y as f32 + 0.0, c.z as f32 + 0.0, w];
    let columns = [
        column(m.matrix3.x_axis, 0.0),
        column(m.matrix3.y_axis, 0.0),
        column(m.matrix3.z_axis, 0.0),
        column(m.translation, 1.0),
    ];
    Some(core::array::from_fn(|k| columns[k / 4][k % 4]))
}
