//! Encodings that only other people's layouts have: PFM, 16-bit PNG, JPEG.

use crate::dataset::formats::{FormatError, Pixels, Plane};
use image::codecs::jpeg::JpegEncoder;

/// An 8-bit picture of three channels.
pub(super) fn rgb(image: &Plane) -> Result<Vec<u8>, FormatError> {
    Plane { width: image.width, height: image.height, pixels: Pixels::Rgb(image.to_rgb8()) }.encode()
}

/// An 8-bit picture of one channel.
pub(super) fn gray(width: u32, height: u32, values: Vec<u8>) -> Result<Vec<u8>, FormatError> {
    Plane { width, height, pixels: Pixels::Gray(values) }.encode()
}

/// 32-bit floats as TIFF.
pub(super) fn float_tiff(width: u32, height: u32, values: Vec<f32>) -> Result<Vec<u8>, FormatError> {
    Plane { width, height, pixels: Pixels::Float(values) }.encode()
}

/// PFM of one channel: little-endian, rows from the bottom up.
pub(super) fn pfm(width: u32, height: u32, values: &[f32]) -> Vec<u8> {
    let mut bytes = format!("Pf\n{width} {height}\n-1.0\n").into_bytes();
    bytes.reserve(values.len() * 4);
    for row in values.chunks_exact(width as usize).rev() {
        bytes.extend(row.iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes
}

/// A 16-bit PNG of one channel.
pub(super) fn png16(width: u32, height: u32, values: &[u16]) -> Result<Vec<u8>, FormatError> {
    let failed = |e: png::EncodingError| FormatError::Encode(e.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_deflate_compression(png::DeflateCompression::Level(6));
    encoder.set_filter(png::Filter::Up);
    let mut writer = encoder.write_header().map_err(failed)?;
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
    writer.write_image_data(&data).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

/// A JPEG of high quality.
pub(super) fn jpeg(image: &Plane) -> Result<Vec<u8>, FormatError> {
    const QUALITY: u8 = 97;
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(&image.to_rgb8(), image.width, image.height, image::ExtendedColorType::Rgb8)
        .map_err(|e| FormatError::Encode(e.to_string()))?;
    Ok(bytes)
}
