//! Arrays of wider values and height maps: TIFF and `GeoTIFF`, deflate 6 with a predictor.

use super::{FormatError, PixelKind, Pixels, Plane};
use satseed_scene::Raster;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag as ReadTag;
use tiff_core::{Compression, ExtraSample, PhotometricInterpretation, Predictor, Tag, TagValue};
use tiff_writer::{ImageBuilder, TiffVariant, TiffWriteSample, TiffWriter, WriteOptions};

/// Rows that are compressed together: a file of 2048 columns has strips of 2 MB, and a reader of one row reads no more.
const ROWS_PER_STRIP: u32 = 256;
const DEFLATE_LEVEL: u32 = 6;

const MODEL_PIXEL_SCALE: u16 = 33550;
const MODEL_TIEPOINT: u16 = 33922;
const GEO_KEY_DIRECTORY: u16 = 34735;
const GEO_ASCII_PARAMS: u16 = 34737;
const GDAL_NODATA: u16 = 42113;

/// Heights of a scene over the world's plane.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// World x of the first column's cell centres, m.
    pub west_m: f64,
    /// World y of the first row's cell centres, m.
    pub south_m: f64,
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Cells eastward.
    pub width: u32,
    /// Cells northward.
    pub height: u32,
    /// Height at each cell's centre, m, row by row from the south; NaN where there is nothing.
    pub heights_m: Vec<f32>,
}

pub(super) fn encode<T: TiffWriteSample>(
    width: u32,
    height: u32,
    kind: PixelKind,
    values: &[T],
) -> Result<Vec<u8>, FormatError> {
    let floats = matches!(kind, PixelKind::Float | PixelKind::Radiance(_));
    let predictor = if floats { Predictor::FloatingPoint } else { Predictor::Horizontal };
    let mut image = ImageBuilder::new(width, height).predictor(predictor);
    let channels = kind.channels();
    if channels > 1 {
        image = image.samples_per_pixel(channels as u16).photometric(PhotometricInterpretation::Rgb);
    }
    if channels > 3 {
        // Readers drop or take for opacity what stands behind red, green and blue: four bands are four bands.
        image =
            image.photometric(PhotometricInterpretation::MinIsBlack).extra_samples(vec![ExtraSample::Unspecified; 3]);
    }
    write(image, width, height, kind.channels(), values)
}

fn write<T: TiffWriteSample>(
    image: ImageBuilder,
    width: u32,
    height: u32,
    channels: usize,
    values: &[T],
) -> Result<Vec<u8>, FormatError> {
    let failed = |e: tiff_writer::Error| FormatError::Encode(e.to_string());
    let image = image
        .sample_type::<T>()
        .strips(ROWS_PER_STRIP.min(height))
        .compression(Compression::Deflate)
        .deflate_level(DEFLATE_LEVEL);
    let options = WriteOptions { variant: TiffVariant::Classic, ..WriteOptions::default() };
    let mut writer = TiffWriter::new(Cursor::new(Vec::new()), options).map_err(failed)?;
    let handle = writer.add_image(image).map_err(failed)?;
    let strip = width as usize * channels * ROWS_PER_STRIP.min(height) as usize;
    for (i, rows) in values.chunks(strip).enumerate() {
        writer.write_block(&handle, i, rows).map_err(failed)?;
    }
    Ok(writer.finish().map_err(failed)?.into_inner())
}

fn failed(e: impl std::fmt::Display) -> FormatError {
    FormatError::Decode(e.to_string())
}

/// A decoder that never takes more memory than an array of `bytes` needs.
fn decoder(bytes: &[u8], decoded_bytes: usize) -> Result<Decoder<Cursor<&[u8]>>, FormatError> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = decoded_bytes;
    limits.intermediate_buffer_size = decoded_bytes.max(1 << 16);
    limits.ifd_value_size = 1 << 20;
    Ok(Decoder::new(Cursor::new(bytes)).map_err(failed)?.with_limits(limits))
}

