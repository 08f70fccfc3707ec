//! Triangles against the rays of a bundle.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::LANES;
use super::frame::Frame;
use super::shaft::{overlap, splat4};
use crate::block::{Leaf, Rows, slot};
use crate::bvh8::Child;
use crate::query::{Candidate, Query};
use crate::simd::{Lanes, Wide};
use crate::single::may_cross;
use crate::tree::Trees;
use crate::triangle::ShearedPacket;

impl Frame {
    /// Offers a block's triangles to the rays that may meet them; tells whether any took one.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn meet<L: Lanes, Q: Query>(
        &mut self,
        lanes: L,
        trees: &Trees,
        place: u32,
        block: &Leaf<'_>,
        rows: Option<&Rows>,
        leaf: Child,
        sheared: &[ShearedPacket],
        queries: &mut [Q],
    ) -> bool {
        let outline = &self.outline;
        let mut corners = block.along::<L::X8>(outline.axes, rows);
        for corner in &mut corners {
            corner[2] = corner[2].mul(L::X8::splat(outline.sign)).sub(L::X8::splat(outline.reference));
        }
        let [a, b, c] = corners;
        let low = [a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1]), a[2].min(b[2]).min(c[2])];
        let high = [a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1]), a[2].max(b[2]).max(c[2])];
        let s = &outline.bundle;
        let mut left = low[2].le(L::X8::splat(s.far)) & L::X8::splat(s.start).le(high[2]) & ((1 << leaf.count) - 1);
        for k in 0..2 {
            let lines = splat4([s.low[k], s.low_slope[k], s.high[k], s.high_slope[k]]);
            left &= overlap(lines, [low[2], high[2]], [low[k], high[k]]);
        }
        if left == 0 {
            return false;
        }
        let instance = trees.placements[place as usize].instance;
        let (low, high) = (store3(low), store3(high));
        let corners = [store3(a), store3(b), store3(c)];
        let mut touched = 0_u32;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let mut packets = self.outline.shafts.meet::<L>(
                [L::X16::splat(low[2][lane]), L::X16::splat(high[2][lane])],
                [[low[0][lane], high[0][lane]], [low[1][lane], high[1][lane]]],
            );
            if packets == 0 {
                continue;
            }
            let triangle = block.block.index[lane];
            let mut world = None;
            while packets != 0 {
                let p = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let mut rays = self.sieve::<L>(p, &corners, lane, low[2][lane], high[2][lane]);
                if rays == 0 {
                    continue;
                }
                let world = world.get_or_insert_with(|| trees.world_corners(place, &block.triangle(lane)));
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
        if touched != 0 {
            self.refresh(lanes, touched);
        }
        touched != 0
    }

    /// A bit for each ray of a packet that may meet the triangle of a lane, of these depths.
    #[inline(always)]
    fn sieve<L: Lanes>(&self, p: usize, corners: &[[[f32; 8]; 3]; 3], lane: usize, near: f32, far: f32) -> u32 {
        let packet = &self.packets[p];
        let open =
            L::X16::splat(near).le(L::X16::load(&packet.far)) & L::X16::load(&packet.start).le(L::X16::splat(far));
        if open == 0 {
            return 0;
        }
        let zero = L::X16::splat(0.0);
        let mut sides = [[zero; 3]; 2];
        for i in 0..3 {
            let depth = L::X16::splat(corners[i][2][lane]);
            for k in 0..2 {
                let (place, slope) = (L::X16::load(&packet.place[k]), L::X16::load(&packet.slope[k]));
                sides[k][i] = L::X16::splat(corners[i][k][lane]).sub(place).sub(slope.mul(depth));
            }
        }
        may_cross(sides[0], sides[1], self.error_m) & open
    }
}

#[inline(always)]
fn store3<X: Wide<8>>(of: [X; 3]) -> [[f32; 8]; 3] {
    [of[0].store(), of[1].store(), of[2].store()]
}
