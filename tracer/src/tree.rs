//! What a tracer holds: a tree for each mesh, its triangles in blocks of eight, and the tree over the instances.

use crate::bvh8::Bvh8;
use crate::query::Candidate;
use crate::simd::Wide;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use satseed_scene::{Instance, Mesh, QUANTUM_M, Scene};

/// Most triangles behind a lane of a mesh's tree: one block.
const MAX_LEAF: u32 = 8;

/// Most that trees hold for a triangle of a mesh, bytes, on average over a mesh whose neighbouring triangles lie within
/// 64 m; a mesh takes a few hundred more.
pub const BYTES_PER_TRIANGLE: usize = 70;

/// The same of a mesh of any shape.
pub const BYTES_PER_WIDE_TRIANGLE: usize = 140;

/// Most that trees hold for an instance, bytes, on average over a scene.
pub const BYTES_PER_INSTANCE: usize = 320;

/// Eight triangles of a leaf, a lane each, in the mesh's frame. Vertices stand on a lattice ([`QUANTUM_M`]), and those of a
/// leaf close together: so 16 bits hold a coordinate exactly. Three cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Corner, axis, lane; quanta from `base_m`. Lanes that hold no triangle repeat the last one.
    quanta: [[[u16; 8]; 3]; 3],
    /// Lowest coordinates, m.
    base_m: [f32; 3],
    /// Where the corners stand in [`MeshTree::wide`] if they do not fit into 16 bits, else [`FITS`].
    wide: u32,
    /// Index of each lane's triangle in its mesh.
    pub(crate) index: [u32; 8],
}

/// See [`Block::wide`].
const FITS: u32 = u32::MAX;

/// Corner, axis, lane; m.
type Corners = [[[f32; 8]; 3]; 3];

/// A block with the corners that may stand elsewhere.
#[derive(Clone, Copy)]
pub(crate) struct Leaf<'t> {
    pub(crate) block: &'t Block,
    wide: &'t [Corners],
}

impl Leaf<'_> {
    /// One coordinate (m) of one corner of all triangles.
    #[inline(always)]
    pub(crate) fn coordinates<X: Wide<8>>(&self, corner: usize, axis: usize) -> X {
        let block = self.block;
        if block.wide == FITS {
            // Every step is exact: the sum is the vertex's own coordinate.
            let quanta = X::load_u16(&block.quanta[corner][axis]);
            quanta.mul(X::splat(QUANTUM_M as f32)).add(X::splat(block.base_m[axis]))
        } else {
            X::load(&self.wide[block.wide as usize][corner][axis])
        }
    }

    /// The corners of one lane's triangle, m.
    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        let block = self.block;
        let mut corners = [[0.0; 3]; 3];
        if block.wide == FITS {
            for (corner, quanta) in corners.iter_mut().zip(&block.quanta) {
                for axis in 0..3 {
                    corner[axis] = f32::from(quanta[axis][lane]) * QUANTUM_M as f32 + block.base_m[axis];
                }
            }
        } else {
            for (corner, wide) in corners.iter_mut().zip(&self.wide[block.wide as usize]) {
                for axis in 0..3 {
                    corner[axis] = wide[axis][lane];
                }
            }
        }
        corners
    }
}

impl Block {
    /// A block of up to eight triangles.
    fn new(triangles: &[[[f32; 3]; 3]], indices: &[u32], wide: &mut Vec<Corners>) -> Self {
        let of = |lane: usize| lane.min(triangles.len() - 1);
        let corners: Corners = core::array::from_fn(|corner| {
            core::array::from_fn(|axis| core::array::from_fn(|lane| triangles[of(lane)][corner][axis]))
        });
        let mut base_m = [f32::INFINITY; 3];
        for corner in triangles.as_flattened() {
            base_m = core::array::from_fn(|axis| base_m[axis].min(corner[axis]));
        }
        let mut fits = true;
        let quanta = core::array::from_fn(|corner| {
            core::array::from_fn(|axis: usize| {
                corners[corner][axis].map(|x: f32| {
                    let quanta = (f64::from(x) - f64::from(base_m[axis])) / QUANTUM_M;
                    fits &= quanta == f64::from(quanta as u16)
                        && (f32::from(quanta as u16) * QUANTUM_M as f32 + base_m[axis]).to_bits() == x.to_bits();
                    quanta as u16
                })
            })
        });
        let place = if fits { FITS } else { wide.len() as u32 };
        if !fits {
            wide.push(corners);
        }
        Self { quanta, base_m, wide: place, index: core::array::from_fn(|lane| indices[of(lane)]) }
    }
}

/// Number of a lane of a block.
#[inline]
pub(crate) fn slot(block: u32, lane: usize) -> u32 {
    block * 8 + lane as u32
}

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
