//! Grids of samples over the plane.

use crate::texture_noise::cell;
use glam::DVec2;

/// A grid of posts. Post (i, j) stands at `origin_m + (i, j) * cell_m`; i runs east, j north.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    /// World position of post (0, 0), m.
    pub origin_m: DVec2,
    /// Distance of neighbouring posts, m.
    pub cell_m: f64,
    /// Posts eastward.
    pub width: usize,
    /// Posts northward.
    pub height: usize,
    /// Values, row by row from the south.
    pub data: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// A raster of one value.
    pub fn filled(origin_m: DVec2, cell_m: f64, width: usize, height: usize, value: T) -> Self {
        Self { origin_m, cell_m, width, height, data: vec![value; width * height] }
    }

    /// The value of post (i, j).
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> T {
        self.data[j * self.width + i]
    }

    /// Sets post (i, j).
    #[inline]
    pub fn set(&mut self, i: usize, j: usize, value: T) {
        self.data[j * self.width + i] = value;
    }

    /// The value of the nearest post inside the grid.
    #[inline]
    pub fn get_clamped(&self, i: i64, j: i64) -> T {
        let i = i.clamp(0, self.width as i64 - 1) as usize;
        let j = j.clamp(0, self.height as i64 - 1) as usize;
        self.get(i, j)
    }

    /// World position of post (i, j), m.
    pub fn position(&self, i: usize, j: usize) -> DVec2 {
        self.origin_m + DVec2::new(i as f64, j as f64) * self.cell_m
    }

    /// Grid coordinates of a world position: fractional (i, j).
    #[inline]
    pub fn grid_from_world(&self, p: DVec2) -> DVec2 {
        (p - self.origin_m) / self.cell_m
    }
}

impl<T: Copy + Into<f64>> Raster<T> {
    /// Bilinear value at a world position; beyond the border, the border's value.
    #[inline]
    pub fn bilinear(&self, p: DVec2) -> f64 {
        let g = self.grid_from_world(p);
        let (fi, fj) = (libm::floor(g.x), libm::floor(g.y));
        let (u, v) = (g.x - fi, g.y - fj);
        let (i, j) = (fi as i64, fj as i64);
        let at = |di, dj| -> f64 { self.get_clamped(i + di, j + dj).into() };
        let low = at(0, 0) + (at(1, 0) - at(0, 0)) * u;
        let high = at(0, 1) + (at(1, 1) - at(0, 1)) * u;
        low + (high - low) * v
    }
}

pub(crate) const CHANNELS: usize = MaterialRaster::CHANNELS;

/// Rasters of one grid that materials read: 8-bit values, all those of a post side by side, with their means over 2, 4,
/// 8 ... posts, so that a large footprint sees the mean of what it covers.
#[derive(Clone, Debug)]
pub struct MaterialRaster {
    levels: Vec<Raster<[u8; CHANNELS]>>,
}

impl MaterialRaster {
    /// Channels of every raster: a post is one vector register.
    pub const CHANNELS: usize = 16;

    /// From the values of every post in 255ths; what is not used of the 16 channels costs memory alone.
    pub fn new(values: Raster<[u8; CHANNELS]>) -> Self {
        let mut levels = vec![values];
        while let Some(last) = levels.last() {
            if last.width < 2 || last.height < 2 {
                break;
            }
            levels.push(halved(last));
        }
        Self { levels }
    }

    /// Means of all channels over about a square of side `footprint_m` around `p`, 0..1: bilinear within the level
    /// whose posts stand one half to one footprint apart.
    #[inline]
    pub fn sample(&self, p: DVec2, footprint_m: f64) -> [f32; CHANNELS] {
        let mut level = &self.levels[0];
        for coarser in &self.levels[1..] {
            if coarser.cell_m > footprint_m {
                break;
            }
            level = coarser;
        }
        let last = DVec2::new(level.width as f64, level.height as f64);
        let g = level.grid_from_world(p).clamp(DVec2::NEG_ONE, last);
        let ((i, u), (j, v)) = (cell(g.x), cell(g.y));
        let clamped = |k: i32, count: usize| k.clamp(0, count as i32 - 1) as usize;
        let columns = [clamped(i, level.width), clamped(i + 1, level.width)];
        let rows = [clamped(j, level.height), clamped(j + 1, level.height)];
        let at = |column: usize, row: usize| &level.data[rows[row] * level.width + columns[column]];
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        let share = |u: f32, v: f32| u * v * (1.0 / 255.0);
        let w = [share(1.0 - u, 1.0 - v), share(u, 1.0 - v), share(1.0 - u, v), share(u, v)];
        core::array::from_fn(|k| {
            f32::from(a[k]) * w[0] + f32::from(b[k]) * w[1] + (f32::from(c[k]) * w[2] + f32::from(d[k]) * w[3])
        })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|l| l.data.len() * CHANNELS).sum()
    }

    /// The finest level.
    pub fn finest(&self) -> &Raster<[u8; CHANNELS]> {
        &self.levels[0]
    }
}

fn halved(fine: &Raster<[u8; CHANNELS]>) -> Raster<[u8; CHANNELS]> {
    let (width, height) = (fine.width / 2, fine.height / 2);
    let mut data = Vec::with_capacity(width * height);
    for j in 0..height {
        for i in 0..width {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| fine.get(2 * i + di, 2 * j + dj));
            data.push(core::array::from_fn(|k| ((four.iter().map(|f| u16::from(f[k])).sum::<u16>() + 2) / 4) as u8));
        }
    }
    Raster { origin_m: fine.origin_m + DVec2::splat(fine.cell_m / 2.0), cell_m: fine.cell_m * 2.0, width, height, data }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_reproduces_a_plane() {
        let mut r = Raster::filled(DVec2::new(-3.0, 2.0), 0.5, 9, 7, 0.0_f64);
        for j in 0..7 {
            for i in 0..9 {
                let p = r.position(i, j);
                r.set(i, j, 2.0 * p.x - p.y);
            }
        }
        let p = DVec2::new(-1.3, 3.9);
        assert!((r.bilinear(p) - (2.0 * p.x - p.y)).abs() < 1e-12);
    }

    #[test]
    fn a_large_footprint_sees_the_mean() {
        let mut r = Raster::filled(DVec2::ZERO, 1.0, 64, 64, [0; CHANNELS]);
        for j in 0..64 {
            for i in 0..64 {
                let mut channels = [0; CHANNELS];
                channels[3] = 255 * ((i + j) % 2) as u8;
                channels[15] = (i * 4) as u8;
                r.set(i, j, channels);
            }
        }
        let m = MaterialRaster::new(r);
        assert_eq!(m.sample(DVec2::new(10.0, 10.0), 0.1)[3], 0.0);
        assert!((m.sample(DVec2::new(10.0, 10.5), 0.1)[3] - 0.5).abs() < 1e-6);
        assert!((m.sample(DVec2::new(30.3, 30.1), 16.0)[3] - 0.5).abs() < 0.01);
        for footprint_m in [0.1, 1.0, 3.0, 8.0] {
            let slope = m.sample(DVec2::new(30.3, 30.1), footprint_m)[15];
            assert!((slope - 30.3 * 4.0 / 255.0).abs() < 0.005, "{footprint_m}: {slope}");
        }
        // Beyond the border, the border's value.
        assert_eq!(m.sample(DVec2::new(-9e9, 3.0), 0.1)[15], 0.0);
        assert!((m.sample(DVec2::new(9e9, 3.0), 0.1)[15] - 252.0 / 255.0).abs() < 1e-6);
    }
}
