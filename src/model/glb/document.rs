//! The part of glTF 2.0 (Khronos 2021) that a scene needs, and the GLB container around it.

use crate::model::ModelError;
use serde::Serialize;

/// The JSON chunk.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document<'a> {
    pub asset: Asset,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_used: Vec<&'static str>,
    pub scene: u32,
    pub scenes: [SceneEntry<'a>; 1],
    pub nodes: Vec<Node<'a>>,
    pub meshes: Vec<MeshEntry<'a>>,
    pub materials: Vec<MaterialEntry<'a>>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: [Buffer; 1],
}

#[derive(Debug, Serialize)]
pub(super) struct Asset {
    pub version: &'static str,
    pub generator: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct SceneEntry<'a> {
    pub name: &'a str,
    pub nodes: [u32; 1],
    pub extras: SceneExtras<'a>,
}

/// What the file shows, for scripts; Blender shows it as the scene's custom properties.
#[derive(Debug, Serialize)]
pub(super) struct SceneExtras<'a> {
    #[serde(flatten)]
    pub about: &'a crate::model::About,
    pub units: &'static str,
    pub frame: &'static str,
    pub pivot_height_m: f64,
    pub full_detail_radius_m: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Node<'a> {
    pub name: &'a str,
    /// Columns one after the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f32; 16]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<u32>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<NodeExtras>,
}

/// Where the node stands in the scene's object table.
#[derive(Debug, Serialize)]
pub(super) struct NodeExtras {
    pub object: u32,
    pub class: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct MeshEntry<'a> {
    pub name: &'a str,
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Serialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: u32,
    pub material: u32,
}

#[derive(Debug, Serialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: u32,
    #[serde(rename = "NORMAL", skip_serializing_if = "Option::is_none")]
    pub normal: Option<u32>,
    #[serde(rename = "COLOR_0", skip_serializing_if = "Option::is_none")]
    pub color: Option<u32>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MaterialEntry<'a> {
    pub name: &'a str,
    pub pbr_metallic_roughness: MetallicRoughness,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub double_sided: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extensions: Option<MaterialExtensions>,
    pub extras: MaterialExtras,
}

#[derive(Debug, Serialize)]
pub(super) struct MetallicRoughness {
    /// Linear red, green, blue, and opacity.
    #[serde(rename = "baseColorFactor")]
    pub base_color: [f32; 4],
    #[serde(rename = "metallicFactor")]
    pub metallic: f32,
    #[serde(rename = "roughnessFactor")]
    pub roughness: f32,
}

#[derive(Debug, Serialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_ior")]
    pub ior: Ior,
}

#[derive(Debug, Serialize)]
pub(super) struct Ior {
    pub ior: f32,
}

#[derive(Debug, Serialize)]
pub(super) struct MaterialExtras {
    pub class: &'static str,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: u32,
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<[f32; 3]>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: u32,
    pub byte_offset: u64,
    pub byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_stride: Option<u32>,
    pub target: u32,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub byte_length: u64,
}

/// The two chunks as one file: each a multiple of 4 bytes, the JSON filled up with spaces.
pub(super) fn container(document: &Document<'_>, binary: &[u8]) -> Result<Vec<u8>, ModelError> {
    let mut json = serde_json::to_vec(document).expect("numbers, names and lists alone");
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() as u64 + 8 + binary.len() as u64;
    let length = u32::try_from(total).map_err(|_| ModelError::TooLarge { bytes: total })?;
    let mut bytes = Vec::with_capacity(length as usize);
    bytes.extend_from_slice(b"glTF");
    for word in [2, length, json.len() as u32] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    bytes.extend_from_slice(b"JSON");
    bytes.extend_from_slice(&json);
    bytes.extend_from_slice(&(binary.len() as u32).to_le_bytes());
    bytes.extend_from_slice(b"BIN\0");
    bytes.extend_from_slice(binary);
    Ok(bytes)
}