pub(super) fn decode(bytes: &[u8], kind: PixelKind, width: u32, height: u32) -> Result<Pixels, FormatError> {
    let mut decoder = decoder(bytes, width as usize * height as usize * kind.bytes_per_pixel())?;
    let (found_width, found_height) = decoder.dimensions().map_err(failed)?;
    if (found_width, found_height) != (width, height) {
        return Err(FormatError::Size { width, height, found_width, found_height });
    }
    let color = decoder.colortype().map_err(failed)?;
    let wrong = || FormatError::Kind { expected: kind, found: format!("{color:?}") };
    let (channels, bits) = layout(color).ok_or_else(wrong)?;
    if channels != kind.channels() || bits * channels != 8 * kind.bytes_per_pixel() {
        return Err(wrong());
    }
    match (kind, decoder.read_image().map_err(failed)?) {
        (PixelKind::Float, DecodingResult::F32(v)) => Ok(Pixels::Float(v)),
        (PixelKind::Id, DecodingResult::U32(v)) => Ok(Pixels::Id(v)),
        (PixelKind::Vector, DecodingResult::I16(v)) => Ok(Pixels::Vector(v)),
        (PixelKind::Bytes4, DecodingResult::U8(v)) => Ok(Pixels::Bytes4(v)),
        (PixelKind::Counts(n), DecodingResult::U16(v)) => Ok(Pixels::Counts(n, v)),
        (PixelKind::Radiance(n), DecodingResult::F32(v)) => Ok(Pixels::Radiance(n, v)),
        _ => Err(wrong()),
    }
}

/// Values a pixel and bits a value.
fn layout(color: tiff::ColorType) -> Option<(usize, usize)> {
    match color {
        tiff::ColorType::Gray(bits) => Some((1, bits.into())),
        tiff::ColorType::RGB(bits) => Some((3, bits.into())),
        tiff::ColorType::RGBA(bits) => Some((4, bits.into())),
        tiff::ColorType::Multiband { bit_depth, num_samples } => Some((num_samples.into(), bit_depth.into())),
        _ => None,
    }
}

/// What image a TIFF file holds; none where it is none.
pub(super) fn kind_of(bytes: &[u8]) -> Option<PixelKind> {
    // Room for tags alone.
    let mut decoder = decoder(bytes, 1 << 12).ok()?;
    let (channels, bits) = layout(decoder.colortype().ok()?)?;
    let format = decoder.find_tag_unsigned_vec::<u16>(ReadTag::SampleFormat).ok()?;
    match (bits, format.and_then(|f| f.first().copied()).unwrap_or(1)) {
        (8, 1) if channels == 4 => Some(PixelKind::Bytes4),
        (16, 1) => Some(PixelKind::Counts(channels as u8)),
        (32, 3) => Some(PixelKind::Radiance(channels as u8)),
        _ => None,
    }
}

/// A height map as a `GeoTIFF`: a local metric frame, the first row in the north, as every GIS expects.
///
/// # Errors
/// Where the array's length does not fit its size.
pub fn encode_height_map(map: &HeightMap) -> Result<Vec<u8>, FormatError> {
    let (width, height) = (map.width, map.height);
    if map.heights_m.len() != width as usize * height as usize || map.heights_m.is_empty() {
        return Err(FormatError::Length { width, height, kind: PixelKind::Float, found: map.heights_m.len() });
    }
    // The tie point is the outer corner of the north-western cell (raster type "pixel is area").
    let west = map.west_m - map.cell_m / 2.0;
    let north = map.south_m + (f64::from(height) - 0.5) * map.cell_m;
    let citation = "satseed local frame: east, north, up in metres|";
    let keys = [
        [1, 1, 0, 4],
        [1024, 0, 1, 32767],                                // GTModelType: user-defined
        [1025, 0, 1, 1],                                    // GTRasterType: pixel is area
        [1026, GEO_ASCII_PARAMS, citation.len() as u16, 0], // GTCitation
        [3076, 0, 1, 9001],                                 // ProjLinearUnits: metre
    ];
    let image = ImageBuilder::new(width, height)
        .predictor(Predictor::FloatingPoint)
        .tag(Tag::new(MODEL_PIXEL_SCALE, TagValue::Double(vec![map.cell_m, map.cell_m, 0.0])))
        .tag(Tag::new(MODEL_TIEPOINT, TagValue::Double(vec![0.0, 0.0, 0.0, west, north, 0.0])))
        .tag(Tag::new(GEO_KEY_DIRECTORY, TagValue::Short(keys.concat())))
        .tag(Tag::new(GEO_ASCII_PARAMS, TagValue::Ascii(citation.to_owned())))
        .tag(Tag::new(GDAL_NODATA, TagValue::Ascii("nan".to_owned())));
    write(image, width, height, 1, &flipped(&map.heights_m, width as usize))
}

