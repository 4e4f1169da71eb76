//! The `taut` command.

mod cli;
mod daemon;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
