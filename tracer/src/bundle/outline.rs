//! The outlines of a bundle in the frame of a tree, and its way through that tree.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::LANES;
use super::frame::{Frame, axes};
use super::shaft::{Shaft, Shafts, range};
use crate::bvh8::{Bvh8, Child, Node8};
use crate::simd::{Lanes, Wide, prefetch};
use crate::slab::Bounds;
use glam::DAffine3;

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

/// A bundle's shaft and those of its packets.
pub(super) struct Outline {
    /// Two cross axes and the axis of depth.
    pub(super) axes: [usize; 3],
    /// Depth is `sign * z - reference`.
    pub(super) sign: f32,
    pub(super) reference: f32,
    pub(super) shafts: Shafts,
    pub(super) bundle: Shaft,
}

impl Outline {
    /// The next leaf or instance that packets' shafts meet, nearer ones first, and a bit for each of these packets. `behind`
    /// is what leaves name.
    #[inline(always)]
    pub(super) fn next<L: Lanes, B>(
        &self,
        _: L,
        nodes: &[Node8],
        behind: &[B],
        stack: &mut Vec<Entry>,
    ) -> Option<(Entry, u32)> {
        let [x, y, z] = self.axes;
        let s = &self.bundle;
        while let Some(entry) = stack.pop() {
            if entry.near > s.far {
                continue;
            }
            let mut packets = 0xffff;
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
                return Some((entry, packets));
            }
            let node = &nodes[entry.child.first as usize];
            let (low, high) = (&node.boxes.low, &node.boxes.high);
            let (near, far) = self.depths::<8, L::X8>(L::X8::load(&low[z]), L::X8::load(&high[z]));
            let low = [L::X8::load(&low[x]), L::X8::load(&low[y]), near];
            let high = [L::X8::load(&high[x]), L::X8::load(&high[y]), far];
            let mut met = s.meet::<L>(low, high);
            let nears = near.store();
            let base = stack.len();
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let near = nears[lane];
                let child = node.children[lane];
                if child.count > 0 {
                    prefetch(&behind[child.first as usize]);
                } else {
                    prefetch(&nodes[child.first as usize]);
                }
                stack.push(Entry { child, near, parent: entry.child.first, lane: lane as u32 });
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

    /// Depths between which an entry's box stands.
    #[inline(always)]
    fn depths_of(&self, nodes: &[Node8], entry: &Entry) -> [f32; 2] {
        let Some(parent) = nodes.get(entry.parent as usize) else { return [f32::NEG_INFINITY, f32::INFINITY] };
        let [a, b] = [&parent.boxes.low, &parent.boxes.high]
            .map(|border| border[self.axes[2]][entry.lane as usize] * self.sign - self.reference);
        [a.min(b), a.max(b)]
    }
}

/// A bundle inside an instance: its outlines there, while the rays themselves stay in the world.
///
/// Between two depths of the world a packet's rays stay in the hull of its shaft's two sections. Turned into the
/// instance's frame, the sections' corners bound it by planes along the rays' mean direction.
pub(super) struct View {
    pub(super) outline: Outline,
    /// Packets that entered.
    chosen: u32,
    /// The world's depths between which each packet is seen.
    from: [f32; LANES],
    to: [f32; LANES],
    /// Largest depth here of the section at `from`, and how it grows with the world's depth.
    depth: [f32; LANES],
    growth: [f32; LANES],
    error_m: f32,
}

impl View {
    /// The `chosen` packets as they pass the box of an instance, which `entry` names, in the frame of the tree in there.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(
        _: L,
        frame: &Frame,
        nodes: &[Node8],
        entry: &Entry,
        chosen: u32,
        m: &DAffine3,
        tree: &Bvh8,
    ) -> Self {
        let (world, error_m) = (&frame.outline, frame.error_m);
        let [near, far] = world.depths_of(nodes, entry);
        let from = L::X16::load(&world.shafts.start).max(L::X16::splat(near - error_m));
        let to = L::X16::load(&world.shafts.far).min(L::X16::splat(far + error_m));
        let [ux, uy, uz] = world.axes;
        let sign = f64::from(world.sign);
        // The columns of the world's cross axes and of growing depth, and the place of depth 0 on the axis of depth.
        let columns = [m.matrix3.col(ux), m.matrix3.col(uy), m.matrix3.col(uz) * sign];
        let rest = m.translation + columns[2] * f64::from(world.reference);
        let middle = &world.bundle;
        let slope = |k: usize| f64::from(f32::midpoint(middle.low_slope[k], middle.high_slope[k]));
        let mean = columns[2] + columns[0] * slope(0) + columns[1] * slope(1);
        let [x, y, z] = axes(mean);
        let sign = if mean[z] < 0.0 { -1.0 } else { 1.0 };
        let reference = (nearest(tree.bounds, z, sign) as f32).next_down();
        // Roundings of f32 on the way: at most ten, of twice the largest entry times six lengths of the world.
        let scale = columns.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
        let own_error_m = (2.0 * tree.slack + 8.0 * scale * f64::from(error_m)) as f32;
        let ahead =
            [columns[0][z], columns[1][z], columns[2][z], rest[z] - sign * f64::from(reference)].map(|v| v * sign);
        let slopes = [mean[x] / (mean[z] * sign), mean[y] / (mean[z] * sign)];
        let row = |k: usize, slope: f64| {
            let own = [columns[0][k], columns[1][k], columns[2][k], rest[k]];
            core::array::from_fn(|i| (own[i] - slope * ahead[i]) as f32)
        };
        let rows: [[f32; 4]; 3] = [row(x, slopes[0]), row(y, slopes[1]), ahead.map(|v| v as f32)];
        let (first, second) = (Section::new(&world.shafts, from), Section::new(&world.shafts, to));
        let error = L::X16::splat(own_error_m);
        let mut shafts = Shafts::NONE;
        for k in 0..2 {
            let ([low, high], [low_end, high_end]) = (first.extent(&rows[k]), second.extent(&rows[k]));
            shafts.low[k] = low.min(low_end).sub(error).store();
            shafts.high[k] = high.max(high_end).add(error).store();
            shafts.low_slope[k] = [slopes[k] as f32; LANES];
            shafts.high_slope[k] = shafts.low_slope[k];
        }
        let ([low, depth], [low_end, depth_end]) = (first.extent(&rows[2]), second.extent(&rows[2]));
        // A shorter way than the error is as good as none.
        let growth = depth_end.sub(depth).div(to.sub(from).max(L::X16::splat(error_m)));
        shafts.start = low.min(low_end).sub(error).store();
        let mut bundle = Shaft::NONE;
        bundle.start = f32::INFINITY;
        (bundle.low, bundle.high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for p in 0..LANES {
            if chosen >> p & 1 == 0 {
                continue;
            }
            bundle.start = bundle.start.min(shafts.start[p]);
            for k in 0..2 {
                bundle.low[k] = bundle.low[k].min(shafts.low[k][p]);
                bundle.high[k] = bundle.high[k].max(shafts.high[k][p]);
            }
        }
        for k in 0..2 {
            bundle.low_slope[k] = slopes[k] as f32;
            bundle.high_slope[k] = slopes[k] as f32;
        }
        let outline = Outline { axes: [x, y, z], sign: sign as f32, reference, shafts, bundle };
        let (from, to, depth, growth) = (from.store(), to.store(), depth.store(), growth.store());
        let mut view = Self { outline, chosen, from, to, depth, growth, error_m: own_error_m };
        view.refresh::<L>(&world.shafts);
        view
    }

    /// Takes over how far the packets still look.
    #[inline(always)]
    pub(super) fn refresh<L: Lanes>(&mut self, world: &Shafts) {
        let from = L::X16::load(&self.from);
        let far = L::X16::load(&world.far);
        let open = self.chosen & from.le(far);
        let depth = L::X16::load(&self.depth);
        let way = far.min(L::X16::load(&self.to)).sub(from);
        let deepest = depth.max(depth.add(way.mul(L::X16::load(&self.growth))));
        let mut far = deepest.add(L::X16::splat(self.error_m)).store();
        for p in 0..LANES {
            if open >> p & 1 == 0 {
                far[p] = f32::NEG_INFINITY;
            }
        }
        self.outline.shafts.far = far;
        self.outline.bundle.far = range(&far).1;
    }
}

/// Where sixteen shafts pass a depth each.
struct Section<X> {
    low: [X; 2],
    high: [X; 2],
    depth: X,
}

impl<X: Wide<LANES>> Section<X> {
    #[inline(always)]
    fn new(shafts: &Shafts, depth: X) -> Self {
        let mut section = Self { low: [depth; 2], high: [depth; 2], depth };
        for k in 0..2 {
            section.low[k] = X::load(&shafts.low[k]).add(X::load(&shafts.low_slope[k]).mul(depth));
            section.high[k] = X::load(&shafts.high[k]).add(X::load(&shafts.high_slope[k]).mul(depth));
        }
        section
    }

    /// Between which values a sum of both cross coordinates, depth and 1, with these factors, lies.
    #[inline(always)]
    fn extent(&self, factors: &[f32; 4]) -> [X; 2] {
        let rest = self.depth.mul(X::splat(factors[2])).add(X::splat(factors[3]));
        let (mut least, mut most) = (rest, rest);
        for k in 0..2 {
            let (a, b) = (self.low[k].mul(X::splat(factors[k])), self.high[k].mul(X::splat(factors[k])));
            least = least.add(a.min(b));
            most = most.add(a.max(b));
        }
        [least, most]
    }
}

/// Signed depth of the nearer border of bounds along an axis.
#[inline(always)]
fn nearest(bounds: Bounds, axis: usize, sign: f64) -> f64 {
    (bounds.low[axis] * sign).min(bounds.high[axis] * sign)
}
