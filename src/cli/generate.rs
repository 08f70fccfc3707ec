//! `satseed generate`

use super::Exit;
use super::args::GenerateArgs;
use super::output::write_stdout;
use super::plan::write_summary;
use satseed::plan::Plan;

pub(crate) fn run(args: &GenerateArgs) -> anyhow::Result<Exit> {
    let recipe = args.recipe.load()?;
    let plan = Plan::new(&recipe)?;
    if args.dry_run {
        write_stdout(|out| write_summary(out, &recipe, &plan, args.jobs.unwrap_or(1)))?;
        return Ok(Exit::Fine);
    }
    anyhow::bail!("generate is not built yet")
}
