//! The encodings of a dataset's files: every array has one, and the same array gives the same bytes everywhere.
//!
//! 8-bit arrays are PNG with fdeflate's fast filter, wider ones TIFF with deflate 6 and the predictor that fits their
//! type, or `OpenEXR` where a recipe asks for it. All encoders are integer code without a dependence on processor,
//! threads or clock.

mod exr;
mod png;
mod tiff;

pub use tiff::{HeightMap, decode_height_map, encode_height_map};

/// The values of an array, row by row from the top.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// One byte a pixel.
    Gray(Vec<u8>),
    /// Three bytes a pixel.
    Rgb(Vec<u8>),
    /// One 32-bit float a pixel.
    Float(Vec<f32>),
    /// One 32-bit number a pixel.
    Id(Vec<u32>),
    /// Three signed 16-bit numbers a pixel.
    Vector(Vec<i16>),
    /// Four bytes a pixel.
    Bytes4(Vec<u8>),
    /// 16-bit numbers, so many a pixel: 1, 3 or 4.
    Counts(u8, Vec<u16>),
    /// 32-bit floats, so many a pixel: 1, 3 or 4.
    Radiance(u8, Vec<f32>),
    /// The same, for another kind of file.
    SceneLinear(u8, Vec<f32>),
}

/// What kind of values an array holds; it decides the encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PixelKind {
    /// [`Pixels::Gray`], PNG.
    Gray,
    /// [`Pixels::Rgb`], PNG.
    Rgb,
    /// [`Pixels::Float`], TIFF.
    Float,
    /// [`Pixels::Id`], TIFF.
    Id,
    /// [`Pixels::Vector`], TIFF.
    Vector,
    /// [`Pixels::Bytes4`], TIFF.
    Bytes4,
    /// [`Pixels::Counts`] of so many values, TIFF.
    Counts(u8),
    /// [`Pixels::Radiance`] of so many values, TIFF.
    Radiance(u8),
    /// [`Pixels::SceneLinear`] of so many values, `OpenEXR`.
    SceneLinear(u8),
}

impl PixelKind {
    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Gray | Self::Rgb => "png",
            Self::SceneLinear(_) => "exr",
            _ => "tif",
        }
    }

    /// Values a pixel.
    fn channels(self) -> usize {
        match self {
            Self::Gray | Self::Float | Self::Id => 1,
            Self::Rgb | Self::Vector => 3,
            Self::Bytes4 => 4,
            Self::Counts(n) | Self::Radiance(n) | Self::SceneLinear(n) => n.into(),
        }
    }

    /// Bytes a pixel takes in memory and in the pixel hash.
    pub fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Rgb => 3,
            Self::Float | Self::Id | Self::Bytes4 => 4,
            Self::Vector => 6,
            Self::Counts(n) => 2 * usize::from(n),
            Self::Radiance(n) | Self::SceneLinear(n) => 4 * usize::from(n),
        }
    }
}

/// A two-dimensional array.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Pixels,
}

/// What is wrong with an array or with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The array's length does not fit its size.
    #[error("an array of {found} values cannot be {width} x {height} pixels of {kind:?}")]
    Length {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Kind of values.
        kind: PixelKind,
        /// Values given.
        found: usize,
    },
    /// The file has another size than it must have.
    #[error("it is {found_width} x {found_height} pixels, but {width} x {height} are expected")]
    Size {
        /// Expected columns.
        width: u32,
        /// Expected rows.
        height: u32,
        /// Columns found.
        found_width: u32,
        /// Rows found.
        found_height: u32,
    },
    /// The file holds another kind of values.
    #[error("it holds {}, but {expected:?} is expected", shown(found))]
    Kind {
        /// Expected kind.
        expected: PixelKind,
        /// Found, in the decoder's words.
        found: String,
    },
    /// The file cannot be decoded.
    #[error("it cannot be decoded: {}", shown(.0))]
    Decode(String),
    /// The array cannot be encoded.
    #[error("the array cannot be encoded: {0}")]
    Encode(String),
}

