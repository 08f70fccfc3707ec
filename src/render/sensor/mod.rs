//! From radiance to numbers, as an imager does it: optics, smear, detector noise, pan-sharpening, coding.
//!
//! A sensor's **signal** is radiance in units of [`Light::white_radiance`](super::Light): about the reflectance of what is
//! seen, plus the air's own light. Everything before the coding is in it.

mod coding;
mod noise;
mod optics;
mod sharpen;

pub use coding::{Coding, Exposure, Image, ImagePixels};
pub use noise::Noise;
pub use optics::{MAX_MTF, MIN_MTF, Optics};

pub(super) use coding::code;

use super::film::Radiance;
use super::light::{Light, Veil};
use rayon::prelude::*;
use satseed_scene::{Bands, SeedPath};
use sharpen::Sharpener;

/// Which bands a sensor delivers, in the order in which they stand in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BandSet {
    /// One panchromatic band, 450 to 800 nm.
    Pan,
    /// Red, green, blue.
    Rgb,
    /// Red, green, blue, near infrared.
    RgbNir,
}

impl BandSet {
    /// Values a pixel.
    pub fn count(self) -> usize {
        match self {
            Self::Pan => 1,
            Self::Rgb => 3,
            Self::RgbNir => 4,
        }
    }

    /// The scene's bands behind an image's bands; none for pan, which is made of all.
    fn order(self) -> &'static [usize] {
        match self {
            Self::Pan => &[],
            Self::Rgb => &[2, 1, 0],
            Self::RgbNir => &[2, 1, 0, 3],
        }
    }
}

/// How colour comes to the resolution of the panchromatic band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanSharpening {
    /// Pixels of the panchromatic band along the side of a colour pixel, 2..=8.
    pub ratio: u32,
    /// How far the colour bands lie beside the panchromatic one, px of the latter, -2..2: red by so much along a row, blue
    /// by as much the other way.
    pub offset_px: f64,
}

/// An imager, by its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// What it delivers.
    pub bands: BandSet,
    /// Blur.
    pub optics: Optics,
    /// What the detectors add.
    pub noise: Noise,
    /// Colour from coarser bands; none where each band has the full resolution. Not for a panchromatic image.
    pub sharpening: Option<PanSharpening>,
    /// What numbers it delivers.
    pub coding: Coding,
}

impl Sensor {
    /// The pixel's box alone: no optics, no noise; stretched to 8 bits.
    pub const IDEAL: Self = Self {
        bands: BandSet::Rgb,
        optics: Optics { mtf_at_nyquist: None, smear_px: 0.0 },
        noise: Noise::NONE,
        sharpening: None,
        coding: Coding::WORLDVIEW3_8_BIT,
    };

    /// Like `WorldView`-3's pan-sharpened colour as delivered to the eye: MTF 0.15 at Nyquist, colour four times coarser,
    /// 11 bits stretched to 8.
    pub const WORLDVIEW3_RGB: Self = Self {
        bands: BandSet::Rgb,
        optics: Optics { mtf_at_nyquist: Some(0.15), smear_px: 0.4 },
        noise: Noise { snr: Some(150.0), read: 0.000_5, column_gain: 0.003 },
        sharpening: Some(PanSharpening { ratio: 4, offset_px: 0.2 }),
        coding: Coding::WORLDVIEW3_8_BIT,
    };

    /// Like GF-7's panchromatic stereo cameras: one band, a softer image, 11-bit counts as they come.
    pub const GF7_PAN: Self = Self {
        bands: BandSet::Pan,
        optics: Optics { mtf_at_nyquist: Some(0.12), smear_px: 0.5 },
        noise: Noise { snr: Some(100.0), read: 0.000_8, column_gain: 0.004 },
        sharpening: None,
        coding: Coding::Counts,
    };

    /// Radiance at the sensor as it is, W / (m^2 sr um): the pixel's box alone, no noise, 32-bit floats.
    pub const LINEAR: Self = Self { coding: Coding::Radiance, ..Self::IDEAL };

