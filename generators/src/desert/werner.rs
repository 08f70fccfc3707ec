//! The slab model of wind-blown sand (Werner 1995, "Eolian dunes: computer simulations and attractor interpretation").
//!
//! Sand lies in slabs on a periodic grid. A slab that the wind reaches is lifted, hops downwind and comes to rest, always
//! in the lee of a dune, more often on sand than on bare ground; what stands too steeply slides. Which dunes grow from
//! that depends on how much sand there is and on the winds alone.

use crate::kit::terrain::noise::fractal;
use glam::DVec2;
use satseed_scene::SeedPath;

/// A neighbour in the same row or column may lie so many slabs lower, m of sand: with [`SLAB`] the angle of repose.
const REPOSE: i32 = 4;
/// The same of a diagonal neighbour.
const REPOSE_DIAGONAL: i32 = 6;
/// Thickness of a slab in cells: 33 degrees are [`REPOSE`] slabs.
pub(super) const SLAB: f64 = 0.6494 / REPOSE as f64;
/// Fall of the line below which the wind does not reach, slabs per cell: 15 degrees.
const SHADOW_FALL: f32 = (0.2679 / SLAB) as f32;
/// Rows that are asked together.
const STRIP: usize = 24;
/// In 32nds: how often a hopping slab rests on sand, and on bare ground.
const REST_ON_SAND: u32 = 19;
const REST_ON_GROUND: u32 = 13;

/// What the wind does, and with how much sand.
#[derive(Clone, Debug)]
pub(super) struct Regime {
    /// A hop of each wind, cells: along the first axis, or more along the second one than along the first.
    pub(super) hops: Vec<[i32; 2]>,
    /// Sweeps before the wind turns to the next.
    pub(super) sweeps_a_wind: usize,
    /// Sweeps in all; in one, every cell is asked once in the mean.
    pub(super) sweeps: usize,
    /// Mean thickness of the sand, slabs.
    pub(super) mean: f64,
    /// Size of the patches that it lies in at first, cells across the mean wind, and how much longer they are along it.
    pub(super) patch: [f64; 2],
}

impl Regime {
    /// The wind that blew last.
    pub(super) fn last_hop(&self) -> [i32; 2] {
        self.hops[(self.sweeps - 1) / self.sweeps_a_wind % self.hops.len()]
    }
}

/// Slabs on a periodic square of `n` by `n` cells after the winds of a regime.
pub(super) fn blow(n: usize, regime: &Regime, path: &SeedPath) -> Vec<u16> {
    let mut field = Field { n, slabs: spread(n, regime, path), lee: vec![false; n * n], line: vec![0.0; n * n] };
    let mut rng = path.child("wind").rng();
    for sweep in 0..regime.sweeps {
        let hop = regime.hops[sweep / regime.sweeps_a_wind % regime.hops.len()];
        // The lee moves by a small part of a cell in one sweep: it is found once for all of it.
        field.find_lee(hop);
        for poll in 0..n * n {
            let word = rng.next_u64();
            // Strip after strip, so that what is asked lies near in memory; within one, in no order.
            let first = poll / (n * STRIP) * STRIP * n;
            let cells = (n * STRIP).min(n * n - first);
            let from = first + (((word >> 32) * cells as u64) >> 32) as usize;
            if field.slabs[from] == 0 || field.lee[from] {
                continue;
            }
            field.lift(from, poll);
            let mut bits = word as u32;
            let mut to = from;
            for k in 0.. {
                to = field.downwind(to, hop);
                if k % 6 == 5 {
                    bits = rng.next_u64() as u32;
                }
                let rest = if field.slabs[to] > 0 { REST_ON_SAND } else { REST_ON_GROUND };
                if field.lee[to] || bits & 31 < rest {
                    break;
                }
                bits >>= 5;
            }
            field.drop(to, poll);
        }
    }
    field.slabs
}

