//! What a reader of the file finds, held against the scene.

use super::*;
use crate::recipe::{Recipe, Region};
use glam::{DAffine3, DMat3, DVec3, DVec4};
use satseed_scene::{Bands, Brdf, Coordinate, Field, Layer, Material, Mesh, Object};
use serde_json::Value;

/// A file taken apart again.
struct Read {
    json: Value,
    binary: Vec<u8>,
}

/// A triangle as a viewer shows it: corners in the world's axes, and the linear colour of each.
struct Shown {
    corners_m: [DVec3; 3],
    rgb: [[f64; 3]; 3],
}

impl Read {
    fn new(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8), &bytes[16..20]), (&b"glTF"[..], 2, bytes.len(), &b"JSON"[..]));
        let end = 20 + word(12);
        assert_eq!((end % 4, &bytes[end + 4..end + 8], word(end)), (0, &b"BIN\0"[..], bytes.len() - end - 8));
        Self { json: serde_json::from_slice(&bytes[20..end]).unwrap(), binary: bytes[end + 8..].to_vec() }
    }

    fn list(&self, name: &str) -> &[Value] {
        self.json[name].as_array().unwrap()
    }

    /// The numbers of an accessor, as they are stored.
    fn numbers(&self, accessor: &Value) -> Vec<f64> {
        let accessor = &self.list("accessors")[number(accessor)];
        let view = &self.list("bufferViews")[number(&accessor["bufferView"])];
        let columns = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            other => panic!("{other}"),
        };
        let start = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
        let count = number(&accessor["count"]) * columns;
        let kind = number(&accessor["componentType"]);
        let size = [(5121, 1), (5123, 2), (5125, 4), (5126, 4)].iter().find(|k| k.0 == kind).unwrap().1;
        assert!(number(&accessor["byteOffset"]) + count * size <= number(&view["byteLength"]));
        assert!(view["byteStride"].is_null() || number(&view["byteStride"]) == size * columns);
        let value = |b: &[u8]| match kind {
            5121 => f64::from(b[0]),
            5123 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            5125 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            _ => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        };
        self.binary[start..start + count * size].chunks_exact(size).map(value).collect()
    }

    /// What node `k` of the root's children shows, primitive after primitive.
    fn shown(&self, k: usize) -> Vec<Shown> {
        let nodes = self.list("nodes");
        let root = &nodes[number(&self.json["scenes"][0]["nodes"][0])];
        let node = &nodes[number(&root["children"][k])];
        let mut shown = Vec::new();
        for primitive in self.list("meshes")[number(&node["mesh"])]["primitives"].as_array().unwrap() {
            let positions = self.numbers(&primitive["attributes"]["POSITION"]);
            let colours = &primitive["attributes"]["COLOR_0"];
            let colours = (!colours.is_null()).then(|| self.numbers(colours));
            let material = &self.list("materials")[number(&primitive["material"])]["pbrMetallicRoughness"];
            let factor = floats(&material["baseColorFactor"]);
            for triangle in self.numbers(&primitive["indices"]).chunks_exact(3) {
                let corner = |i: f64| {
                    let p = DVec3::from_slice(&positions[3 * i as usize..]);
                    let up_is_y = transformed(&root["matrix"], transformed(&node["matrix"], p));
                    DVec3::new(up_is_y.x, -up_is_y.z, up_is_y.y)
                };
                let rgb = |i: f64| {
                    let share = |c: usize| colours.as_ref().map_or(1.0, |v| v[4 * i as usize + c] / 255.0);
                    core::array::from_fn(|c| factor[c] * share(c))
                };
                let of = [triangle[0], triangle[1], triangle[2]];
                shown.push(Shown { corners_m: of.map(corner), rgb: of.map(rgb) });
            }
        }
        shown
    }
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn transformed(matrix: &Value, p: DVec3) -> DVec3 {
    if matrix.is_null() {
        return p;
    }
    let m = floats(matrix);
    (0..4).fold(DVec3::ZERO, |sum, c| sum + DVec4::from_slice(&m[4 * c..]).truncate() * p.extend(1.0)[c])
}

fn about() -> About {
    About {
        scene: "test-scene-7".to_owned(),
        region: "test".to_owned(),
        variant: "scene".to_owned(),
        seed: 7,
        generator_version: 1,
        params_hash: "0".repeat(64),
    }
}

