//! Where a dataset's files go: create-only, on disk or in object storage.
//!
//! A file appears whole or not at all, and never changes once it stands. Everything else that reliability needs
//! (resume, verify, equal trees) is built on these two facts and on nothing that only a disk can do.

mod disk;
mod memory;
#[cfg(feature = "cloud")]
mod object;

pub use disk::DiskStore;
pub use memory::MemoryStore;
#[cfg(feature = "cloud")]
pub use object::ObjectStore;

/// Unfinished files begin so. A dot is not allowed in a dataset's own names, so nothing else can be meant.
pub(super) const UNFINISHED: &str = ".satseed-unfinished-";

/// A file as [`Store::list`] sees it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Path below the store's root, with `/` between its parts.
    pub path: String,
    /// Size, bytes; none where the entry is a link or no regular file, which a dataset never holds.
    pub bytes: Option<u64>,
}

/// A place for files that are written once.
///
/// Paths are relative, with `/` between parts; each part is `[A-Za-z0-9_.-]`, at most 128 long and does not begin with a
/// dot. Anything else is refused, whatever wrote it, since paths also come from strangers' manifests.
pub trait Store: Send + Sync {
    /// Creates a file with this content, whole and durable on return, or nothing at all.
    ///
    /// # Errors
    /// [`StoreError::Exists`] where the path is taken: its content stays as it was. [`StoreError::Full`] where there is
    /// no room: nothing is left behind.
    fn put(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError>;

    /// The content of a file.
    ///
    /// # Errors
    /// [`StoreError::NotFound`] where there is none.
    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError>;

    /// The size of a file in bytes, none where there is no such file.
    fn size(&self, path: &str) -> Result<Option<u64>, StoreError>;

    /// Every file at or below a folder (all of them for the empty prefix), sorted by path. No link is followed.
    fn list(&self, prefix: &str) -> Result<Vec<Entry>, StoreError>;

    /// Removes a file that nothing has recorded yet. The writer calls it for the left-overs of a run that died, and for
    /// nothing else: what a record names is never touched.
    fn discard(&self, path: &str) -> Result<(), StoreError>;

    /// Clears what dead writers left unfinished. Only who knows that nobody else is writing may call it.
    fn clear_unfinished(&self) -> Result<(), StoreError>;

    /// Whether others may be writing here at the same time. Then what stands is whole and somebody's own: nothing is
    /// cleared or discarded for not being what it should be.
    fn is_shared(&self) -> bool {
        false
    }

    /// [`Self::put`] of a content that comes piece by piece and need not fit memory. An error among the pieces is given
    /// back, and nothing is created.
    ///
    /// # Errors
    /// As [`Self::put`].
    fn put_chunks(&self, path: &str, chunks: &mut Chunks<'_>) -> Result<(), StoreError> {
        let mut content = Vec::new();
        for chunk in chunks {
            content.extend(chunk?);
        }
        self.put(path, &content)
    }

    /// Hands over the content of a file piece by piece.
    ///
    /// # Errors
    /// As [`Self::get`]; pieces may have been handed over before.
    fn get_chunks(&self, path: &str, each: &mut dyn FnMut(&[u8])) -> Result<(), StoreError> {
        each(&self.get(path)?);
        Ok(())
    }
}

/// The pieces of a content.
pub type Chunks<'a> = dyn Iterator<Item = Result<Vec<u8>, StoreError>> + 'a;

/// Why a store could not do what was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The path is taken.
    #[error("`{path}` exists already, and a dataset's files are written once")]
    Exists {
        /// Below the root.
        path: String,
    },
    /// There is no such file.
    #[error("`{path}` does not exist")]
    NotFound {
        /// Below the root.
        path: String,
    },
    /// No room is left.
    #[error(
        "no room for `{path}` ({bytes} bytes): free some space and run the same command again, it goes on from here"
    )]
    Full {
        /// Below the root.
        path: String,
        /// What was to be written.
        bytes: u64,
    },
    /// Not a path that a dataset may hold.
    #[error("`{path}` cannot be a dataset's file: {why}")]
    BadPath {
        /// As given.
        path: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A server said no, or nothing at all.
    #[error("cannot {doing} `{path}`: {reason}")]
    Remote {
        /// What was tried.
        doing: &'static str,
        /// Which file, with the root.
        path: String,
        /// What the server said, and what to do.
        reason: String,
    },
    /// A place that is none.
    #[error("`{place}` is no place for a dataset: {why}")]
    BadPlace {
        /// As given.
        place: String,
        /// What would be right.
        why: String,
    },
    /// The system said no.
    #[error("cannot {doing} `{path}`: {reason}")]
    Io {
        /// What was tried.
        doing: &'static str,
        /// Which file, with the root.
        path: String,
        /// The system's reason.
        reason: std::io::Error,
    },
}

