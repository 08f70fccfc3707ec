//! Colour from coarse bands, detail from the panchromatic one, by ratios of what comes from the ground (Brovey with the haze
//! taken off first: Lolli et al., IEEE GRSL 14(12), 2017): what gives real crops their bleeding colours.
//!
//! Ratios of all light, haze included, would scale the haze by the detail. Haze is mostly blue: beside every shadow's edge
//! blue would fall below any dark object's, a stretch would begin there, and all shade would come out navy.

use super::PanSharpening;
use super::noise::Detector;
use super::optics::{Kernel, Optics};
use crate::render::film::Radiance;
use rayon::prelude::*;
use satseed_scene::Bands;

/// How much of each band a panchromatic detector sees: 450 to 800 nm.
const PAN_RESPONSE: [f32; 4] = [0.22, 0.30, 0.33, 0.15];
/// Where the ground gives less than this, colours are mostly noise: detail then adds to all bands alike.
const DARK: f32 = 0.01;

/// The panchromatic value of four bands of radiance.
pub(super) fn pan_of(radiance: Bands) -> f32 {
    weighted(radiance, PAN_RESPONSE)
}

/// What each band's signal adds to the panchromatic signal, where a signal of 1 is a radiance of `white`: sum 1.
pub(super) fn pan_shares(white: Bands) -> [f32; 4] {
    let all = pan_of(white);
    core::array::from_fn(|b| PAN_RESPONSE[b] * white[b] / all)
}

#[inline]
pub(super) fn weighted(bands: Bands, weights: [f32; 4]) -> f32 {
    bands[0] * weights[0] + bands[1] * weights[1] + bands[2] * weights[2] + bands[3] * weights[3]
}

/// What sharpens: a line of panchromatic detectors and coarser lines of colour beside it.
pub(super) struct Sharpener {
    /// How much coarser, and where.
    pub how: PanSharpening,
    /// The blur of the panchromatic band.
    pub optics: Optics,
    /// The signal that does not come from the ground before the pixel.
    pub haze: Bands,
    /// What each band adds to the panchromatic signal, [`pan_shares`].
    pub share: [f32; 4],
    /// The panchromatic detectors.
    pub pan: Detector,
    /// Those of the scene's bands, as wide as the coarse image.
    pub colours: [Detector; 4],
}

impl Sharpener {
    /// The bands of `order` at full resolution, from exposed radiance and what the air and the unit of signals make of it.
    pub(super) fn run(
        &self,
        ground: &Radiance,
        at_sensor: &(impl Fn(Bands) -> Bands + Sync),
        order: &[usize],
    ) -> Vec<f32> {
        let (width, height) = (ground.width as usize, ground.height as usize);
        let coarse = Coarse::new(ground, at_sensor, self.how.ratio, self.optics, &self.colours);
        // Red lies a little to one side, blue to the other.
        let PanSharpening { ratio, offset_px } = self.how;
        let across = [-offset_px, 0.0, offset_px, 0.0].map(|offset| Taps::line(width, ratio, offset, coarse.width));
        let down = Taps::line(height, ratio, 0.0, coarse.height);
        let haze_pan = weighted(self.haze, self.share);
        let mut out = vec![0.0; width * height * order.len()];
        out.par_chunks_mut(width * order.len()).enumerate().for_each(|(v, row)| {
            let middle: Vec<Bands> =
                (0..coarse.width).map(|i| down[v].sum(|j| coarse.data[j * coarse.width + i])).collect();
            let pixels = row.chunks_exact_mut(order.len()).zip(&ground.data[v * width..]);
            for (u, (pixel, radiance)) in pixels.enumerate() {
                let detail = self.pan.read(u, v, weighted(at_sensor(*radiance), self.share));
                let colour = Bands(core::array::from_fn(|b| across[b][u].sum_band(&middle, b)));
                let coarse_pan = weighted(colour, self.share);
                let per_ground = (detail - coarse_pan) / ((coarse_pan - haze_pan).max(0.0) + DARK);
                for (value, b) in pixel.iter_mut().zip(order) {
                    *value = colour[*b] + per_ground * ((colour[*b] - self.haze[*b]).max(0.0) + DARK);
                }
            }
        });
        out
    }
}

/// The colour bands as their own coarse detectors record them.
struct Coarse {
    width: usize,
    height: usize,
    data: Vec<Bands>,
}

