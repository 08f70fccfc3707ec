//! Scalar texture fields: data, and the one evaluator that knows what they mean.
//!
//! Every primitive returns its mean over the footprint and the standard deviation that the footprint swallowed. A
//! threshold ([`Field::Ramp`]) widens by that deviation, so that a far view of a speckled surface has the colour of the
//! speckles' mean and not that of their mean height.

use crate::noise::{NOISE_DEVIATION, gradient_noise_2d, gradient_noise_3d, hash_cell, unit_from_hash};
use crate::raster::MaterialRaster;
use glam::{DVec2, DVec3};

/// A point of a surface as a texture sees it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// World position, m.
    pub world_m: DVec3,
    /// Position in the object's own frame, m.
    pub object_m: DVec3,
    /// Texture coordinates, m along the surface. (0, 0) where a mesh has none.
    pub uv_m: DVec2,
    /// Unit normal, world frame, smooth where the mesh says so; turned towards the viewer.
    pub normal: DVec3,
    /// Side of the square that one sample stands for, m on the surface.
    pub footprint_m: f64,
    /// The instance's own four numbers, -1..1.
    pub variation: [f32; 4],
}

/// Which position a primitive is keyed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// World east, north, up.
    World,
    /// The object's own frame.
    Object,
    /// The mesh's texture coordinates (third coordinate 0).
    Uv,
}

/// One coordinate of a space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// The space.
    pub space: Space,
    /// 0, 1 or 2.
    pub axis: u8,
}

impl Coordinate {
    /// World height.
    pub const HEIGHT: Self = Self { space: Space::World, axis: 2 };
    /// First texture coordinate.
    pub const U: Self = Self { space: Space::Uv, axis: 0 };
    /// Second texture coordinate.
    pub const V: Self = Self { space: Space::Uv, axis: 1 };
}

/// A scalar over a surface. Lengths are metres.
#[derive(Clone, Debug)]
pub enum Field {
    /// The same everywhere.
    Constant(f32),
    /// A coordinate, m.
    Along(Coordinate),
    /// Fractal gradient noise: mean 0, range about -1..1. Octaves shorter than two footprints are dropped.
    Noise {
        /// What it is keyed by. In [`Space::Uv`] it is two-dimensional, else three-dimensional.
        space: Space,
        /// Seed.
        seed: u32,
        /// Wavelength of the first octave, m.
        wavelength_m: f32,
        /// Number of octaves; each is 1.93 times shorter than the one before.
        octaves: u8,
        /// Amplitude of an octave relative to the one before; the sum is normalised to the first.
        gain: f32,
        /// Wavelengths along the axes are multiplied by this: (1, 1, 8) makes vertical streaks.
        stretch: [f32; 3],
    },
    /// A value of its own, uniform in -1..1, for every cell of a grid. Axes whose size is 0 are not cut.
    Cells {
        /// What it is keyed by.
        space: Space,
        /// Seed.
        seed: u32,
        /// Size of a cell, m.
        size_m: [f32; 3],
        /// Share of the first axis's size by which every second row of the second axis is shifted (bond of tiles).
        stagger: f32,
    },
    /// 1 inside stripes of a width, 0 between, area-averaged.
    Stripes {
        /// Across which coordinate they repeat.
        across: Coordinate,
        /// Distance of stripes, m.
        period_m: f32,
        /// Width of a stripe, m.
        width_m: f32,
        /// Where a stripe's lower border lies, m.
        offset_m: f32,
    },
    /// 1 on the borders of irregular cells (mud cracks, joints, cobbles), 0 inside.
    Cracks {
        /// What it is keyed by; two-dimensional (the first two axes).
        space: Space,
        /// Seed.
        seed: u32,
        /// Mean size of a cell, m.
        cell_m: f32,
        /// Width of a border, m.
        width_m: f32,
    },
    /// A raster of the scene by its index, over world east and north, 0..1.
    Raster(u32),
    /// Upward component of the unit normal: 1 flat, 0 vertical.
    Upward,
    /// Cosine of the normal with a unit direction.
    Facing([f32; 3]),
    /// One of the instance's four numbers, -1..1.
    Variation(u8),
    /// The inner field at a place shifted by noise: `amplitude_m` in all axes of all spaces.
    Warped {
        /// The field.
        of: Box<Field>,
        /// Seed.
        seed: u32,
        /// Wavelength of the shift, m.
        wavelength_m: f32,
        /// Greatest shift, m.
        amplitude_m: f32,
    },
    /// `of * by + plus`.
    Affine {
        /// The field.
        of: Box<Field>,
        /// Factor.
        by: f32,
        /// Summand.
        plus: f32,
    },
    /// Sum of fields.
    Sum(Vec<Field>),
    /// Product of fields.
    Product(Vec<Field>),
    /// The largest of fields.
    Max(Vec<Field>),
    /// 0 below `from`, 1 above `to`, smooth between; `from > to` turns it round.
    Ramp {
        /// The field.
        of: Box<Field>,
        /// Where it is 0.
        from: f32,
        /// Where it is 1.
        to: f32,
    },
}

