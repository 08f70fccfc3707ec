//! Eight-wide trees: obvhs builds a binary tree, which is collapsed.
//!
//! Meister and Bittner's PLOC with reinsertion (obvhs, `fast` settings) gives the topology; opening the child with the
//! largest surface until there are eight gives the wide nodes. The answer of a query does not depend on any of it.

use crate::slab::{Bounds, Boxes8};
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use std::time::Duration;

/// One wide node.
#[derive(Clone, Debug)]
pub(crate) struct Node8 {
    pub(crate) boxes: Boxes8,
    pub(crate) children: [Child; 8],
}

/// What stands behind a lane: primitives `first..first + count` in leaf order, or a node (`count` 0).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Child {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// A tree over boxes.
#[derive(Clone, Debug)]
pub(crate) struct Bvh8 {
    /// Node 0 is the root; empty for an empty list.
    pub(crate) nodes: Vec<Node8>,
    /// For each place in leaf order, the index of the box it came from.
    pub(crate) order: Vec<u32>,
    pub(crate) bounds: Bounds,
}

const MAX_LEAF: u32 = 4;

impl Bvh8 {
    /// A tree over boxes given as lower and upper corners.
    pub(crate) fn build(boxes: &[([f32; 3], [f32; 3])]) -> Self {
        let aabbs: Vec<Aabb> =
            boxes.iter().map(|(low, high)| Aabb::new(Vec3A::from(*low), Vec3A::from(*high))).collect();
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for b in boxes {
            low = low.min(DVec3::from(b.0.map(f64::from)));
            high = high.max(DVec3::from(b.1.map(f64::from)));
        }
        let mut tree = Self { nodes: Vec::new(), order: Vec::new(), bounds: Bounds { low, high } };
        if boxes.is_empty() {
            return tree;
        }
        if boxes.len() <= 8 {
            // A node of single boxes; the builder wants more than one.
            tree.order = (0..boxes.len() as u32).collect();
            let lanes: Vec<(Aabb, Child)> =
                aabbs.iter().enumerate().map(|(i, b)| (*b, Child { first: i as u32, count: 1 })).collect();
            tree.nodes.push(node(&lanes));
            return tree;
        }
        let parameters = BvhBuildParams { max_prims_per_leaf: MAX_LEAF, ..BvhBuildParams::fast_build() };
        let mut build_time = Duration::ZERO;
        let binary = build_bvh2(&aabbs, parameters, &mut build_time);
        tree.order.clone_from(&binary.primitive_indices);
        tree.collapse(&binary, 0);
        tree
    }

    /// Adds the wide node for a binary node and everything below it; gives its index.
    fn collapse(&mut self, binary: &Bvh2, root: u32) -> u32 {
        let at = |i: u32| &binary.nodes[i as usize];
        let mut open = vec![root];
        while open.len() < 8 {
            let largest = open
                .iter()
                .enumerate()
                .filter(|(_, i)| !at(**i).is_leaf())
                .max_by(|a, b| at(*a.1).aabb.half_area().total_cmp(&at(*b.1).aabb.half_area()).then(b.0.cmp(&a.0)))
                .map(|(k, _)| k);
            let Some(k) = largest else { break };
            let first = at(open[k]).first_index;
            open[k] = first;
            open.push(first + 1);
        }
        let index = self.nodes.len() as u32;
        self.nodes.push(node(&[]));
        let mut lanes = Vec::with_capacity(8);
        for i in open {
            let n = at(i);
            let child = if n.is_leaf() {
                Child { first: n.first_index, count: n.prim_count }
            } else {
                Child { first: self.collapse(binary, i), count: 0 }
            };
            lanes.push((n.aabb, child));
        }
        self.nodes[index as usize] = node(&lanes);
        index
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node8>() + self.order.len() * 4
    }
}

fn node(lanes: &[(Aabb, Child)]) -> Node8 {
    let mut node = Node8 {
        boxes: Boxes8 { low: [[f32::INFINITY; 8]; 3], high: [[f32::NEG_INFINITY; 8]; 3] },
        children: [Child::default(); 8],
    };
    for (lane, (aabb, child)) in lanes.iter().enumerate() {
        for axis in 0..3 {
            node.boxes.low[axis][lane] = aabb.min[axis];
            node.boxes.high[axis][lane] = aabb.max[axis];
        }
        node.children[lane] = *child;
    }
    node
}
