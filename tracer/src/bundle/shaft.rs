//! Outlines of rays over depth.
#![allow(clippy::needless_range_loop)] // Lanes and axes are numbers here, across several arrays at once.

use super::LANES;
use crate::simd::{Lanes, Wide};

/// Sixteen rays over depth.
#[derive(Clone, Copy)]
pub(super) struct Packet {
    /// Place at depth 0 and slope, for both cross axes, m.
    pub(super) place: [[f32; LANES]; 2],
    pub(super) slope: [[f32; LANES]; 2],
    /// Depth at which a ray starts, and beyond which it wants nothing; minus infinity once it is done.
    pub(super) start: [f32; LANES],
    pub(super) far: [f32; LANES],
}

/// Outlines of sixteen shafts over depth: lower and upper line along both cross axes.
#[derive(Clone, Copy)]
pub(super) struct Shafts {
    pub(super) low: [[f32; LANES]; 2],
    pub(super) low_slope: [[f32; LANES]; 2],
    pub(super) high: [[f32; LANES]; 2],
    pub(super) high_slope: [[f32; LANES]; 2],
    pub(super) start: [f32; LANES],
    pub(super) far: [f32; LANES],
}

/// One shaft.
#[derive(Clone, Copy)]
pub(super) struct Shaft {
    pub(super) low: [f32; 2],
    pub(super) low_slope: [f32; 2],
    pub(super) high: [f32; 2],
    pub(super) high_slope: [f32; 2],
    pub(super) start: f32,
    pub(super) far: f32,
}
impl Packet {
    pub(super) const NONE: Self = Self {
        place: [[0.0; LANES]; 2],
        slope: [[0.0; LANES]; 2],
        start: [0.0; LANES],
        far: [f32::NEG_INFINITY; LANES],
    };

    /// Puts one of the open rays into the lanes of all others, which are done, so that they widen no shaft.
    #[inline(always)]
    pub(super) fn keep(&mut self, open: u32) {
        let one = open.trailing_zeros() as usize % LANES;
        for lane in (0..LANES).filter(|lane| open >> lane & 1 == 0) {
            for k in 0..2 {
                self.place[k][lane] = self.place[k][one];
                self.slope[k][lane] = self.slope[k][one];
            }
            self.start[lane] = self.start[one];
        }
    }
}

impl Shafts {
    pub(super) const NONE: Self = Self {
        low: [[0.0; LANES]; 2],
        low_slope: [[0.0; LANES]; 2],
        high: [[0.0; LANES]; 2],
        high_slope: [[0.0; LANES]; 2],
        start: [f32::INFINITY; LANES],
        far: [f32::NEG_INFINITY; LANES],
    };

    /// The wider side of one shaft halfway to a depth.
    #[inline(always)]
    pub(super) fn side(&self, p: usize, depth: f32) -> f32 {
        self.one(p).side(depth)
    }

    /// A bit for each shaft that meets a box, given as two depths and ranges along both cross axes.
    #[inline(always)]
    pub(super) fn meet<L: Lanes>(&self, depths: [L::X16; 2], ranges: [[f32; 2]; 2]) -> u32 {
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

    /// For each of eight boxes the chosen packets whose shafts meet it, given as lower and upper borders along both cross axes
    /// and depth; none if no box is met. `bundle` is the shaft around all.
    #[inline(always)]
    pub(super) fn meet_each<L: Lanes>(
        &self,
        mut packets: u32,
        boxes: u32,
        bundle: &Shaft,
        low: [L::X8; 3],
        high: [L::X8; 3],
    ) -> Option<[u32; 8]> {
        // As many packets against eight boxes at a time as boxes against sixteen packets, or fewer.
        const FEW: u32 = 6;
        let mut packets_of = [0; 8];
        let mut any = 0;
        if packets.count_ones() <= FEW {
            while packets != 0 {
                let p = packets.trailing_zeros() as usize;
                packets &= packets - 1;
                let mut met = boxes & self.one(p).meet::<L>(low, high);
                any |= met;
                while met != 0 {
                    let lane = met.trailing_zeros() as usize;
                    met &= met - 1;
                    packets_of[lane] |= 1 << p;
                }
            }
            return (any != 0).then_some(packets_of);
        }
        let mut left = boxes & bundle.meet::<L>(low, high);
        if left == 0 {
            return None;
        }
        let [x, y, z] = [low[0].store(), low[1].store(), low[2].store()];
        let [x_high, y_high, z_high] = [high[0].store(), high[1].store(), high[2].store()];
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let depths = [L::X16::splat(z[lane]), L::X16::splat(z_high[lane])];
            packets_of[lane] = packets & self.meet::<L>(depths, [[x[lane], x_high[lane]], [y[lane], y_high[lane]]]);
            any |= packets_of[lane];
        }
        (any != 0).then_some(packets_of)
    }

