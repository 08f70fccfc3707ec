//! Drainage: every post gets a way down, and the area that drains through it.

use satseed_scene::Raster;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The eight neighbours, east first, counter-clockwise.
pub const NEIGHBOURS: [(i64, i64); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Least drop along a filled depression, m per post: what makes its water find the outlet.
const FILL_DROP_M: f32 = 1e-4;

/// Who drains into whom.
#[derive(Clone, Debug)]
pub struct Drainage {
    /// The post into which each post drains; outlets drain into themselves.
    pub receiver: Vec<u32>,
    /// All posts, each after its receiver.
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

/// Raises depressions until every post has a way down to an outlet, and returns the ways.
///
/// Priority flood (Barnes, Lehman, Mulla 2014) with a small drop along filled parts; then each post drains to its
/// steepest lower neighbour (D8). Ties go to the lower post number. Outlets keep their heights. O(n log n).
pub fn fill_and_drain(z: &mut Raster<f32>, is_outlet: impl Fn(usize) -> bool) -> Drainage {
    let (width, height) = (z.width, z.height);
    let n = width * height;
    let mut heap = BinaryHeap::with_capacity(n / 4);
    let mut seen = vec![false; n];
    let mut order = Vec::with_capacity(n);
    let mut receiver: Vec<u32> = (0..n as u32).collect();
    let entry = |z: f32, post: usize| Reverse((u64::from(key(z)) << 32) | post as u64);
    let mut outlets = vec![false; n];
    for post in (0..n).filter(|p| is_outlet(*p)) {
        outlets[post] = true;
        seen[post] = true;
        heap.push(entry(z.data[post], post));
    }
    while let Some(Reverse(code)) = heap.pop() {
        let post = code as u32 as usize;
        let floor = z.data[post] + FILL_DROP_M;
        order.push(post as u32);
        for (_, next) in neighbours(width, height, post) {
            if !seen[next] {
                seen[next] = true;
                if z.data[next] < floor {
                    z.data[next] = floor;
                }
                heap.push(entry(z.data[next], next));
            }
        }
    }
    for &post in &order {
        let post = post as usize;
        if outlets[post] {
            continue;
        }
        let mut steepest = 0.0;
        for (k, next) in neighbours(width, height, post) {
            let run = if k % 2 == 0 { 1.0 } else { core::f32::consts::SQRT_2 };
            let drop = (z.data[post] - z.data[next]) / run;
            if drop > steepest {
                steepest = drop;
                receiver[post] = next as u32;
            }
        }
    }
    Drainage { receiver, order }
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
        let border = |p: usize| p % 60 == 0 || p % 60 == 59 || p / 60 == 0 || p / 60 == 49;
        let before = z.clone();
        let drainage = fill_and_drain(&mut z, border);
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
