//! Arguments in, exit code out: the only place that prints.
//!
//! stdout carries data only; errors and logs go to stderr. A closed pipe ends the program quietly.

mod args;
mod completions;
mod cost;
mod evaluate;
mod explain;
mod export;
mod gallery;
mod generate;
mod info;
mod logging;
mod merge;
mod new_file;
mod one_scene;
mod output;
mod place;
mod plan;
mod presets;
mod preview;
mod profile;
mod progress;
mod scene;
mod shard;
mod sweep;
mod verify;

use args::{Cli, Command};
use clap::Parser as _;
use std::process::ExitCode;

/// How a command ended without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// All is well.
    Fine,
    /// A check found what it looks for.
    CheckFailed,
    /// Stopped by a signal at a sample's border; the same command resumes.
    Stopped,
}

/// Exit code of an error: one sentence on stderr. Mistakes on the command line have the same.
const ERROR: u8 = 2;

/// Runs the command of the process's arguments.
pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    logging::start(&cli.logging);
    match run(&cli.command) {
        Ok(Exit::Fine) => ExitCode::SUCCESS,
        Ok(Exit::CheckFailed) => ExitCode::from(1),
        Ok(Exit::Stopped) => ExitCode::from(75),
        Err(error) if output::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            logging::report(&cli.logging, &error);
            ExitCode::from(ERROR)
        }
    }
}

fn run(command: &Command) -> anyhow::Result<Exit> {
    match command {
        Command::Presets(args) => presets::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Preview(args) => preview::run(args),
        Command::Scene(args) => scene::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Info(args) => info::run(args),
        Command::Explain(args) => explain::run(args),
        Command::Evaluate(args) => evaluate::run(args),
        Command::Sweep(args) => sweep::run(args),
        Command::Export(args) => export::run(args),
        Command::Gallery(args) => gallery::run(args),
        Command::Completions(args) => completions::run(args),
    }
}
