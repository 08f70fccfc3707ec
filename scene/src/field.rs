//! Scalar texture fields: data, and the one evaluator that knows what they mean.
//!
//! Every primitive returns its mean over the footprint and the variance that the footprint swallowed. A threshold
//! ([`Field::Ramp`]) widens by that deviation, so that a far view of a speckled surface has the colour of the speckles'
//! mean and not that of their mean height.

use crate::fractal::Fractal;
use crate::noise::{hash_cell, unit_from_hash};
use crate::raster::{CHANNELS, MaterialRaster};
use crate::texture_noise::{SLOPE_DEVIATION, floor, slope_2d};
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
    /// World east and north alone (third coordinate 0): vertical surfaces have vertical streaks.
    Plan,
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
    /// Fractal gradient noise: mean 0, range about -1..1.
    Noise(Fractal),
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
    /// A raster of the scene over world east and north, 0..1.
    Raster {
        /// Its index in the scene.
        raster: u32,
        /// Which of its channels.
        channel: u8,
    },
    /// Upward component of the unit normal: 1 flat, 0 vertical.
    Upward,
    /// Cosine of the normal with a unit direction.
    Facing([f32; 3]),
    /// One of the instance's four numbers, -1..1.
    Variation(u8),
    /// The inner field at a place shifted along the first two axes of all spaces, by the slope of a noise over the plan.
    Warped {
        /// The field.
        of: Box<Field>,
        /// Seed.
        seed: u32,
        /// Wavelength of the shift, m.
        wavelength_m: f32,
        /// About the greatest shift along an axis, m.
        amplitude_m: f32,
    },
    /// The inner field in a frame turned about the vertical: its first axis points along a unit direction of the plan.
    Turned {
        /// The field.
        of: Box<Field>,
        /// East and north part of its first axis.
        along: [f64; 2],
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

/// A field's mean over the footprint and the variance that the footprint hides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// Mean over the footprint.
    pub mean: f32,
    /// Variance within the footprint.
    pub variance: f32,
}

impl Filtered {
    const fn exact(mean: f32) -> Self {
        Self { mean, variance: 0.0 }
    }
}

/// A point under evaluation: what several fields of one material ask for is worked out once.
pub(crate) struct Look<'a> {
    pub(crate) point: &'a SurfacePoint,
    rasters: &'a [MaterialRaster],
    /// The raster looked at last, and its channels here.
    last: Option<u32>,
    channels: [f32; CHANNELS],
    /// The noise evaluated last, and its value here.
    last_noise: Option<(&'a Fractal, Filtered)>,
}

impl<'a> Look<'a> {
    pub(crate) fn new(point: &'a SurfacePoint, rasters: &'a [MaterialRaster]) -> Self {
        Self { point, rasters, last: None, channels: [0.0; CHANNELS], last_noise: None }
    }

    fn noise(&mut self, fractal: &'a Fractal) -> Filtered {
        match self.last_noise {
            Some((last, value)) if last.is(fractal) => value,
            _ => {
                let value = fractal.evaluate(self.point);
                self.last_noise = Some((fractal, value));
                value
            }
        }
    }

    fn raster(&mut self, raster: u32, channel: u8) -> f32 {
        if self.last != Some(raster) {
            let p = self.point;
            self.channels = self.rasters[raster as usize].sample(p.world_m.truncate(), p.footprint_m);
            self.last = Some(raster);
        }
        self.channels[channel as usize]
    }
}

impl Field {
    /// Fractal noise keyed by world position.
    pub fn world_noise(seed: u32, wavelength_m: f32, octaves: u8) -> Self {
        Self::Noise(Fractal::new(Space::World, seed, wavelength_m, octaves))
    }

    /// Fractal noise keyed by position in the object's frame.
    pub fn object_noise(seed: u32, wavelength_m: f32, octaves: u8) -> Self {
        Self::Noise(Fractal::new(Space::Object, seed, wavelength_m, octaves))
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
        self.at(&mut Look::new(p, rasters))
    }

