//! Tar shards for streaming: `{key}.left.png` and so on, in the native coding.

use super::super::Place;
use super::super::encode::{float_tiff, gray};
use super::super::pair::{Pair, Side};
use super::{Files, Unfit};
use crate::dataset::formats::FormatError;

/// Samples of the dataset in a shard, all of their tiles side by side: at 2048 x 2048 px some 200 MB, which loaders stream well.
pub(super) const SAMPLES: usize = 8;
/// What ends a tar file.
pub(super) const END: [u8; 1024] = [0; 1024];

/// A pair's entries, which follow upon those of the pairs before it in the same shard.
pub(super) fn entries(pair: &Pair, place: Place) -> Files {
    let mut shard = ::tar::Builder::new(Vec::new());
    let failed = |e: std::io::Error| Unfit::Format(FormatError::Encode(e.to_string()));
    let mut put = |name: &str, bytes: &[u8]| {
        let mut header = ::tar::Header::new_ustar();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        shard.append_data(&mut header, format!("{}.{name}", pair.name), bytes).map_err(failed)
    };
    for (side, view, labelled) in [(&pair.left, "left", true), (&pair.right, "right", pair.has_right_labels)] {
        let Side { image, disparity_px, validity } = side;
        put(&format!("{view}.{}", image.kind().extension()), &image.encode()?)?;
        if labelled {
            let (width, height) = (image.width, image.height);
            let ending = if view == "left" { "" } else { "_right" };
            put(&format!("disparity{ending}.tif"), &float_tiff(width, height, disparity_px.clone())?)?;
            put(&format!("validity{ending}.png"), &gray(width, height, validity.clone())?)?;
        }
    }
    let mut camera = serde_json::to_vec_pretty(&pair.camera).unwrap_or_default();
    camera.push(b'\n');
    put("camera.json", &camera)?;
    // Without the end that a finished tar has: that comes after the shard's last pair.
    let bytes = std::mem::take(shard.get_mut());
    Ok(vec![(format!("shards/{:06}.tar", place.sample / SAMPLES), bytes)])
}
