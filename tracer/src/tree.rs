//! What a tracer holds: a tree for each mesh, its triangles in blocks of eight, and the tree over the instances.

use crate::bvh8::Bvh8;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use satseed_scene::{Instance, Mesh, Scene};

/// Most triangles behind a lane of a mesh's tree: one block.
const MAX_LEAF: u32 = 8;

/// Most that trees hold for a triangle of a mesh, bytes, on average over a mesh, whatever its shape; a mesh takes a few
/// hundred more.
pub const BYTES_PER_TRIANGLE: usize = 100;

/// Most that trees hold for an instance, bytes, on average over a scene.
pub const BYTES_PER_INSTANCE: usize = 320;

/// Eight triangles of a leaf, a lane each, in the mesh's frame.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Corner, axis, lane; m. Lanes that hold no triangle repeat the last one.
    pub(crate) corners: [[[f32; 8]; 3]; 3],
    /// Index of each lane's triangle in its mesh.
    pub(crate) index: [u32; 8],
}

impl Block {
    /// The corners of one lane's triangle.
    #[inline]
    pub(crate) fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        let c = &self.corners;
        [
            [c[0][0][lane], c[0][1][lane], c[0][2][lane]],
            [c[1][0][lane], c[1][1][lane], c[1][2][lane]],
            [c[2][0][lane], c[2][1][lane], c[2][2][lane]],
        ]
    }
}

/// A mesh's tree. A leaf's `first` is its block.
pub(crate) struct MeshTree {
    pub(crate) tree: Bvh8,
    pub(crate) blocks: Vec<Block>,
}

impl MeshTree {
    fn new(mesh: &Mesh) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions_m[v as usize]);
        let boxes: Vec<_> = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = corners(t);
                let low = core::array::from_fn(|i| a[i].min(b[i]).min(c[i]));
                let high = core::array::from_fn(|i| a[i].max(b[i]).max(c[i]));
                (low, high)
            })
            .collect();
        let mut tree = Bvh8::build(&boxes, MAX_LEAF);
        let mut blocks = Vec::with_capacity(tree.order.len() / 5);
        let order = std::mem::take(&mut tree.order);
        for child in tree.nodes.iter_mut().flat_map(|n| &mut n.children).filter(|c| c.count > 0) {
            let members = &order[child.first as usize..(child.first + child.count) as usize];
            let mut block = Block { corners: [[[0.0; 8]; 3]; 3], index: [0; 8] };
            for lane in 0..8 {
                let index = members[lane.min(members.len() - 1)];
                block.index[lane] = index;
                for (k, corner) in corners(&mesh.triangles[index as usize]).into_iter().enumerate() {
                    for (axis, x) in corner.into_iter().enumerate() {
                        block.corners[k][axis][lane] = x;
                    }
                }
            }
            child.first = blocks.len() as u32;
            blocks.push(block);
        }
        Self { tree, blocks }
    }
}

/// Where an instance stands, as rays come to it. They come in the order of the tree, so that neighbours in space are
/// neighbours in memory; two cache lines each.
#[repr(C, align(64))]
pub(crate) struct Placement {
    pub(crate) object_from_world: DAffine3,
    pub(crate) mesh: u32,
    pub(crate) instance: u32,
    /// The instance's frame is the world's: nothing to transform.
    pub(crate) identity: bool,
}

/// Both levels of a scene.
pub(crate) struct Trees {
    pub(crate) meshes: Vec<MeshTree>,
    /// Over the instances, one behind a lane; a leaf's `first` is its placement.
    pub(crate) instances: Bvh8,
    pub(crate) placements: Vec<Placement>,
    /// For each placement; only decisions need it.
    world_from_object: Vec<DAffine3>,
}

impl Trees {
    pub(crate) fn new(scene: &Scene) -> Self {
        let meshes: Vec<MeshTree> = scene.meshes.par_iter().map(MeshTree::new).collect();
        let boxes: Vec<_> = scene.instances.iter().map(|i| world_box(i, &meshes[i.mesh as usize])).collect();
        let mut instances = Bvh8::build(&boxes, 1);
        let order = std::mem::take(&mut instances.order);
        let world_from_object: Vec<DAffine3> =
            order.iter().map(|i| scene.instances[*i as usize].world_from_object).collect();
        let placements = order
            .iter()
            .zip(&world_from_object)
            .map(|(instance, world_from_object)| Placement {
                object_from_world: world_from_object.inverse(),
                mesh: scene.instances[*instance as usize].mesh,
                instance: *instance,
                identity: *world_from_object == DAffine3::IDENTITY,
            })
            .collect();
        Self { meshes, instances, placements, world_from_object }
    }

    /// The true position of a placed triangle's corners: f64 transform times f32 vertex.
    #[inline]
    pub(crate) fn world_corners(&self, place: u32, corners: &[[f32; 3]; 3]) -> [DVec3; 3] {
        let identity = self.placements[place as usize].identity;
        let m = &self.world_from_object[place as usize];
        let at = |c: &[f32; 3]| {
            let p = DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2]));
            if identity { p } else { m.transform_point3(p) }
        };
        [at(&corners[0]), at(&corners[1]), at(&corners[2])]
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(|m| m.tree.bytes() + m.blocks.len() * size_of::<Block>()).sum();
        meshes + self.instances.bytes() + self.placements.len() * (size_of::<Placement>() + size_of::<DAffine3>())
    }
}

/// A box in f32 that holds the placed mesh.
fn world_box(instance: &Instance, mesh: &MeshTree) -> ([f32; 3], [f32; 3]) {
    let b = mesh.tree.bounds;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for k in 0..8 {
        let pick = |bit: u32, axis: usize| if k >> bit & 1 == 0 { b.low[axis] } else { b.high[axis] };
        let p = instance.world_from_object.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)));
        low = low.min(p);
        high = high.max(p);
    }
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    (low.to_array().map(down), high.to_array().map(up))
}
