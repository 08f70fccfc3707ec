//! Radiance as `OpenEXR`: scan lines of 32-bit floats, ZIP over 16 of them (lossless), lines from the top.

use super::{FormatError, PixelKind, Pixels};
use exr::meta::MetaData;
use exr::meta::attribute::ChannelDescription;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, LineOrder, ReadChannels as _,
    ReadLayers as _, Vec2, WritableImage as _, read,
};
use std::io::Cursor;

/// Channel names in the order in which a pixel's values stand. The file has them by the alphabet, as its format asks.
fn names(channels: usize) -> &'static [&'static str] {
    match channels {
        1 => &["Y"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "N"],
    }
}

pub(super) fn encode(width: u32, height: u32, channels: usize, values: &[f32]) -> Result<Vec<u8>, FormatError> {
    let plane = |k: usize| FlatSamples::F32(values.iter().skip(k).step_by(channels).copied().collect());
    let list = names(channels).iter().enumerate().map(|(k, name)| AnyChannel::new(*name, plane(k))).collect();
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = (width as usize, height as usize);
    let image = Image::from_encoded_channels(size, encoding, AnyChannels::sort(list));
    let mut bytes = Cursor::new(Vec::new());
    // One thread: samples are written side by side already.
    image.write().non_parallel().to_buffered(&mut bytes).map_err(|e| FormatError::Encode(e.to_string()))?;
    Ok(bytes.into_inner())
}

fn failed(e: impl std::fmt::Display) -> FormatError {
    FormatError::Decode(e.to_string())
}

/// The header of a file of one flat layer.
fn header(bytes: &[u8]) -> Result<Header, FormatError> {
    let mut headers = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(failed)?.headers;
    match headers.pop() {
        Some(header) if headers.is_empty() && !header.deep => Ok(header),
        _ => Err(failed("it does not hold one flat image")),
    }
}

/// How many values a pixel has where a header's channels are what [`encode`] writes.
fn channels_of(header: &Header) -> Option<usize> {
    let list = &header.channels.list;
    let mut expected = names(list.len()).to_vec();
    expected.sort_unstable();
    let same = |(channel, name): (&ChannelDescription, &&str)| {
        channel.sample_type == SampleType::F32 && channel.name == **name && channel.sampling == Vec2(1, 1)
    };
    (list.len() == expected.len() && list.iter().zip(&expected).all(same)).then_some(expected.len())
}

pub(super) fn decode(bytes: &[u8], kind: PixelKind, width: u32, height: u32) -> Result<Pixels, FormatError> {
    let header = header(bytes)?;
    let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let (found_width, found_height) = (size(header.layer_size.width()), size(header.layer_size.height()));
    if (found_width, found_height) != (width, height) {
        return Err(FormatError::Size { width, height, found_width, found_height });
    }
    let channels = kind.channels();
    if channels_of(&header) != Some(channels) {
        let list: Vec<String> =
            header.channels.list.iter().map(|c| format!("{} {:?}", c.name, c.sample_type)).collect();
        return Err(FormatError::Kind { expected: kind, found: list.join(", ") });
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(failed)?;
    let mut values = vec![0.0; width as usize * height as usize * channels];
    for channel in &image.layer_data.channel_data.list {
        let k = names(channels).iter().position(|name| channel.name == **name);
        let (Some(k), FlatSamples::F32(samples)) = (k, &channel.sample_data) else {
            return Err(failed("its channels are not those of its header"));
        };
        for (value, sample) in values.iter_mut().skip(k).step_by(channels).zip(samples) {
            *value = *sample;
        }
    }
    Ok(Pixels::SceneLinear(channels as u8, values))
}

/// What image a file holds; none where it is no such file.
pub(super) fn kind_of(bytes: &[u8]) -> Option<PixelKind> {
    channels_of(&header(bytes).ok()?).map(|n| PixelKind::SceneLinear(n as u8))
}