impl Coarse {
    /// Blurs on to the coarse pixels' own point spread, as many times wider as the pixels are, and decimates. What lies
    /// beyond the frame counts as little as if the detectors ended there.
    fn new(
        ground: &Radiance,
        at_sensor: &(impl Fn(Bands) -> Bands + Sync),
        ratio: u32,
        optics: Optics,
        colours: &[Detector; 4],
    ) -> Self {
        let (width, height) = (ground.width as usize, ground.height as usize);
        let (coarse_width, coarse_height) = (width.div_ceil(ratio as usize), height.div_ceil(ratio as usize));
        // The radiance has the fine pixels' spread already.
        let sigma = optics.sigma_px() * f64::from(ratio * ratio - 1).sqrt();
        let kernel = Kernel::new(sigma, 0.0, ratio);
        let lines = |line: usize, count: usize| {
            let first = (line * ratio as usize) as i32 - kernel.reach;
            let inside = |k: i32| (0..count as i32).contains(&(first + k));
            let known: f32 = (0..).zip(&kernel.weights).filter(|(k, _)| inside(*k)).map(|(_, w)| *w).sum();
            let (kernel, scale) = (&kernel, 1.0 / known);
            (0..)
                .zip(&kernel.weights)
                .filter(move |(k, _)| inside(*k))
                .map(move |(k, w)| ((first + k) as usize, *w * scale))
                .collect::<Vec<_>>()
        };
        let across: Vec<Vec<(usize, f32)>> = (0..coarse_width).map(|i| lines(i, width)).collect();
        let rows: Vec<Vec<Bands>> = ground
            .data
            .par_chunks(width)
            .map(|row| {
                let row: Vec<Bands> = row.iter().map(|g| at_sensor(*g)).collect();
                across.iter().map(|taps| taps.iter().fold(Bands::ZERO, |sum, (u, w)| sum + row[*u] * *w)).collect()
            })
            .collect();
        let data: Vec<Vec<Bands>> = (0..coarse_height)
            .into_par_iter()
            .map(|j| {
                let taps = lines(j, height);
                (0..coarse_width)
                    .map(|i| {
                        let signal = taps.iter().fold(Bands::ZERO, |sum, (v, w)| sum + rows[*v][i] * *w);
                        Bands(core::array::from_fn(|b| colours[b].read(i, j, signal[b]).max(0.0)))
                    })
                    .collect()
            })
            .collect();
        Self { width: coarse_width, height: coarse_height, data: data.concat() }
    }
}

/// Where a fine pixel reads a coarse line: a cubic through four coarse pixels (Catmull and Rom 1974).
#[derive(Clone, Copy, Debug)]
struct Taps {
    at: [u32; 4],
    weights: [f32; 4],
}

impl Taps {
    /// The taps of a line of fine pixels; beyond its ends the coarse line stays what it is there.
    fn line(fine: usize, ratio: u32, offset_px: f64, coarse: usize) -> Vec<Self> {
        (0..fine)
            .map(|u| {
                let x = (u as f64 + 0.5 + offset_px) / f64::from(ratio) - 0.5;
                let first = libm::floor(x);
                let t = (x - first) as f32;
                let at = core::array::from_fn(|k| (first as i32 - 1 + k as i32).clamp(0, coarse as i32 - 1) as u32);
                let (t2, t3) = (t * t, t * t * t);
                let weights = [
                    0.5 * (2.0 * t2 - t - t3),
                    0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
                    0.5 * (t + 4.0 * t2 - 3.0 * t3),
                    0.5 * (t3 - t2),
                ];
                Self { at, weights }
            })
            .collect()
    }

    fn sum(&self, value: impl Fn(usize) -> Bands) -> Bands {
        (0..4).fold(Bands::ZERO, |sum, k| sum + value(self.at[k] as usize) * self.weights[k])
    }