/// The sand before any wind: uneven over the scale of a few dunes, so that no two parts of a field look the same.
fn spread(n: usize, regime: &Regime, path: &SeedPath) -> Vec<u16> {
    let mut rng = path.child("sand").rng();
    let seed = path.child("patches").hash_u32();
    (0..n * n)
        .map(|p| {
            // The noise does not repeat where the grid does: blended into its own other end.
            let at = |i: usize, j: usize| {
                fractal(DVec2::new(i as f64 / regime.patch[1], j as f64), seed, regime.patch[0], 3, 0.5)
            };
            let (i, j) = (p % n, p / n);
            let w = (i as f64 / n as f64, j as f64 / n as f64);
            let x = |j: usize| at(i + n, j) * (1.0 - w.0) + at(i, j) * w.0;
            let uneven = x(j + n) * (1.0 - w.1) + x(j) * w.1;
            let thick = regime.mean * (1.0 + 1.5 * uneven).max(0.0);
            (thick + rng.unit()) as u16
        })
        .collect()
}

struct Field {
    n: usize,
    slabs: Vec<u16>,
    /// Whether the wind does not reach a cell.
    lee: Vec<bool>,
    /// Height of the line below which it does not, slabs.
    line: Vec<f32>,
}

impl Field {
    #[inline]
    fn downwind(&self, p: usize, hop: [i32; 2]) -> usize {
        let n = self.n as i32;
        let wrap = |x: i32| {
            if x >= n {
                x - n
            } else if x < 0 {
                x + n
            } else {
                x
            }
        };
        let (i, j) = ((p as u32 % n as u32) as i32, (p as u32 / n as u32) as i32);
        (wrap(j + hop[1]) * n + wrap(i + hop[0])) as usize
    }

    fn find_lee(&mut self, hop: [i32; 2]) {
        for (line, slabs) in self.line.iter_mut().zip(&self.slabs) {
            *line = f32::from(*slabs);
        }
        shadow_lines(&mut self.line, self.n, hop, SHADOW_FALL);
        for p in 0..self.lee.len() {
            self.lee[p] = self.line[p] > f32::from(self.slabs[p]);
        }
    }

    /// The eight neighbours, the four straight ones first.
    #[inline]
    fn around(&self, p: usize) -> [usize; 8] {
        let n = self.n;
        let (i, j) = (p as u32 % n as u32, p as u32 / n as u32);
        let (last, whole) = (n as u32 - 1, n * n);
        let east = if i == last { p + 1 - n } else { p + 1 };
        let west = if i == 0 { p + n - 1 } else { p - 1 };
        let north = |q: usize| if j == last { q + n - whole } else { q + n };
        let south = |q: usize| if j == 0 { q + whole - n } else { q - n };
        [east, north(p), west, south(p), north(east), north(west), south(west), south(east)]
    }

    /// The neighbour towards which (`sign` 1) or from which (-1) sand slides, if any; `turn` breaks ties.
    #[inline]
    fn unstable(&self, p: usize, sign: i32, turn: usize) -> Option<usize> {
        let own = i32::from(self.slabs[p]);
        let around = self.around(p);
        let mut best = (0, None);
        for k in 0..8 {
            // Straight and diagonal ones each begin somewhere else every time.
            let k = (k & 4) | ((k + turn) & 3);
            let q = around[k];
            let excess = (own - i32::from(self.slabs[q])) * sign - if k < 4 { REPOSE } else { REPOSE_DIAGONAL };
            if excess > best.0 {
                best = (excess, Some(q));
            }
        }
        best.1
    }

    /// Takes a slab, and lets slide down what stood on it.
    fn lift(&mut self, mut p: usize, turn: usize) {
        self.slabs[p] -= 1;
        while let Some(q) = self.unstable(p, -1, turn) {
            self.slabs[p] += 1;
            self.slabs[q] -= 1;
            p = q;
        }
    }

