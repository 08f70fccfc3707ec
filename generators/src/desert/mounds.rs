//! Coppice dunes: mounds of sand that shrubs catch and hold, each with a tail downwind.

use super::dunes::Dunes;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{SeedPath, hash_cell, unit_from_hash};

/// Side of the cells in which at most one mound stands, m.
const CELL_M: f64 = 9.0;

/// A mound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mound {
    /// Its middle, world, m.
    pub(super) at_m: DVec2,
    /// Height, m.
    pub(super) height_m: f64,
    /// Radius at which it has fallen to a third, m.
    pub(super) radius_m: f64,
    /// Key of its own randomness.
    pub(super) cell: (i32, i32),
}

/// All mounds of the full detail.
pub(super) struct Mounds {
    wind: DVec2,
    first: i32,
    count: usize,
    cells: Vec<Option<Mound>>,
}

impl Mounds {
    /// Mounds of the square of half side `half_m`, `density` times as many as in nature.
    pub(super) fn new(dunes: &Dunes, half_m: f64, density: f64, path: &SeedPath) -> Self {
        let seed = path.hash_u32();
        // One cell more than the square: what stands just beyond it reaches into it.
        let first = libm::floor(-half_m / CELL_M) as i32 - 1;
        let count = (2 * -first) as usize;
        let cells = (0..count * count)
            .into_par_iter()
            .map(|k| mound(dunes, (first + (k % count) as i32, first + (k / count) as i32), density, seed, path))
            .collect();
        Self { wind: dunes.along, first, count, cells }
    }

    /// What all mounds near a place add to its height, m.
    pub(super) fn height_m(&self, p: DVec2) -> f64 {
        let g = (p / CELL_M).floor();
        let (ci, cj) = (g.x as i32 - self.first, g.y as i32 - self.first);
        let mut highest = 0.0_f64;
        for j in cj - 1..=cj + 1 {
            for i in ci - 1..=ci + 1 {
                let inside = i >= 0 && j >= 0 && (i as usize) < self.count && (j as usize) < self.count;
                if !inside {
                    continue;
                }
                if let Some(m) = &self.cells[j as usize * self.count + i as usize] {
                    highest = highest.max(m.rise_m(p, self.wind));
                }
            }
        }
        highest
    }

    /// Every mound, row by row.
    pub(super) fn all(&self) -> impl Iterator<Item = &Mound> {
        self.cells.iter().flatten()
    }
}

impl Mound {
    fn rise_m(&self, p: DVec2, wind: DVec2) -> f64 {
        let d = p - self.at_m;
        let (x, y) = (wind.dot(d), wind.perp_dot(d));
        // The tail is twice as long as the front and narrows.
        let x = if x > 0.0 { x / 2.1 } else { x };
        let r2 = (x * x + y * y) / (self.radius_m * self.radius_m);
        if r2 > 5.0 { 0.0 } else { self.height_m * (libm::exp(-r2) - libm::exp(-5.0)) }
    }
}

fn mound(dunes: &Dunes, cell: (i32, i32), density: f64, seed: u32, path: &SeedPath) -> Option<Mound> {
    let draw = f64::from(unit_from_hash(hash_cell(cell.0, cell.1, 0, seed)));
    let corner = DVec2::new(f64::from(cell.0), f64::from(cell.1)) * CELL_M;
    let groves = smoothstep(-0.05, 0.35, fractal(corner, seed, 130.0, 3, 0.55));
    if draw > 0.75 * density * (0.16 + 0.84 * groves) {
        return None;
    }
    let mut rng = path.index((u64::from(cell.0 as u32) << 32) | u64::from(cell.1 as u32)).rng();
    let at_m = corner + DVec2::new(rng.range(0.15, 0.85), rng.range(0.15, 0.85)) * CELL_M;
    let sand = dunes.sand(at_m);
    // On sheets and between dunes; moving sand buries them.
    if sand.thick_m > 1.6 || sand.lee > 0.5 {
        return None;
    }
    let height_m = rng.lognormal(0.5, 0.45).clamp(0.18, 1.2);
    Some(Mound { at_m, height_m, radius_m: (height_m * rng.range(1.55, 2.1)).clamp(0.6, 2.2), cell })
}
