//! One ray at a time: for rays that go their own ways.

use crate::block::{Leaf, slot};
use crate::bvh8::{Bvh8, Child, Node8};
use crate::query::{Candidate, Query};
use crate::simd::{Lanes, Wide, dispatch, prefetch};
use crate::slab::{SlabRay, inverse};
use crate::tree::Trees;
use crate::triangle::{ShearedRay, main_axis};
use glam::DVec3;

dispatch! {
    /// Takes one ray through the scene. The stack is empty before and after.
    fn trace<Q: Query>(trees: &Trees, query: &mut Q, stack: &mut Vec<Entry>) = whole
}

#[inline(always)]
fn whole<L: Lanes, Q: Query>(lanes: L, trees: &Trees, query: &mut Q, stack: &mut Vec<Entry>) {
    // One stack for both levels: the inner walk works above what the outer one left.
    let sheared = ShearedRay::new(query.origin(), query.direction());
    let (origin, direction) = (query.origin(), query.direction());
    let Some(mut outer) = Walk::enter(&trees.instances, origin, direction, inverse(direction), query.limit(), stack)
    else {
        return;
    };
    while let Some(leaf) = outer.next(lanes, &trees.placements, stack, query.limit()) {
        for place in leaf.first..leaf.first + leaf.count {
            through_instance(lanes, trees, place, &sheared, query, stack);
        }
        if query.limit() < 0.0 {
            stack.clear();
            return;
        }
    }
}

#[inline(always)]
fn through_instance<L: Lanes, Q: Query>(
    lanes: L,
    trees: &Trees,
    place: u32,
    sheared: &ShearedRay,
    query: &mut Q,
    stack: &mut Vec<Entry>,
) {
    let placement = &trees.placements[place as usize];
    let mesh = &trees.meshes[placement.mesh as usize];
    let (mut origin, mut direction) = (query.origin(), query.direction());
    if !placement.identity {
        origin = placement.object_from_world.transform_point3(origin);
        direction = placement.object_from_world.transform_vector3(direction);
    }
    let bottom = stack.len();
    let inverse = inverse(direction);
    let Some(mut walk) = Walk::enter(&mesh.tree, origin, direction, inverse, query.limit(), stack) else { return };
    let sieve = Sieve::new(&walk.ray, origin, direction, inverse, mesh.tree.slack);
    while let Some(leaf) = walk.next(lanes, &mesh.blocks, stack, query.limit()) {
        let block = mesh.leaf(leaf.first);
        let mut left = sieve.pass::<L>(&block, walk.ray.limit(query.limit())) & ((1 << leaf.count) - 1);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let triangle = block.block.index[lane];
            if !query.starts_on(placement.instance, triangle) {
                let corners = trees.world_corners(place, &block.triangle(lane));
                let with = Candidate { instance: placement.instance, triangle, place, slot: slot(leaf.first, lane) };
                query.decide(sheared, &with, &corners);
            }
        }
        if query.limit() < 0.0 {
            stack.truncate(bottom);
            return;
        }
    }
}

/// A node or leaf that waits, and where the ray enters it.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    child: Child,
    near: f32,
}

/// A ray's way through a tree: gives the leaves that it meets, nearer ones first.
struct Walk<'t> {
    nodes: &'t [Node8],
    ray: SlabRay,
    bottom: usize,
}

impl<'t> Walk<'t> {
    #[inline(always)]
    fn enter(
        tree: &'t Bvh8,
        origin: DVec3,
        direction: DVec3,
        inverse: DVec3,
        limit: f64,
        stack: &mut Vec<Entry>,
    ) -> Option<Self> {
        let slack = tree.slack;
        let (near, _) = tree.bounds.clip(origin, inverse, 0.0, limit, slack)?;
        let bottom = stack.len();
        if !tree.nodes.is_empty() {
            stack.push(Entry { child: Child { first: 0, count: 0 }, near: 0.0 });
        }
        Some(Self { nodes: &tree.nodes, ray: SlabRay::new(origin, direction, inverse, near, slack), bottom })
    }

