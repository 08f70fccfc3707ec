//! `satseed export`

use super::Exit;
use super::args::ExportArgs;
use super::output::{sample_bar, write_stdout};
use satseed::dataset::{Dataset, DiskStore};
use satseed::export::{Options, export};
use satseed::pipeline::thread_pool;

pub(crate) fn run(args: &ExportArgs) -> anyhow::Result<Exit> {
    let store = DiskStore::open(&args.dir)?;
    let dataset = Dataset::open(&store)?;
    let options = Options {
        layout: args.layout,
        overlap: args.crop,
        downsample: args.downsample,
        tile: args.tile,
        split: args.split.clone(),
    };
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    let bar = sample_bar();
    let done = |id: &str| {
        tracing::debug!("exported {id}");
        bar.inc(1);
    };
    let exported = thread_pool(jobs)?.install(|| export(&dataset, &args.out, &options, &done));
    bar.finish_and_clear();
    let exported = exported?;
    write_stdout(|out| writeln!(out, "{} pairs, {} files, {} bytes", exported.pairs, exported.files, exported.bytes))?;
    Ok(Exit::Fine)
}
