//! Reading rasters between their posts.

use glam::DVec2;
use satseed_scene::Raster;

/// Catmull-Rom value at a world position: passes through the posts with a continuous slope. Beyond the border, the
/// border's value.
pub fn bicubic(raster: &Raster<f32>, p_m: DVec2) -> f64 {
    let g = raster.grid_from_world(p_m);
    let (fi, fj) = (libm::floor(g.x), libm::floor(g.y));
    let (wx, wy) = (weights(g.x - fi), weights(g.y - fj));
    let (i, j) = (fi as i64, fj as i64);
    let mut sum = 0.0;
    if i >= 1 && j >= 1 && i + 2 < raster.width as i64 && j + 2 < raster.height as i64 {
        let corner = (j as usize - 1) * raster.width + i as usize - 1;
        for (row, w) in wy.iter().enumerate() {
            let r = &raster.data[corner + row * raster.width..][..4];
            sum += w
                * (wx[0] * f64::from(r[0])
                    + wx[1] * f64::from(r[1])
                    + wx[2] * f64::from(r[2])
                    + wx[3] * f64::from(r[3]));
        }
    } else {
        for (row, w) in (-1..).zip(wy) {
            for (column, v) in (-1..).zip(wx) {
                sum += w * v * f64::from(raster.get_clamped(i + column, j + row));
            }
        }
    }
    sum
}

fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (-3.0 * t3 + 4.0 * t2 + t), 0.5 * (t3 - t2)]
}

/// Eastward and northward slope at a post, m per m, by central differences (one-sided on the border).
pub fn gradient(raster: &Raster<f32>, i: usize, j: usize) -> DVec2 {
    let difference = |a: f32, b: f32, posts: usize| f64::from(b - a) / (posts as f64 * raster.cell_m);
    let (west, east) = (i.saturating_sub(1), (i + 1).min(raster.width - 1));
    let (south, north) = (j.saturating_sub(1), (j + 1).min(raster.height - 1));
    DVec2::new(
        difference(raster.get(west, j), raster.get(east, j), east - west),
        difference(raster.get(i, south), raster.get(i, north), north - south),
    )
}

/// 0 below `from`, 1 above `to`, smooth between.
pub fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bicubic_passes_through_posts_and_keeps_planes() {
        let mut r = Raster::filled(DVec2::new(-2.0, 1.0), 2.0, 8, 8, 0.0_f32);
        for j in 0..8 {
            for i in 0..8 {
                let p = r.position(i, j);
                r.set(i, j, (3.0 * p.x - 0.5 * p.y) as f32);
            }
        }
        for p in [DVec2::new(3.3, 6.1), DVec2::new(4.0, 7.0), DVec2::new(5.9, 8.2)] {
            assert!((bicubic(&r, p) - (3.0 * p.x - 0.5 * p.y)).abs() < 1e-6);
        }
        assert_eq!(gradient(&r, 3, 4), DVec2::new(3.0, -0.5));
        r.set(4, 4, 9.0);
        assert_eq!(bicubic(&r, r.position(4, 4)), 9.0);
    }
}
