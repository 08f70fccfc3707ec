//! A store in a folder.

use super::{Chunks, Entry, Store, StoreError, UNFINISHED, check_path};
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Files in a folder.
///
/// A file is written under a temporary name beside its place, synced, and then given its name by a rename that refuses
/// to replace; the folder is synced after. Until the rename the file does not exist for anyone who reads the dataset.
#[derive(Debug)]
pub struct DiskStore {
    root: PathBuf,
    counter: AtomicU64,
    links_only: bool,
    shared: bool,
    /// Of this machine and process, for names of unfinished files: other machines may write into the same folder.
    owner: String,
}

impl DiskStore {
    /// A store in an existing folder.
    ///
    /// # Errors
    /// Where `root` is no folder.
    pub fn open(root: &Path) -> Result<Self, StoreError> {
        let metadata = fs::metadata(root).map_err(|e| failed("open", root, e))?;
        if !metadata.is_dir() {
            return Err(failed("open", root, io::Error::from(ErrorKind::NotADirectory)));
        }
        let counter = AtomicU64::new(0);
        Ok(Self { root: root.to_owned(), counter, links_only: false, shared: false, owner: owner() })
    }

    /// A store in a folder that is made where it is missing.
    pub fn create(root: &Path) -> Result<Self, StoreError> {
        fs::create_dir_all(root).map_err(|e| failed("create the folder", root, e))?;
        if let Some(parent) = root.parent().filter(|p| !p.as_os_str().is_empty()) {
            sync_folder(parent)?;
        }
        Self::open(root)
    }

    /// Never renames: a new name is a hard link, and the temporary one is removed. For file systems without a rename
    /// that refuses to replace; [`Store::put`] falls back to it by itself.
    #[must_use]
    pub fn with_links(mut self) -> Self {
        self.links_only = true;
        self
    }

    /// Others may be writing into the same folder: see [`Store::is_shared`].
    #[must_use]
    pub fn shared(mut self) -> Self {
        self.shared = true;
        self
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The place of a checked path. A link anywhere on the way is refused, since it could lead out of the root.
    fn place(&self, path: &str) -> Result<PathBuf, StoreError> {
        check_path(path)?;
        let mut place = self.root.clone();
        for part in path.split('/') {
            place.push(part);
            match fs::symlink_metadata(&place) {
                Ok(m) if m.file_type().is_symlink() => {
                    return Err(StoreError::BadPath { path: path.to_owned(), why: "it leads through a link" });
                }
                _ => {}
            }
        }
        Ok(place)
    }

    /// Makes the folders above a file, each durable before anything stands in it.
    fn make_parents(&self, path: &str) -> Result<(), StoreError> {
        let mut folder = self.root.clone();
        let mut parts = path.split('/').peekable();
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                break;
            }
            let parent = folder.clone();
            folder.push(part);
            match fs::create_dir(&folder) {
                Ok(()) => sync_folder(&parent)?,
                Err(e) if e.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
                Err(e) if is_full(&e) => return Err(StoreError::Full { path: path.to_owned(), bytes: 0 }),
                Err(e) => return Err(failed("create the folder", &folder, e)),
            }
        }
        Ok(())
    }
}

impl DiskStore {
    /// Creates a file of what `fill` writes: an error of the system's is inside, of the content's outside.
    fn put_filled(
        &self,
        path: &str,
        bytes: u64,
        fill: &mut dyn FnMut(&mut File) -> Result<io::Result<()>, StoreError>,
    ) -> Result<(), StoreError> {
        let place = self.place(path)?;
        if fs::symlink_metadata(&place).is_ok() {
            return Err(StoreError::Exists { path: path.to_owned() });
        }
        self.make_parents(path)?;
        let folder = place.parent().unwrap_or(&self.root);
        let number = self.counter.fetch_add(1, Ordering::Relaxed);
        let temporary = folder.join(format!("{UNFINISHED}{}-{number}", self.owner));
        let system = |error: io::Error| match error {
            e if is_full(&e) => StoreError::Full { path: path.to_owned(), bytes },
            e if e.kind() == ErrorKind::AlreadyExists => StoreError::Exists { path: path.to_owned() },
            e => failed("write", &place, e),
        };
        let written = (|| {
            let mut file = OpenOptions::new().write(true).create_new(true).open(&temporary).map_err(system)?;
            fill(&mut file)?.and_then(|()| file.sync_all()).map_err(system)?;
            if self.links_only { link(&temporary, &place) } else { rename_new(&temporary, &place) }.map_err(system)
        })();
        if let Err(error) = written {
            // The error at hand says more than a failure to clean up, and the next run clears what is left.
            let _ = fs::remove_file(&temporary);
            return Err(error);
        }
        sync_folder(folder)
    }
}

impl Store for DiskStore {
    fn put(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.put_filled(path, bytes.len() as u64, &mut |file| Ok(file.write_all(bytes)))
    }

    fn put_chunks(&self, path: &str, chunks: &mut Chunks<'_>) -> Result<(), StoreError> {
        self.put_filled(path, 0, &mut |file| {
            for chunk in &mut *chunks {
                if let Err(error) = file.write_all(&chunk?) {
                    return Ok(Err(error));
                }
            }
            Ok(Ok(()))
        })
    }

