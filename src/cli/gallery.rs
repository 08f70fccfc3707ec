//! `satseed gallery`

use super::Exit;
use super::args::GalleryArgs;
use super::new_file::NewFile;
use satseed::dataset::{Dataset, DiskStore, FolderLock};
use satseed::gallery::{gallery_html, put_gallery};
use satseed::pipeline::thread_pool;

pub(crate) fn run(args: &GalleryArgs) -> anyhow::Result<Exit> {
    let store = DiskStore::open(&args.dir)?;
    let pool = thread_pool(std::thread::available_parallelism().map_or(1, usize::from))?;
    if let Some(file) = &args.output {
        let dataset = Dataset::open(&store)?;
        let output = NewFile::create(file)?;
        output.finish(&pool.install(|| gallery_html(&dataset, false))?)?;
    } else {
        let _lock = FolderLock::take(&args.dir)?;
        pool.install(|| put_gallery(&store))?;
    }
    Ok(Exit::Fine)
}
