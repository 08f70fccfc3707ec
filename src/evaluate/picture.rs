//! Images of other datasets: PNG or TIFF, of 8 or 16 bits, grey or colour.

use super::prediction::{MAX_SIDE_PX, PredictionError, Size, content_at_most};
use crate::dataset::formats::decoded_bytes_at_most;
use std::io::Cursor;
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// Most bytes of an image's file: 16,384 x 16,384 pixels of four 16-bit channels.
const MAX_BYTES: u64 = 1 << 31;

/// Reads an image as RGB of 8 bits, a grey one as three equal channels. 16-bit TIFF is brought down so that its highest value
/// is 255: such sensors use 10 to 12 of the bits.
pub(super) fn read_rgb(path: &Path) -> Result<(Vec<u8>, Size), PredictionError> {
    let bytes = content_at_most(path, MAX_BYTES)?;
    let (values, channels, size) =
        if path.extension().is_some_and(|e| e == "png") { from_png(&bytes)? } else { from_tiff(&bytes)? };
    if values.len() != size.pixels() * channels {
        return Err(PredictionError::new("it does not hold the pixels that it claims"));
    }
    let rgb = values.chunks_exact(channels).flat_map(|p| if channels < 3 { [p[0]; 3] } else { [p[0], p[1], p[2]] });
    Ok((rgb.collect(), size))
}

fn size_of(width: u32, height: u32, file_bytes: usize) -> Result<Size, PredictionError> {
    let size = Size { width, height };
    if [width, height].iter().all(|n| (1..=MAX_SIDE_PX).contains(n)) {
        if size.pixels() as u64 > decoded_bytes_at_most(file_bytes) {
            return Err(PredictionError::new(format!("{file_bytes} bytes cannot hold {width} x {height} pixels")));
        }
        return Ok(size);
    }
    Err(PredictionError::new(format!("it is {width} x {height} pixels, but a side has 1 to {MAX_SIDE_PX}")))
}

fn from_png(bytes: &[u8]) -> Result<(Vec<u8>, usize, Size), PredictionError> {
    let failed = |e: png::DecodingError| PredictionError::decoding(&e);
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(failed)?;
    let size = size_of(reader.info().width, reader.info().height, bytes.len())?;
    let channels = reader.output_color_type().0.samples();
    let mut values = vec![0; size.pixels() * channels];
    reader.next_frame(&mut values).map_err(failed)?;
    Ok((values, channels, size))
}

fn from_tiff(bytes: &[u8]) -> Result<(Vec<u8>, usize, Size), PredictionError> {
    let failed = |e: tiff::TiffError| PredictionError::decoding(&e);
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(failed)?;
    let (width, height) = decoder.dimensions().map_err(failed)?;
    let size = size_of(width, height, bytes.len())?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = size.pixels() * 8;
    limits.intermediate_buffer_size = (size.pixels() * 8).max(1 << 16);
    limits.ifd_value_size = 1 << 20;
    decoder = decoder.with_limits(limits);
    let channels = match decoder.colortype().map_err(failed)? {
        tiff::ColorType::Gray(_) => 1,
        tiff::ColorType::RGB(_) => 3,
        tiff::ColorType::RGBA(_) => 4,
        other => return Err(PredictionError::new(format!("it is a TIFF of {other:?}, but an image is grey or RGB"))),
    };
    let values = match decoder.read_image().map_err(failed)? {
        DecodingResult::U8(v) => v,
        DecodingResult::U16(v) => {
            let most = u32::from(v.iter().copied().max().unwrap_or(1).max(1));
            v.into_iter().map(|x| (u32::from(x) * 255 / most) as u8).collect()
        }
        _ => return Err(PredictionError::new("an image has 8 or 16 bits a channel")),
    };
    Ok((values, channels, size))
}
