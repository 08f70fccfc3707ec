//! Datasets.
pub mod formats;
mod lock;
mod store;
pub use lock::{FolderLock, LockError};
pub use store::{DiskStore, Entry, MemoryStore, Store, StoreError, check_path};
