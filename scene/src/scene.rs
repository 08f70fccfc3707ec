//! A scene: what stands around one pivot.

use crate::material::{Class, Material};
use crate::mesh::{Mesh, MeshError};
use crate::raster::MaterialRaster;
use glam::{DAffine3, DVec3};

/// A half-line in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, m.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Object frame to world frame. A vertex's true position is this, in f64, times its f32 coordinates.
    pub world_from_object: DAffine3,
    /// Index into [`Scene::objects`].
    pub object: u32,
    /// Index into [`Scene::material_sets`].
    pub material_set: u32,
    /// Four numbers in -1..1 that materials may read: what makes one of a kind differ from the next.
    pub variation: [f32; 4],
}

/// One thing of a scene, as the instance label and the object table name it. Object 0 is the bare terrain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Path in the scene's seed tree, such as `block/17/house/3`.
    pub path: String,
    /// What it is as a whole; its triangles may be of several classes.
    pub class: Class,
}

/// Everything that stands around one pivot. It knows neither cameras nor light.
///
/// The pivot's foot is the origin of the world's plane. Instances of object 0 are the bare terrain: the DTM is made of
/// them alone.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Meshes, each placed by one or more instances.
    pub meshes: Vec<Mesh>,
    /// Placements.
    pub instances: Vec<Instance>,
    /// Materials.
    pub materials: Vec<Material>,
    /// For each material set, the index of the material that stands in each slot.
    pub material_sets: Vec<Vec<u32>>,
    /// Rasters that materials read.
    pub rasters: Vec<MaterialRaster>,
    /// Object table; entry 0 is the terrain.
    pub objects: Vec<Object>,
    /// Height of the ground at the pivot, m.
    pub pivot_height_m: f64,
    /// Within this distance from the pivot geometry stands in full detail, m.
    pub full_detail_radius_m: f64,
}

/// What is wrong with a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneError {
    /// A mesh is not legal.
    Mesh {
        /// Which.
        mesh: usize,
        /// Why.
        error: MeshError,
    },
    /// An instance names something that does not exist.
    Instance {
        /// Which.
        instance: usize,
        /// What it names.
        what: &'static str,
    },
    /// A material set names a material that does not exist.
    MaterialSet {
        /// Which.
        set: usize,
    },
}

impl core::fmt::Display for SceneError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Mesh { mesh, error } => write!(f, "mesh {mesh}: {error}"),
            Self::Instance { instance, what } => write!(f, "instance {instance} names a {what} that does not exist"),
            Self::MaterialSet { set } => write!(f, "material set {set} names a material that does not exist"),
        }
    }
}

impl core::error::Error for SceneError {}

impl Scene {
    /// The material of an instance's triangle.
    #[inline]
    pub fn material(&self, instance: u32, triangle: u32) -> &Material {
        let instance = &self.instances[instance as usize];
        let slot = self.meshes[instance.mesh as usize].slots[triangle as usize];
        &self.materials[self.material_sets[instance.material_set as usize][slot as usize] as usize]
    }

    /// World positions of a triangle's corners, m, f64.
    #[inline]
    pub fn corners(&self, instance: u32, triangle: u32) -> [DVec3; 3] {
        let instance = &self.instances[instance as usize];
        self.meshes[instance.mesh as usize]
            .corners(triangle as usize)
            .map(|p| instance.world_from_object.transform_point3(p))
    }

    /// Checks every mesh and every index.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (mesh, m) in self.meshes.iter().enumerate() {
            m.validate().map_err(|error| SceneError::Mesh { mesh, error })?;
        }
        for (set, materials) in self.material_sets.iter().enumerate() {
            if materials.iter().any(|m| *m as usize >= self.materials.len()) {
                return Err(SceneError::MaterialSet { set });
            }
        }
        for (instance, i) in self.instances.iter().enumerate() {
            let missing = |what| Err(SceneError::Instance { instance, what });
            let Some(mesh) = self.meshes.get(i.mesh as usize) else { return missing("mesh") };
            let Some(set) = self.material_sets.get(i.material_set as usize) else { return missing("material set") };
            if mesh.slots.iter().any(|s| *s as usize >= set.len()) {
                return missing("material slot");
            }
            if i.object as usize >= self.objects.len() {
                return missing("object");
            }
        }
        Ok(())
    }

    /// Triangles held, and triangles seen through all instances.
    pub fn triangle_counts(&self) -> (usize, usize) {
        let held = self.meshes.iter().map(|m| m.triangles.len()).sum();
        let placed = self.instances.iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum();
        (held, placed)
    }

    /// BLAKE3 over everything that decides a pixel or a label, for golden hashes.
    pub fn hash(&self) -> [u8; 32] {
        let mut h = blake3::Hasher::new();
        let count = |h: &mut blake3::Hasher, n: usize| {
            h.update(&(n as u64).to_le_bytes());
        };
        count(&mut h, self.meshes.len());
        for m in &self.meshes {
            count(&mut h, m.positions_m.len());
            for v in m.positions_m.iter().chain(&m.normals).flatten().chain(m.uvs_m.iter().flatten()) {
                h.update(&v.to_bits().to_le_bytes());
            }
            count(&mut h, m.triangles.len());
            for v in m.triangles.iter().flatten() {
                h.update(&v.to_le_bytes());
            }
            for v in &m.slots {
                h.update(&v.to_le_bytes());
            }
        }
        count(&mut h, self.instances.len());
        for i in &self.instances {
            for v in i.world_from_object.to_cols_array() {
                h.update(&v.to_bits().to_le_bytes());
            }
            for v in [i.mesh, i.object, i.material_set] {
                h.update(&v.to_le_bytes());
            }
            for v in i.variation {
                h.update(&v.to_bits().to_le_bytes());
            }
        }
        // Debug output of floats is the shortest text that reads back to the same bits: as good as the bits.
        for m in &self.materials {
            h.update(format!("{m:?}").as_bytes());
        }
        for set in &self.material_sets {
            count(&mut h, set.len());
            for v in set {
                h.update(&v.to_le_bytes());
            }
        }
        for r in &self.rasters {
            h.update(r.finest().data.as_flattened());
        }
        for o in &self.objects {
            count(&mut h, o.path.len());
            h.update(o.path.as_bytes());
            h.update(&[o.class as u8]);
        }
        h.update(&self.pivot_height_m.to_bits().to_le_bytes());
        *h.finalize().as_bytes()
    }
}
