//! From a signal to the numbers of a file.

use rayon::prelude::*;

/// Highest 11-bit count.
const LAST_COUNT: u16 = 2047;
/// Narrowest stretch, counts: an even field is not blown up to noise.
const LEAST_RANGE: u16 = 32;

/// How much of the haze, by which a visible band's dark end lies above the clearest band's, a stretch leaves in the image,
/// percent. Delivered images keep some: with this much, shade has the ratios of red, green and blue that the darkest pixels of
/// real 8-bit WorldView-3 crops have, about 1 : 1.3 : 1.8.
const HAZE_LEFT_PERCENT: u32 = 15;

/// What numbers a sensor delivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coding {
    /// 8 bits, stretched between two percentiles of all views of a pair together and bent by a tone curve. Each band
    /// begins near its own low percentile, since air is brighter in blue, and a little of that haze stays; one range serves all
    /// visible bands, so that colours stay what they are.
    Stretched {
        /// Share of the pixels at or below code 0, percent, 0..=20.
        low_percent: f64,
        /// Share of the pixels below code 255 in the band with the widest range, percent, 80..=100.
        high_percent: f64,
        /// Exponent of the tone curve, 0.2..=1.
        gamma: f64,
    },
    /// 11 bits in 16, the same for every scene and sun: 2047 is a signal of 1.
    Counts,
    /// 32-bit floats, radiance, W / (m^2 sr um).
    Radiance,
}

impl Coding {
    /// As delivered to the eye.
    pub const WORLDVIEW3_8_BIT: Self = Self::Stretched { low_percent: 0.3, high_percent: 99.6, gamma: 0.5 };
}

/// The numbers of an image, row by row from the top, the bands of a pixel side by side.
#[derive(Clone, Debug, PartialEq)]
pub enum ImagePixels {
    /// 8 bits.
    Bytes(Vec<u8>),
    /// 11-bit counts, 0..=2047.
    Counts(Vec<u16>),
    /// Radiance, W / (m^2 sr um).
    Radiance(Vec<f32>),
}

/// What a sensor delivers of one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Values a pixel: 1 panchromatic; 3 red, green, blue; 4 with near infrared.
    pub channels: usize,
    /// `width * height * channels` values.
    pub pixels: ImagePixels,
}

impl Image {
    /// Its values where they are bytes, else nothing.
    pub fn bytes(&self) -> &[u8] {
        if let ImagePixels::Bytes(values) = &self.pixels { values } else { &[] }
    }
}

/// What the detectors recorded of one view: all that happens to it by itself. The views of a pair are coded together.
#[derive(Clone, Debug)]
pub struct Exposure(pub(super) Image);

/// The count of a signal.
#[inline]
pub(super) fn count_of(signal: f32) -> u16 {
    (signal * f32::from(LAST_COUNT) + 0.5).clamp(0.0, f32::from(LAST_COUNT)) as u16
}

/// Codes views together. Those of a pair share one stretch, so that equal signals are equal numbers.
pub(in crate::render) fn code(exposures: Vec<Exposure>, coding: Coding) -> Vec<Image> {
    let Coding::Stretched { low_percent, high_percent, gamma } = coding else {
        return exposures.into_iter().map(|e| e.0).collect();
    };
    let channels = exposures.iter().map(|e| e.0.channels).max().unwrap_or(0);
    let histograms = histograms(&exposures, channels);
    let mut ends: Vec<[u16; 2]> =
        histograms.iter().map(|h| [percentile(h, low_percent), percentile(h, high_percent)]).collect();
    let clearest = ends.iter().take(3).map(|[low, _]| *low).min().unwrap_or(0);
    for [low, _] in ends.iter_mut().take(3) {
        *low -= ((u32::from(*low - clearest) * HAZE_LEFT_PERCENT + 50) / 100) as u16;
    }
    let range = |[low, high]: &[u16; 2]| high.saturating_sub(*low).max(LEAST_RANGE);
    let visible = ends.iter().take(3).map(range).max().unwrap_or(LEAST_RANGE);
    let tables: Vec<Vec<u8>> = ends
        .iter()
        .enumerate()
        .map(|(band, ends)| table(ends[0], if band < 3 { visible } else { range(ends) }, gamma))
        .collect();
    exposures
        .into_iter()
        .map(|Exposure(image)| {
            let code = |(i, count): (usize, &u16)| tables[i % image.channels][usize::from(*count)];
            let bytes = counts(&image).par_iter().enumerate().map(code).collect();
            Image { pixels: ImagePixels::Bytes(bytes), ..image }
        })
        .collect()
}

