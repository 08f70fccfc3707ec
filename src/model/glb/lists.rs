//! glTF's lists of meshes and materials while they grow: what is the same is there once.

use super::buffers::Buffers;
use super::class_name;
use super::colours::{Colour, Rgb, material_of};
use super::document::{
    Attributes, Ior, MaterialEntry, MaterialExtensions, MaterialExtras, MeshEntry, MetallicRoughness, Primitive,
};
use super::parts::Part;
use satseed_scene::{Brdf, Instance, Material, Mesh, Scene};
use std::collections::BTreeMap;

/// A coat mirrors: this rough, so that a viewer's lamps show on it.
const COAT_ROUGHNESS: f32 = 0.05;

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
    /// The scene's material.
    material: u32,
    /// The even colour's levels; none where vertices have colours.
    even: Option<[u8; 3]>,
}

/// The lists, and the buffers that they speak of.
pub(super) struct Lists<'s> {
    scene: &'s Scene,
    pub meshes: Vec<MeshEntry<'s>>,
    pub materials: Vec<MaterialEntry<'s>>,
    pub buffers: Buffers,
    /// The accessors of each mesh's parts, from when it is first shown.
    geometry: BTreeMap<u32, Vec<Geometry>>,
    /// For each material that is coloured at vertices, the largest red, green and blue: colours are stored as shares of
    /// it, and a viewer that knows no colours at vertices shows it.
    brightest: BTreeMap<u32, Rgb>,
    mesh_numbers: BTreeMap<(u32, Vec<MaterialKey>), u32>,
    material_numbers: BTreeMap<MaterialKey, u32>,
}

impl<'s> Lists<'s> {
    /// Empty lists for instances with parts of these colours.
    pub(super) fn new(scene: &'s Scene, parts: &[Vec<Part>], colours: &[Vec<Colour>]) -> Self {
        let mut brightest: BTreeMap<u32, Rgb> = BTreeMap::new();
        for (instance, colours) in scene.instances.iter().zip(colours) {
            for (part, colour) in parts[instance.mesh as usize].iter().zip(colours) {
                let Colour::Vertices(rgb) = colour else { continue };
                let key = key(scene, instance, part, colour);
                let most = brightest.entry(key.material).or_insert([1.0 / 255.0; 3]);
                for colour in rgb {
                    *most = core::array::from_fn(|k| most[k].max(colour[k]));
                }
            }
        }
        Self {
            scene,
            meshes: Vec::new(),
            materials: Vec::new(),
            buffers: Buffers::default(),
            geometry: BTreeMap::new(),
            brightest,
            mesh_numbers: BTreeMap::new(),
            material_numbers: BTreeMap::new(),
        }
    }

    /// The number of the glTF mesh that shows an instance; none where it has no triangle.
    pub(super) fn mesh(&mut self, instance: &Instance, parts: &[Part], colours: &[Colour]) -> Option<u32> {
        if parts.is_empty() {
            return None;
        }
        let keys: Vec<MaterialKey> =
            parts.iter().zip(colours).map(|(part, colour)| key(self.scene, instance, part, colour)).collect();
        // Only what stands once has colours at its vertices, so no other instance has the same keys and other colours.
        if let Some(number) = self.mesh_numbers.get(&(instance.mesh, keys.clone())) {
            return Some(*number);
        }
        let geometry = self.geometry(instance.mesh, parts);
        let primitives = (0..parts.len())
            .map(|k| {
                let Geometry { position, normal, indices } = geometry[k];
                let material = self.material(keys[k], material_of(self.scene, instance, &parts[k]));
                let color = match &colours[k] {
                    Colour::Even(_) => None,
                    Colour::Vertices(rgb) => {
                        let shares = in_255ths(rgb, self.brightest[&keys[k].material]);
                        Some(self.buffers.colours(&shares))
                    }
                };
                Primitive { attributes: Attributes { position, normal, color }, indices, material }
            })
            .collect();
        let name = &self.scene.objects[instance.object as usize].path;
        self.meshes.push(MeshEntry { name, primitives });
        let number = self.meshes.len() as u32 - 1;
        self.mesh_numbers.insert((instance.mesh, keys), number);
        Some(number)
    }

    fn geometry(&mut self, mesh: u32, parts: &[Part]) -> Vec<Geometry> {
        if let Some(geometry) = self.geometry.get(&mesh) {
            return geometry.clone();
        }
        let Mesh { positions_m, normals, .. } = &self.scene.meshes[mesh as usize];
        let of_part = |part: &Part| {
            let of = |list: &[[f32; 3]]| -> Vec<[f32; 3]> { part.vertices.iter().map(|v| list[*v as usize]).collect() };
            Geometry {
                position: self.buffers.positions(&of(positions_m)),
                normal: (!normals.is_empty()).then(|| self.buffers.normals(&of(normals))),
                indices: self.buffers.indices(part.triangles.as_flattened(), part.vertices.len()),
            }
        };
        let geometry: Vec<Geometry> = parts.iter().map(of_part).collect();
        self.geometry.insert(mesh, geometry.clone());
        geometry
    }

    fn material(&mut self, key: MaterialKey, material: &'s Material) -> u32 {
        *self.material_numbers.entry(key).or_insert_with(|| {
            let rgb = key.even.map_or_else(|| self.brightest[&key.material], Colour::linear);
            self.materials.push(entry(material, rgb));
            self.materials.len() as u32 - 1
        })
    }
}

fn key(scene: &Scene, instance: &Instance, part: &Part, colour: &Colour) -> MaterialKey {
    let material = scene.material_sets[instance.material_set as usize][part.slot as usize];
    let even = match colour {
        Colour::Even(levels) => Some(*levels),
        Colour::Vertices(_) => None,
    };
    MaterialKey { material, even }
}

fn entry(material: &Material, [red, green, blue]: Rgb) -> MaterialEntry<'_> {
    let index = material.brdf.mirror_index();
    let roughness = if index.is_some() { COAT_ROUGHNESS } else { 1.0 };
    MaterialEntry {
        name: &material.name,
        pbr_metallic_roughness: MetallicRoughness { base_color: [red, green, blue, 1.0], metallic: 0.0, roughness },
        double_sided: matches!(material.brdf, Brdf::Leaf { .. }),
        extensions: index.map(|ior| MaterialExtensions { ior: Ior { ior } }),
        extras: MaterialExtras { class: class_name(material.class) },
    }
}

/// Colours as 255ths of the brightest one.
fn in_255ths(colours: &[Rgb], most: Rgb) -> Vec<[u8; 4]> {
    let share = |x: f32, most: f32| (x / most * 255.0).clamp(0.0, 255.0).round_ties_even() as u8;
    colours.iter().map(|c| [share(c[0], most[0]), share(c[1], most[1]), share(c[2], most[2]), u8::MAX]).collect()
}
