//! TIFF of one channel: floats, or whole numbers of pixels.

use super::{PredictionError, Size};
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};

pub(super) fn decode(bytes: &[u8], size: Size) -> Result<Vec<f64>, PredictionError> {
    let failed = |e: tiff::TiffError| PredictionError::decoding(&e);
    let mut limits = Limits::default();
    limits.decoding_buffer_size = size.pixels() * 8;
    limits.intermediate_buffer_size = (size.pixels() * 8).max(1 << 16);
    limits.ifd_value_size = 1 << 20;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(failed)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(failed)?;
    size.expect(u64::from(width), u64::from(height))?;
    let color = decoder.colortype().map_err(failed)?;
    if !matches!(color, tiff::ColorType::Gray(_)) {
        return Err(PredictionError::new(format!("it is a TIFF of {color:?}, but a disparity map has one channel")));
    }
    let values: Vec<f64> = match decoder.read_image().map_err(failed)? {
        DecodingResult::F32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::F64(v) => v,
        DecodingResult::F16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U64(v) => v.into_iter().map(|x| x as f64).collect(),
        DecodingResult::I8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I64(v) => v.into_iter().map(|x| x as f64).collect(),
    };
    if values.len() != size.pixels() {
        let (found, needed) = (values.len(), size.pixels());
        return Err(PredictionError::new(format!("it decodes to {found} values, but {needed} are expected")));
    }
    Ok(values)
}
