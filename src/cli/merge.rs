//! `satseed merge`

use super::Exit;
use super::args::MergeArgs;
use super::generate::default_jobs;
use super::output::write_stdout;
use super::place::{Place, URL_JOBS, is_url, open_store};
use super::verify::planned;
use anyhow::Context as _;
use satseed::dataset::{RECIPE, Store};
use satseed::pipeline::{Merge, merge, thread_pool};

pub(crate) fn run(args: &MergeArgs) -> anyhow::Result<Exit> {
    if args.from.is_empty() && !is_url(&args.dir) {
        // Not created where it is missing: there would be nothing to merge.
        open_store(&args.dir)?;
    }
    let sources = args.from.iter().map(|from| open_store(from)).collect::<anyhow::Result<Vec<_>>>()?;
    let place = Place::create(&args.dir)?;
    let all = [(place.store(), &args.dir)].into_iter().chain(sources.iter().map(AsRef::as_ref).zip(&args.from));
    let mut first = None;
    for (store, dir) in all {
        if store.size(RECIPE)?.is_some() {
            first = Some((store, dir));
            break;
        }
    }
    let (store, dir) =
        first.with_context(|| format!("{} holds no recipe.toml: no shard has written there", args.dir.display()))?;
    let (recipe, plan) = planned(store, dir)?;
    let jobs = match args.jobs {
        Some(jobs) => jobs as usize,
        None if args.from.iter().chain([&args.dir]).any(|place| is_url(place)) => URL_JOBS,
        None => default_jobs(),
    };
    let from: Vec<&dyn Store> = sources.iter().map(AsRef::as_ref).collect();
    let how = Merge { from: &from, pages: !args.no_pages };
    let root_hash = thread_pool(jobs)?.install(|| merge(&recipe, &plan, place.store(), how))?;
    write_stdout(|out| writeln!(out, "{}", root_hash.hex()))?;
    Ok(Exit::Fine)
}