/// A field's mean over the footprint and the deviation that the footprint hides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// Mean over the footprint.
    pub mean: f32,
    /// Standard deviation within the footprint.
    pub deviation: f32,
}

impl Filtered {
    const fn exact(mean: f32) -> Self {
        Self { mean, deviation: 0.0 }
    }
}

/// How much shorter each octave of noise is. Not an integer, so that lattices never fall together.
const LACUNARITY: f64 = 1.93;

impl Field {
    /// Fractal noise keyed by world position.
    pub fn world_noise(seed: u32, wavelength_m: f32, octaves: u8) -> Self {
        Self::Noise { space: Space::World, seed, wavelength_m, octaves, gain: 0.5, stretch: [1.0; 3] }
    }

    /// Fractal noise keyed by position in the object's frame.
    pub fn object_noise(seed: u32, wavelength_m: f32, octaves: u8) -> Self {
        Self::Noise { space: Space::Object, seed, wavelength_m, octaves, gain: 0.5, stretch: [1.0; 3] }
    }

    /// `self * by`.
    #[must_use]
    pub fn times(self, by: f32) -> Self {
        Self::Affine { of: Box::new(self), by, plus: 0.0 }
    }

    /// `self * by + plus`.
    #[must_use]
    pub fn affine(self, by: f32, plus: f32) -> Self {
        Self::Affine { of: Box::new(self), by, plus }
    }

    /// [`Field::Ramp`] over this field.
    #[must_use]
    pub fn ramp(self, from: f32, to: f32) -> Self {
        Self::Ramp { of: Box::new(self), from, to }
    }

