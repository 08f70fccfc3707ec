//! Grids of samples over the plane.

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

/// A raster that materials read: 8-bit values with their means over 2, 4, 8 ... posts, so that a large footprint sees
/// the mean of what it covers.
#[derive(Clone, Debug)]
pub struct MaterialRaster {
    levels: Vec<Raster<u8>>,
}

impl MaterialRaster {
    /// Values 0..1 are stored in steps of 1/255; anything outside is clamped.
    pub fn new(values: &Raster<f32>) -> Self {
        let data = values.data.iter().map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect();
        let mut levels = vec![Raster {
            origin_m: values.origin_m,
            cell_m: values.cell_m,
            width: values.width,
            height: values.height,
            data,
        }];
        while let Some(last) = levels.last() {
            if last.width < 2 || last.height < 2 {
                break;
            }
            levels.push(halved(last));
        }
        Self { levels }
    }

    /// Mean over a square of side `footprint_m` around `p`, 0..1: bilinear within the two nearest levels.
    #[inline]
    pub fn sample(&self, p: DVec2, footprint_m: f64) -> f32 {
        let ratio = footprint_m / self.levels[0].cell_m;
        let level = if ratio <= 1.0 { 0.0 } else { libm::log2(ratio) };
        let last = self.levels.len() - 1;
        let low = (level as usize).min(last);
        let blend = (level - low as f64).clamp(0.0, 1.0);
        let a = self.levels[low].bilinear(p);
        let value = if blend > 0.0 && low < last { a + (self.levels[low + 1].bilinear(p) - a) * blend } else { a };
        (value / 255.0) as f32
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|l| l.data.len()).sum()
    }

    /// The finest level.
    pub fn finest(&self) -> &Raster<u8> {
        &self.levels[0]
    }
}

fn halved(fine: &Raster<u8>) -> Raster<u8> {
    let (width, height) = (fine.width / 2, fine.height / 2);
    let mut data = Vec::with_capacity(width * height);
    for j in 0..height {
        for i in 0..width {
            let sum: u32 = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .iter()
                .map(|(di, dj)| u32::from(fine.get(2 * i + di, 2 * j + dj)))
                .sum();
            data.push(((sum + 2) / 4) as u8);
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
        let mut r = Raster::filled(DVec2::ZERO, 1.0, 64, 64, 0.0_f32);
        for j in 0..64 {
            for i in 0..64 {
                r.set(i, j, ((i + j) % 2) as f32);
            }
        }
        let m = MaterialRaster::new(&r);
        assert_eq!(m.sample(DVec2::new(10.0, 10.0), 0.1), 0.0);
        assert!((m.sample(DVec2::new(30.3, 30.1), 16.0) - 0.5).abs() < 0.01);
    }
}