/// A decoder's words, which may quote a stranger's file: not too long, and nothing that steers a terminal.
fn shown(text: &str) -> String {
    text.chars().take(200).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

impl Plane {
    /// What kind of values it holds.
    pub fn kind(&self) -> PixelKind {
        match self.pixels {
            Pixels::Gray(_) => PixelKind::Gray,
            Pixels::Rgb(_) => PixelKind::Rgb,
            Pixels::Float(_) => PixelKind::Float,
            Pixels::Id(_) => PixelKind::Id,
            Pixels::Vector(_) => PixelKind::Vector,
            Pixels::Bytes4(_) => PixelKind::Bytes4,
            Pixels::Counts(n, _) => PixelKind::Counts(n),
            Pixels::Radiance(n, _) => PixelKind::Radiance(n),
            Pixels::SceneLinear(n, _) => PixelKind::SceneLinear(n),
        }
    }

    /// The bytes of a file with this array.
    ///
    /// # Errors
    /// Where the array's length does not fit its size.
    pub fn encode(&self) -> Result<Vec<u8>, FormatError> {
        self.check_length()?;
        match &self.pixels {
            Pixels::Gray(v) | Pixels::Rgb(v) => png::encode(self.width, self.height, self.kind(), v),
            Pixels::Float(v) | Pixels::Radiance(_, v) => tiff::encode(self.width, self.height, self.kind(), v),
            Pixels::SceneLinear(n, v) => exr::encode(self.width, self.height, usize::from(*n), v),
            Pixels::Id(v) => tiff::encode(self.width, self.height, self.kind(), v),
            Pixels::Vector(v) => tiff::encode(self.width, self.height, self.kind(), v),
            Pixels::Bytes4(v) => tiff::encode(self.width, self.height, self.kind(), v),
            Pixels::Counts(_, v) => tiff::encode(self.width, self.height, self.kind(), v),
        }
    }

    /// The same array as TIFF, whatever its kind.
    ///
    /// # Errors
    /// Where the array's length does not fit its size.
    pub fn encode_tiff(&self) -> Result<Vec<u8>, FormatError> {
        self.check_length()?;
        match &self.pixels {
            Pixels::Gray(v) | Pixels::Rgb(v) => tiff::encode(self.width, self.height, self.kind(), v),
            _ => self.encode(),
        }
    }

    /// Reads a file of a known kind and size. Nothing is allocated for a file of another size, since files also come
    /// from strangers.
    ///
    /// # Errors
    /// Where the file is damaged, or its kind or size is not the expected one.
    pub fn decode(bytes: &[u8], kind: PixelKind, width: u32, height: u32) -> Result<Self, FormatError> {
        let needed = u64::from(width) * u64::from(height) * kind.bytes_per_pixel() as u64;
        if needed > decoded_bytes_at_most(bytes.len()) {
            let found = bytes.len();
            return Err(FormatError::Decode(format!(
                "{found} bytes cannot hold {width} x {height} pixels of {kind:?}"
            )));
        }
        let pixels = match kind {
            PixelKind::Gray => Pixels::Gray(png::decode(bytes, kind, width, height)?),
            PixelKind::Rgb => Pixels::Rgb(png::decode(bytes, kind, width, height)?),
            PixelKind::SceneLinear(_) => exr::decode(bytes, kind, width, height)?,
            _ => tiff::decode(bytes, kind, width, height)?,
        };
        let plane = Self { width, height, pixels };
        plane.check_length()?;
        Ok(plane)
    }

    /// Reads a file that holds one of several kinds, as the file itself says.
    ///
    /// # Errors
    /// As [`Plane::decode`]; what holds none of the kinds is refused as if the first was expected.
    pub fn decode_one_of(bytes: &[u8], kinds: &[PixelKind], width: u32, height: u32) -> Result<Self, FormatError> {
        let named = if kinds.len() > 1 { file_kind(bytes) } else { None };
        let kind = named.filter(|kind| kinds.contains(kind)).unwrap_or(kinds[0]);
        Self::decode(bytes, kind, width, height)
    }

    /// Its floats; empty where it holds others.
    pub fn into_floats(self) -> Vec<f32> {
        if let Pixels::Float(values) = self.pixels { values } else { Vec::new() }
    }

    /// Its bytes; empty where it holds others.
    pub fn into_bytes(self) -> Vec<u8> {
        if let Pixels::Gray(values) | Pixels::Rgb(values) = self.pixels { values } else { Vec::new() }
    }

    /// Its picture as red, green, blue of 8 bits, for people and for what works on grey levels: 11-bit counts by their high
    /// bits, radiance from 0 to its largest value.
    pub fn to_rgb8(&self) -> Vec<u8> {
        let channels = self.kind().channels();
        let bytes: Vec<u8> = match &self.pixels {
            Pixels::Gray(v) | Pixels::Rgb(v) | Pixels::Bytes4(v) => v.clone(),
            Pixels::Counts(_, v) => v.iter().map(|x| (x >> 3).min(255) as u8).collect(),
            Pixels::Float(v) | Pixels::Radiance(_, v) | Pixels::SceneLinear(_, v) => {
                let largest = v.iter().copied().filter(|x| x.is_finite()).fold(f32::MIN_POSITIVE, f32::max);
                v.iter().map(|x| (x / largest * 255.0).clamp(0.0, 255.0) as u8).collect()
            }
            Pixels::Id(_) | Pixels::Vector(_) => Vec::new(),
        };
        match channels {
            1 => bytes.iter().flat_map(|b| [*b; 3]).collect(),
            3 => bytes,
            _ => bytes.chunks_exact(channels).flat_map(|p| [p[0], p[1], p[2]]).collect(),
        }
    }

    /// BLAKE3 over the array in row-major order, little-endian, without padding: it outlives a change of encoder.
    pub fn pixel_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        match &self.pixels {
            Pixels::Gray(v) | Pixels::Rgb(v) | Pixels::Bytes4(v) => {
                hasher.update(v);
            }
            Pixels::Float(v) | Pixels::Radiance(_, v) | Pixels::SceneLinear(_, v) => {
                update_chunked(&mut hasher, v, |x| x.to_bits().to_le_bytes());
            }
            Pixels::Id(v) => update_chunked(&mut hasher, v, u32::to_le_bytes),
            Pixels::Vector(v) => update_chunked(&mut hasher, v, i16::to_le_bytes),
            Pixels::Counts(_, v) => update_chunked(&mut hasher, v, u16::to_le_bytes),
        }
        hasher.finalize()
    }

    /// The index of the first pixel where two arrays of the same kind and size differ, bit by bit.
    pub fn first_difference(&self, other: &Self) -> Option<usize> {
        fn first<T>(a: &[T], b: &[T], same: impl Fn(&T, &T) -> bool) -> Option<usize> {
            a.iter().zip(b).position(|(x, y)| !same(x, y)).or((a.len() != b.len()).then_some(a.len().min(b.len())))
        }
        let value = match (&self.pixels, &other.pixels) {
            (Pixels::Gray(a), Pixels::Gray(b))
            | (Pixels::Rgb(a), Pixels::Rgb(b))
            | (Pixels::Bytes4(a), Pixels::Bytes4(b)) => first(a, b, |x, y| x == y),
            (Pixels::Counts(n, a), Pixels::Counts(m, b)) if n == m => first(a, b, |x, y| x == y),
            (Pixels::Radiance(n, a), Pixels::Radiance(m, b))
            | (Pixels::SceneLinear(n, a), Pixels::SceneLinear(m, b))
                if n == m =>
            {
                first(a, b, |x, y| x.to_bits() == y.to_bits())
            }
            (Pixels::Float(a), Pixels::Float(b)) => first(a, b, |x, y| x.to_bits() == y.to_bits()),
            (Pixels::Id(a), Pixels::Id(b)) => first(a, b, |x, y| x == y),
            (Pixels::Vector(a), Pixels::Vector(b)) => first(a, b, |x, y| x == y),
            _ => Some(0),
        };
        value.map(|i| i / self.kind().channels())
    }

    /// The value of one pixel, for people.
    pub fn describe(&self, pixel: usize) -> String {
        let three = |i: usize| 3 * i..3 * i + 3;
        let several = |n: u8| usize::from(n) * pixel..usize::from(n) * (pixel + 1);
        match &self.pixels {
            Pixels::Bytes4(v) => v.get(several(4)).map_or_else(String::new, |x| format!("{x:?}")),
            Pixels::Counts(n, v) => v.get(several(*n)).map_or_else(String::new, |x| format!("{x:?}")),
            Pixels::Radiance(n, v) | Pixels::SceneLinear(n, v) => {
                v.get(several(*n)).map_or_else(String::new, |x| format!("{x:?}"))
            }
            Pixels::Gray(v) => v.get(pixel).map_or_else(String::new, |x| format!("{x}")),
            Pixels::Float(v) => v.get(pixel).map_or_else(String::new, |x| format!("{x} ({:08x})", x.to_bits())),
            Pixels::Id(v) => v.get(pixel).map_or_else(String::new, |x| format!("{x}")),
            Pixels::Rgb(v) => v.get(three(pixel)).map_or_else(String::new, |x| format!("{x:?}")),
            Pixels::Vector(v) => v.get(three(pixel)).map_or_else(String::new, |x| format!("{x:?}")),
        }
    }

    fn check_length(&self) -> Result<(), FormatError> {
        let found = match &self.pixels {
            Pixels::Gray(v) | Pixels::Rgb(v) | Pixels::Bytes4(v) => v.len(),
            Pixels::Float(v) | Pixels::Radiance(_, v) | Pixels::SceneLinear(_, v) => v.len(),
            Pixels::Counts(_, v) => v.len(),
            Pixels::Id(v) => v.len(),
            Pixels::Vector(v) => v.len(),
        };
        let (width, height, kind) = (self.width, self.height, self.kind());
        if self.width as usize * self.height as usize * kind.channels() == found && found > 0 {
            Ok(())
        } else {
            Err(FormatError::Length { width, height, kind, found })
        }
    }
}

