//! Triangles against the rays of a bundle.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::LANES;
use super::frame::Frame;
use crate::block::{Leaf, Rows, slot};
use crate::bvh8::Child;
use crate::query::{Candidate, Query};
use crate::simd::{Lanes, Wide};
use crate::single::may_cross;
use crate::tree::Trees;
use crate::triangle::{Crossing, ShearedPacket};
use glam::DVec3;

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
        packets: u32,
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
        let packets_of = self.outline.shafts.meet_each::<L>(packets, (1 << leaf.count) - 1, &outline.bundle, low, high);
        let Some(packets_of) = packets_of else { return false };
        let instance = trees.placements[place as usize].instance;
        let (near, far) = (low[2].store(), high[2].store());
        let corners = [store3(a), store3(b), store3(c)];
        let mut touched = 0_u32;
        for lane in 0..leaf.count as usize {
            let mut packets = packets_of[lane];
            if packets == 0 {
                continue;
            }
            let triangle = block.block.index[lane];
            let with = Candidate { instance, triangle, place, slot: slot(leaf.first, lane) };
            let mut world = None;
            while packets != 0 {
                let p = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let mut rays = self.sieve::<L>(p, &corners, lane, near[lane], far[lane]);
                if rays == 0 {
                    continue;
                }
                let world = world.get_or_insert_with(|| trees.world_corners(place, &block.triangle(lane)));
                if sheared[p].is_for_single(rays) {
                    while rays != 0 {
                        let ray = rays.trailing_zeros() as usize;
                        rays &= rays - 1;
                        if let Some(crossing) = sheared[p].ray(ray).cross(world) {
                            touched |= self.take(p, ray, &with, world, &crossing, queries);
                        }
                    }
                    continue;
                }
                let crossings = sheared[p].cross::<L::D16>(rays, world);
                rays = crossings.met;
                while rays != 0 {
                    let ray = rays.trailing_zeros() as usize;
                    rays &= rays - 1;
                    touched |= self.take(p, ray, &with, world, &crossings.of(ray), queries);
                }
            }
        }
        if touched != 0 {
            self.refresh(lanes, touched);
        }
        touched != 0
    }

    /// Offers a crossing to a ray of a packet; gives the packet's bit if it was taken.
    #[inline(always)]
    fn take<Q: Query>(
        &mut self,
        p: usize,
        ray: usize,
        with: &Candidate,
        corners: &[DVec3; 3],
        crossing: &Crossing,
        queries: &mut [Q],
    ) -> u32 {
        let query = &mut queries[p * LANES + ray];
        let before = query.limit();
        if query.starts_on(with.instance, with.triangle) {
            return 0;
        }
        query.take(with, corners, crossing);
        if query.limit() == before {
            return 0;
        }
        self.packets[p].far[ray] = self.far_of(&queries[p * LANES + ray]);
        1 << p
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