    /// The next leaf that is entered before `limit`. `behind` is what leaves name.
    #[inline(always)]
    fn next<L: Lanes, B>(&mut self, _: L, behind: &[B], stack: &mut Vec<Entry>, limit: f64) -> Option<Child> {
        let limit = self.ray.limit(limit);
        while stack.len() > self.bottom {
            let entry = stack.pop()?;
            if entry.near > limit {
                continue;
            }
            if entry.child.count > 0 {
                return Some(entry.child);
            }
            let node = &self.nodes[entry.child.first as usize];
            let (nears, mut met) = self.ray.meet::<L::X8>(&node.boxes, limit);
            let base = stack.len();
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let (child, near) = (node.children[lane], nears[lane]);
                if child.count > 0 {
                    prefetch(&behind[child.first as usize]);
                } else {
                    prefetch(&self.nodes[child.first as usize]);
                }
                stack.push(Entry { child, near });
                // The nearest comes to lie on top.
                let mut k = stack.len() - 1;
                while k > base && stack[k - 1].near < near {
                    stack.swap(k - 1, k);
                    k -= 1;
                }
            }
        }
        None
    }
}

/// Sorts out triangles that a ray surely misses, in f32 with a bound, eight at a time.
///
/// The triangle is sheared as in the exact test. What f32 does wrong displaces a corner by less than `error_m`, so an
/// edge function is wrong by less than `error_m` times the sum of its coordinates' sizes, and `error_m` squared.
struct Sieve {
    axes: [usize; 3],
    from: [f32; 3],
    shear: [f32; 2],
    /// Which way depth grows along the third axis, and how much of it there is in a unit of distance.
    sign: f32,
    depth_per_t: f32,
    error_m: f32,
}

impl Sieve {
    #[inline(always)]
    fn new(ray: &SlabRay, origin: DVec3, direction: DVec3, inverse: DVec3, slack: f64) -> Self {
        let z = main_axis(direction);
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let from = origin + direction * ray.start_t;
        Self {
            axes: [x, y, z],
            from: [from[x] as f32, from[y] as f32, from[z] as f32],
            shear: [(direction[x] * inverse[z]) as f32, (direction[y] * inverse[z]) as f32],
            sign: if direction[z] < 0.0 { -1.0 } else { 1.0 },
            depth_per_t: direction[z].abs() as f32,
            error_m: slack as f32,
        }
    }

    /// A bit for each lane that may be met, at a distance of at most `limit` from the start of the walk.
    #[inline(always)]
    fn pass<L: Lanes>(&self, block: &Leaf<'_>, limit: f32) -> u32 {
        let [ix, iy, iz] = self.axes;
        let zero = L::X8::splat(0.0);
        let (mut x, mut y, mut depth) = ([zero; 3], [zero; 3], [zero; 3]);
        for k in 0..3 {
            let z = block.coordinates::<L::X8>(k, iz).sub(L::X8::splat(self.from[2]));
            x[k] = block
                .coordinates::<L::X8>(k, ix)
                .sub(L::X8::splat(self.from[0]))
                .sub(z.mul(L::X8::splat(self.shear[0])));
            y[k] = block
                .coordinates::<L::X8>(k, iy)
                .sub(L::X8::splat(self.from[1]))
                .sub(z.mul(L::X8::splat(self.shear[1])));
            depth[k] = z.mul(L::X8::splat(self.sign));
        }
        let deepest = depth[0].max(depth[1]).max(depth[2]);
        let nearest = depth[0].min(depth[1]).min(depth[2]);
        let last = limit * self.depth_per_t * (1.0 + 4.0 * f32::EPSILON) + self.error_m;
        may_cross(x, y, self.error_m) & L::X8::splat(-self.error_m).le(deepest) & nearest.le(L::X8::splat(last))
    }
}

/// A bit for each lane in which the origin may lie inside the triangle of corners `x`, `y`, of which each coordinate is
/// known to `error_m`.
#[inline(always)]
pub(crate) fn may_cross<const N: usize, X: Wide<N>>(x: [X; 3], y: [X; 3], error_m: f32) -> u32 {
    // The largest size stands for any.
    let [a, b, c] = [x[0].abs().add(y[0].abs()), x[1].abs().add(y[1].abs()), x[2].abs().add(y[2].abs())];
    let bound = a.max(b).max(c).mul(X::splat(4.0 * error_m)).add(X::splat(4.0 * error_m * error_m));
    let below = X::splat(0.0).sub(bound);
    let (mut surely_positive, mut surely_negative) = (0, 0);
    for (p, q) in [(2, 1), (0, 2), (1, 0)] {
        let edge = x[p].mul(y[q]).sub(y[p].mul(x[q]));
        // Not "less or equal", so that a NaN is sure of nothing.
        surely_positive |= bound.le(edge);
        surely_negative |= edge.le(below);
    }
    !(surely_positive & surely_negative)
}