/// Refuses a path that leaves the root or could not stand on every system.
///
/// # Errors
/// [`StoreError::BadPath`] with what is wrong.
pub fn check_path(path: &str) -> Result<(), StoreError> {
    // Escaped: a stranger's path must not steer a terminal.
    let shown = || path.chars().take(200).flat_map(char::escape_default).collect();
    let bad = |why| Err(StoreError::BadPath { path: shown(), why });
    if path.is_empty() || path.len() > 512 {
        return bad("a path has 1 to 512 characters");
    }
    for part in path.split('/') {
        if part.is_empty() || part.len() > 128 {
            return bad("each part of a path has 1 to 128 characters");
        }
        if part.starts_with('.') {
            return bad("no part of a path begins with a dot");
        }
        if !part.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.')) {
            return bad("a path holds only letters, digits, `_`, `-`, `.` and `/`");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_strangers_are_refused() {
        for bad in ["", "/etc/passwd", "../x", "a/../b", "a//b", "a/", "./a", "a\\b", "a/.hidden", "ä", "a\0b", "C:x"]
        {
            assert!(matches!(check_path(bad), Err(StoreError::BadPath { .. })), "{bad:?}");
        }
        assert!(check_path(&"x/".repeat(400)).is_err());
        for good in ["recipe.toml", "canyon-gorge-1/b03-a17/left.png", "croissant.json"] {
            check_path(good).unwrap();
        }
    }

    /// What every store must do, whichever it is. Object stores have no folders that a file could stand in the way of.
    pub(super) fn conforms(store: &dyn Store, has_folders: bool) {
        assert_eq!(store.list("").unwrap(), []);
        assert!(matches!(store.get("a/b.bin"), Err(StoreError::NotFound { .. })));
        assert_eq!(store.size("a/b.bin").unwrap(), None);

        store.put("a/b.bin", b"one").unwrap();
        store.put("a/empty", b"").unwrap();
        store.put("b.bin", &vec![7; 100_000]).unwrap();
        store.put("a/b/c/d", b"deep").unwrap();
        assert_eq!(store.get("a/b.bin").unwrap(), b"one");
        assert_eq!(store.get("a/empty").unwrap(), b"");
        assert_eq!(store.get("b.bin").unwrap(), vec![7; 100_000]);
        assert_eq!(store.size("b.bin").unwrap(), Some(100_000));
        assert_eq!(store.size("a").unwrap(), None, "a folder is no file");
        assert!(matches!(store.get("a"), Err(StoreError::NotFound { .. })));

        // Create-only: the first content stays, also where the second is the same.
        assert!(matches!(store.put("a/b.bin", b"two"), Err(StoreError::Exists { .. })));
        assert!(matches!(store.put("a/b.bin", b"one"), Err(StoreError::Exists { .. })));
        assert_eq!(store.get("a/b.bin").unwrap(), b"one");
        // A file is no folder, a folder no file.
        if has_folders {
            assert!(store.put("a/b.bin/c", b"x").is_err());
            assert!(store.put("a/b/c", b"x").is_err());
        }

        let paths = |prefix| -> Vec<(String, Option<u64>)> {
            store.list(prefix).unwrap().into_iter().map(|e| (e.path, e.bytes)).collect()
        };
        let all = [("a/b.bin", 3), ("a/b/c/d", 4), ("a/empty", 0), ("b.bin", 100_000)];
        assert_eq!(paths(""), all.map(|(p, n)| (p.to_owned(), Some(n))));
        assert_eq!(paths("a/b"), [("a/b/c/d".to_owned(), Some(4))]);
        assert_eq!(paths("a/b.bin"), [("a/b.bin".to_owned(), Some(3))]);
        assert_eq!(paths("nothing"), []);

        store.discard("a/empty").unwrap();
        assert!(matches!(store.discard("a/empty"), Err(StoreError::NotFound { .. })));
        store.put("a/empty", b"again").unwrap();
        assert_eq!(store.get("a/empty").unwrap(), b"again");

        for bad in ["../x", "/x", "", "a/../x"] {
            assert!(matches!(store.put(bad, b""), Err(StoreError::BadPath { .. })));
            assert!(matches!(store.get(bad), Err(StoreError::BadPath { .. })));
            assert!(matches!(store.size(bad), Err(StoreError::BadPath { .. })));
            assert!(matches!(store.discard(bad), Err(StoreError::BadPath { .. })));
        }

        // Many writers of one path: exactly one wins, and its content is whole.
        let winners: usize = std::thread::scope(|scope| {
            let threads: Vec<_> =
                (0..8_u8).map(|i| scope.spawn(move || store.put("race", &vec![i; 50_000]).is_ok())).collect();
            threads.into_iter().map(|t| usize::from(t.join().unwrap())).sum()
        });
        assert_eq!(winners, 1);
        let content = store.get("race").unwrap();
        assert!(content.len() == 50_000 && content.iter().all(|b| *b == content[0]));

        // In pieces, also more of them than one request holds; an error on the way creates nothing.
        let pieces = |n: u8| (0..n).map(|i| Ok(vec![i; 1 << 20]));
        store.put_chunks("pieces", &mut pieces(70)).unwrap();
        assert!(matches!(store.put_chunks("pieces", &mut pieces(1)), Err(StoreError::Exists { .. })));
        let (mut bytes, mut sum) = (0, 0_u64);
        let mut count = |piece: &[u8]| {
            bytes += piece.len();
            sum += piece.iter().map(|b| u64::from(*b)).sum::<u64>();
        };
        store.get_chunks("pieces", &mut count).unwrap();
        assert_eq!((bytes, sum), (70 << 20, (0..70).sum::<u64>() << 20));
        assert!(matches!(store.get_chunks("a", &mut |_| ()), Err(StoreError::NotFound { .. })));
        let broken = || StoreError::NotFound { path: "elsewhere".into() };
        let mut failing = pieces(70).chain([Err(broken())]);
        assert!(matches!(store.put_chunks("broken", &mut failing), Err(StoreError::NotFound { .. })));
        let mut failing = pieces(1).chain([Err(broken())]);
        assert!(matches!(store.put_chunks("broken", &mut failing), Err(StoreError::NotFound { .. })));
        assert_eq!(store.size("broken").unwrap(), None);

        // One large content too: whole, and once.
        store.put("large", &vec![9; 70 << 20]).unwrap();
        assert!(matches!(store.put("large", &vec![8; 70 << 20]), Err(StoreError::Exists { .. })));
        let content = store.get("large").unwrap();
        assert!(content.len() == 70 << 20 && content.iter().all(|b| *b == 9));

        store.clear_unfinished().unwrap();
        assert_eq!(store.list("").unwrap().len(), 7, "only unfinished files are cleared");
    }

    #[test]
    fn memory_conforms() {
        conforms(&MemoryStore::default(), true);
    }

    #[test]
    fn disk_conforms() {
        let folder = tempfile::tempdir().unwrap();
        conforms(&DiskStore::open(folder.path()).unwrap(), true);
    }

    /// Where a file system knows no rename that refuses, links do the same.
    #[test]
    fn disk_conforms_with_links() {
        let folder = tempfile::tempdir().unwrap();
        conforms(&DiskStore::open(folder.path()).unwrap().with_links(), true);
    }
}