/// A strip of ground whose first part is darker the higher it lies, and four cubes' halves on it.
fn small() -> Scene {
    let ground = Mesh {
        positions_m: vec![
            [0.0; 3],
            [4.0, 0.0, 0.0],
            [4.0, 4.0, 1.0],
            [0.0, 4.0, 1.0],
            [0.0, 9.0, 1.0],
            [4.0, 9.0, 1.0],
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4]],
        slots: vec![0, 0, 1, 1],
        ..Mesh::default()
    };
    let thing = Mesh {
        positions_m: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]],
        slots: vec![1, 0, 1],
        ..Mesh::default()
    };
    let height = Field::Along(Coordinate::HEIGHT);
    let slope = Material::diffuse("slope", Class::Sand, Bands::new(0.1, 0.2, 0.4, 0.5))
        .with(Layer::Mix { color: Bands::ZERO, amount: height.affine(0.5, 0.0) });
    let paint = Material::diffuse("paint", Class::Vehicle, Bands::new(0.04, 0.16, 0.36, 0.5))
        .with(Layer::Brightness { amount: Field::Variation(2) });
    let mut glass = Material::diffuse("glass", Class::Vehicle, Bands::grey(0.04));
    glass.brdf = Brdf::Coated { index: 1.52 };
    let mut leaf = Material::diffuse("leaf", Class::Tree, Bands::grey(0.04));
    leaf.brdf = Brdf::Leaf { transmission: Bands::ZERO };
    let object = |path: &str, class| Object { path: path.to_owned(), class };
    let tilted =
        DMat3::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7) * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.5));
    let thing_at = |x: f64, object, material_set, darker: f32| Instance {
        mesh: 1,
        world_from_object: DAffine3::from_mat3_translation(tilted, DVec3::new(x, 3.0, 2.0)),
        object,
        material_set,
        variation: [0.0, 0.0, -darker, 0.0],
    };
    let ground_is =
        Instance { mesh: 0, world_from_object: DAffine3::IDENTITY, object: 0, material_set: 0, variation: [0.0; 4] };
    Scene {
        meshes: vec![ground, thing],
        instances: vec![
            ground_is,
            thing_at(1.0, 1, 1, 0.0),
            thing_at(2.0, 2, 1, 0.001),
            thing_at(3.0, 2, 1, 0.75),
            thing_at(4.0, 3, 2, 0.0),
        ],
        materials: vec![slope, paint, glass, leaf],
        material_sets: vec![vec![0, 2], vec![1, 2], vec![1, 3]],
        objects: vec![
            object("terrain", Class::Ground),
            object("car/1", Class::Vehicle),
            object("car/2", Class::Vehicle),
            object("tree", Class::Tree),
        ],
        pivot_height_m: 1.5,
        full_detail_radius_m: 9.0,
        ..Scene::default()
    }
}

/// Every triangle of every instance, in the order of slots, is where the scene has it.
fn assert_same_triangles(scene: &Scene, read: &Read) {
    assert_eq!(read.json["nodes"][0]["children"].as_array().unwrap().len(), scene.instances.len());
    for (i, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
        order.sort_by_key(|t| mesh.slots[*t]);
        let shown = read.shown(i);
        assert_eq!(shown.len(), order.len(), "instance {i}");
        for (shown, triangle) in shown.iter().zip(order) {
            for (found, expected) in shown.corners_m.iter().zip(scene.corners(i as u32, triangle as u32)) {
                // A matrix of f32: 2^-24 of each product.
                let bound_m = 1e-6 + 4e-7 * expected.abs().max_element();
                assert!((*found - expected).length() < bound_m, "instance {i}: {found} is not {expected}");
            }
        }
    }
}

