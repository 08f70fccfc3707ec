//! Weighted distances by a front that grows from its sources: valley walls that climb from channels, cones of scree
//! that fall from chutes. Distances are exact to the nearest source that a neighbour knows, so circles are round.

use super::flow::NEIGHBOURS;
use glam::DVec2;
use satseed_scene::Raster;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A straight source with a value at each end and a width within which the value does not yet rise.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Its ends, m.
    pub ends_m: [DVec2; 2],
    /// Value at the ends, m.
    pub values_m: [f64; 2],
    /// Half its width at the ends, m.
    pub half_widths_m: [f64; 2],
}

impl Source {
    /// Least of `value + distance beyond the half width` over the source's points, and where along it (0..1).
    pub fn reach(&self, p_m: DVec2) -> (f64, f64) {
        let [a, b] = self.ends_m;
        let along = b - a;
        let length = along.length();
        if length < 1e-9 {
            let d = ((p_m - a).length() - self.half_widths_m[0]).max(0.0);
            return (d + self.values_m[0].min(self.values_m[1]), 0.0);
        }
        let foot = (p_m - a).dot(along) / (length * length);
        let across = (p_m - a - along * foot).length();
        // Where the value rises along the source by g per metre, the nearest way leaves it lower down.
        let g = ((self.values_m[1] - self.values_m[0]) / length).clamp(-0.999, 0.999);
        let t = (foot - across * g / f64::sqrt(1.0 - g * g) / length).clamp(0.0, 1.0);
        let lerp = |v: [f64; 2]| v[0] + (v[1] - v[0]) * t;
        let d = ((p_m - a - along * t).length() - lerp(self.half_widths_m)).max(0.0);
        (lerp(self.values_m) + d, t)
    }
}

/// For every post the least reach over all sources, up to `limit_m`, and the number of the source it comes from
/// (`u32::MAX` where none reaches). `shape` gives the grid.
pub fn rise<T: Copy>(shape: &Raster<T>, sources: &[Source], limit_m: f64) -> (Raster<f32>, Raster<u32>) {
    let mut value = Raster::filled(shape.origin_m, shape.cell_m, shape.width, shape.height, limit_m as f32);
    let mut from = Raster::filled(shape.origin_m, shape.cell_m, shape.width, shape.height, u32::MAX);
    let mut heap = BinaryHeap::new();
    let offer = |value: &mut Raster<f32>, from: &mut Raster<u32>, heap: &mut BinaryHeap<_>, post: usize, s: u32| {
        let p = shape.position(post % shape.width, post / shape.width);
        let reach = sources[s as usize].reach(p).0 as f32;
        if reach < value.data[post] {
            value.data[post] = reach;
            from.data[post] = s;
            // Offsets keep values positive, so that their bits order as they do.
            heap.push(Reverse((ordered(reach), post as u32, s)));
        }
    };
    for (s, source) in sources.iter().enumerate() {
        let pad = source.half_widths_m[0].max(source.half_widths_m[1]) + 1.5 * shape.cell_m;
        let low = shape.grid_from_world(source.ends_m[0].min(source.ends_m[1]) - pad);
        let high = shape.grid_from_world(source.ends_m[0].max(source.ends_m[1]) + pad);
        let clamp = |x: f64, n: usize| libm::ceil(x).clamp(0.0, n as f64) as usize;
        for j in clamp(low.y, shape.height)..clamp(high.y, shape.height) {
            for i in clamp(low.x, shape.width)..clamp(high.x, shape.width) {
                offer(&mut value, &mut from, &mut heap, j * shape.width + i, s as u32);
            }
        }
    }
    while let Some(Reverse((reach, post, s))) = heap.pop() {
        let post = post as usize;
        if from.data[post] != s || ordered(value.data[post]) != reach {
            continue;
        }
        let (i, j) = ((post % shape.width) as i64, (post / shape.width) as i64);
        for (di, dj) in NEIGHBOURS {
            let (ni, nj) = (i + di, j + dj);
            if ni >= 0 && nj >= 0 && ni < shape.width as i64 && nj < shape.height as i64 {
                offer(&mut value, &mut from, &mut heap, nj as usize * shape.width + ni as usize, s);
            }
        }
    }
    (value, from)
}

fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The apex of a cone of scree.
#[derive(Clone, Copy, Debug)]
pub struct Apex {
    /// Where, m.
    pub at_m: DVec2,
    /// Height of the apex, m.
    pub height_m: f64,
    /// Fall per metre.
    pub tangent: f64,
    /// Cover above which the cone ends, m: more would not stay.
    pub max_cover_m: f64,
}

/// Thickness, m, of the cones of scree that lie on `ground`: for each post the highest cone that reaches it over posts
/// that it covers.
pub fn cones(ground: &Raster<f32>, apexes: &[Apex]) -> Raster<f32> {
    let mut cover = Raster::filled(ground.origin_m, ground.cell_m, ground.width, ground.height, 0.0_f32);
    let mut best = Raster::filled(ground.origin_m, ground.cell_m, ground.width, ground.height, f32::MIN);
    let mut heap = BinaryHeap::new();
    for (n, apex) in apexes.iter().enumerate() {
        let g = ground.grid_from_world(apex.at_m);
        let (i, j) = (libm::floor(g.x + 0.5) as i64, libm::floor(g.y + 0.5) as i64);
        if i >= 0 && j >= 0 && i < ground.width as i64 && j < ground.height as i64 {
            let post = j as usize * ground.width + i as usize;
            if apex.height_m as f32 > best.data[post] {
                best.data[post] = apex.height_m as f32;
                heap.push((ordered(best.data[post]), Reverse(post as u32), n as u32));
            }
        }
    }
    while let Some((height, Reverse(post), n)) = heap.pop() {
        let post = post as usize;
        if ordered(best.data[post]) != height {
            continue;
        }
        let apex = &apexes[n as usize];
        let thick = best.data[post] - ground.data[post];
        if f64::from(thick) > apex.max_cover_m {
            continue;
        }
        cover.data[post] = thick.max(0.0);
        let (i, j) = ((post % ground.width) as i64, (post / ground.width) as i64);
        for (di, dj) in NEIGHBOURS {
            let (ni, nj) = (i + di, j + dj);
            if ni < 0 || nj < 0 || ni >= ground.width as i64 || nj >= ground.height as i64 {
                continue;
            }
            let next = nj as usize * ground.width + ni as usize;
            let p = ground.position(ni as usize, nj as usize);
            let cone = (apex.height_m - (p - apex.at_m).length() * apex.tangent) as f32;
            if cone > best.data[next] && cone > ground.data[next] {
                best.data[next] = cone;
                heap.push((ordered(cone), Reverse(next as u32), n));
            }
        }
    }
    cover
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_gives_round_contours_and_a_line_its_distance() {
        let shape = Raster::filled(DVec2::splat(-100.0), 2.0, 101, 101, ());
        let point = Source { ends_m: [DVec2::ZERO; 2], values_m: [5.0; 2], half_widths_m: [3.0; 2] };
        let (value, _) = rise(&shape, &[point], 1e3);
        for (i, j) in [(0, 0), (17, 90), (50, 3), (77, 31)] {
            let expected = (shape.position(i, j).length() - 3.0).max(0.0) + 5.0;
            assert!((f64::from(value.get(i, j)) - expected).abs() < 1e-3);
        }
        // A source that climbs by 0.6 per metre is left where the wall to it is shortest: a plane of slope 1.
        let line = Source {
            ends_m: [DVec2::new(-200.0, 0.0), DVec2::new(200.0, 0.0)],
            values_m: [0.0, 240.0],
            half_widths_m: [0.0; 2],
        };
        let (v, _) = rise(&shape, &[line], 1e3);
        let gx = f64::from(v.get(60, 80) - v.get(40, 80)) / 40.0;
        let gy = f64::from(v.get(50, 90) - v.get(50, 70)) / 40.0;
        assert!((gx - 0.6).abs() < 1e-3 && (gy - 0.8).abs() < 1e-3, "{gx} {gy}");
    }

    #[test]
    fn a_cone_lies_on_flat_ground() {
        let ground = Raster::filled(DVec2::splat(-20.0), 1.0, 41, 41, 2.0_f32);
        let apex = Apex { at_m: DVec2::ZERO, height_m: 8.0, tangent: 0.7, max_cover_m: 10.0 };
        let cover = cones(&ground, &[apex]);
        assert_eq!(cover.get(20, 20), 6.0);
        assert!((cover.get(24, 23) - (6.0 - 3.5)).abs() < 1e-5);
        assert_eq!(cover.get(30, 20), 0.0);
    }
}
