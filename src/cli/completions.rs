//! `satseed completions`

use super::Exit;
use super::args::{Cli, CompletionsArgs};
use super::output::write_stdout;
use clap::CommandFactory as _;

pub(crate) fn run(args: &CompletionsArgs) -> anyhow::Result<Exit> {
    // Into memory first: the library panics where it cannot write.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "satseed", &mut script);
    write_stdout(|out| out.write_all(&script))?;
    Ok(Exit::Fine)
}
