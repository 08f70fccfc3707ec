//! A file of the user's that is written whole or not at all.

use anyhow::Context as _;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A file under way: it stands beside its place, and gets its name when it is whole.
#[derive(Debug)]
pub(crate) struct NewFile {
    place: PathBuf,
    beside: PathBuf,
    file: File,
}

impl NewFile {
    /// Begins a file, so that a place that cannot be written is told before any work is done for it.
    pub(crate) fn create(place: &Path) -> anyhow::Result<Self> {
        let folder = place.parent().filter(|p| !p.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|f| !f.is_dir()) {
            anyhow::bail!("{} is no folder: create it, or name another place for the file", folder.display());
        }
        if place.is_dir() || place.file_name().is_none() {
            anyhow::bail!("{} is a folder: name a file in it", place.display());
        }
        let mut beside = place.to_owned().into_os_string();
        beside.push(".satseed-unfinished");
        let beside = PathBuf::from(beside);
        let file = File::create(&beside).with_context(|| format!("cannot write {}", place.display()))?;
        Ok(Self { place: place.to_owned(), beside, file })
    }

    /// Fills it and gives it its name, in place of a file that had it.
    pub(crate) fn finish(self, bytes: &[u8]) -> anyhow::Result<()> {
        self.fill(bytes)?.keep()
    }

    /// Fills it; its name comes with [`Filled::keep`], so that files that belong together can come together.
    pub(crate) fn fill(mut self, bytes: &[u8]) -> anyhow::Result<Filled> {
        let written = self.file.write_all(bytes).and_then(|()| self.file.sync_all());
        written.with_context(|| format!("cannot write {}", self.place.display()))?;
        Ok(Filled(self))
    }
}

/// A file that lacks nothing but its name.
#[derive(Debug)]
pub(crate) struct Filled(NewFile);

impl Filled {
    /// Gives the file its name.
    pub(crate) fn keep(self) -> anyhow::Result<()> {
        let NewFile { place, beside, .. } = &self.0;
        fs::rename(beside, place).with_context(|| format!("cannot write {}", place.display()))
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        // Where it has its name already there is nothing to remove.
        let _ = fs::remove_file(&self.beside);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let name = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("a.bin");
        fs::write(&place, "old").unwrap();
        drop(NewFile::create(&place).unwrap());
        drop(NewFile::create(&place).unwrap().fill(b"half").unwrap());
        assert_eq!(fs::read(&place).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.bin"]);
        NewFile::create(&place).unwrap().finish(b"new").unwrap();
        assert_eq!(fs::read(&place).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn places_that_cannot_be_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let told = |path: &Path| NewFile::create(path).unwrap_err().to_string();
        assert!(told(&folder.path().join("no/a.glb")).contains("is no folder"));
        assert!(told(folder.path()).contains("is a folder"));
        assert!(names(folder.path()).is_empty());
    }
}
