//! The way of a bundle through a tree.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::LANES;
use super::frame::Frame;
use super::shaft::{overlap, range, splat4};
use crate::bvh8::{Child, Node8};
use crate::query::{Candidate, Query};
use crate::simd::{Lanes, Wide};
use crate::single::may_cross;
use crate::tree::{Leaf, Trees, slot};
use crate::triangle::ShearedPacket;

/// A node or leaf that waits, and the depth at which the shaft enters it.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) child: Child,
    pub(super) near: f32,
    /// The node and lane that hold its box; no such node for a root.
    pub(super) parent: u32,
    pub(super) lane: u32,
}

impl Entry {
    pub(super) const ROOT: Self =
        Self { child: Child { first: 0, count: 0 }, near: f32::NEG_INFINITY, parent: u32::MAX, lane: 0 };
}
impl Frame {
    /// The next leaf that packets' shafts meet, nearer ones first, and a bit for each of these packets.
    #[inline(always)]
    pub(super) fn next<L: Lanes>(&self, _: L, nodes: &[Node8], stack: &mut Vec<Entry>) -> Option<(Child, u32)> {
        let [x, y, z] = self.axes;
        let s = &self.bundle;
        while let Some(entry) = stack.pop() {
            if entry.near > s.far {
                continue;
            }
            let mut packets = (1 << self.packets.len()) - 1;
            if let Some(parent) = nodes.get(entry.parent as usize) {
                let (low, high, lane) = (&parent.boxes.low, &parent.boxes.high, entry.lane as usize);
                let (near, far) = self.depths::<16, L::X16>(L::X16::splat(low[z][lane]), L::X16::splat(high[z][lane]));
                packets =
                    self.shafts.meet::<L>([near, far], [[low[x][lane], high[x][lane]], [low[y][lane], high[y][lane]]]);
                if packets == 0 {
                    continue;
                }
            }
            if entry.child.count > 0 {
                return Some((entry.child, packets));
            }
            let node = &nodes[entry.child.first as usize];
            let (low, high) = (&node.boxes.low, &node.boxes.high);
            let (near, far) = self.depths::<8, L::X8>(L::X8::load(&low[z]), L::X8::load(&high[z]));
            let mut met = near.le(L::X8::splat(s.far)) & L::X8::splat(s.start).le(far);
            for (k, axis) in [(0, x), (1, y)] {
                met &= overlap(
                    splat4([s.low[k], s.low_slope[k], s.high[k], s.high_slope[k]]),
                    [near, far],
                    [L::X8::load(&low[axis]), L::X8::load(&high[axis])],
                );
            }
            let nears = near.store();
            let base = stack.len();
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let near = nears[lane];
                stack.push(Entry { child: node.children[lane], near, parent: entry.child.first, lane: lane as u32 });
                let mut k = stack.len() - 1;
                while k > base && stack[k - 1].near < near {
                    stack.swap(k - 1, k);
                    k -= 1;
                }
            }
        }
        None
    }

    /// Depths of lower and upper borders along the axis of depth: the nearer and the farther.
    #[inline(always)]
    pub(super) fn depths<const N: usize, X: Wide<N>>(&self, low: X, high: X) -> (X, X) {
        let (sign, reference) = (X::splat(self.sign), X::splat(self.reference));
        let (a, b) = (low.mul(sign).sub(reference), high.mul(sign).sub(reference));
        if self.sign > 0.0 { (a, b) } else { (b, a) }
    }

    /// Offers a block's triangles to the rays that may meet them; gives the packets of which a ray took one.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn meet<L: Lanes, Q: Query>(
        &mut self,
        _: L,
        trees: &Trees,
        place: u32,
        block: &Leaf<'_>,
        leaf: Child,
        sheared: &[ShearedPacket],
        queries: &mut [Q],
    ) -> u32 {
        let [x, y, z] = self.axes;
        let instance = trees.placements[place as usize].instance;
        let (low_z, high_z) = extent::<L>(block, z);
        let (near, far) = self.depths::<8, L::X8>(low_z, high_z);
        let ranges = [extent::<L>(block, x), extent::<L>(block, y)];
        let s = &self.bundle;
        let mut left = near.le(L::X8::splat(s.far)) & L::X8::splat(s.start).le(far) & ((1 << leaf.count) - 1);
        for k in 0..2 {
            let lines = splat4([s.low[k], s.low_slope[k], s.high[k], s.high_slope[k]]);
            left &= overlap(lines, [near, far], [ranges[k].0, ranges[k].1]);
        }
        if left == 0 {
            return 0;
        }
        let (near, far) = (near.store(), far.store());
        let ranges = [(ranges[0].0.store(), ranges[0].1.store()), (ranges[1].0.store(), ranges[1].1.store())];
        let mut touched = 0_u32;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let mut packets = self.shafts.meet::<L>(
                [L::X16::splat(near[lane]), L::X16::splat(far[lane])],
                [[ranges[0].0[lane], ranges[0].1[lane]], [ranges[1].0[lane], ranges[1].1[lane]]],
            );
            if packets == 0 {
                continue;
            }
            let corners = block.triangle(lane);
            let triangle = block.block.index[lane];
            let mut world = None;
            while packets != 0 {
                let p = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let mut rays = self.sieve::<L>(p, &corners, near[lane], far[lane]);
                if rays == 0 {
                    continue;
                }
                let world = world.get_or_insert_with(|| trees.world_corners(place, &corners));
                let crossings = sheared[p].cross::<L::D16>(rays, world);
                rays = crossings.met;
                while rays != 0 {
                    let ray = rays.trailing_zeros() as usize;
                    rays &= rays - 1;
                    let query = &mut queries[p * LANES + ray];
                    if query.starts_on(instance, triangle) {
                        continue;
                    }
                    let before = query.limit();
                    let with = Candidate { instance, triangle, place, slot: slot(leaf.first, lane) };
                    query.take(&with, world, &crossings.of(ray));
                    if query.limit() != before {
                        self.packets[p].far[ray] = self.far_of(&queries[p * LANES + ray]);
                        touched |= 1 << p;
                    }
                }
            }
        }
        let mut changed = touched;
        while changed != 0 {
            let p = changed.trailing_zeros() as usize;
            changed &= changed - 1;
            self.shafts.far[p] = range(&self.packets[p].far).1;
        }
        if touched != 0 {
            self.bundle.far = range(&self.shafts.far).1;
        }
        touched
    }

    /// A bit for each ray of a packet that may meet a triangle of these depths.
    #[inline(always)]
    pub(super) fn sieve<L: Lanes>(&self, p: usize, corners: &[[f32; 3]; 3], near: f32, far: f32) -> u32 {
        let packet = &self.packets[p];
        let open =
            L::X16::splat(near).le(L::X16::load(&packet.far)) & L::X16::load(&packet.start).le(L::X16::splat(far));
        if open == 0 {
            return 0;
        }
        let zero = L::X16::splat(0.0);
        let mut sides = [[zero; 3]; 2];
        for i in 0..3 {
            let depth = L::X16::splat(corners[i][self.axes[2]] * self.sign - self.reference);
            for k in 0..2 {
                let (place, slope) = (L::X16::load(&packet.place[k]), L::X16::load(&packet.slope[k]));
                sides[k][i] = L::X16::splat(corners[i][self.axes[k]]).sub(place).sub(slope.mul(depth));
            }
        }
        may_cross(sides[0], sides[1], self.error_m) & open
    }
}

/// Lower and upper borders of a block's triangles along an axis.
#[inline(always)]
fn extent<L: Lanes>(block: &Leaf<'_>, axis: usize) -> (L::X8, L::X8) {
    let a = block.coordinates::<L::X8>(0, axis);
    let b = block.coordinates::<L::X8>(1, axis);
    let c = block.coordinates::<L::X8>(2, axis);
    (a.min(b).min(c), a.max(b).max(c))
}
