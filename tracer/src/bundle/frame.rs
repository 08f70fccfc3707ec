//! The rays of a bundle.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::outline::Outline;
use super::shaft::{Packet, Shaft, Shafts, range};
use super::{GRAIN_M, LANES, STEEPEST, Split, WIDEST_BUNDLE, WIDEST_PACKET};
use crate::query::Query;
use crate::simd::{Doubles, Lanes, Wide};
use crate::slab::Bounds;
use crate::tree::Trees;
use crate::triangle::{main_axis, sizes};
use glam::DVec3;

/// Sixteen rays as they were asked, a lane each. Lanes beyond the last ray repeat it and want nothing.
pub(super) struct Rays {
    pub(super) origin: [[f64; LANES]; 3],
    pub(super) direction: [[f64; LANES]; 3],
    limit: [f64; LANES],
}

impl Rays {
    #[inline(always)]
    pub(super) fn new<Q: Query>(members: &[Q]) -> Self {
        let mut rays = Self { origin: [[0.0; LANES]; 3], direction: [[0.0; LANES]; 3], limit: [-1.0; LANES] };
        for lane in 0..LANES {
            let q = &members[lane.min(members.len() - 1)];
            let (o, d) = (q.origin(), q.direction());
            for k in 0..3 {
                rays.origin[k][lane] = o[k];
                rays.direction[k][lane] = d[k];
            }
            if lane < members.len() {
                rays.limit[lane] = q.limit();
            }
        }
        rays
    }
}

/// A bundle in the world's frame.
pub(super) struct Frame {
    pub(super) outline: Outline,
    /// Depth up to which the shafts' lines hold, m.
    depth: f32,
    /// What f32 may displace a ray by, and a triangle that it brings to the world, m.
    pub(super) error_m: f32,
    pub(super) packets: Vec<Packet>,
    /// How many rays each packet's shaft is drawn around.
    drawn: [u32; LANES],
}

