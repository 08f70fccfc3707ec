//! A sample made small: images by means, labels by every k-th pixel, since labels have no means.

use crate::dataset::formats::{FormatError, Plane};
use image::codecs::jpeg::JpegEncoder;
use miniz_oxide::deflate::compress_to_vec_zlib;

/// Quality of the JPEGs.
const QUALITY: u8 = 88;
/// Of zlib; higher ones gain a percent.
const LEVEL: u8 = 7;
/// A disparity is held in so many steps a pixel.
const STEPS: f32 = 256.0;
/// Bits of a disparity's number, and the number of 0 px; 0 stands for none.
const BITS: u32 = 22;
const ZERO: i32 = 1 << (BITS - 1);

/// A small sample.
pub(super) struct Reduced {
    pub(super) every: u32,
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// JPEG.
    pub(super) left: Vec<u8>,
    /// JPEG.
    pub(super) right: Vec<u8>,
    /// Numbers as `page/data.js` reads them: differences, their bytes by significance, zlib.
    pub(super) labels: Vec<u8>,
}

/// Makes a sample small. Both images have the left one's size.
pub(super) fn reduced(
    images: &(Plane, Plane),
    disparity_px: &[f32],
    validity: &[u8],
    most_px: u32,
) -> Result<Reduced, FormatError> {
    let (width, height) = (images.0.width, images.0.height);
    let every = width.max(height).div_ceil(most_px).max(1);
    // As many as have the pixel in their middle within the frame.
    let across = |pixels: u32| pixels.saturating_sub(every / 2).div_ceil(every).max(1);
    let (columns, rows) = (across(width), across(height));
    let middle = |i: u32, pixels: u32| (i * every + every / 2).min(pixels - 1) as usize;
    let codes: Vec<i32> = (0..rows * columns)
        .map(|i| {
            let at = middle(i / columns, height) * width as usize + middle(i % columns, width);
            code(disparity_px[at], validity[at])
        })
        .collect();
    let small = |image: &Plane| jpeg(columns, rows, &means(image, every, columns, rows));
    Ok(Reduced {
        every,
        columns,
        rows,
        left: small(&images.0)?,
        right: small(&images.1)?,
        labels: zipped(&codes, columns as usize),
    })
}

/// Validity above the disparity's number.
fn code(disparity_px: f32, validity: u8) -> i32 {
    let number = if disparity_px.is_finite() {
        (libm::roundf(disparity_px * STEPS) as i32).saturating_add(ZERO).clamp(1, (1 << BITS) - 1)
    } else {
        0
    };
    number | (i32::from(validity & 3) << BITS)
}

/// Each number as the difference to the one before it in its row (the first: to the one above), sign in the lowest bit;
/// lowest bytes first, then the next, since alike bytes compress.
fn zipped(codes: &[i32], columns: usize) -> Vec<u8> {
    let before = |i: usize| match (i % columns, i) {
        (_, 0) => 0,
        (0, _) => codes[i - columns],
        _ => codes[i - 1],
    };
    let differences: Vec<u32> = (0..codes.len())
        .map(|i| {
            let d = codes[i] - before(i);
            ((d << 1) ^ (d >> 31)) as u32
        })
        .collect();
    let planes: Vec<u8> = (0..4).flat_map(|byte| differences.iter().map(move |d| (d >> (8 * byte)) as u8)).collect();
    compress_to_vec_zlib(&planes, LEVEL)
}

/// Means over squares of `every` pixels, those at the border over what there is of them.
fn means(image: &Plane, every: u32, columns: u32, rows: u32) -> Vec<u8> {
    let rgb = image.to_rgb8();
    if every == 1 {
        return rgb;
    }
    let mut out = Vec::with_capacity(3 * (columns * rows) as usize);
    for row in 0..rows {
        for column in 0..columns {
            let span = |i: u32, pixels: u32| i * every..((i + 1) * every).min(pixels);
            let (us, vs) = (span(column, image.width), span(row, image.height));
            let count = (us.len() * vs.len()) as u32;
            let mut sum = [0_u32; 3];
            for v in vs {
                let start = 3 * (v * image.width + us.start) as usize;
                for pixel in rgb[start..start + 3 * us.len()].chunks_exact(3) {
                    sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += u32::from(*p));
                }
            }
            out.extend(sum.map(|s| ((s + count / 2) / count) as u8));
        }
    }
    out
}

fn jpeg(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|e| FormatError::Encode(e.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::formats::Pixels;
    use miniz_oxide::inflate::decompress_to_vec_zlib;

    /// What `page/data.js` does.
    fn unzipped(bytes: &[u8], columns: usize) -> Vec<i32> {
        let planes = decompress_to_vec_zlib(bytes).unwrap();
        let count = planes.len() / 4;
        let mut codes: Vec<i32> = Vec::new();
        for i in 0..count {
            let d = (0..4).fold(0_u32, |d, byte| d | (u32::from(planes[byte * count + i]) << (8 * byte)));
            let before = match (i % columns, i) {
                (_, 0) => 0,
                (0, _) => codes[i - columns],
                _ => codes[i - 1],
            };
            codes.push(before + ((d >> 1) as i32 ^ -((d & 1) as i32)));
        }
        codes
    }

    #[test]
    fn labels_are_those_of_the_pixels_in_the_middle() {
        let (width, height) = (25_u32, 13_u32);
        let at = |u: u32, v: u32| (v * width + u) as usize;
        let mut disparity: Vec<f32> = (0..width * height).map(|i| i as f32 * 0.377 - 40.0).collect();
        let mut validity = vec![1_u8; disparity.len()];
        disparity[at(7, 4)] = f32::NAN;
        validity[at(7, 4)] = 0;
        (disparity[at(12, 4)], validity[at(12, 4)]) = (-9000.0, 3);
        let image = || Plane { width, height, pixels: Pixels::Gray((0..width * height).map(|i| i as u8).collect()) };
        let r = reduced(&(image(), image()), &disparity, &validity, 5).unwrap();
        // Middles at 2, 7, ... 22 and at 2, 7, 12.
        assert_eq!((r.every, r.columns, r.rows), (5, 5, 3));
        let codes = unzipped(&r.labels, 5);
        for (i, code) in codes.iter().enumerate() {
            let (u, v) = (i as u32 % 5 * 5 + 2, i as u32 / 5 * 5 + 2);
            let (number, seen) = (code & ((1 << BITS) - 1), code >> BITS);
            assert_eq!(seen, i32::from(validity[at(u, v)]));
            let d = disparity[at(u, v)];
            if d.is_finite() {
                let told = (number - ZERO) as f32 / STEPS;
                assert!((told - d.max(-8192.0)).abs() <= 0.5 / STEPS + 1e-3 * f32::from(d < -8192.0), "{told} {d}");
            } else {
                assert_eq!(number, 0);
            }
        }
    }

    #[test]
    fn pictures_are_means() {
        let pixels = vec![10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 121];
        let image = Plane { width: 4, height: 3, pixels: Pixels::Gray(pixels) };
        assert_eq!(means(&image, 2, 2, 2), [35, 35, 35, 55, 55, 55, 95, 95, 95, 116, 116, 116]);
    }
}
