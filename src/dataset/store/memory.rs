//! A store in memory, for tests and for making a sample again without writing it.

use super::{Entry, Store, StoreError, check_path};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files in memory.
#[derive(Debug, Default)]
pub struct MemoryStore {
    files: Mutex<BTreeMap<String, Vec<u8>>>,
}

impl MemoryStore {
    fn files(&self) -> MutexGuard<'_, BTreeMap<String, Vec<u8>>> {
        // Every change is one insert or remove, so a panic elsewhere leaves the map whole.
        self.files.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Everything it holds.
    pub fn into_files(self) -> BTreeMap<String, Vec<u8>> {
        self.files.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for MemoryStore {
    fn put(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        check_path(path)?;
        let mut files = self.files();
        if files.contains_key(path) {
            return Err(StoreError::Exists { path: path.to_owned() });
        }
        let below = format!("{path}/");
        let is_folder = files.range(below.clone()..).next().is_some_and(|(p, _)| p.starts_with(&below));
        let through_file = path.match_indices('/').any(|(i, _)| files.contains_key(&path[..i]));
        if is_folder || through_file {
            return Err(StoreError::BadPath { path: path.to_owned(), why: "a file is no folder" });
        }
        files.insert(path.to_owned(), bytes.to_vec());
        Ok(())
    }

    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError> {
        check_path(path)?;
        self.files().get(path).cloned().ok_or_else(|| StoreError::NotFound { path: path.to_owned() })
    }

    fn size(&self, path: &str) -> Result<Option<u64>, StoreError> {
        check_path(path)?;
        Ok(self.files().get(path).map(|b| b.len() as u64))
    }

    fn list(&self, prefix: &str) -> Result<Vec<Entry>, StoreError> {
        let below = format!("{prefix}/");
        Ok(self
            .files()
            .iter()
            .filter(|(path, _)| prefix.is_empty() || *path == prefix || path.starts_with(&below))
            .map(|(path, content)| Entry { path: path.clone(), bytes: Some(content.len() as u64) })
            .collect())
    }

    fn discard(&self, path: &str) -> Result<(), StoreError> {
        check_path(path)?;
        self.files().remove(path).map(|_| ()).ok_or_else(|| StoreError::NotFound { path: path.to_owned() })
    }

    fn clear_unfinished(&self) -> Result<(), StoreError> {
        Ok(())
    }
}