    /// Adds a slab, which slides to where it can rest.
    fn drop(&mut self, mut p: usize, turn: usize) {
        self.slabs[p] += 1;
        while let Some(q) = self.unstable(p, 1, turn) {
            self.slabs[p] -= 1;
            self.slabs[q] += 1;
            p = q;
        }
    }
}

/// Raises every height to the highest line that falls downwind from one before it, `fall` per cell, on a periodic grid.
pub(super) fn shadow_lines(line: &mut [f32], n: usize, hop: [i32; 2], fall: f32) {
    // Far enough round for what the border cut off.
    let again = n.min(200);
    if hop[1] == 0 {
        for row in line.chunks_exact_mut(n) {
            let mut upwind = f32::MIN;
            for k in 0..n + again {
                let i = if hop[0] > 0 { k % n } else { n - 1 - k % n };
                upwind = row[i].max(upwind - fall);
                row[i] = upwind;
            }
        }
        return;
    }
    // Rows from upwind down; the place upwind lies between two cells of the row before.
    let shift = f64::from(hop[0]) / f64::from(hop[1].abs());
    let fall = fall * f64::sqrt(1.0 + shift * shift) as f32;
    let whole = libm::floor(shift) as i64;
    let part = (shift - whole as f64) as f32;
    let mut upwind = vec![f32::MIN; n];
    for k in 0..n + again {
        let j = if hop[1] > 0 { k % n } else { n - 1 - k % n };
        let row = &mut line[j * n..][..n];
        if k > 0 {
            for i in 0..n {
                let from = |d: i64| upwind[(i as i64 - whole - d).rem_euclid(n as i64) as usize];
                row[i] = row[i].max(from(0) * (1.0 - part) + from(1) * part - fall);
            }
        }
        upwind.copy_from_slice(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regime(mean: f64) -> Regime {
        Regime { hops: vec![[5, 0]], sweeps_a_wind: 1, sweeps: 120, mean, patch: [170.0, 1.0] }
    }

    #[test]
    fn sand_is_kept_and_rests() {
        let path = SeedPath::root("slabs", 3);
        let n = 96;
        let before: u64 = spread(n, &regime(6.0), &path).iter().map(|s| u64::from(*s)).sum();
        let slabs = blow(n, &regime(6.0), &path);
        assert_eq!(slabs.iter().map(|s| u64::from(*s)).sum::<u64>(), before);
        for p in 0..n * n {
            let (i, j) = (p % n, p / n);
            for q in [j * n + (i + 1) % n, (j + 1) % n * n + i] {
                let step = i32::from(slabs[p]) - i32::from(slabs[q]);
                assert!(step.abs() <= REPOSE, "{step} slabs at {i}, {j}");
            }
        }
    }

    #[test]
    fn dunes_grow_out_of_a_sheet() {
        let path = SeedPath::root("slabs", 4);
        let n = 128;
        let slabs = blow(n, &regime(8.0), &path);
        assert!(*slabs.iter().max().unwrap() > 20, "no dune higher than {} slabs", slabs.iter().max().unwrap());
    }

    #[test]
    fn shadows_fall_downwind_in_every_direction() {
        let n = 40;
        for hop in [[5, 0], [3, 4], [3, -4], [0, 5]] {
            let mut line = vec![0.0; n * n];
            for (p, height) in line.iter_mut().enumerate() {
                if (17..24).contains(&(p % n)) && (17..24).contains(&(p / n)) {
                    *height = 10.0;
                }
            }
            shadow_lines(&mut line, n, hop, 1.0);
            let at = |k: i32| line[((20 + hop[1] * k) as usize % n) * n + (20 + hop[0] * k) as usize % n];
            assert!(at(2) > 1.5 && at(2) < 5.0, "{hop:?}: {}", at(2));
            assert_eq!(at(-1), 0.0, "{hop:?}");
        }
    }
}
