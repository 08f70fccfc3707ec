//! The rays of a bundle as a tree sees them.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::shaft::{Packet, Shaft, Shafts, range, splat4};
use super::{GRAIN_M, LANES, STEEPEST, Split, WIDEST_BUNDLE, WIDEST_PACKET};
use crate::bvh8::Bvh8;
use crate::query::Query;
use crate::simd::{Lanes, Wide};
use crate::slab::Bounds;
use crate::tree::Placement;
use crate::triangle::main_axis;
use glam::DVec3;

/// A bundle in the frame of a tree.
pub(super) struct Frame {
    /// Two cross axes and the axis of depth.
    pub(super) axes: [usize; 3],
    /// Depth is `sign * z - reference`.
    pub(super) sign: f32,
    pub(super) reference: f32,
    /// Depth up to which the shafts' lines hold, m.
    pub(super) depth: f32,
    /// What f32 may displace a ray by, m.
    pub(super) error_m: f32,
    pub(super) packets: Vec<Packet>,
    pub(super) shafts: Shafts,
    pub(super) bundle: Shaft,
    /// From the world to this frame: the world's rays are followed up to their limits.
    pub(super) from_world: Option<glam::DAffine3>,
}

impl Frame {
    /// The rays in the world's frame, if they share a way.
    #[inline(always)]
    pub(super) fn world<L: Lanes, Q: Query>(lanes: L, tree: &Bvh8, queries: &[Q]) -> Result<Self, Split> {
        let mean = queries.iter().fold(DVec3::ZERO, |sum, q| sum + q.direction());
        let axes = axes(mean);
        let [x, y, z] = axes;
        let sign = if mean[z] < 0.0 { -1.0 } else { 1.0 };
        let [first, last] = depths(tree.bounds, z, sign);
        let (mut start, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
        for q in queries {
            let (o, d) = (q.origin(), q.direction());
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
                    let (o, d) = (q.origin(), q.direction());
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
    pub(super) fn seen_from<L: Lanes>(
        &self,
        lanes: L,
        placement: &Placement,
        tree: &Bvh8,
        chosen: u32,
    ) -> Option<Self> {
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
    pub(super) fn outline<L: Lanes>(&mut self, _: L, chosen: u32) {
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
    pub(super) fn refresh<Q: Query>(&mut self, queries: &[Q], packets: u32) {
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
    pub(super) fn far_of<Q: Query>(&self, q: &Q) -> f32 {
        let limit = q.limit();
        if limit < 0.0 {
            return f32::NEG_INFINITY;
        }
        let at = q.origin() + q.direction() * limit;
        let at = self.from_world.map_or(at, |m| m.transform_point3(at));
        far(at[self.axes[2]] * f64::from(self.sign) - f64::from(self.reference), self.error_m, self.depth)
    }
}

/// Two cross axes and the axis that a direction goes along most.
#[inline(always)]
pub(super) fn axes(direction: DVec3) -> [usize; 3] {
    let z = main_axis(direction);
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
/// `cross[0] row[0] + cross[1] row[1] + row[constant]`.
#[inline(always)]
fn plus<const N: usize, X: Wide<N>>(cross: [X; 2], row: [X; 4], constant: usize) -> X {
    cross[0].mul(row[0]).add(cross[1].mul(row[1])).add(row[constant])
}
