//! NPY, NumPy's own format, versions 1 to 3: a header that is a Python dictionary, then the raw array.
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>
//!
//! Read here and not by a package: of the dictionary three keys in their usual form are all that is wanted, and a file of a
//! stranger's must not drive a parser of any Python literal.

use super::{PredictionError, Size, expect_length};
use half::f16;

/// Longest header that is looked at; NumPy itself trusts no longer one.
const MAX_HEADER: usize = 10_000;

pub(super) fn decode(bytes: &[u8], size: Size) -> Result<Vec<f64>, PredictionError> {
    let none = || PredictionError::new("it is no NPY file, or its header is damaged");
    let (header, data) = split(bytes).ok_or_else(none)?;
    let header = Header::parse(header).ok_or_else(none)?;
    let (rows, columns) = match header.shape.as_slice() {
        &[rows, columns] => (rows, columns),
        other => {
            let shape: Vec<_> = other.iter().map(u64::to_string).collect();
            return Err(PredictionError::new(format!(
                "its shape is ({}), but a disparity map has rows and columns",
                shape.join(", ")
            )));
        }
    };
    size.expect(columns, rows)?;
    let unknown = || {
        PredictionError::new(format!(
            "it holds `{}`, but disparities are floats or whole numbers",
            header.descr.escape_default()
        ))
    };
    let values = numbers(&header.descr, data, size.pixels()).ok_or_else(unknown)??;
    if !header.fortran_order {
        return Ok(values);
    }
    let (width, height) = (size.width as usize, size.height as usize);
    Ok((0..size.pixels()).map(|i| values[(i % width) * height + i / width]).collect())
}

fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let rest = bytes.strip_prefix(b"\x93NUMPY")?;
    let (length, rest) = match rest {
        [1, 0, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, 0, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return None,
    };
    if length > MAX_HEADER || length > rest.len() {
        return None;
    }
    let (header, data) = rest.split_at(length);
    Some((std::str::from_utf8(header).ok()?, data))
}

/// The numbers of a raw array; none where the type is not known.
fn numbers(descr: &str, data: &[u8], count: usize) -> Option<Result<Vec<f64>, PredictionError>> {
    macro_rules! read {
        ($t:ty, $big:expr, $into:expr) => {{
            const N: usize = size_of::<$t>();
            expect_length(data.len(), count * N).map(|()| {
                let from = if $big { <$t>::from_be_bytes } else { <$t>::from_le_bytes };
                let value = |b: &[u8]| $into(from(b.try_into().expect("chunks of N bytes")));
                data.chunks_exact(N).map(value).collect()
            })
        }};
    }
    let (order, kind) = descr.split_at_checked(1)?;
    let big = match order {
        "<" | "|" | "=" => false,
        ">" => true,
        _ => return None,
    };
    Some(match kind {
        "f2" => read!(f16, big, f64::from),
        "f4" => read!(f32, big, f64::from),
        "f8" => read!(f64, big, f64::from),
        "i1" => read!(i8, big, f64::from),
        "i2" => read!(i16, big, f64::from),
        "i4" => read!(i32, big, f64::from),
        "i8" => read!(i64, big, |x| x as f64),
        "u1" => read!(u8, big, f64::from),
        "u2" => read!(u16, big, f64::from),
        "u4" => read!(u32, big, f64::from),
        "u8" => read!(u64, big, |x| x as f64),
        _ => return None,
    })
}

struct Header {
    descr: String,
    fortran_order: bool,
    /// Without the ones that a batch or channel axis leaves at either end.
    shape: Vec<u64>,
}

impl Header {
    /// `{'descr': '<f4', 'fortran_order': False, 'shape': (512, 512), }`
    fn parse(text: &str) -> Option<Self> {
        let mut rest = text.trim().strip_prefix('{')?.strip_suffix('}')?.trim();
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        while !rest.is_empty() {
            let (key, after) = quoted(rest)?;
            let after = after.trim_start().strip_prefix(':')?.trim_start();
            let after = match key {
                "descr" => {
                    let (value, after) = quoted(after)?;
                    descr = Some(value.to_owned());
                    after
                }
                "fortran_order" => {
                    fortran_order = Some(after.starts_with("True"));
                    after.strip_prefix("True").or_else(|| after.strip_prefix("False"))?
                }
                "shape" => {
                    let (inside, after) = after.strip_prefix('(')?.split_once(')')?;
                    let numbers = inside.split(',').map(str::trim).filter(|n| !n.is_empty());
                    shape = Some(numbers.map(|n| n.parse().ok()).collect::<Option<Vec<u64>>>()?);
                    after
                }
                _ => return None,
            };
            rest = after.trim_start();
            rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
        }
        let mut shape = shape?;
        while shape.len() > 2 && shape.last() == Some(&1) {
            shape.pop();
        }
        while shape.len() > 2 && shape[0] == 1 {
            shape.remove(0);
        }
        Some(Self { descr: descr?, fortran_order: fortran_order?, shape })
    }
}

/// A quoted text at the beginning, and what follows it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let mark = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(mark)
}
