//! The vertices of a border, decided by the border alone.

use super::breakline::Piece;
use super::{Grain, Ground, Layout};
use glam::{DVec2, DVec3};
use satseed_scene::quantise_m;

/// A side of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    South,
    North,
    West,
    East,
}

impl Side {
    pub(super) const ALL: [Self; 4] = [Self::South, Self::North, Self::West, Self::East];

    /// The axis along which the side runs.
    fn along(self) -> usize {
        match self {
            Self::South | Self::North => 0,
            Self::West | Self::East => 1,
        }
    }
}

/// The vertices of a border from its western or southern end to the other, corners included.
pub(super) struct Border {
    pub(super) vertices_m: Vec<DVec3>,
}

impl Border {
    pub(super) fn new(
        layout: &Layout,
        side: Side,
        column: usize,
        row: usize,
        grain: Grain,
        ground: &impl Ground,
        pieces: &[Vec<Piece>],
    ) -> Self {
        let (column_from, row_from) = match side {
            Side::South | Side::West => (column, row),
            Side::North => (column, row + 1),
            Side::East => (column + 1, row),
        };
        let from = layout.corner_m(column_from, row_from);
        let along = side.along();
        let across = 1 - along;
        let step = if along == 0 { DVec2::X } else { DVec2::Y };
        let count = libm::round(layout.tile_m / grain.post_m) as usize;
        let posts: Vec<(f64, f64)> = (0..=count)
            .map(|k| {
                let t = k as f64 * grain.post_m;
                (t, ground.height_m(from + step * t))
            })
            .collect();
        // Breaklines that end on this border or cross it, seen from the tiles on both sides.
        let mut fixed: Vec<(f64, f64)> = Vec::new();
        let mut collect = |tile: Option<usize>| {
            for p in tile.into_iter().flat_map(|t| &pieces[t]).flat_map(|piece| piece.ends_m) {
                let t = p[along] - from[along];
                if p[across] == from[across] && t > 0.0 && t < layout.tile_m {
                    fixed.push((t, p.z));
                }
            }
        };
        let tile_at = |c: i64, r: i64| {
            let inside = c >= 0 && r >= 0 && c < layout.columns as i64 && r < layout.rows as i64;
            inside.then(|| r as usize * layout.columns + c as usize)
        };
        let (c, r) = (column_from as i64, row_from as i64);
        collect(tile_at(c, r));
        collect(if along == 0 { tile_at(c, r - 1) } else { tile_at(c - 1, r) });
        fixed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        fixed.dedup_by(|b, a| a.0 == b.0);
        let mut profile = vec![(0.0, f64::from(quantise_m(posts[0].1)))];
        let end = (layout.tile_m, f64::from(quantise_m(posts[count].1)));
        for &stop in fixed.iter().chain([&end]) {
            let start = *profile.last().expect("the profile begins with a corner");
            let low = posts.partition_point(|p| p.0 <= start.0);
            let high = posts.partition_point(|p| p.0 < stop.0);
            simplify(start, stop, &posts[low..high], grain.max_error_m - 1.0 / 1024.0, &mut profile);
            profile.push(stop);
        }
        let vertices_m = profile.iter().map(|&(t, z)| (from + step * t).extend(z)).collect();
        Self { vertices_m }
    }
}

/// Ramer-Douglas-Peucker by vertical distance: adds those of `posts` that are needed between `a` and `b`.
fn simplify(a: (f64, f64), b: (f64, f64), posts: &[(f64, f64)], tolerance_m: f64, out: &mut Vec<(f64, f64)>) {
    let slope = (b.1 - a.1) / (b.0 - a.0);
    let mut worst = (tolerance_m, None);
    for (i, p) in posts.iter().enumerate() {
        let error = (p.1 - a.1 - slope * (p.0 - a.0)).abs();
        if error > worst.0 {
            worst = (error, Some(i));
        }
    }
    if let Some(i) = worst.1 {
        let middle = (posts[i].0, f64::from(quantise_m(posts[i].1)));
        simplify(a, middle, &posts[..i], tolerance_m, out);
        out.push(middle);
        simplify(middle, b, &posts[i + 1..], tolerance_m, out);
    }
}
