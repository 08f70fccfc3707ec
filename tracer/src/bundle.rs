//! Many rays that go nearly the same way, taken through the scene together.
//!
//! Rays are kept as lines over depth along the axis that they share most of: `x(w) = x + slope_x w`. Between two planes
//! of depth the rays of a bundle stay between the straight lines through their outermost points, its shaft; one test of
//! the shaft stands for all rays. Sixteen rays make a packet with a shaft of its own; sixteen packets a bundle. What the
//! shafts leave is sieved ray by ray in f32 with a bound, and what that leaves is decided in f64, in the same words as
//! for single rays. So the answers are those of single rays, bit for bit.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use crate::bvh8::{Bvh8, Child, Node8};
use crate::query::Query;
use crate::simd::{Lanes, Wide, dispatch};
use crate::single::{self, may_cross, through_instance};
use crate::slab::Bounds;
use crate::tree::{Block, Placement, Trees};
use crate::triangle::ShearedRay;
use glam::DVec3;

const LANES: usize = 16;
/// Rays of a bundle at most.
pub(crate) const MOST: usize = LANES * LANES;
/// About the size of what stands behind a leaf, m. Rays that lie farther apart than some of them meet more triangles
/// together than alone.
const GRAIN_M: f32 = 1.5;
/// Grains that a packet may be wide, and packets and grains that a bundle may be.
const WIDEST_PACKET: f32 = 2.5;
const WIDEST_BUNDLE: f32 = 8.0;
/// Rays whose slope against the shared axis is larger go alone.
const STEEPEST: f64 = 1.6;

/// Side of a square of neighbouring rays that fill a bundle.
pub const TILE_SIDE: u32 = 16;

/// The cells (column, row) of a tile in the order in which their rays make the narrowest packets: squares of 4 x 4.
pub fn tile_order(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let squares = move |j: u32| (0..width.div_ceil(4)).map(move |i| (4 * i, 4 * j));
    (0..height.div_ceil(4))
        .flat_map(squares)
        .flat_map(|(x, y)| (0..16).map(move |k| (x + k % 4, y + k / 4)))
        .filter(move |(x, y)| *x < width && *y < height)
}

dispatch! {
    /// Takes up to [`MOST`] rays through the scene.
    fn trace<Q: Query>(trees: &Trees, queries: &mut [Q]) = whole
}

#[inline(always)]
fn whole<L: Lanes, Q: Query>(lanes: L, trees: &Trees, queries: &mut [Q]) {
    let mut stacks = Stacks { outer: Vec::with_capacity(64), inner: Vec::with_capacity(64), alone: Vec::new() };
    let mut parts = vec![queries];
    while let Some(queries) = parts.pop() {
        match Frame::world(lanes, &trees.instances, queries) {
            Ok(frame) => together(lanes, trees, frame, queries, &mut stacks),
            Err(Split::Packets) => parts.extend(queries.chunks_mut(LANES)),
            Err(Split::Rays) => {
                for query in queries {
                    single::whole(lanes, trees, query, &mut stacks.alone);
                }
            }
        }
    }
}

/// Takes rays that share a way through the scene.
#[inline(always)]
fn together<L: Lanes, Q: Query>(lanes: L, trees: &Trees, mut world: Frame, queries: &mut [Q], stacks: &mut Stacks) {
    let sheared: Vec<ShearedRay> = queries.iter().map(|q| ShearedRay::new(q.ray())).collect();
    stacks.outer.push(Entry::ROOT);
    while let Some((leaf, packets)) = world.next(lanes, &trees.instances.nodes, &mut stacks.outer) {
        for place in leaf.first..leaf.first + leaf.count {
            let placement = &trees.placements[place as usize];
            let mesh = &trees.meshes[placement.mesh as usize];
            if placement.identity {
                stacks.inner.push(Entry::ROOT);
                while let Some((leaf, _)) = world.next(lanes, &mesh.tree.nodes, &mut stacks.inner) {
                    let block = &mesh.blocks[leaf.first as usize];
                    world.meet(lanes, trees, place, block, leaf.count, &sheared, queries);
                }
                continue;
            }
            let Some(mut object) = world.seen_from(lanes, placement, &mesh.tree, packets) else {
                for (index, (query, sheared)) in queries.iter_mut().zip(&sheared).enumerate() {
                    if packets >> (index / LANES) & 1 == 1 {
                        through_instance(lanes, trees, place, sheared, query, &mut stacks.alone);
                    }
                }
                world.refresh(queries, packets);
                continue;
            };
            let mut touched = 0;
            stacks.inner.push(Entry::ROOT);
            while let Some((leaf, _)) = object.next(lanes, &mesh.tree.nodes, &mut stacks.inner) {
                let block = &mesh.blocks[leaf.first as usize];
                touched |= object.meet(lanes, trees, place, block, leaf.count, &sheared, queries);
            }
            if touched != 0 {
                world.refresh(queries, touched);
            }
        }
    }
}