/// Reads what [`encode_height_map`] wrote.
///
/// # Errors
/// Where it is damaged, no height map, or larger than `max_cells`.
pub fn decode_height_map(bytes: &[u8], max_cells: usize) -> Result<HeightMap, FormatError> {
    let mut decoder = decoder(bytes, max_cells.saturating_mul(4))?;
    let (width, height) = decoder.dimensions().map_err(failed)?;
    if width as usize * height as usize > max_cells {
        return Err(failed(format!("{width} x {height} cells are more than the {max_cells} that a scene may have")));
    }
    let numbers = |decoder: &mut Decoder<_>, tag| decoder.get_tag_f64_vec(ReadTag::Unknown(tag)).map_err(failed);
    let scale = numbers(&mut decoder, MODEL_PIXEL_SCALE)?;
    let tie = numbers(&mut decoder, MODEL_TIEPOINT)?;
    let (&[cell_m, ..], &[_, _, _, west, north, ..]) = (scale.as_slice(), tie.as_slice()) else {
        return Err(failed("its scale or tie point is incomplete"));
    };
    if !(cell_m > 0.0 && cell_m.is_finite() && west.is_finite() && north.is_finite()) {
        return Err(failed("its scale or tie point is no number"));
    }
    match decoder.read_image().map_err(failed)? {
        DecodingResult::F32(v) if v.len() == width as usize * height as usize => Ok(HeightMap {
            west_m: west + cell_m / 2.0,
            south_m: north - (f64::from(height) - 0.5) * cell_m,
            cell_m,
            width,
            height,
            heights_m: flipped(&v, width as usize),
        }),
        _ => Err(failed("it is no map of 32-bit floats")),
    }
}

/// A scene's raster, post by post.
impl From<Raster<f32>> for HeightMap {
    fn from(raster: Raster<f32>) -> Self {
        Self {
            west_m: raster.origin_m.x,
            south_m: raster.origin_m.y,
            cell_m: raster.cell_m,
            width: raster.width as u32,
            height: raster.height as u32,
            heights_m: raster.data,
        }
    }
}

impl HeightMap {
    /// BLAKE3 over the heights as the file has them: row by row from the north, little-endian.
    pub fn pixel_hash(&self) -> blake3::Hash {
        let pixels = Pixels::Float(flipped(&self.heights_m, self.width as usize));
        Plane { width: self.width, height: self.height, pixels }.pixel_hash()
    }
}

fn flipped(values: &[f32], width: usize) -> Vec<f32> {
    values.chunks_exact(width).rev().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> HeightMap {
        let heights_m = (0..7 * 5).map(|i| if i == 3 { f32::NAN } else { i as f32 * 0.5 - 4.0 }).collect();
        HeightMap { west_m: -3.0, south_m: -2.0, cell_m: 0.5, width: 7, height: 5, heights_m }
    }

    #[test]
    fn height_maps_read_back_with_their_frame() {
        let map = map();
        let back = decode_height_map(&encode_height_map(&map).unwrap(), 100).unwrap();
        assert_eq!((back.west_m, back.south_m, back.cell_m), (-3.0, -2.0, 0.5));
        assert_eq!((back.width, back.height), (7, 5));
        for (a, b) in map.heights_m.iter().zip(&back.heights_m) {
            assert_eq!(a.to_bits(), b.to_bits());
        }
    }

    #[test]
    fn the_first_row_in_the_file_is_the_northern_one() {
        let map = map();
        let mut decoder = Decoder::new(Cursor::new(encode_height_map(&map).unwrap())).unwrap();
        let DecodingResult::F32(values) = decoder.read_image().unwrap() else { panic!("floats") };
        assert_eq!(values[..7], map.heights_m[28..]);
        let tie = decoder.get_tag_f64_vec(ReadTag::Unknown(MODEL_TIEPOINT)).unwrap();
        assert_eq!(tie, [0.0, 0.0, 0.0, -3.25, 0.25, 0.0]);
    }

    #[test]
    fn too_large_a_map_is_refused() {
        assert!(decode_height_map(&encode_height_map(&map()).unwrap(), 34).is_err());
        let short = HeightMap { height: 6, ..map() };
        assert!(matches!(encode_height_map(&short), Err(FormatError::Length { .. })));
    }
}