#[test]
fn a_small_scene_is_told_as_it_is() {
    let scene = small();
    scene.validate().unwrap();
    let bytes = glb(&scene, &about()).unwrap();
    assert_eq!(bytes, glb(&scene, &about()).unwrap());
    let read = Read::new(&bytes);
    assert_same_triangles(&scene, &read);

    // The slope's colour at its vertices: reflectance 0.4, 0.2, 0.1, half of it 1 m up.
    for Shown { corners_m, rgb } in &read.shown(0)[..2] {
        for (p, rgb) in corners_m.iter().zip(rgb) {
            for (found, at_0_m) in rgb.iter().zip([0.4, 0.2, 0.1]) {
                assert!((found - at_0_m * (1.0 - 0.5 * p.z)).abs() < 0.4 / 255.0, "{rgb:?} at {p}");
            }
        }
    }
    // Paint: square roots 0.6, 0.4, 0.2 are levels.
    let paint = |k: usize| read.shown(k)[0].rgb[0];
    for (found, expected) in paint(1).iter().zip([0.36, 0.16, 0.04]) {
        assert!((found - expected).abs() < 1e-6);
    }
    for (found, expected) in paint(3).iter().zip([0.09, 0.04, 0.01]) {
        assert!((found - expected).abs() < 1e-6, "three quarters darker");
    }

    // Like instances share a mesh; others share its vertices.
    let mesh = |k: usize| number(&read.json["nodes"][k + 1]["mesh"]);
    assert!(mesh(1) == mesh(2) && mesh(1) != mesh(3) && mesh(1) != mesh(4));
    let attributes = |k: usize| &read.json["meshes"][mesh(k)]["primitives"];
    for k in [3, 4] {
        for p in 0..2 {
            assert_eq!(attributes(k)[p]["attributes"], attributes(1)[p]["attributes"]);
            assert_eq!(attributes(k)[p]["indices"], attributes(1)[p]["indices"]);
        }
    }
    let material = |name: &str| read.list("materials").iter().find(|m| m["name"] == name).unwrap();
    assert_eq!(material("leaf")["doubleSided"], true);
    assert!(material("glass")["doubleSided"].is_null());
    assert_eq!(material("glass")["extensions"]["KHR_materials_ior"]["ior"], 1.52);
    assert!(material("glass")["pbrMetallicRoughness"]["roughnessFactor"].as_f64().unwrap() < 0.1);
    assert_eq!(read.json["extensionsUsed"], serde_json::json!(["KHR_materials_ior"]));
    assert_eq!(read.json["nodes"][4]["name"], "car/2");
    assert_eq!(read.json["nodes"][4]["extras"], serde_json::json!({ "object": 2, "class": "vehicle" }));
    let extras = &read.json["scenes"][0]["extras"];
    assert_eq!((&extras["seed"], &extras["units"], &extras["pivot_height_m"]), (&7.into(), &"m".into(), &1.5.into()));
}

#[test]
fn a_scene_of_nothing_has_no_model() {
    assert!(matches!(glb(&Scene::default(), &about()), Err(ModelError::Empty)));
    let mut scene = small();
    scene.meshes[1] = Mesh::default();
    let read = Read::new(&glb(&scene, &about()).unwrap());
    assert!(read.json["nodes"][2]["mesh"].is_null(), "an instance of nothing is a place");
    assert_eq!(read.list("meshes").len(), 1);
}

/// What generators make: the whole geometry, and colours near the mean of what the renderer would see.
#[test]
fn every_region_is_told_as_it_is() {
    for name in Region::NAMES {
        let recipe = format!("[[scene]]\n{name} = {{ radius_m = 60.0 }}\npivots = 1");
        let region = Recipe::parse("test", &recipe).unwrap().region(name, None).unwrap();
        let scene = region.build(5);
        let read = Read::new(&glb(&scene, &about()).unwrap());
        assert_same_triangles(&scene, &read);
        // Each mesh once, a vertex where slots meet once for each of them.
        let distinct: usize = scene.meshes.iter().flat_map(parts).map(|p| p.vertices.len()).sum();
        let strides: Vec<&Value> = read.list("bufferViews").iter().filter(|v| v["byteStride"] == 12).collect();
        assert!(number(&strides[0]["byteLength"]) <= 12 * distinct, "{name}");
        let coloured =
            |m: &Value| m["primitives"].as_array().unwrap().iter().any(|p| !p["attributes"]["COLOR_0"].is_null());
        let ground: Vec<&Value> = read
            .list("nodes")
            .iter()
            .filter(|n| n["extras"]["object"] == 0)
            .map(|n| &read.list("meshes")[number(&n["mesh"])])
            .collect();
        let count = ground.iter().filter(|m| coloured(m)).count();
        assert!(
            5 * count >= 4 * ground.len(),
            "{name}: {count} of {} tiles of ground have colours at their vertices",
            ground.len()
        );
    }
}