    /// The field's value at a point of a surface.
    pub fn evaluate(&self, p: &SurfacePoint, rasters: &[MaterialRaster]) -> Filtered {
        match self {
            Self::Constant(value) => Filtered::exact(*value),
            Self::Along(c) => Filtered::exact(coordinate(p, *c) as f32),
            Self::Noise { space, seed, wavelength_m, octaves, gain, stretch } => {
                fractal(p, *space, *seed, *wavelength_m, *octaves, *gain, *stretch)
            }
            Self::Cells { space, seed, size_m, stagger } => cells(p, *space, *seed, *size_m, *stagger),
            Self::Stripes { across, period_m, width_m, offset_m } => {
                stripes(coordinate(p, *across) - f64::from(*offset_m), *period_m, *width_m, p.footprint_m)
            }
            Self::Cracks { space, seed, cell_m, width_m } => cracks(p, *space, *seed, *cell_m, *width_m),
            Self::Raster(index) => {
                Filtered::exact(rasters[*index as usize].sample(p.world_m.truncate(), p.footprint_m))
            }
            Self::Upward => Filtered::exact(p.normal.z as f32),
            Self::Facing(d) => Filtered::exact(
                (p.normal.x * f64::from(d[0]) + p.normal.y * f64::from(d[1]) + p.normal.z * f64::from(d[2])) as f32,
            ),
            Self::Variation(i) => Filtered::exact(p.variation[*i as usize]),
            Self::Warped { of, seed, wavelength_m, amplitude_m } => {
                of.evaluate(&warped(p, *seed, *wavelength_m, *amplitude_m), rasters)
            }
            Self::Affine { of, by, plus } => {
                let f = of.evaluate(p, rasters);
                Filtered { mean: f.mean * by + plus, deviation: f.deviation * by.abs() }
            }
            Self::Sum(fields) => {
                let (mut mean, mut variance) = (0.0, 0.0);
                for f in fields.iter().map(|f| f.evaluate(p, rasters)) {
                    mean += f.mean;
                    variance += f.deviation * f.deviation;
                }
                Filtered { mean, deviation: variance.sqrt() }
            }
            Self::Product(fields) => {
                let mut product = Filtered::exact(1.0);
                for f in fields {
                    if product.mean == 0.0 && product.deviation == 0.0 {
                        break;
                    }
                    let f = f.evaluate(p, rasters);
                    // Variance of a product of independent factors.
                    let (a, b) = (product.mean * f.deviation, f.mean * product.deviation);
                    let c = product.deviation * f.deviation;
                    product = Filtered { mean: product.mean * f.mean, deviation: (a * a + b * b + c * c).sqrt() };
                }
                product
            }
            Self::Max(fields) => fields
                .iter()
                .map(|f| f.evaluate(p, rasters))
                .fold(Filtered::exact(f32::MIN), |a, b| if b.mean > a.mean { b } else { a }),
            Self::Ramp { of, from, to } => ramp(of.evaluate(p, rasters), *from, *to),
        }
    }
}

#[inline]
fn position(p: &SurfacePoint, space: Space) -> DVec3 {
    match space {
        Space::World => p.world_m,
        Space::Object => p.object_m,
        Space::Uv => p.uv_m.extend(0.0),
    }
}

#[inline]
fn coordinate(p: &SurfacePoint, c: Coordinate) -> f64 {
    position(p, c.space)[c.axis as usize]
}

