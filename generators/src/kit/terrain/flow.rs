//! Drainage: every post gets a way down, and the area that drains through it.

use satseed_scene::{Raster, hash_cell, unit_from_hash};

/// The eight neighbours, east first, counter-clockwise.
pub const NEIGHBOURS: [(i64, i64); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Least drop along a filled depression, m per post: what makes its water find the outlet.
const FILL_DROP_M: f32 = 1e-4;

/// Spread of the weights of slopes.
pub const WANDER: f32 = 0.4;

/// Who drains into whom.
#[derive(Clone, Debug)]
pub struct Drainage {
    /// The post into which each post drains; outlets drain into themselves.
    pub receiver: Vec<u32>,
    /// All posts that an outlet was found for, each after its receiver.
    pub order: Vec<u32>,
}

/// Bits of a float that order as the float does.
fn key(z: f32) -> u32 {
    let bits = z.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The neighbours of a post inside the grid, with the direction's number.
#[inline]
fn neighbours(width: usize, height: usize, post: usize) -> impl Iterator<Item = (usize, usize)> {
    let (i, j) = ((post % width) as i64, (post / width) as i64);
    NEIGHBOURS.iter().enumerate().filter_map(move |(k, (di, dj))| {
        let (ni, nj) = (i + di, j + dj);
        let inside = ni >= 0 && nj >= 0 && ni < width as i64 && nj < height as i64;
        inside.then(|| (k, nj as usize * width + ni as usize))
    })
}

/// Raises depressions until every post has a way down to an outlet, and returns all posts in the order in which the
/// flood reached them: each after some lower neighbour. Outlets keep their heights.
///
/// Priority flood (Barnes, Lehman, Mulla 2014) with a small drop along filled parts.
pub fn fill(z: &mut Raster<f32>, is_outlet: impl Fn(usize) -> bool) -> Vec<u32> {
    let (width, height) = (z.width, z.height);
    let n = width * height;
    let mut heap = RadixHeap::default();
    let mut seen = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for post in (0..n).filter(|p| is_outlet(*p)) {
        seen[post] = true;
        heap.push(key(z.data[post]), post as u32);
    }
    while let Some(post) = heap.pop() {
        let floor = z.data[post as usize] + FILL_DROP_M;
        order.push(post);
        for (_, next) in neighbours(width, height, post as usize) {
            if !seen[next] {
                seen[next] = true;
                if z.data[next] < floor {
                    z.data[next] = floor;
                }
                heap.push(key(z.data[next]), next as u32);
            }
        }
    }
    order
}

/// [`fill`], then the ways down: each post drains to its steepest lower neighbour (D8), each slope weighed by a hash of
/// place, direction and `wander` between 1 - [`WANDER`] and 1 + [`WANDER`] (after Rho8, Fairfield and Leymarie 1991):
/// plain D8 draws straight lines in eight directions. O(n).
pub fn fill_and_drain(z: &mut Raster<f32>, wander: u32, is_outlet: impl Fn(usize) -> bool) -> Drainage {
    let order = fill(z, &is_outlet);
    let mut receiver: Vec<u32> = (0..z.data.len() as u32).collect();
    for (post, to) in receiver.iter_mut().enumerate() {
        if is_outlet(post) {
            continue;
        }
        let mut steepest = 0.0;
        for (k, next) in neighbours(z.width, z.height, post) {
            let fall = z.data[post] - z.data[next];
            if fall <= 0.0 {
                continue;
            }
            let weight = 1.0 - WANDER + 2.0 * WANDER * unit_from_hash(hash_cell(post as i32, k as i32, 0, wander));
            let slope = fall * weight * if k % 2 == 0 { 1.0 } else { core::f32::consts::FRAC_1_SQRT_2 };
            if slope > steepest {
                steepest = slope;
                *to = next as u32;
            }
        }
    }
    Drainage { receiver, order }
}

/// A queue for keys that never fall below the last one taken (Ahuja, Mehlhorn, Orlin, Tarjan 1990): the bucket of a key
/// is the highest bit in which it differs from that one.
struct RadixHeap {
    last: u32,
    buckets: [Vec<(u32, u32)>; 33],
}

impl Default for RadixHeap {
    fn default() -> Self {
        Self { last: 0, buckets: core::array::from_fn(|_| Vec::new()) }
    }
}

impl RadixHeap {
    fn push(&mut self, key: u32, value: u32) {
        let bucket = (32 - (key ^ self.last).leading_zeros()) as usize;
        self.buckets[bucket].push((key, value));
    }

    fn pop(&mut self) -> Option<u32> {
        if self.buckets[0].is_empty() {
            let first = self.buckets.iter().position(|b| !b.is_empty())?;
            let moved = core::mem::take(&mut self.buckets[first]);
            self.last = moved.iter().map(|m| m.0).min()?;
            for (key, value) in moved {
                self.push(key, value);
            }
        }
        self.buckets[0].pop().map(|m| m.1)
    }
}

impl Drainage {
    /// The area that drains through each post, m2, its own cell included.
    pub fn area_m2(&self, cell_m: f64) -> Vec<f32> {
        let mut area = vec![(cell_m * cell_m) as f32; self.receiver.len()];
        for &post in self.order.iter().rev() {
            let to = self.receiver[post as usize];
            if to != post {
                area[to as usize] += area[post as usize];
            }
        }
        area
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::terrain::noise::fractal;
    use glam::DVec2;

    #[test]
    fn every_post_drains_and_areas_add_up() {
        let mut z = Raster::filled(DVec2::ZERO, 2.0, 60, 50, 0.0_f32);
        for j in 0..50 {
            for i in 0..60 {
                let p = z.position(i, j);
                z.set(i, j, (fractal(p, 3, 30.0, 4, 0.6) * 20.0) as f32);
            }
        }
        let border = |p: usize| [0, 59].contains(&(p % 60)) || [0, 49].contains(&(p / 60));
        let before = z.clone();
        let drainage = fill_and_drain(&mut z, 1, border);
        assert_eq!(drainage.order.len(), 3000);
        assert!(z.data.iter().zip(&before.data).all(|(a, b)| a >= b));
        for p in 0..3000 {
            let to = drainage.receiver[p] as usize;
            assert!(border(p) && to == p || z.data[to] < z.data[p], "post {p}");
        }
        let area = drainage.area_m2(2.0);
        let out: f32 = (0..3000).filter(|p| border(*p)).map(|p| area[p]).sum();
        assert_eq!(out, 3000.0 * 4.0);
    }
}