/// How often each count stands in each band of all views. Whole numbers: parts may be added in any order.
fn histograms(exposures: &[Exposure], channels: usize) -> Vec<Vec<u64>> {
    /// Pixels that one task counts.
    const PART: usize = 1 << 18;
    let empty = || vec![vec![0_u64; usize::from(LAST_COUNT) + 1]; channels];
    let of_part = |part: &[u16]| {
        let mut histograms = empty();
        for pixel in part.chunks_exact(channels) {
            for (histogram, count) in histograms.iter_mut().zip(pixel) {
                histogram[usize::from(*count)] += 1;
            }
        }
        histograms
    };
    let add = |mut sum: Vec<Vec<u64>>, part: Vec<Vec<u64>>| {
        for (sum, n) in sum.iter_mut().flatten().zip(part.iter().flatten()) {
            *sum += n;
        }
        sum
    };
    let views = exposures.par_iter().flat_map(|Exposure(image)| counts(image).par_chunks(PART * channels.max(1)));
    views.map(of_part).reduce(empty, add)
}

fn counts(image: &Image) -> &[u16] {
    if let ImagePixels::Counts(values) = &image.pixels { values } else { &[] }
}

/// The lowest count that at least a share of the pixels does not exceed.
fn percentile(histogram: &[u64], percent: f64) -> u16 {
    let total: u64 = histogram.iter().sum();
    let wanted = total as f64 * percent / 100.0;
    let mut below = 0;
    for (count, n) in histogram.iter().enumerate() {
        below += n;
        if below as f64 >= wanted && below > 0 {
            return count as u16;
        }
    }
    LAST_COUNT
}

/// The code of every count.
fn table(low: u16, range: u16, gamma: f64) -> Vec<u8> {
    let code = |count: u16| {
        let share = (f64::from(count) - f64::from(low)) / f64::from(range);
        (libm::pow(share.clamp(0.0, 1.0), gamma) * 255.0 + 0.5) as u8
    };
    (0..=LAST_COUNT).map(code).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exposure(counts: Vec<u16>) -> Exposure {
        let (width, height) = (counts.len() as u32 / 3, 1);
        Exposure(Image { width, height, channels: 3, pixels: ImagePixels::Counts(counts) })
    }

    #[test]
    fn equal_counts_of_a_pair_are_equal_codes() {
        let (dark, bright): (Vec<u16>, Vec<u16>) = ((0..3000).collect(), (0..3000).map(|i| 700 + i / 3).collect());
        let dark: Vec<u16> = dark.into_iter().map(|i: u16| 100 + i / 5).collect();
        let coding = Coding::Stretched { low_percent: 1.0, high_percent: 99.0, gamma: 0.5 };
        let both = code(vec![exposure(dark.clone()), exposure(bright.clone())], coding);
        let alone = code(vec![exposure(dark.clone())], coding);
        assert_ne!(both[0], alone[0], "the other view moves the stretch");
        let find = |counts: &[u16], count: u16| counts.iter().step_by(3).position(|c| *c == count).unwrap() * 3;
        let (a, b) = (find(&dark, 699), find(&bright, 700));
        assert!(both[1].bytes()[b].abs_diff(both[0].bytes()[a]) <= 1);
        let clipped = both.iter().flat_map(Image::bytes).filter(|b| **b == 0 || **b == 255).count();
        assert!(clipped < 6000 * 3 / 100, "{clipped}");
    }

    #[test]
    fn an_even_field_stays_even() {
        let coding = Coding::WORLDVIEW3_8_BIT;
        let noisy: Vec<u16> = (0..3000).map(|i| 500 + i % 3).collect();
        let image = &code(vec![exposure(noisy)], coding)[0];
        let (low, high) = image.bytes().iter().fold((255, 0), |(l, h), b| (*b.min(&l), *b.max(&h)));
        assert!(high - low < 80, "{low}..{high}");
    }

    #[test]
    fn counts_end_where_eleven_bits_end() {
        assert_eq!([count_of(-1.0), count_of(0.5), count_of(1.0), count_of(7.0)], [0, 1024, 2047, 2047]);
        assert_eq!(count_of(f32::NAN), 0);
    }
}