/// What waits, of both levels of bundles and of rays that go alone.
struct Stacks {
    outer: Vec<Entry>,
    inner: Vec<Entry>,
    alone: Vec<single::Entry>,
}

/// Why rays cannot go as one bundle; it decides over time, never over answers.
enum Split {
    /// Their packets can.
    Packets,
    /// They go their own ways.
    Rays,
}

/// A node or leaf that waits, and the depth at which the shaft enters it.
#[derive(Clone, Copy)]
struct Entry {
    child: Child,
    near: f32,
    /// The node and lane that hold its box; no such node for a root.
    parent: u32,
    lane: u32,
}

impl Entry {
    const ROOT: Self =
        Self { child: Child { first: 0, count: 0 }, near: f32::NEG_INFINITY, parent: u32::MAX, lane: 0 };
}

/// Sixteen rays over depth.
#[derive(Clone, Copy)]
struct Packet {
    /// Place at depth 0 and slope, for both cross axes, m.
    place: [[f32; LANES]; 2],
    slope: [[f32; LANES]; 2],
    /// Depth at which a ray starts, and beyond which it wants nothing; minus infinity once it is done.
    start: [f32; LANES],
    far: [f32; LANES],
}

/// Outlines of sixteen shafts over depth: lower and upper line along both cross axes.
#[derive(Clone, Copy)]
struct Shafts {
    low: [[f32; LANES]; 2],
    low_slope: [[f32; LANES]; 2],
    high: [[f32; LANES]; 2],
    high_slope: [[f32; LANES]; 2],
    start: [f32; LANES],
    far: [f32; LANES],
}

/// One shaft.
#[derive(Clone, Copy)]
struct Shaft {
    low: [f32; 2],
    low_slope: [f32; 2],
    high: [f32; 2],
    high_slope: [f32; 2],
    start: f32,
    far: f32,
}

/// A bundle in the frame of a tree.
struct Frame {
    /// Two cross axes and the axis of depth.
    axes: [usize; 3],
    /// Depth is `sign * z - reference`.
    sign: f32,
    reference: f32,
    /// Depth up to which the shafts' lines hold, m.
    depth: f32,
    /// What f32 may displace a ray by, m.
    error_m: f32,
    packets: Vec<Packet>,
    shafts: Shafts,
    bundle: Shaft,
    /// From the world to this frame: the world's rays are followed up to their limits.
    from_world: Option<glam::DAffine3>,
}