    pub(crate) fn at<'a>(&'a self, look: &mut Look<'a>) -> Filtered {
        let p = look.point;
        match self {
            Self::Constant(value) => Filtered::exact(*value),
            Self::Along(c) => Filtered::exact(coordinate(p, *c) as f32),
            Self::Noise(fractal) => look.noise(fractal),
            Self::Cells { space, seed, size_m, stagger } => cells(p, *space, *seed, *size_m, *stagger),
            Self::Stripes { across, period_m, width_m, offset_m } => {
                stripes(coordinate(p, *across) - f64::from(*offset_m), *period_m, *width_m, p.footprint_m)
            }
            Self::Cracks { space, seed, cell_m, width_m } => cracks(p, *space, *seed, *cell_m, *width_m),
            Self::Raster { raster, channel } => Filtered::exact(look.raster(*raster, *channel)),
            Self::Upward => Filtered::exact(p.normal.z as f32),
            Self::Facing(d) => Filtered::exact(
                (p.normal.x * f64::from(d[0]) + p.normal.y * f64::from(d[1]) + p.normal.z * f64::from(d[2])) as f32,
            ),
            Self::Variation(i) => Filtered::exact(p.variation[*i as usize]),
            Self::Warped { of, seed, wavelength_m, amplitude_m } => {
                of.evaluate(&warped(p, *seed, *wavelength_m, *amplitude_m), look.rasters)
            }
            Self::Turned { of, along } => of.evaluate(&turned(p, *along), look.rasters),
            Self::Affine { of, by, plus } => {
                let f = of.at(look);
                Filtered { mean: f.mean * by + plus, variance: f.variance * by * by }
            }
            Self::Sum(fields) => {
                let mut sum = Filtered::exact(0.0);
                for field in fields {
                    let f = field.at(look);
                    sum.mean += f.mean;
                    sum.variance += f.variance;
                }
                sum
            }
            Self::Product(fields) => {
                let mut product = Filtered::exact(1.0);
                for field in fields {
                    if product.mean == 0.0 && product.variance == 0.0 {
                        break;
                    }
                    let f = field.at(look);
                    // Variance of a product of independent factors.
                    let variance = product.mean * product.mean * f.variance
                        + f.mean * f.mean * product.variance
                        + product.variance * f.variance;
                    product = Filtered { mean: product.mean * f.mean, variance };
                }
                product
            }
            Self::Max(fields) => {
                let mut largest = Filtered::exact(f32::MIN);
                for field in fields {
                    let f = field.at(look);
                    if f.mean > largest.mean {
                        largest = f;
                    }
                }
                largest
            }
            Self::Ramp { of, from, to } => ramp(of.at(look), *from, *to),
        }
    }

    /// Derivatives over the first two axes, 1/m, where they are known in closed form.
    pub(crate) fn slope(&self, p: &SurfacePoint) -> Option<[f64; 2]> {
        match self {
            Self::Noise(fractal) => fractal.slope(p),
            Self::Turned { of, along: [c, s] } => {
                of.slope(&turned(p, [*c, *s])).map(|[u, v]| [u * c - v * s, u * s + v * c])
            }
            _ => None,
        }
    }

    /// Whether a footprint hides all of the field's relief.
    pub(crate) fn is_hidden(&self, footprint_m: f64) -> bool {
        match self {
            Self::Noise(fractal) => fractal.is_hidden(footprint_m),
            Self::Turned { of, .. } => of.is_hidden(footprint_m),
            _ => false,
        }
    }
}

#[inline]
pub(crate) fn position(p: &SurfacePoint, space: Space) -> DVec3 {
    match space {
        Space::World => p.world_m,
        Space::Plan => DVec3::new(p.world_m.x, p.world_m.y, 0.0),
        Space::Object => p.object_m,
        Space::Uv => p.uv_m.extend(0.0),
    }
}

#[inline]
fn coordinate(p: &SurfacePoint, c: Coordinate) -> f64 {
    position(p, c.space)[c.axis as usize]
}

/// Variance of a uniform draw from -1..1.
const UNIFORM_VARIANCE: f32 = 1.0 / 3.0;

fn cells(p: &SurfacePoint, space: Space, seed: u32, size_m: [f32; 3], stagger: f32) -> Filtered {
    let smallest = size_m.iter().copied().filter(|s| *s > 0.0).fold(f32::MAX, f32::min);
    // Full contrast while a cell is twice the footprint, none when it is half of it.
    let keep = ((f64::from(smallest) / p.footprint_m - 0.5) / 1.5).clamp(0.0, 1.0) as f32;
    let variance = (1.0 - keep) * (1.0 - keep) * UNIFORM_VARIANCE;
    if keep == 0.0 {
        return Filtered { mean: 0.0, variance };
    }
    let q = position(p, space);
    let index = |axis: usize, shift: f64| {
        if size_m[axis] > 0.0 { floor(q[axis] / f64::from(size_m[axis]) + shift) } else { 0 }
    };
    let j = index(1, 0.0);
    let i = index(0, f64::from(stagger) * f64::from(j & 1));
    let value = unit_from_hash(hash_cell(i, j, index(2, 0.0), seed)) * 2.0 - 1.0;
    Filtered { mean: value * keep, variance }
}

/// Share of [x - w/2, x + w/2] that lies inside stripes [k * period, k * period + width].
fn stripes(x: f64, period_m: f32, width_m: f32, footprint_m: f64) -> Filtered {
    let (period, width) = (f64::from(period_m), f64::from(width_m));
    let covered = |t: f64| {
        let k = f64::from(floor(t / period));
        k * width + (t - k * period).min(width)
    };
    covering((covered(x + footprint_m / 2.0) - covered(x - footprint_m / 2.0)) / footprint_m)
}

/// What covers a share of the footprint, where it is 1, and 0 elsewhere.
fn covering(share: f64) -> Filtered {
    let mean = share.clamp(0.0, 1.0) as f32;
    Filtered { mean, variance: mean * (1.0 - mean) }
}

