//! PFM: `Pf`, columns and rows, a number whose sign is the byte order, then rows of 32-bit floats from the bottom up.
//! <https://www.pauldebevec.com/Research/HDR/PFM/>

use super::{PredictionError, Size, expect_length};

pub(super) fn decode(bytes: &[u8], size: Size) -> Result<Vec<f64>, PredictionError> {
    let none = || PredictionError::new("it is no PFM, which begins with `Pf`, its size and the byte order");
    let mut rest = bytes;
    match token(&mut rest) {
        Some("Pf") => {}
        Some("PF") => {
            return Err(PredictionError::new(
                "it is a PFM of three channels (`PF`), but a disparity map has one (`Pf`)",
            ));
        }
        _ => return Err(none()),
    }
    let mut number = || token(&mut rest)?.parse::<u64>().ok();
    let (width, height) = (number().ok_or_else(none)?, number().ok_or_else(none)?);
    let scale: f64 = token(&mut rest).and_then(|t| t.parse().ok()).ok_or_else(none)?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(PredictionError::new(
            "its byte order is neither positive (big-endian) nor negative (little-endian)",
        ));
    }
    size.expect(width, height)?;
    expect_length(rest.len(), size.pixels() * 4)?;
    let value = |b: &[u8]| {
        let four = [b[0], b[1], b[2], b[3]];
        f64::from(if scale < 0.0 { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) })
    };
    Ok(rest.chunks_exact(size.width as usize * 4).rev().flat_map(|row| row.chunks_exact(4).map(value)).collect())
}

/// The next word of the header; exactly one white space after it is taken too.
fn token<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let text: &'a [u8] = rest;
    let begin = text.iter().take(64).position(|b| !b.is_ascii_whitespace())?;
    let length = text[begin..].iter().take(64).position(u8::is_ascii_whitespace)?;
    *rest = &text[begin + length + 1..];
    std::str::from_utf8(&text[begin..begin + length]).ok()
}
