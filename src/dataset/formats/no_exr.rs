//! What a build without `OpenEXR` says of its files.

use super::{FormatError, PixelKind, Pixels};

const SENTENCE: &str = "OpenEXR is not in this build: build satseed with `--features exr`";

pub(super) fn encode(_: u32, _: u32, _: usize, _: &[f32]) -> Result<Vec<u8>, FormatError> {
    Err(FormatError::Encode(SENTENCE.to_owned()))
}

pub(super) fn decode(_: &[u8], _: PixelKind, _: u32, _: u32) -> Result<Pixels, FormatError> {
    Err(FormatError::Decode(SENTENCE.to_owned()))
}

pub(super) fn kind_of(_: &[u8]) -> Option<PixelKind> {
    None
}