    fn get_chunks(&self, path: &str, each: &mut dyn FnMut(&[u8])) -> Result<(), StoreError> {
        let place = self.place(path)?;
        if !place.is_file() {
            return Err(StoreError::NotFound { path: path.to_owned() });
        }
        let reading = |e| failed("read", &place, e);
        let (mut file, mut buffer) = (File::open(&place).map_err(reading)?, vec![0; 1 << 20]);
        loop {
            match file.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(n) => each(&buffer[..n]),
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(reading(e)),
            }
        }
    }

    fn is_shared(&self) -> bool {
        self.shared
    }

    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError> {
        let place = self.place(path)?;
        if !place.is_file() {
            return Err(StoreError::NotFound { path: path.to_owned() });
        }
        fs::read(&place).map_err(|e| failed("read", &place, e))
    }

    fn size(&self, path: &str) -> Result<Option<u64>, StoreError> {
        let place = self.place(path)?;
        match fs::symlink_metadata(&place) {
            Ok(m) => Ok(m.is_file().then_some(m.len())),
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
            Err(e) => Err(failed("look at", &place, e)),
        }
    }

    fn list(&self, prefix: &str) -> Result<Vec<Entry>, StoreError> {
        let mut entries = Vec::new();
        if prefix.is_empty() {
            walk(&self.root, "", &mut |_, entry| entries.push(entry))?;
        } else {
            let place = self.place(prefix)?;
            if place.is_dir() {
                walk(&place, prefix, &mut |_, entry| entries.push(entry))?;
            } else if let Some(bytes) = self.size(prefix)? {
                entries.push(Entry { path: prefix.to_owned(), bytes: Some(bytes) });
            }
        }
        entries.sort();
        Ok(entries)
    }

    fn discard(&self, path: &str) -> Result<(), StoreError> {
        let place = self.place(path)?;
        match fs::remove_file(&place) {
            Ok(()) => Ok(()),
            Err(e) if e.kind() == ErrorKind::NotFound => Err(StoreError::NotFound { path: path.to_owned() }),
            Err(e) => Err(failed("remove", &place, e)),
        }
    }

    fn clear_unfinished(&self) -> Result<(), StoreError> {
        let mut unfinished = Vec::new();
        walk(&self.root, "", &mut |place, _| {
            if place.file_name().is_some_and(|n| n.to_string_lossy().starts_with(UNFINISHED)) {
                unfinished.push(place.to_owned());
            }
        })?;
        for place in unfinished {
            fs::remove_file(&place).map_err(|e| failed("remove the unfinished", &place, e))?;
        }
        Ok(())
    }
}

/// Every file below a folder, links and other oddities included, but not followed.
fn walk(folder: &Path, prefix: &str, found: &mut dyn FnMut(&Path, Entry)) -> Result<(), StoreError> {
    let reading = |e| failed("list", folder, e);
    for entry in fs::read_dir(folder).map_err(reading)? {
        let entry = entry.map_err(reading)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = if prefix.is_empty() { name } else { format!("{prefix}/{name}") };
        let kind = entry.file_type().map_err(reading)?;
        if kind.is_dir() {
            walk(&entry.path(), &path, found)?;
        } else {
            let bytes = if kind.is_file() { Some(entry.metadata().map_err(reading)?.len()) } else { None };
            found(&entry.path(), Entry { path, bytes });
        }
    }
    Ok(())
}

/// Which process of which machine this is, in letters that a file name may have.
fn owner() -> String {
    let system = rustix::system::uname();
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let machine: String = system.nodename().to_string_lossy().chars().take(48).map(plain).collect();
    format!("{machine}-{}", std::process::id())
}

fn failed(doing: &'static str, path: &Path, reason: io::Error) -> StoreError {
    StoreError::Io { doing, path: path.display().to_string(), reason }
}

fn is_full(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
}

/// Gives a file its name, unless that name is taken.
fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, from, CWD, to, RenameFlags::NOREPLACE) {
        Ok(()) => Ok(()),
        // NFS and some others do not know the flag.
        Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => link(from, to),
        Err(e) => Err(e.into()),
    }
}

fn link(from: &Path, to: &Path) -> io::Result<()> {
    fs::hard_link(from, to)?;
    fs::remove_file(from)
}

/// Makes the names in a folder durable.
fn sync_folder(folder: &Path) -> Result<(), StoreError> {
    File::open(folder).and_then(|f| f.sync_all()).map_err(|e| failed("sync the folder", folder, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dead_writers_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let store = DiskStore::open(folder.path()).unwrap();
        store.put("scene/sample/left.png", b"whole").unwrap();
        let half = folder.path().join(format!("scene/sample/{UNFINISHED}4711-0"));
        fs::write(&half, b"ha").unwrap();
        store.clear_unfinished().unwrap();
        assert!(!half.exists());
        assert_eq!(store.get("scene/sample/left.png").unwrap(), b"whole");
    }

    #[test]
    fn no_link_is_followed() {
        let folder = tempfile::tempdir().unwrap();
        let outside = tempfile::tempdir().unwrap();
        fs::write(outside.path().join("secret"), b"s").unwrap();
        std::os::unix::fs::symlink(outside.path(), folder.path().join("scene")).unwrap();
        std::os::unix::fs::symlink(outside.path().join("secret"), folder.path().join("file")).unwrap();
        let store = DiskStore::open(folder.path()).unwrap();
        for path in ["scene/secret", "file", "scene/new"] {
            assert!(matches!(store.get(path), Err(StoreError::BadPath { .. })), "{path}");
            assert!(matches!(store.put(path, b"x"), Err(StoreError::BadPath { .. })), "{path}");
        }
        let listed: Vec<_> = store.list("").unwrap().into_iter().map(|e| (e.path, e.bytes)).collect();
        assert_eq!(listed, [("file".to_owned(), None), ("scene".to_owned(), None)]);
    }
}
