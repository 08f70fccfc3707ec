//! Streams, tracks and rides as lines that any place can ask for the nearest of.

use super::HALF_M;
use glam::{DVec2, DVec3};

/// Side of a look-up cell, m.
const CELL_M: f64 = 16.0;

/// A straight part of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Its ends, m; heights are the line's own.
    pub(super) ends_m: [DVec3; 2],
    /// Half the line's width at both ends, m.
    pub(super) half_m: [f64; 2],
}

/// Where a place is, seen from a line.
#[allow(clippy::struct_field_names, reason = "the unit stands in the name")]
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// Distance from the line, m, positive on its left.
    pub(super) offset_m: f64,
    /// The line's own height there, m.
    pub(super) level_m: f64,
    /// Half its width there, m.
    pub(super) half_m: f64,
}

/// Lines with a look-up.
pub(super) struct Lines {
    parts: Vec<Part>,
    across: usize,
    /// For each cell, the parts within reach.
    cells: Vec<Vec<u32>>,
    reach_m: f64,
}

impl Lines {
    /// Lines that are found from as far as `reach_m`.
    pub(super) fn new(parts: Vec<Part>, reach_m: f64) -> Self {
        let across = libm::ceil(2.0 * HALF_M / CELL_M) as usize;
        let mut lines = Self { parts, across, cells: vec![Vec::new(); across * across], reach_m };
        for k in 0..lines.parts.len() {
            let [a, b] = lines.parts[k].ends_m.map(DVec3::truncate);
            let (low, high) = (lines.cell(a.min(b) - reach_m), lines.cell(a.max(b) + reach_m));
            for j in low.1..=high.1 {
                for i in low.0..=high.0 {
                    lines.cells[j * across + i].push(k as u32);
                }
            }
        }
        lines
    }

    fn cell(&self, p: DVec2) -> (usize, usize) {
        let index = |x: f64| (((x + HALF_M) / CELL_M).max(0.0) as usize).min(self.across - 1);
        (index(p.x), index(p.y))
    }

    /// The nearest line within reach.
    pub(super) fn near(&self, p: DVec2) -> Option<Near> {
        let (i, j) = self.cell(p);
        let mut best: Option<(f64, Near)> = None;
        for k in &self.cells[j * self.across + i] {
            let part = &self.parts[*k as usize];
            let [a, b] = part.ends_m.map(DVec3::truncate);
            let along = b - a;
            let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            let away = p - a - along * t;
            let distance = away.length();
            if distance < self.reach_m && best.is_none_or(|b| distance < b.0) {
                let lerp = |v: [f64; 2]| v[0] + (v[1] - v[0]) * t;
                let near = Near {
                    offset_m: if along.perp_dot(away) < 0.0 { -distance } else { distance },
                    level_m: lerp(part.ends_m.map(|e| e.z)),
                    half_m: lerp(part.half_m),
                };
                best = Some((distance, near));
            }
        }
        best.map(|b| b.1)
    }

    /// Distance beyond the nearest line's own width, m; negative on it; the reach where none is near.
    pub(super) fn beyond_m(&self, p: DVec2) -> f64 {
        self.near(p).map_or(self.reach_m, |n| n.offset_m.abs() - n.half_m)
    }
}

/// A line through points as parts.
pub(super) fn parts(points_m: &[DVec3], half_m: f64) -> Vec<Part> {
    points_m
        .windows(2)
        .filter(|w| w[0].truncate().distance(w[1].truncate()) > 0.05)
        .map(|w| Part { ends_m: [w[0], w[1]], half_m: [half_m; 2] })
        .collect()
}
