//! Tar shards for streaming: `{key}.left.png` and so on, in the native coding.

use super::super::encode::{float_tiff, gray};
use super::super::pair::{Pair, Side};
use super::{Files, Unfit};
use crate::dataset::formats::FormatError;

/// A shard of one pair; a loader takes any number of them (`shards/*.tar`).
pub(super) fn shard(pair: &Pair) -> Files {
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
    let bytes = shard.into_inner().map_err(failed)?;
    Ok(vec![(format!("shards/{}.tar", pair.name), bytes)])
}