/// What a file of a length can decode to at most: deflate makes up to 1,032 bytes of one. Sizes that a file claims are
/// held against it before anything is allocated.
pub fn decoded_bytes_at_most(file_bytes: usize) -> u64 {
    (1 << 16) + 1032 * file_bytes as u64
}

/// What an image's file says that it holds.
fn file_kind(bytes: &[u8]) -> Option<PixelKind> {
    png::kind_of(bytes).or_else(|| tiff::kind_of(bytes)).or_else(|| exr::kind_of(bytes))
}

fn update_chunked<T: Copy, const N: usize>(hasher: &mut blake3::Hasher, values: &[T], bytes: impl Fn(T) -> [u8; N]) {
    let mut buffer = Vec::with_capacity(N * 8192);
    for chunk in values.chunks(8192) {
        buffer.clear();
        for v in chunk {
            buffer.extend_from_slice(&bytes(*v));
        }
        hasher.update(&buffer);
    }
}

/// The one NaN that stands where nothing was hit: its sign and payload differ between processors otherwise.
pub const MISS: f32 = f32::from_bits(0x7fc0_0000);

/// The nearest multiple of 1/256 px; NaN stays. It halves a disparity file and is below any matcher's precision.
pub fn round_to_256th(disparity_px: f32) -> f32 {
    // The product and the quotient by a power of two are exact, so this rounds once, ties to even.
    (disparity_px * 256.0).round_ties_even() / 256.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: u32, height: u32) -> impl Iterator<Item = usize> {
        0..width as usize * height as usize
    }

    fn planes(width: u32, height: u32) -> Vec<Plane> {
        let of = |pixels| Plane { width, height, pixels };
        let mut all = vec![
            of(Pixels::Gray(ramp(width, height).map(|i| (i * 7 % 251) as u8).collect())),
            of(Pixels::Rgb(ramp(width, height).flat_map(|i| [(i % 256) as u8, (i / 3 % 256) as u8, 7]).collect())),
            of(Pixels::Float(
                ramp(width, height).map(|i| if i % 97 == 0 { MISS } else { i as f32 * 0.37 - 400.0 }).collect(),
            )),
            of(Pixels::Id(ramp(width, height).map(|i| (i as u32).wrapping_mul(2_654_435_761)).collect())),
            of(Pixels::Vector(
                ramp(width, height).flat_map(|i| [i as i16, (i as i16).wrapping_neg(), i16::MIN]).collect(),
            )),
            of(Pixels::Bytes4(ramp(width, height).flat_map(|i| [i as u8, 7, (i / 3) as u8, 200]).collect())),
            of(Pixels::Counts(1, ramp(width, height).map(|i| (i * 7 % 2048) as u16).collect())),
            of(Pixels::Counts(3, ramp(width, height).flat_map(|i| [(i % 2048) as u16, 9, 2047]).collect())),
            of(Pixels::Counts(4, ramp(width, height).flat_map(|i| [(i % 2048) as u16, 9, 0, 40]).collect())),
            of(Pixels::Radiance(1, ramp(width, height).map(|i| i as f32 * 0.01).collect())),
            of(Pixels::Radiance(3, ramp(width, height).flat_map(|i| [i as f32 * 0.01, 3.5, 0.0]).collect())),
            of(Pixels::Radiance(4, ramp(width, height).flat_map(|i| [i as f32 * 0.01, 3.5, 0.0, 90.0]).collect())),
        ];
        let values = |n: usize| (0..width as usize * height as usize * n).map(|i| i as f32 * 0.37 - 4.0).collect();
        all.extend([1, 3, 4].map(|n| of(Pixels::SceneLinear(n, values(n.into())))));
        all
    }

    #[test]
    fn every_kind_reads_back_bit_by_bit() {
        for (width, height) in [(1, 1), (3, 700), (301, 259)] {
            for plane in planes(width, height) {
                let bytes = plane.encode().unwrap();
                assert_eq!(bytes, plane.encode().unwrap());
                let back = Plane::decode(&bytes, plane.kind(), width, height).unwrap();
                assert_eq!(plane.first_difference(&back), None, "{:?} {width} x {height}", plane.kind());
                assert_eq!(plane.pixel_hash(), back.pixel_hash());
            }
        }
    }

    /// A change of these bytes is a change of every dataset: it must be meant, and told in CHANGELOG.md.
    #[test]
    fn encoders_have_not_changed() {
        // What labels and 8-bit colour are written as; the other sensors' are held by tests/sensor.rs.
        let hashes: Vec<_> = planes(301, 259)[..5]
            .iter()
            .map(|p| {
                (blake3::hash(&p.encode().unwrap()).to_hex()[..16].to_owned(), p.pixel_hash().to_hex()[..16].to_owned())
            })
            .collect();
        let expected = GOLDEN.map(|(bytes, pixels)| (bytes.to_owned(), pixels.to_owned()));
        assert_eq!(hashes, expected);
    }

    const GOLDEN: [(&str, &str); 5] = [
        ("53058096e2c950d4", "8ede0577a5e29694"),
        ("0af84038f3340b91", "1547826f4c8b7db7"),
        ("a834b89a3fed989a", "b14dcb826d849248"),
        ("31b368f9688b1c97", "2a31df42dff7d4ec"),
        ("85e7d1ebd072d6cc", "d981cee6f51786a6"),
    ];

    #[test]
    fn another_size_kind_or_a_damaged_file_is_refused() {
        for plane in planes(40, 30) {
            let bytes = plane.encode().unwrap();
            let kind = plane.kind();
            assert!(matches!(Plane::decode(&bytes, kind, 41, 30), Err(FormatError::Size { .. })));
            for other in planes(40, 30).iter().map(Plane::kind) {
                // One float a pixel is a label or a radiance: the file cannot tell.
                let floats = |k| matches!(k, PixelKind::Float | PixelKind::Radiance(1));
                let same = other == kind || (floats(other) && floats(kind));
                assert_eq!(Plane::decode(&bytes, other, 40, 30).is_ok(), same, "{kind:?} as {other:?}");
            }
            for cut in [0, 1, 7, bytes.len() / 2, bytes.len() - 20] {
                assert!(Plane::decode(&bytes[..cut], kind, 40, 30).is_err(), "{kind:?} cut to {cut}");
            }
        }
    }

    /// An image's file says itself what it holds.
    #[test]
    fn the_kind_of_an_image_is_read_from_its_file() {
        let kinds = crate::dataset::Layer::Image.kinds();
        for plane in planes(40, 30) {
            let back = Plane::decode_one_of(&plane.encode().unwrap(), kinds, 40, 30);
            if kinds.contains(&plane.kind()) {
                assert_eq!(back.unwrap().first_difference(&plane), None, "{:?}", plane.kind());
                assert_eq!(plane.to_rgb8().len(), 40 * 30 * 3, "{:?}", plane.kind());
            } else if plane.kind() != PixelKind::Float {
                assert!(back.is_err(), "{:?}", plane.kind());
            }
        }
    }

    /// Damaged files give an error or an array, never a panic.
    #[test]
    fn no_damaged_byte_makes_a_decoder_panic() {
        for plane in planes(24, 17) {
            let bytes = plane.encode().unwrap();
            for at in 0..bytes.len() {
                for value in [0, 0x7f, 0xff] {
                    let mut damaged = bytes.clone();
                    damaged[at] = value;
                    let _ = Plane::decode(&damaged, plane.kind(), 24, 17);
                }
            }
        }
    }

    /// A frame of one colour is what deflate shrinks most; it must still be readable, and a claim beyond it is refused.
    #[test]
    fn claims_beyond_what_deflate_can_do_are_refused() {
        let side = 3000;
        let plane = Plane { width: side, height: side, pixels: Pixels::Gray(vec![1; (side * side) as usize]) };
        let bytes = plane.encode().unwrap();
        assert!(Plane::decode(&bytes, PixelKind::Gray, side, side).is_ok());
        let error = Plane::decode(&bytes[..100], PixelKind::Vector, 16384, 16384).unwrap_err().to_string();
        assert!(error.contains("100 bytes cannot hold 16384 x 16384"), "{error}");
    }

    #[test]
    fn an_array_that_does_not_fit_is_refused() {
        let plane = Plane { width: 4, height: 4, pixels: Pixels::Rgb(vec![0; 16]) };
        assert!(matches!(plane.encode(), Err(FormatError::Length { .. })));
        let plane = Plane { width: 0, height: 4, pixels: Pixels::Gray(vec![]) };
        assert!(plane.encode().is_err());
    }

    #[test]
    fn differences_are_found_by_pixel() {
        let a = Plane { width: 2, height: 2, pixels: Pixels::Rgb(vec![0; 12]) };
        let mut values = vec![0; 12];
        values[8] = 1;
        let b = Plane { width: 2, height: 2, pixels: Pixels::Rgb(values) };
        assert_eq!(a.first_difference(&b), Some(2));
        assert_eq!(b.describe(2), "[0, 0, 1]");
        assert_eq!(a.first_difference(&a), None);
    }

    #[test]
    fn rounding_to_256ths() {
        assert_eq!(round_to_256th(666.666_7), 170_667.0 / 256.0);
        assert_eq!(round_to_256th(-0.001), 0.0);
        assert_eq!(round_to_256th(1.5 / 256.0), 2.0 / 256.0, "ties to even");
        assert_eq!(round_to_256th(MISS).to_bits(), MISS.to_bits());
        for i in 0..100_000 {
            let d = i as f32 * 0.0137 - 600.0;
            assert!((round_to_256th(d) - d).abs() <= 1.0 / 512.0);
        }
    }
}
