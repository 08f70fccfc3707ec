//! Four spectral bands, the unit of colour everywhere inside satseed.

use core::ops::{Add, AddAssign, Index, Mul};

/// Values in the blue (480 nm), green (545 nm), red (660 nm) and near-infrared (830 nm) band, in this order.
///
/// What the values are (reflectance 0..1, irradiance, radiance) is said where they stand.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Bands(pub [f32; 4]);

impl Bands {
    /// Zero in every band.
    pub const ZERO: Self = Self([0.0; 4]);
    /// One in every band.
    pub const ONE: Self = Self([1.0; 4]);

    /// Blue, green, red, near infrared.
    pub const fn new(blue: f32, green: f32, red: f32, nir: f32) -> Self {
        Self([blue, green, red, nir])
    }

    /// The same value in every band.
    pub const fn grey(value: f32) -> Self {
        Self([value; 4])
    }

    /// `self` where `t` is 0, `other` where it is 1, straight between.
    #[inline]
    #[must_use]
    pub fn lerp(self, other: Self, t: f32) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + (other.0[i] - self.0[i]) * t))
    }

    /// Every band through `f`.
    #[inline]
    #[must_use]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    /// The largest band.
    pub fn max_band(self) -> f32 {
        self.0.iter().copied().fold(f32::MIN, f32::max)
    }
}

impl Add for Bands {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] + o.0[i]))
    }
}
impl AddAssign for Bands {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl Mul for Bands {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] * o.0[i]))
    }
}
impl Mul<f32> for Bands {
    type Output = Self;
    #[inline]
    fn mul(self, k: f32) -> Self {
        Self(self.0.map(|v| v * k))
    }
}
impl Index<usize> for Bands {
    type Output = f32;
    fn index(&self, i: usize) -> &f32 {
        &self.0[i]
    }
}
