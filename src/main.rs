//! The command line of satseed.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