impl Frame {
    /// Rays in the world's frame, if they share a way.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, trees: &Trees, rays: &[Rays]) -> Result<Self, Split> {
        let mut mean = DVec3::ZERO;
        for k in 0..3 {
            let mut sum = [0.0; LANES];
            for r in rays {
                for lane in 0..LANES {
                    sum[lane] += r.direction[k][lane];
                }
            }
            for lane in 0..LANES {
                mean[k] += sum[lane];
            }
        }
        let axes = axes(mean);
        let [x, y, z] = axes;
        let sign = if mean[z] < 0.0 { -1.0 } else { 1.0 };
        let [first, last] = depths(trees.instances.bounds, z, sign);
        let (mut start, mut end) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let mut fit = 0xffff;
        for r in rays {
            let most = L::D16::load(&r.direction[z]).mul(L::D16::splat(STEEPEST * sign));
            fit &= sizes::<L::D16>(&r.direction[x]).le(most) & sizes::<L::D16>(&r.direction[y]).le(most);
            for lane in 0..LANES {
                let from = r.origin[z][lane] * sign;
                let to = from + r.direction[z][lane] * sign * r.limit[lane];
                start[lane] = if from < start[lane] { from } else { start[lane] };
                end[lane] = if to > end[lane] { to } else { end[lane] };
            }
        }
        if fit != 0xffff {
            return Err(if rays.len() > 1 { Split::Packets } else { Split::Rays });
        }
        let start = start.into_iter().fold(f64::INFINITY, f64::min);
        let end = end.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // f32's own depth of the first plane: boxes are placed against the same number.
        let reference = (start.max(first) as f32).next_down();
        let depth = (end.min(last) - f64::from(reference)).max(1e-3) as f32;
        let error_m = (2.0 * trees.instances.slack + trees.displacement_m) as f32;
        let mut packets = vec![Packet::NONE; rays.len()];
        for (packet, r) in packets.iter_mut().zip(rays) {
            let (ox, oy, oz) = (&r.origin[x], &r.origin[y], &r.origin[z]);
            let (dx, dy, dz) = (&r.direction[x], &r.direction[y], &r.direction[z]);
            for lane in 0..LANES {
                let inverse = 1.0 / dz[lane];
                let (slope_x, slope_y) = (dx[lane] * inverse * sign, dy[lane] * inverse * sign);
                let behind = f64::from(reference) - oz[lane] * sign;
                packet.place[0][lane] = (ox[lane] + slope_x * behind) as f32;
                packet.place[1][lane] = (oy[lane] + slope_y * behind) as f32;
                packet.slope[0][lane] = slope_x as f32;
                packet.slope[1][lane] = slope_y as f32;
                packet.start[lane] = -behind as f32 - error_m;
                let far = far(-behind + r.limit[lane] * dz[lane] * sign, error_m, depth);
                packet.far[lane] = if r.limit[lane] < 0.0 { f32::NEG_INFINITY } else { far };
            }
        }
        let outline = Outline { axes, sign: sign as f32, reference, shafts: Shafts::NONE, bundle: Shaft::NONE };
        let mut frame = Self { outline, depth, error_m, packets, drawn: [LANES as u32; LANES] };
        frame.draw(lanes, !0);
        // A shaft that is much wider than its rays need meets much that none of them meets.
        let mut sides = [0.0; LANES];
        let sides = &mut sides[..rays.len()];
        for (p, side) in sides.iter_mut().enumerate() {
            *side = frame.outline.shafts.side(p, depth);
        }
        sides.sort_unstable_by(f32::total_cmp);
        let usual = sides[sides.len() / 2];
        if usual > WIDEST_PACKET * GRAIN_M {
            return Err(Split::Rays);
        }
        if rays.len() > 1 && frame.outline.bundle.side(depth) > WIDEST_BUNDLE * (usual + GRAIN_M) {
            return Err(Split::Packets);
        }
        Ok(frame)
    }

    /// Draws the shafts of chosen packets around their rays, and the bundle's around the packets that still want something.
    #[inline(always)]
    fn draw<L: Lanes>(&mut self, _: L, chosen: u32) {
        let depth = L::X16::splat(self.depth);
        let Outline { shafts, bundle, .. } = &mut self.outline;
        for (p, packet) in self.packets.iter().enumerate() {
            if chosen >> p & 1 == 0 {
                continue;
            }
            for k in 0..2 {
                let place = L::X16::load(&packet.place[k]);
                let end = place.add(L::X16::load(&packet.slope[k]).mul(depth));
                let (low, high) = range(&place.store());
                let (low_end, high_end) = range(&end.store());
                shafts.line(p, k, [low, high, low_end, high_end], self.error_m, self.depth);
            }
            shafts.start[p] = range(&packet.start).0;
            shafts.far[p] = range(&packet.far).1;
        }
        for k in 0..2 {
            let (s, n) = (&*shafts, self.packets.len());
            let end = |at: &[f32; LANES], slope: &[f32; LANES], p: usize| at[p] + slope[p] * self.depth;
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            let (mut low_end, mut high_end) = (f32::INFINITY, f32::NEG_INFINITY);
            for p in (0..n).filter(|p| s.far[*p] > f32::NEG_INFINITY) {
                low = low.min(s.low[k][p]);
                high = high.max(s.high[k][p]);
                low_end = low_end.min(end(&s.low[k], &s.low_slope[k], p));
                high_end = high_end.max(end(&s.high[k], &s.high_slope[k], p));
            }
            bundle.low[k] = low - self.error_m;
            bundle.high[k] = high + self.error_m;
            bundle.low_slope[k] = (low_end - low) / self.depth;
            bundle.high_slope[k] = (high_end - high) / self.depth;
        }
        bundle.start = range(&shafts.start).0;
        bundle.far = range(&shafts.far).1;
    }

    /// Takes over how far the rays of some packets still look. Where half of a packet's rays are done since its shaft was
    /// drawn, it is drawn anew around the others: in crowns few are left, and far apart.
    #[inline(always)]
    pub(super) fn refresh<L: Lanes>(&mut self, lanes: L, mut packets: u32) {
        let mut fewer = 0;
        while packets != 0 {
            let p = packets.trailing_zeros() as usize;
            packets &= packets - 1;
            let packet = &mut self.packets[p];
            self.outline.shafts.far[p] = range(&packet.far).1;
            let open = !L::X16::load(&packet.far).le(L::X16::splat(f32::NEG_INFINITY)) & 0xffff;
            if open != 0 && 2 * open.count_ones() <= self.drawn[p] {
                self.drawn[p] = open.count_ones();
                packet.keep(open);
                fewer |= 1 << p;
            }
        }
        if fewer == 0 {
            self.outline.bundle.far = range(&self.outline.shafts.far).1;
        } else {
            self.draw(lanes, fewer);
        }
    }

    /// Depth of a ray's limit.
    #[inline(always)]
    pub(super) fn far_of<Q: Query>(&self, q: &Q) -> f32 {
        let limit = q.limit();
        if limit < 0.0 {
            return f32::NEG_INFINITY;
        }
        let (z, sign) = (self.outline.axes[2], f64::from(self.outline.sign));
        let at = (q.origin()[z] + q.direction()[z] * limit) * sign;
        far(at - f64::from(self.outline.reference), self.error_m, self.depth)
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
