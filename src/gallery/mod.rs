//! A dataset to look at: one HTML file that needs no network and no server.
//!
//! It holds every sample's views, reduced, and the labels of every k-th pixel, exact to 1/512 px; where the file lies in the
//! dataset's folder it shows the whole images from beside it. Scripts and style stand in `page/` and are ours.

mod page;
mod reduced;

pub use page::gallery_html;

use crate::dataset::formats::FormatError;
use crate::dataset::{Dataset, GALLERY, ReadError, Seal, Store, StoreError, WriteError, put_same};

/// Most samples of a gallery; of a larger dataset it shows so many, evenly spread over the plan.
pub const MOST_SAMPLES: usize = 1000;

/// Why there is no gallery.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GalleryError {
    /// The dataset cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Another one stands there.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A picture cannot be encoded.
    #[error("sample `{id}`: {reason}")]
    Format {
        /// Which sample.
        id: String,
        /// Why.
        reason: FormatError,
    },
}

/// Writes a finished dataset's gallery into its own folder, on the current rayon pool. The caller holds the folder's lock.
///
/// # Errors
/// Where the dataset cannot be read or the store fails.
pub fn put_gallery(store: &dyn Store) -> Result<(), GalleryError> {
    let page = gallery_html(&Dataset::open(store)?, true)?;
    match store.get(GALLERY) {
        Ok(standing) if standing == page => return Ok(()),
        Ok(_) => store.discard(GALLERY)?,
        Err(StoreError::NotFound { .. }) => {}
        Err(other) => return Err(other.into()),
    }
    // Another machine may have finished the same dataset meanwhile.
    Ok(put_same(store, GALLERY, &page)?)
}

/// The same, where none stands there that is whole and shows this dataset.
///
/// # Errors
/// Where the dataset cannot be read or the store fails.
pub fn ensure_gallery(store: &dyn Store) -> Result<(), GalleryError> {
    let root_hash = Dataset::open(store)?.root_hash().hex();
    match store.get(GALLERY) {
        Ok(page) if Seal::of(&page).is_some_and(|seal| seal.root_hash == root_hash) => Ok(()),
        Ok(_) | Err(StoreError::NotFound { .. }) => put_gallery(store),
        Err(other) => Err(other.into()),
    }
}