    #[inline]
    fn sum_band(&self, line: &[Bands], band: usize) -> f32 {
        (0..4).fold(0.0, |sum, k| sum + line[self.at[k] as usize][band] * self.weights[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::sensor::Noise;
    use satseed_scene::SeedPath;

    fn quiet(width: usize) -> Detector {
        Noise::NONE.detector(&SeedPath::root("quiet", 1), 0, width)
    }

    fn run(ground: &Radiance, offset_px: f64) -> Vec<f32> {
        let optics = Optics { mtf_at_nyquist: Some(0.15), smear_px: 0.0 };
        let how = PanSharpening { ratio: 4, offset_px };
        let colours = core::array::from_fn(|_| quiet(ground.width as usize / 4 + 1));
        let pan = quiet(ground.width as usize);
        let sharpener = Sharpener { how, optics, haze: Bands::ZERO, share: pan_shares(Bands::ONE), pan, colours };
        sharpener.run(ground, &|g| g, &[2, 1, 0])
    }

    /// Blue haze over a grey edge: on the dark side no band comes out darker than it is, and the shade keeps its grey.
    #[test]
    fn haze_takes_no_part_in_ratios() {
        let haze = Bands::new(0.15, 0.08, 0.03, 0.02);
        let (dark, bright) = (0.02, 0.3);
        let ground = field(|u| Bands::grey(if u < 33 { dark } else { bright }));
        let optics = Optics { mtf_at_nyquist: Some(0.15), smear_px: 0.0 };
        let how = PanSharpening { ratio: 4, offset_px: 0.0 };
        let colours = core::array::from_fn(|_| quiet(ground.width as usize / 4 + 1));
        let pan = quiet(ground.width as usize);
        let sharpener = Sharpener { how, optics, haze, share: pan_shares(Bands::ONE), pan, colours };
        let out = sharpener.run(&ground, &|g| g + haze, &[2, 1, 0]);
        for u in 0..66 {
            for (c, band) in [2, 1, 0].into_iter().enumerate() {
                let found = out[(17 * 66 + u) * 3 + c] - haze[band];
                let expected = if u < 33 { dark } else { bright };
                assert!((found - expected).abs() < 1e-4, "{u}, band {band}: {found}, not {expected}");
            }
        }
    }

    fn field(colour: impl Fn(usize) -> Bands) -> Radiance {
        let (width, height) = (66, 35);
        Radiance { width, height, data: (0..width * height).map(|i| colour((i % width) as usize)).collect() }
    }

    #[test]
    fn an_even_field_keeps_its_colour_up_to_the_border() {
        let out = run(&field(|_| Bands::new(0.1, 0.2, 0.3, 0.4)), 0.2);
        for (i, value) in out.iter().enumerate() {
            let expected = [0.3, 0.2, 0.1][i % 3];
            assert!((value / expected - 1.0).abs() < 1e-5, "{i}: {value}");
        }
    }

    /// Across a grey edge the detail is sharp; across an edge of colour alone it bleeds over some four pixels.
    #[test]
    fn detail_is_sharp_and_colour_bleeds() {
        let grey = run(&field(|u| Bands::grey(if u < 33 { 0.1 } else { 0.4 })), 0.0);
        let row = |out: &[f32], u: usize| [0, 1, 2].map(|c| out[(17 * 66 + u) * 3 + c]);
        for (u, expected) in [(31, 0.1), (32, 0.1), (33, 0.4), (34, 0.4)] {
            assert!(row(&grey, u).iter().all(|v| (v / expected - 1.0).abs() < 1e-4), "{u}: {:?}", row(&grey, u));
        }
        // Red and blue of one panchromatic signal.
        let [blue, _, red, _] = pan_shares(Bands::ONE);
        let hue = run(
            &field(
                |u| if u < 33 { Bands::new(0.3 / blue, 0.0, 0.0, 0.0) } else { Bands::new(0.0, 0.0, 0.3 / red, 0.0) },
            ),
            0.0,
        );
        let purity = |u: usize| row(&hue, u)[0] * red / 0.3;
        assert!(purity(20) < 0.01 && purity(46) > 0.99, "{} {}", purity(20), purity(46));
        assert!((0.2..0.8).contains(&purity(33)), "{}", purity(33));
        assert!(purity(31) > 0.05 && purity(35) < 0.95, "{} {}", purity(31), purity(35));
    }

    /// The coarse pixels lie where the fine ones are: a linear ramp of colour stays in place, and the offset moves it.
    #[test]
    fn colour_lies_where_it_was() {
        let ramp = |offset_px| {
            let out = run(&field(|u| Bands::new(0.2, 0.2, 0.2 + 0.002 * u as f32, 0.2)), offset_px);
            let ratio = |u: usize| f64::from(out[(17 * 66 + u) * 3] / out[(17 * 66 + u) * 3 + 2]);
            (ratio(33) - 1.0) * 0.2 / 0.002
        };
        assert!((ramp(0.0) - 33.0).abs() < 0.02, "{}", ramp(0.0));
        assert!((ramp(0.5) - 33.5).abs() < 0.05, "{}", ramp(0.5));
    }
}