    /// One of the shafts.
    #[inline(always)]
    fn one(&self, p: usize) -> Shaft {
        Shaft {
            low: [self.low[0][p], self.low[1][p]],
            low_slope: [self.low_slope[0][p], self.low_slope[1][p]],
            high: [self.high[0][p], self.high[1][p]],
            high_slope: [self.high_slope[0][p], self.high_slope[1][p]],
            start: self.start[p],
            far: self.far[p],
        }
    }

    /// Sets one packet's lines along one cross axis from where its rays stand at depth 0 and at the end.
    #[inline(always)]
    pub(super) fn line(
        &mut self,
        p: usize,
        k: usize,
        [low, high, low_end, high_end]: [f32; 4],
        error_m: f32,
        depth: f32,
    ) {
        self.low[k][p] = low - error_m;
        self.low_slope[k][p] = (low_end - low) / depth;
        self.high[k][p] = high + error_m;
        self.high_slope[k][p] = (high_end - high) / depth;
    }
}

impl Shaft {
    pub(super) const NONE: Self =
        Self { low: [0.0; 2], low_slope: [0.0; 2], high: [0.0; 2], high_slope: [0.0; 2], start: 0.0, far: 0.0 };

    /// A bit for each of eight boxes that it meets, given as lower and upper borders along both cross axes and depth.
    #[inline(always)]
    pub(super) fn meet<L: Lanes>(&self, low: [L::X8; 3], high: [L::X8; 3]) -> u32 {
        let mut met = low[2].le(L::X8::splat(self.far)) & L::X8::splat(self.start).le(high[2]);
        for k in 0..2 {
            let lines = splat4([self.low[k], self.low_slope[k], self.high[k], self.high_slope[k]]);
            met &= overlap(lines, [low[2], high[2]], [low[k], high[k]]);
        }
        met
    }

    /// Its wider side halfway to a depth.
    #[inline(always)]
    pub(super) fn side(&self, depth: f32) -> f32 {
        let side = |k: usize| self.high[k] - self.low[k] + (self.high_slope[k] - self.low_slope[k]) * (0.5 * depth);
        side(0).max(side(1))
    }
}
/// Smallest and largest number.
#[inline(always)]
pub(super) fn range(x: &[f32; LANES]) -> (f32, f32) {
    // Halves against each other, which goes side by side in registers; one after the other waits for itself.
    let (mut low, mut high) = (*x, *x);
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            low[i] = if low[i + half] < low[i] { low[i + half] } else { low[i] };
            high[i] = if high[i + half] > high[i] { high[i + half] } else { high[i] };
        }
        half /= 2;
    }
    (low[0], high[0])
}

/// A bit for each lane where the space between two lines over depth, given as place and slope, meets a range somewhere
/// between two depths.
#[inline(always)]
pub(super) fn overlap<const N: usize, X: Wide<N>>(lines: [X; 4], depths: [X; 2], [low, high]: [X; 2]) -> u32 {
    let [l, ls, h, hs] = lines;
    let lowest = l.add(ls.mul(depths[0])).min(l.add(ls.mul(depths[1])));
    let highest = h.add(hs.mul(depths[0])).max(h.add(hs.mul(depths[1])));
    lowest.le(high) & low.le(highest)
}
// What follows are functions and not closures: only functions are sure to be compiled into their callers, and code that
// is not has no vector instructions.

#[inline(always)]
pub(super) fn splat4<const N: usize, X: Wide<N>>(x: [f32; 4]) -> [X; 4] {
    [X::splat(x[0]), X::splat(x[1]), X::splat(x[2]), X::splat(x[3])]
}