impl Frame {
    /// The rays in the world's frame, if they share a way.
    #[inline(always)]
    fn world<L: Lanes, Q: Query>(lanes: L, tree: &Bvh8, queries: &[Q]) -> Result<Self, Split> {
        let mean = queries.iter().fold(DVec3::ZERO, |sum, q| sum + q.ray().direction);
        let axes = axes(mean);
        let [x, y, z] = axes;
        let sign = if mean[z] < 0.0 { -1.0 } else { 1.0 };
        let [first, last] = depths(tree.bounds, z, sign);
        let (mut start, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
        for q in queries {
            let (o, d) = (q.ray().origin, q.ray().direction);
            let ahead = d[z] * sign;
            if !(d[x].abs() <= STEEPEST * ahead && d[y].abs() <= STEEPEST * ahead) {
                return Err(if queries.len() > LANES { Split::Packets } else { Split::Rays });
            }
            start = start.min(o[z] * sign);
            end = end.max(o[z] * sign + ahead * q.limit());
        }
        // f32's own depth of the first plane: boxes are placed against the same number.
        let reference = (start.max(first) as f32).next_down();
        let depth = (end.min(last) - f64::from(reference)).max(1e-3) as f32;
        let error_m = (2.0 * tree.slack) as f32;
        let packets = queries
            .chunks(LANES)
            .map(|members| {
                let mut packet = Packet::NONE;
                for lane in 0..LANES {
                    let q = &members[lane.min(members.len() - 1)];
                    let (o, d) = (q.ray().origin, q.ray().direction);
                    let inverse = 1.0 / d[z];
                    let slope = [d[x] * inverse * sign, d[y] * inverse * sign];
                    let behind = f64::from(reference) - o[z] * sign;
                    packet.place[0][lane] = (o[x] + slope[0] * behind) as f32;
                    packet.place[1][lane] = (o[y] + slope[1] * behind) as f32;
                    packet.slope[0][lane] = slope[0] as f32;
                    packet.slope[1][lane] = slope[1] as f32;
                    packet.start[lane] = -behind as f32 - error_m;
                    if lane < members.len() {
                        packet.far[lane] = far(-behind + q.limit() * d[z] * sign, error_m, depth);
                    }
                }
                packet
            })
            .collect();
        let mut frame = Self {
            axes,
            sign: sign as f32,
            reference,
            depth,
            error_m,
            packets,
            shafts: Shafts::NONE,
            bundle: Shaft::NONE,
            from_world: None,
        };
        frame.outline(lanes, !0);
        // A shaft that is much wider than its rays need meets much that none of them meets.
        let mut packets: Vec<f32> = (0..frame.packets.len()).map(|p| frame.shafts.side(p, depth)).collect();
        packets.sort_unstable_by(f32::total_cmp);
        let usual = packets[packets.len() / 2];
        if usual > WIDEST_PACKET * GRAIN_M {
            return Err(Split::Rays);
        }
        if queries.len() > LANES && frame.bundle.side(depth) > WIDEST_BUNDLE * (usual + GRAIN_M) {
            return Err(Split::Packets);
        }
        Ok(frame)
    }

    /// Some packets in the frame of an instance with a mesh's tree; none if their rays do not share a way there.
    #[inline(always)]
    fn seen_from<L: Lanes>(&self, lanes: L, placement: &Placement, tree: &Bvh8, chosen: u32) -> Option<Self> {
        let m = &placement.object_from_world;
        let [ux, uy, uz] = self.axes;
        let sign = f64::from(self.sign);
        // The columns of the world's cross axes and of growing depth, and the place of depth 0 on the axis of depth.
        let columns = [m.matrix3.col(ux), m.matrix3.col(uy), m.matrix3.col(uz) * sign];
        let rest = m.translation + columns[2] * f64::from(self.reference);
        let middle = &self.bundle;
        let slope = |k: usize| f64::from(f32::midpoint(middle.low_slope[k], middle.high_slope[k]));
        let mean = columns[2] + columns[0] * slope(0) + columns[1] * slope(1);
        let axes = axes(mean);
        let [x, y, z] = axes;
        let sign = if mean[z] < 0.0 { -1.0 } else { 1.0 };
        let [first, last] = depths(tree.bounds, z, sign);
        let reference = (first as f32).next_down();
        let depth = (last - f64::from(reference)).max(1e-3) as f32;
        let scale = columns.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
        let error_m = (2.0 * tree.slack + 6.0 * scale * f64::from(self.error_m)) as f32;
        // Along each axis of the instance: what the two cross axes, depth and the constant contribute.
        let mut rows = [[0.0_f32; 4]; 3];
        for (row, (k, s)) in rows.iter_mut().zip([(x, 1.0), (y, 1.0), (z, sign)]) {
            *row = [columns[0][k], columns[1][k], columns[2][k], rest[k]].map(|v| (v * s) as f32);
        }
        let rows: [[L::X16; 4]; 3] = [splat4(rows[0]), splat4(rows[1]), splat4(rows[2])];
        let (reference_x, depth_x) = (L::X16::splat(reference), L::X16::splat(depth));
        let (steepest, none) = (L::X16::splat(STEEPEST as f32), L::X16::splat(f32::NEG_INFINITY));
        let mut packets = Vec::with_capacity(self.packets.len());
        for (p, packet) in self.packets.iter().enumerate() {
            if chosen >> p & 1 == 0 {
                packets.push(Packet::NONE);
                continue;
            }
            let place = [L::X16::load(&packet.place[0]), L::X16::load(&packet.place[1])];
            let slope = [L::X16::load(&packet.slope[0]), L::X16::load(&packet.slope[1])];
            let ahead = plus(slope, rows[2], 2);
            let at = plus(place, rows[2], 3).sub(reference_x);
            let sides = [plus(slope, rows[0], 2).div(ahead), plus(slope, rows[1], 2).div(ahead)];
            let within = sides[0].abs().le(steepest) & sides[1].abs().le(steepest) & L::X16::splat(0.0).le(ahead);
            if within != 0xffff {
                return None;
            }
            let (start, limit) = (L::X16::load(&packet.start), L::X16::load(&packet.far));
            let error = L::X16::splat(error_m);
            let mut far = at.add(limit.mul(ahead)).add(error).min(depth_x).store();
            // Those that are done stay so.
            let done = limit.le(none);
            for (lane, far) in far.iter_mut().enumerate() {
                if done >> lane & 1 == 1 {
                    *far = f32::NEG_INFINITY;
                }
            }
            packets.push(Packet {
                place: [
                    plus(place, rows[0], 3).sub(sides[0].mul(at)).store(),
                    plus(place, rows[1], 3).sub(sides[1].mul(at)).store(),
                ],
                slope: [sides[0].store(), sides[1].store()],
                start: at.add(start.mul(ahead)).sub(error).store(),
                far,
            });
        }
        let mut frame = Self {
            axes,
            sign: sign as f32,
            reference,
            depth,
            error_m,
            packets,
            shafts: Shafts::NONE,
            bundle: Shaft::NONE,
            from_world: Some(placement.object_from_world),
        };
        frame.outline(lanes, chosen);
        Some(frame)
    }

    /// Draws the shafts around the rays of chosen packets; the others' shafts stay shut.
    #[inline(always)]
    fn outline<L: Lanes>(&mut self, _: L, chosen: u32) {
        let depth = L::X16::splat(self.depth);
        for (p, packet) in self.packets.iter().enumerate() {
            if chosen >> p & 1 == 0 {
                continue;
            }
            for k in 0..2 {
                let place = L::X16::load(&packet.place[k]);
                let end = place.add(L::X16::load(&packet.slope[k]).mul(depth));
                let (low, high) = range(&place.store());
                let (low_end, high_end) = range(&end.store());
                self.shafts.line(p, k, [low, high, low_end, high_end], self.error_m, self.depth);
            }
            self.shafts.start[p] = range(&packet.start).0;
            self.shafts.far[p] = range(&packet.far).1;
        }
        for k in 0..2 {
            let (s, n) = (&self.shafts, self.packets.len());
            let end = |at: &[f32; LANES], slope: &[f32; LANES], p: usize| at[p] + slope[p] * self.depth;
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            let (mut low_end, mut high_end) = (f32::INFINITY, f32::NEG_INFINITY);
            for p in (0..n).filter(|p| chosen >> p & 1 == 1) {
                low = low.min(s.low[k][p]);
                high = high.max(s.high[k][p]);
                low_end = low_end.min(end(&s.low[k], &s.low_slope[k], p));
                high_end = high_end.max(end(&s.high[k], &s.high_slope[k], p));
            }
            self.bundle.low[k] = low - self.error_m;
            self.bundle.high[k] = high + self.error_m;
            self.bundle.low_slope[k] = (low_end - low) / self.depth;
            self.bundle.high_slope[k] = (high_end - high) / self.depth;
        }
        self.bundle.start = range(&self.shafts.start).0;
        self.bundle.far = range(&self.shafts.far).1;
    }

    /// Takes over the limits of some packets' rays.
    #[inline(always)]
    fn refresh<Q: Query>(&mut self, queries: &[Q], packets: u32) {
        for p in 0..self.packets.len() {
            if packets >> p & 1 == 0 {
                continue;
            }
            for (lane, q) in queries[p * LANES..].iter().take(LANES).enumerate() {
                self.packets[p].far[lane] = self.far_of(q);
            }
            self.shafts.far[p] = range(&self.packets[p].far).1;
        }
        self.bundle.far = range(&self.shafts.far).1;
    }

    /// Depth of a ray's limit in this frame.
    #[inline(always)]
    fn far_of<Q: Query>(&self, q: &Q) -> f32 {
        let limit = q.limit();
        if limit < 0.0 {
            return f32::NEG_INFINITY;
        }
        let at = q.ray().origin + q.ray().direction * limit;
        let at = self.from_world.map_or(at, |m| m.transform_point3(at));
        far(at[self.axes[2]] * f64::from(self.sign) - f64::from(self.reference), self.error_m, self.depth)
    }

    /// The next leaf that packets' shafts meet, nearer ones first, and a bit for each of these packets.
    #[inline(always)]
    fn next<L: Lanes>(&self, _: L, nodes: &[Node8], stack: &mut Vec<Entry>) -> Option<(Child, u32)> {
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
                packets = self.shafts.meet::<L>(
                    [near, far],
                    [[low[x][lane], high[x][lane]], [low[y][lane], high[y][lane]]],
                );
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
    fn depths<const N: usize, X: Wide<N>>(&self, low: X, high: X) -> (X, X) {
        let (sign, reference) = (X::splat(self.sign), X::splat(self.reference));
        let (a, b) = (low.mul(sign).sub(reference), high.mul(sign).sub(reference));
        if self.sign > 0.0 { (a, b) } else { (b, a) }
    }

    /// Offers a block's triangles to the rays that may meet them; gives the packets of which a ray took one.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn meet<L: Lanes, Q: Query>(
        &mut self,
        _: L,
        trees: &Trees,
        place: u32,
        block: &Block,
        count: u32,
        sheared: &[ShearedRay],
        queries: &mut [Q],
    ) -> u32 {
        let [x, y, z] = self.axes;
        let instance = trees.placements[place as usize].instance;
        let (low_z, high_z) = extent::<L>(block, z);
        let (near, far) = self.depths::<8, L::X8>(low_z, high_z);
        let ranges = [extent::<L>(block, x), extent::<L>(block, y)];
        let s = &self.bundle;
        let mut left = near.le(L::X8::splat(s.far)) & L::X8::splat(s.start).le(far) & ((1 << count) - 1);
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
            let triangle = block.index[lane];
            let mut world = None;
            while packets != 0 {
                let p = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let mut rays = self.sieve::<L>(p, &corners, near[lane], far[lane]);
                while rays != 0 {
                    let ray = rays.trailing_zeros() as usize;
                    rays &= rays - 1;
                    let index = p * LANES + ray;
                    let query = &mut queries[index];
                    if query.starts_on(instance, triangle) {
                        continue;
                    }
                    let before = query.limit();
                    let world = world.get_or_insert_with(|| trees.world_corners(place, &corners));
                    query.decide(&sheared[index], instance, triangle, world);
                    if query.limit() != before {
                        self.packets[p].far[ray] = self.far_of(&queries[index]);
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
    fn sieve<L: Lanes>(&self, p: usize, corners: &[[f32; 3]; 3], near: f32, far: f32) -> u32 {
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

impl Packet {
    const NONE: Self = Self {
        place: [[0.0; LANES]; 2],
        slope: [[0.0; LANES]; 2],
        start: [0.0; LANES],
        far: [f32::NEG_INFINITY; LANES],
    };
}

impl Shafts {
    const NONE: Self = Self {
        low: [[0.0; LANES]; 2],
        low_slope: [[0.0; LANES]; 2],
        high: [[0.0; LANES]; 2],
        high_slope: [[0.0; LANES]; 2],
        start: [f32::INFINITY; LANES],
        far: [f32::NEG_INFINITY; LANES],
    };

    /// The wider side of one shaft halfway to a depth.
    #[inline(always)]
    fn side(&self, p: usize, depth: f32) -> f32 {
        let one = |of: &[[f32; LANES]; 2]| [of[0][p], of[1][p]];
        Shaft {
            low: one(&self.low),
            low_slope: one(&self.low_slope),
            high: one(&self.high),
            high_slope: one(&self.high_slope),
            ..Shaft::NONE
        }
        .side(depth)
    }

    /// A bit for each shaft that meets a box, given as two depths and ranges along both cross axes.
    #[inline(always)]
    fn meet<L: Lanes>(&self, depths: [L::X16; 2], ranges: [[f32; 2]; 2]) -> u32 {
        let mut met = depths[0].le(L::X16::load(&self.far)) & L::X16::load(&self.start).le(depths[1]);
        for k in 0..2 {
            let lines = [
                L::X16::load(&self.low[k]),
                L::X16::load(&self.low_slope[k]),
                L::X16::load(&self.high[k]),
                L::X16::load(&self.high_slope[k]),
            ];
            met &= overlap(lines, depths, [L::X16::splat(ranges[k][0]), L::X16::splat(ranges[k][1])]);
        }
        met
    }

    /// Sets one packet's lines along one cross axis from where its rays stand at depth 0 and at the end.
    #[inline(always)]
    fn line(&mut self, p: usize, k: usize, [low, high, low_end, high_end]: [f32; 4], error_m: f32, depth: f32) {
        self.low[k][p] = low - error_m;
        self.low_slope[k][p] = (low_end - low) / depth;
        self.high[k][p] = high + error_m;
        self.high_slope[k][p] = (high_end - high) / depth;
    }
}

impl Shaft {
    const NONE: Self =
        Self { low: [0.0; 2], low_slope: [0.0; 2], high: [0.0; 2], high_slope: [0.0; 2], start: 0.0, far: 0.0 };

    /// Its wider side halfway to a depth.
    #[inline(always)]
    fn side(&self, depth: f32) -> f32 {
        let side = |k: usize| self.high[k] - self.low[k] + (self.high_slope[k] - self.low_slope[k]) * (0.5 * depth);
        side(0).max(side(1))
    }
}

/// Two cross axes and the axis that a direction goes along most.
#[inline(always)]
fn axes(direction: DVec3) -> [usize; 3] {
    let a = direction.abs();
    let z = if a.z >= a.x && a.z >= a.y { 2 } else { usize::from(a.y >= a.x) };
    [(z + 1) % 3, (z + 2) % 3, z]
}

/// Signed depths of bounds along an axis: the nearer and the farther.
#[inline(always)]
fn depths(bounds: Bounds, axis: usize, sign: f64) -> [f64; 2] {
    let (a, b) = (bounds.low[axis] * sign, bounds.high[axis] * sign);
    [a.min(b), a.max(b)]
}

/// A limit's depth, on the safe side.
#[inline(always)]
fn far(depth: f64, error_m: f32, most: f32) -> f32 {
    (depth as f32 + error_m).min(most + error_m)
}

/// Smallest and largest number.
#[inline(always)]
fn range(x: &[f32; LANES]) -> (f32, f32) {
    let (mut low, mut high) = (x[0], x[0]);
    for v in &x[1..] {
        low = if *v < low { *v } else { low };
        high = if *v > high { *v } else { high };
    }
    (low, high)
}

/// A bit for each lane where the space between two lines over depth, given as place and slope, meets a range somewhere
/// between two depths.
#[inline(always)]
fn overlap<const N: usize, X: Wide<N>>(lines: [X; 4], depths: [X; 2], [low, high]: [X; 2]) -> u32 {
    let [l, ls, h, hs] = lines;
    let lowest = l.add(ls.mul(depths[0])).min(l.add(ls.mul(depths[1])));
    let highest = h.add(hs.mul(depths[0])).max(h.add(hs.mul(depths[1])));
    lowest.le(high) & low.le(highest)
}

// What follows are functions and not closures: only functions are sure to be compiled into their callers, and code that
// is not has no vector instructions.

#[inline(always)]
fn splat4<const N: usize, X: Wide<N>>(x: [f32; 4]) -> [X; 4] {
    [X::splat(x[0]), X::splat(x[1]), X::splat(x[2]), X::splat(x[3])]
}

/// `cross[0] row[0] + cross[1] row[1] + row[constant]`.
#[inline(always)]
fn plus<const N: usize, X: Wide<N>>(cross: [X; 2], row: [X; 4], constant: usize) -> X {
    cross[0].mul(row[0]).add(cross[1].mul(row[1])).add(row[constant])
}

/// Lower and upper borders of a block's triangles along an axis.
#[inline(always)]
fn extent<L: Lanes>(block: &Block, axis: usize) -> (L::X8, L::X8) {
    let a = L::X8::load(&block.corners[0][axis]);
    let b = L::X8::load(&block.corners[1][axis]);
    let c = L::X8::load(&block.corners[2][axis]);
    (a.min(b).min(c), a.max(b).max(c))
}
