//! What a tracer holds: a tree for each mesh, with its triangles in blocks, and the tree over the instances.

use crate::block::{Block, Corners, Leaf, Rows};
use crate::bvh8::Bvh8;
use crate::query::Candidate;
use crate::slab::Bounds;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use satseed_scene::{Instance, Mesh, Scene};

/// Most triangles behind a lane of a mesh's tree: one block.
const MAX_LEAF: u32 = 8;

/// Most that trees hold for a triangle of a mesh, bytes, on average over a mesh whose neighbouring triangles lie within
/// 64 m; a mesh takes a few hundred more.
pub const BYTES_PER_TRIANGLE: usize = 70;

/// The same of a mesh of any shape.
pub const BYTES_PER_WIDE_TRIANGLE: usize = 140;

/// Most that trees hold for an instance, bytes, on average over a scene.
pub const BYTES_PER_INSTANCE: usize = 320;

/// A mesh's tree. A leaf's `first` is its block.
pub(crate) struct MeshTree {
    pub(crate) tree: Bvh8,
    pub(crate) blocks: Vec<Block>,
    /// Corners of blocks that are wider than 16 bits reach.
    wide: Vec<Corners>,
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
        let (mut blocks, mut wide) = (Vec::with_capacity(tree.order.len() / 5), Vec::new());
        let order = std::mem::take(&mut tree.order);
        for child in tree.nodes.iter_mut().flat_map(|n| &mut n.children).filter(|c| c.count > 0) {
            let members = &order[child.first as usize..(child.first + child.count) as usize];
            let triangles: Vec<_> = members.iter().map(|m| corners(&mesh.triangles[*m as usize])).collect();
            child.first = blocks.len() as u32;
            blocks.push(Block::new(&triangles, members, &mut wide));
        }
        blocks.shrink_to_fit();
        wide.shrink_to_fit();
        Self { tree, blocks, wide }
    }

    /// A leaf of the tree.
    #[inline(always)]
    pub(crate) fn leaf(&self, block: u32) -> Leaf<'_> {
        Leaf { block: &self.blocks[block as usize], wide: &self.wide }
    }

    /// Bytes held.
    fn bytes(&self) -> usize {
        self.tree.bytes() + self.blocks.capacity() * size_of::<Block>() + self.wide.capacity() * size_of::<Corners>()
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
    /// For each placement; only decisions and bundles need it.
    world_from_object: Vec<DAffine3>,
    /// What f32 may displace any corner by that it brings to the world, m.
    pub(crate) displacement_m: f64,
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
        let displaced = |i: &Instance| displacement_m(&i.world_from_object, meshes[i.mesh as usize].tree.bounds);
        let displacement_m = scene.instances.iter().map(displaced).fold(0.0, f64::max);
        Self { meshes, instances, placements, world_from_object, displacement_m }
    }

    /// The way from a placement's frame to the world; none if they are one.
    #[inline(always)]
    pub(crate) fn rows(&self, place: u32) -> Option<Rows> {
        if self.placements[place as usize].identity {
            return None;
        }
        let m = &self.world_from_object[place as usize];
        let [x, y, z, w] =
            [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis, m.translation].map(glam::DVec3::as_vec3);
        Some([[x.x, y.x, z.x, w.x], [x.y, y.y, z.y, w.y], [x.z, y.z, z.z, w.z]])
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

    /// The true position of a triangle's corners.
    #[inline]
    pub(crate) fn corners(&self, of: &Candidate) -> [DVec3; 3] {
        let mesh = &self.meshes[self.placements[of.place as usize].mesh as usize];
        self.world_corners(of.place, &mesh.leaf(of.slot / 8).triangle(of.slot as usize % 8))
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(MeshTree::bytes).sum();
        meshes + self.instances.bytes() + self.placements.len() * (size_of::<Placement>() + size_of::<DAffine3>())
    }
}

/// What f32 may displace a corner by that it brings to the world, m: 2^-21 of all lengths that occur, where it rounds six
/// times by at most 2^-24 of them.
fn displacement_m(m: &DAffine3, bounds: Bounds) -> f64 {
    let [x, y, z, w] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis, m.translation].map(DVec3::abs);
    let reach = bounds.low.abs().max(bounds.high.abs());
    (x * reach.x + y * reach.y + z * reach.z + w).max_element() * (1.0 / (1_u32 << 21) as f64)
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