    /// The same imager with what a screen shows: 8 bits, stretched, no infrared.
    #[must_use]
    pub fn for_the_eye(self) -> Self {
        let bands = if self.bands == BandSet::RgbNir { BandSet::Rgb } else { self.bands };
        let coding = match self.coding {
            stretched @ Coding::Stretched { .. } => stretched,
            _ => Coding::WORLDVIEW3_8_BIT,
        };
        Self { bands, coding, ..self }
    }

    /// What a view's exposed radiance becomes before the coding. `noise` is a path of its own for each image.
    pub(super) fn record(&self, ground: &Radiance, light: &Light, veil: Veil, noise: &SeedPath) -> Exposure {
        let width = ground.width as usize;
        let signal = self.signal(ground, light, veil, noise);
        let count = self.bands.count();
        let data = match self.coding {
            Coding::Radiance => {
                let unit = self.unit(light);
                let mut scaled = signal;
                scaled.par_chunks_mut(width * count).for_each(|row| {
                    for (i, s) in row.iter_mut().enumerate() {
                        *s *= unit[i % count];
                    }
                });
                ImagePixels::Radiance(scaled)
            }
            Coding::Counts | Coding::Stretched { .. } => {
                ImagePixels::Counts(signal.par_iter().map(|s| coding::count_of(*s)).collect())
            }
        };
        Exposure(Image { width: ground.width, height: ground.height, channels: count, pixels: data })
    }

    /// Radiance of signal 1 in each of the image's bands.
    fn unit(&self, light: &Light) -> Vec<f32> {
        match self.bands {
            BandSet::Pan => vec![sharpen::pan_of(light.white_radiance)],
            other => other.order().iter().map(|b| light.white_radiance[*b]).collect(),
        }
    }

    /// The signal with its noise, band by band within a pixel.
    fn signal(&self, ground: &Radiance, light: &Light, veil: Veil, noise: &SeedPath) -> Vec<f32> {
        let width = ground.width as usize;
        // One multiplication and one sum take the ground's radiance through the air into units of white.
        let gain = Bands(core::array::from_fn(|b| veil.direct[b] / light.white_radiance[b]));
        let added = Bands(core::array::from_fn(|b| veil.added[b] / light.white_radiance[b]));
        let at_sensor = |ground: Bands| ground * gain + added;
        let detector = |band: usize, width: usize| self.noise.detector(noise, band, width);
        match (self.bands, self.sharpening) {
            (BandSet::Pan, _) => {
                // The panchromatic unit is the mean of the bands' radiances, not of their signals.
                let share = sharpen::pan_shares(light.white_radiance);
                let pan = detector(4, width);
                let value =
                    |(i, g): (usize, &Bands)| pan.read(i % width, i / width, sharpen::weighted(at_sensor(*g), share));
                ground.data.par_iter().enumerate().map(value).collect()
            }
            (bands, None) => {
                let detectors: Vec<_> = bands.order().iter().map(|b| (*b, detector(*b, width))).collect();
                let mut out = vec![0.0; ground.data.len() * detectors.len()];
                let pixels = out.par_chunks_mut(detectors.len()).zip(&ground.data);
                pixels.enumerate().for_each(|(i, (pixel, g))| {
                    let signal = at_sensor(*g);
                    for (value, (b, detector)) in pixel.iter_mut().zip(&detectors) {
                        *value = detector.read(i % width, i / width, signal[*b]);
                    }
                });
                out
            }
            (bands, Some(how)) => {
                let colour_width = width.div_ceil(how.ratio as usize);
                let sharpener = Sharpener {
                    how,
                    optics: self.optics,
                    haze: added,
                    share: sharpen::pan_shares(light.white_radiance),
                    pan: detector(4, width),
                    colours: core::array::from_fn(|b| detector(b, colour_width)),
                };
                sharpener.run(ground, &at_sensor, bands.order())
            }
        }
    }
}