fn cracks(p: &SurfacePoint, space: Space, seed: u32, cell_m: f32, width_m: f32) -> Filtered {
    let w = p.footprint_m.max(1e-6);
    if w >= f64::from(cell_m) {
        // Points of density 1 have borders of length 2 in the unit square (Okabe et al., "Spatial Tessellations").
        return covering(2.0 * f64::from(width_m / cell_m));
    }
    let q = position(p, space);
    let size = f64::from(cell_m);
    let (x, y) = (q.x / size, q.y / size);
    let (ci, cj) = (floor(x), floor(y));
    let (fx, fy) = ((x - f64::from(ci)) as f32, (y - f64::from(cj)) as f32);
    // Squares of the two least distances to a point: every cell has one, anywhere in it.
    let (mut nearest, mut second) = (f32::MAX, f32::MAX);
    for dj in -1..=1_i8 {
        for di in -1..=1_i8 {
            let h = hash_cell(ci.wrapping_add(di.into()), cj.wrapping_add(dj.into()), 0, seed);
            let dx = f32::from(di) + (h >> 16) as f32 * (1.0 / 65536.0) - fx;
            let dy = f32::from(dj) + (h & 0xffff) as f32 * (1.0 / 65536.0) - fy;
            let d = dx * dx + dy * dy;
            second = second.min(d.max(nearest));
            nearest = nearest.min(d);
        }
    }
    // Half the difference of the two distances is about the distance to the border.
    let distance_m = f64::from(second.sqrt() - nearest.sqrt()) * 0.5 * size;
    let (half, reach) = (f64::from(width_m) / 2.0, w / 2.0);
    covering(((distance_m + reach).min(half) - (distance_m - reach).max(-half)) / w)
}

fn warped(p: &SurfacePoint, seed: u32, wavelength_m: f32, amplitude_m: f32) -> SurfacePoint {
    let k = 1.0 / f64::from(wavelength_m);
    // The greatest slope is about three deviations.
    let a = f64::from(amplitude_m / (3.0 * SLOPE_DEVIATION));
    let [x, y] = slope_2d(p.world_m.x * k, p.world_m.y * k, seed);
    let d = DVec2::new(f64::from(x), f64::from(y)) * a;
    let d3 = d.extend(0.0);
    SurfacePoint { world_m: p.world_m + d3, object_m: p.object_m + d3, uv_m: p.uv_m + d, ..*p }
}

/// The point as a frame turned about the vertical has it; the normal stays the world's.
fn turned(p: &SurfacePoint, [c, s]: [f64; 2]) -> SurfacePoint {
    let turn = |x: f64, y: f64| (x * c + y * s, y * c - x * s);
    let space = |v: DVec3| {
        let (x, y) = turn(v.x, v.y);
        DVec3::new(x, y, v.z)
    };
    let (u, v) = turn(p.uv_m.x, p.uv_m.y);
    SurfacePoint { world_m: space(p.world_m), object_m: space(p.object_m), uv_m: DVec2::new(u, v), ..*p }
}

/// The smoothstep's mean under a spread of the argument: its borders move out by the hidden deviation.
fn ramp(f: Filtered, from: f32, to: f32) -> Filtered {
    let (middle, half) = (f32::midpoint(from, to), (to - from) / 2.0);
    let smooth = |wide: f32| {
        let t = ((f.mean - middle) / wide * 0.5 + 0.5).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    if f.variance == 0.0 {
        return Filtered::exact(smooth(if half.abs() < 1e-9 { 1e-9 } else { half }));
    }
    let wide = (half * half + 3.0 * f.variance).sqrt();
    let mean = smooth(if half < 0.0 { -wide } else { wide });
    Filtered { mean, variance: (f.variance / (wide * wide)).min(1.0) * mean * (1.0 - mean) }
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
    fn a_turned_field_is_the_field_at_the_turned_place() {
        let along = [0.6, 0.8];
        let streaks = Field::Noise(Fractal::new(Space::World, 9, 2.0, 2).stretched([1.0, 6.0, 1.0]));
        let turned = Field::Turned { of: Box::new(streaks.clone()), along };
        for (x, y) in [(3.1, -7.7), (120.3, 55.0)] {
            // The place (u, v) of the turned frame is u along the direction and v to its left.
            let world = at(x * 0.6 - y * 0.8, x * 0.8 + y * 0.6, 0.1);
            let (a, b) = (turned.evaluate(&world, &[]).mean, streaks.evaluate(&at(x, y, 0.1), &[]).mean);
            assert!((a - b).abs() < 1e-5, "{a} {b}");
            let slope = turned.slope(&world).expect("known in closed form");
            let e = 1e-3;
            let value = |dx: f64, dy: f64| {
                f64::from(turned.evaluate(&at(world.world_m.x + dx, world.world_m.y + dy, 0.1), &[]).mean)
            };
            let differences =
                [(value(e, 0.0) - value(-e, 0.0)) / (2.0 * e), (value(0.0, e) - value(0.0, -e)) / (2.0 * e)];
            for k in 0..2 {
                assert!((slope[k] - differences[k]).abs() < 0.02, "{slope:?} for {differences:?}");
            }
        }
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
