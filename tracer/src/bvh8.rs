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
    /// [`Bounds::slack`] of the bounds, m.
    pub(crate) slack: f64,
}

impl Bvh8 {
    /// A tree over boxes given as lower and upper corners, with at most `max_leaf` of them behind a lane.
    pub(crate) fn build(boxes: &[([f32; 3], [f32; 3])], max_leaf: u32) -> Self {
        let aabbs: Vec<Aabb> =
            boxes.iter().map(|(low, high)| Aabb::new(Vec3A::from(*low), Vec3A::from(*high))).collect();
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for b in boxes {
            low = low.min(DVec3::from(b.0.map(f64::from)));
            high = high.max(DVec3::from(b.1.map(f64::from)));
        }
        let bounds = Bounds { low, high };
        let mut tree = Self { nodes: Vec::new(), order: Vec::new(), bounds, slack: bounds.slack() };
        if boxes.is_empty() {
            return tree;
        }
        if boxes.len() <= 8 {
            // One node; the builder wants more than one box.
            tree.order = (0..boxes.len() as u32).collect();
            let lanes: Vec<(Aabb, Child)> = aabbs
                .chunks(max_leaf as usize)
                .zip((0..).step_by(max_leaf as usize))
                .map(|(boxes, first)| {
                    let all = boxes.iter().fold(Aabb::empty(), |all, b| all.union(b));
                    (all, Child { first, count: boxes.len() as u32 })
                })
                .collect();
            tree.nodes.push(node(&lanes));
            return tree;
        }
        let parameters = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::fast_build() };
        let mut build_time = Duration::ZERO;
        let binary = build_bvh2(&aabbs, parameters, &mut build_time);
        let mut counts = vec![0; binary.nodes.len()];
        count(&binary, 0, &mut counts);
        tree.order.reserve(boxes.len());
        tree.collapse(&binary, &counts, max_leaf, 0);
        tree.nodes.shrink_to_fit();
        tree
    }

    /// Adds the wide node for a binary node and everything below it; gives its index.
    fn collapse(&mut self, binary: &Bvh2, counts: &[u32], max_leaf: u32, root: u32) -> u32 {
        let at = |i: u32| &binary.nodes[i as usize];
        let is_leaf = |i: u32| at(i).is_leaf() || counts[i as usize] <= max_leaf;
        let mut open = vec![root];
        while open.len() < 8 {
            let largest = open
                .iter()
                .enumerate()
                .filter(|(_, i)| !is_leaf(**i))
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
            let child = if is_leaf(i) {
                let first = self.order.len() as u32;
                self.gather(binary, i);
                Child { first, count: self.order.len() as u32 - first }
            } else {
                Child { first: self.collapse(binary, counts, max_leaf, i), count: 0 }
            };
            lanes.push((at(i).aabb, child));
        }
        self.nodes[index as usize] = node(&lanes);
        index
    }

    /// Puts what lies below a binary node next in leaf order.
    fn gather(&mut self, binary: &Bvh2, i: u32) {
        let n = &binary.nodes[i as usize];
        if n.is_leaf() {
            let first = n.first_index as usize;
            self.order.extend_from_slice(&binary.primitive_indices[first..first + n.prim_count as usize]);
        } else {
            self.gather(binary, n.first_index);
            self.gather(binary, n.first_index + 1);
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node8>() + self.order.capacity() * 4
    }
}

/// How many boxes lie below each binary node.
fn count(binary: &Bvh2, i: u32, counts: &mut [u32]) -> u32 {
    let n = &binary.nodes[i as usize];
    let below = if n.is_leaf() {
        n.prim_count
    } else {
        count(binary, n.first_index, counts) + count(binary, n.first_index + 1, counts)
    };
    counts[i as usize] = below;
    below
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
