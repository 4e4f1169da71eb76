//! The `taut` command.

mod cli;
mod daemon;
mod view;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
