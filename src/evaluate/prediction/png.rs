//! 16-bit PNG as KITTI has it: disparity times a scale (256), 0 where there is no prediction.

use super::{PredictionError, Size};
use std::io::Cursor;

pub(super) fn decode(bytes: &[u8], size: Size, scale: f64) -> Result<Vec<f64>, PredictionError> {
    let failed = |e: png::DecodingError| PredictionError::decoding(&e);
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(failed)?;
    let info = reader.info();
    if info.color_type != png::ColorType::Grayscale || info.bit_depth != png::BitDepth::Sixteen {
        return Err(PredictionError::new(format!(
            "it is a PNG of {:?} with {} bits, but a prediction has one channel of 16 bits, disparity times {scale}",
            info.color_type, info.bit_depth as u8
        )));
    }
    size.expect(u64::from(info.width), u64::from(info.height))?;
    let mut values = vec![0; size.pixels() * 2];
    reader.next_frame(&mut values).map_err(failed)?;
    reader.finish().map_err(failed)?;
    let value = |b: &[u8]| match u16::from_be_bytes([b[0], b[1]]) {
        0 => f64::NAN,
        n => f64::from(n) / scale,
    };
    Ok(values.chunks_exact(2).map(value).collect())
}