fn fractal(
    p: &SurfacePoint,
    space: Space,
    seed: u32,
    wavelength_m: f32,
    octaves: u8,
    gain: f32,
    stretch: [f32; 3],
) -> Filtered {
    let q = position(p, space);
    let mut wavelength = f64::from(wavelength_m);
    let (mut amplitude, mut norm, mut mean, mut hidden) = (1.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let (sx, sy, sz) = (f64::from(stretch[0]), f64::from(stretch[1]), f64::from(stretch[2]));
    for octave in 0..u32::from(octaves) {
        norm += amplitude * amplitude;
        // Full weight above four footprints, none below two.
        let keep = ((wavelength / (2.0 * p.footprint_m) - 1.0) as f32).clamp(0.0, 1.0);
        if keep > 0.0 {
            let k = 1.0 / wavelength;
            let s = seed.wrapping_add(octave.wrapping_mul(0x9e37_79b9));
            let value = if space == Space::Uv {
                gradient_noise_2d(q.x * k / sx, q.y * k / sy, s)
            } else {
                gradient_noise_3d(q.x * k / sx, q.y * k / sy, q.z * k / sz, s)
            };
            mean += amplitude * keep * value;
        }
        let lost = amplitude * (1.0 - keep) * NOISE_DEVIATION;
        hidden += lost * lost;
        amplitude *= gain;
        wavelength /= LACUNARITY;
    }
    // Normalised in variance, so that the contrast does not depend on the number of octaves.
    let scale = 1.0 / norm.sqrt();
    Filtered { mean: mean * scale, deviation: hidden.sqrt() * scale }
}

/// Standard deviation of a uniform draw from -1..1.
const UNIFORM_DEVIATION: f32 = 0.577_35;

fn cells(p: &SurfacePoint, space: Space, seed: u32, size_m: [f32; 3], stagger: f32) -> Filtered {
    let q = position(p, space);
    let index = |axis: usize, shift: f64| {
        if size_m[axis] > 0.0 { libm::floor(q[axis] / f64::from(size_m[axis]) + shift) as i32 } else { 0 }
    };
    let j = index(1, 0.0);
    let i = index(0, f64::from(stagger) * f64::from(j & 1));
    let value = unit_from_hash(hash_cell(i, j, index(2, 0.0), seed)) * 2.0 - 1.0;
    let smallest = size_m.iter().copied().filter(|s| *s > 0.0).fold(f32::MAX, f32::min);
    // Full contrast while a cell is twice the footprint, none when it is half of it.
    let keep = ((f64::from(smallest) / p.footprint_m - 0.5) / 1.5).clamp(0.0, 1.0) as f32;
    Filtered { mean: value * keep, deviation: (1.0 - keep) * UNIFORM_DEVIATION }
}

/// Share of [x - w/2, x + w/2] that lies inside stripes [k * period, k * period + width].
fn stripes(x: f64, period_m: f32, width_m: f32, footprint_m: f64) -> Filtered {
    let (period, width) = (f64::from(period_m), f64::from(width_m));
    let covered = |t: f64| {
        let k = libm::floor(t / period);
        k * width + (t - k * period).min(width)
    };
    let share = ((covered(x + footprint_m / 2.0) - covered(x - footprint_m / 2.0)) / footprint_m).clamp(0.0, 1.0);
    Filtered { mean: share as f32, deviation: ((share * (1.0 - share)) as f32).sqrt() }
}

fn cracks(p: &SurfacePoint, space: Space, seed: u32, cell_m: f32, width_m: f32) -> Filtered {
    let q = position(p, space);
    let size = f64::from(cell_m);
    let (x, y) = (q.x / size, q.y / size);
    let (ci, cj) = (libm::floor(x) as i32, libm::floor(y) as i32);
    let (mut nearest, mut second) = (f64::MAX, f64::MAX);
    for dj in -1..=1 {
        for di in -1..=1 {
            let h = hash_cell(ci.wrapping_add(di), cj.wrapping_add(dj), 0, seed);
            let h2 = hash_cell(ci.wrapping_add(di), cj.wrapping_add(dj), 1, seed);
            let dx = f64::from(ci) + f64::from(di) + f64::from(unit_from_hash(h)) - x;
            let dy = f64::from(cj) + f64::from(dj) + f64::from(unit_from_hash(h2)) - y;
            let d = (dx * dx + dy * dy).sqrt();
            if d < nearest {
                second = nearest;
                nearest = d;
            } else if d < second {
                second = d;
            }
        }
    }
    // Half the difference of the two distances is about the distance to the border.
    let distance_m = (second - nearest) * 0.5 * size;
    let w = p.footprint_m.max(1e-6);
    let (half, reach) = (f64::from(width_m) / 2.0, w / 2.0);
    let share = (((distance_m + reach).min(half) - (distance_m - reach).max(-half)) / w).clamp(0.0, 1.0);
    Filtered { mean: share as f32, deviation: ((share * (1.0 - share)) as f32).sqrt() }
}

fn warped(p: &SurfacePoint, seed: u32, wavelength_m: f32, amplitude_m: f32) -> SurfacePoint {
    let k = 1.0 / f64::from(wavelength_m);
    let a = f64::from(amplitude_m);
    let shift = |q: DVec3| {
        let at = |i: u32| f64::from(gradient_noise_3d(q.x * k, q.y * k, q.z * k, seed.wrapping_add(i * 0x51ed))) * a;
        DVec3::new(at(0), at(1), at(2))
    };
    let d = shift(p.world_m);
    SurfacePoint { world_m: p.world_m + d, object_m: p.object_m + d, uv_m: p.uv_m + d.truncate(), ..*p }
}

/// The smoothstep's mean under a spread of the argument: its borders move out by the hidden deviation.
fn ramp(f: Filtered, from: f32, to: f32) -> Filtered {
    let (middle, half) = (f32::midpoint(from, to), (to - from) / 2.0);
    let wide = (half * half + 3.0 * f.deviation * f.deviation).sqrt().max(1e-9);
    let signed = if half < 0.0 { -wide } else { wide };
    let t = ((f.mean - middle) / signed * 0.5 + 0.5).clamp(0.0, 1.0);
    let mean = t * t * (3.0 - 2.0 * t);
    let hidden_share = (f.deviation / wide).min(1.0);
    Filtered { mean, deviation: hidden_share * (mean * (1.0 - mean)).max(0.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, footprint_m: f64) -> SurfacePoint {
        SurfacePoint {
            world_m: DVec3::new(x, y, 0.0),
            object_m: DVec3::new(x, y, 0.0),
            uv_m: DVec2::new(x, y),
            normal: DVec3::Z,
            footprint_m,
            variation: [0.0; 4],
        }
    }

    /// The filtered value at a large footprint is the mean of the values at a small one.
    fn assert_mean_kept(field: &Field, footprint_m: f64, tolerance: f32) {
        let n = 96;
        for (x0, y0) in [(3.3, 7.1), (51.0, -13.7), (-200.2, 90.4)] {
            let coarse = field.evaluate(&at(x0, y0, footprint_m), &[]).mean;
            let mut sum = 0.0;
            for j in 0..n {
                for i in 0..n {
                    let s = |k: i32| (f64::from(k) + 0.5) / f64::from(n) - 0.5;
                    let p = at(x0 + s(i) * footprint_m, y0 + s(j) * footprint_m, footprint_m / f64::from(n));
                    sum += field.evaluate(&p, &[]).mean;
                }
            }
            let mean = sum / (n * n) as f32;
            assert!((mean - coarse).abs() < tolerance, "{field:?}: {mean} fine, {coarse} filtered");
        }
    }

    #[test]
    fn filtering_keeps_the_mean() {
        let stripes = Field::Stripes { across: Coordinate::U, period_m: 3.0, width_m: 0.4, offset_m: 0.1 };
        assert_mean_kept(&stripes, 0.3, 1e-2);
        assert_mean_kept(&stripes, 7.7, 1e-2);
        let noise = Field::world_noise(5, 0.8, 3);
        assert_mean_kept(&noise, 6.0, 0.08);
        assert_mean_kept(&noise.clone().ramp(0.1, 0.3), 6.0, 0.12);
        assert_mean_kept(&Field::Cracks { space: Space::World, seed: 3, cell_m: 2.0, width_m: 0.1 }, 0.2, 0.12);
    }

    #[test]
    fn a_threshold_of_hidden_noise_has_the_colour_of_the_speckles() {
        // 0 everywhere at a footprint that swallows it; a bare threshold would say 0, the speckles cover some part.
        let f = Field::world_noise(5, 0.2, 2).ramp(0.1, 0.15).evaluate(&at(1.0, 1.0, 4.0), &[]);
        assert!(f.mean > 0.2 && f.mean < 0.5, "{}", f.mean);
    }

    #[test]
    fn cells_are_constant_inside() {
        let tiles = Field::Cells { space: Space::Uv, seed: 1, size_m: [0.3, 0.4, 0.0], stagger: 0.5 };
        let value = |x, y| tiles.evaluate(&at(x, y, 0.01), &[]).mean;
        assert_eq!(value(0.31, 0.01), value(0.59, 0.39));
        assert_ne!(value(0.29, 0.01), value(0.31, 0.01));
        assert_eq!(value(0.16, 0.41), value(0.44, 0.79));
    }
}
