//! Where a dataset stands: a folder or a URL.

use anyhow::Context as _;
use satseed::dataset::{DiskStore, FolderLock, Store};
use std::path::Path;

/// Requests at once to a server: most of the time each only waits.
pub(super) const URL_JOBS: usize = 32;

/// A place to write to, with what keeps others from it.
pub(super) struct Place {
    store: Box<dyn Store>,
    _lock: Option<FolderLock>,
}

impl Place {
    /// A place for one process alone. Object storage has no locks: there, whoever writes the same writes the same bytes.
    pub(super) fn create(place: &Path) -> anyhow::Result<Self> {
        if let Some(url) = url(place) {
            return Ok(Self { store: open_url(url)?, _lock: None });
        }
        let store = DiskStore::create(place)?;
        Ok(Self { store: Box::new(store), _lock: Some(FolderLock::take(place)?) })
    }

    /// A place that other shards of the plan may be writing to.
    pub(super) fn create_shared(place: &Path) -> anyhow::Result<Self> {
        if url(place).is_some() {
            return Self::create(place);
        }
        let store = DiskStore::create(place)?.shared();
        Ok(Self { store: Box::new(store), _lock: Some(FolderLock::share(place)?) })
    }

    /// Its store.
    pub(super) fn store(&self) -> &dyn Store {
        self.store.as_ref()
    }
}

/// A place to read.
pub(super) fn open_store(place: &Path) -> anyhow::Result<Box<dyn Store>> {
    match url(place) {
        Some(url) => open_url(url),
        None => Ok(Box::new(DiskStore::open(place)?)),
    }
}

/// Whether a place is in object storage.
pub(super) fn is_url(place: &Path) -> bool {
    url(place).is_some()
}

fn url(place: &Path) -> Option<&str> {
    let text = place.to_str()?;
    let (scheme, _) = text.split_once("://")?;
    scheme.bytes().all(|b| b.is_ascii_alphanumeric()).then_some(text)
}

fn open_url(url: &str) -> anyhow::Result<Box<dyn Store>> {
    #[cfg(feature = "cloud")]
    if satseed::dataset::ObjectStore::is_url(url) {
        return Ok(Box::new(satseed::dataset::ObjectStore::open(url)?));
    }
    let schemes = if cfg!(feature = "cloud") {
        "a folder, or s3://, gs:// or az://"
    } else {
        "a folder: this build has no object storage, which the feature `cloud` adds"
    };
    None.with_context(|| format!("`{url}` is no place for a dataset: write {schemes}"))
}
