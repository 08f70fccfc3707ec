//! One writer at a time.

use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A folder's lock, held as long as this lives. The system drops it with its owner, however that one ends, so a dead
/// owner never blocks the next. It is a lock on the folder itself: no file is left in the dataset.
#[derive(Debug)]
pub struct FolderLock {
    _folder: File,
}

/// Why a folder could not be locked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LockError {
    /// Another process holds it.
    #[error("another satseed is writing into `{}`: wait for it to end, or choose another folder", folder.display())]
    Held {
        /// Which folder.
        folder: PathBuf,
    },
    /// The system said no.
    #[error("cannot lock the folder `{}`: {reason}", folder.display())]
    Io {
        /// Which folder.
        folder: PathBuf,
        /// The system's reason.
        reason: std::io::Error,
    },
}

impl FolderLock {
    /// Takes the lock of an existing folder, or says at once that it is held.
    ///
    /// # Errors
    /// [`LockError::Held`] where another process has it.
    pub fn take(folder: &Path) -> Result<Self, LockError> {
        Self::lock(folder, FlockOperation::NonBlockingLockExclusive)
    }

    /// Takes part in the lock of an existing folder, which others may share but nobody may have alone: shards of one plan
    /// write into one folder, while a whole run or a merge waits for none of them to be at work.
    ///
    /// # Errors
    /// [`LockError::Held`] where another process has it alone.
    pub fn share(folder: &Path) -> Result<Self, LockError> {
        Self::lock(folder, FlockOperation::NonBlockingLockShared)
    }

    fn lock(folder: &Path, how: FlockOperation) -> Result<Self, LockError> {
        let failed = |reason| LockError::Io { folder: folder.to_owned(), reason };
        let file = File::open(folder).map_err(failed)?;
        match flock(&file, how) {
            Ok(()) => Ok(Self { _folder: file }),
            Err(Errno::WOULDBLOCK) => Err(LockError::Held { folder: folder.to_owned() }),
            Err(e) => Err(failed(e.into())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_is_refused_until_the_first_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let first = FolderLock::take(folder.path()).unwrap();
        let refusal = FolderLock::take(folder.path()).unwrap_err();
        assert!(matches!(refusal, LockError::Held { .. }));
        assert!(refusal.to_string().contains("another satseed is writing"));
        drop(first);
        let shards = [(); 2].map(|()| FolderLock::share(folder.path()).unwrap());
        assert!(matches!(FolderLock::take(folder.path()), Err(LockError::Held { .. })));
        drop(shards);
        let alone = FolderLock::take(folder.path()).unwrap();
        assert!(matches!(FolderLock::share(folder.path()), Err(LockError::Held { .. })));
        drop(alone);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
    }
}
