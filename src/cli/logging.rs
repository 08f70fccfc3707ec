//! Logs and errors on stderr.
//!
//! Levels: error ends the command; warn is something that the user should act on; info is a step that takes long; debug
//! is each sample; trace is for developers. Warnings are shown unless asked otherwise.

use super::args::{LogFormat, LoggingArgs};
use std::io::{self, IsTerminal as _, Write as _};
use tracing::level_filters::LevelFilter;

/// Starts logging.
pub(crate) fn start(args: &LoggingArgs) {
    let level = match (args.quiet, args.verbose) {
        (2.., _) => LevelFilter::OFF,
        (1, _) => LevelFilter::ERROR,
        (0, 0) => LevelFilter::WARN,
        (0, 1) => LevelFilter::INFO,
        (0, 2) => LevelFilter::DEBUG,
        (0, 3..) => LevelFilter::TRACE,
    };
    // A closed stderr must not end a run: what cannot be logged is not logged.
    let builder = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(io::stderr)
        .with_target(false)
        .log_internal_errors(false);
    match args.log_format {
        LogFormat::Json => builder.json().init(),
        LogFormat::Text => builder.without_time().with_ansi(io::stderr().is_terminal()).init(),
    }
}

/// Tells the error that ends the command.
pub(crate) fn report(args: &LoggingArgs, error: &anyhow::Error) {
    match args.log_format {
        LogFormat::Json => tracing::error!("{error:#}"),
        LogFormat::Text if args.quiet >= 2 => {}
        LogFormat::Text => drop(writeln!(io::stderr(), "error: {error:#}")),
    }
}
