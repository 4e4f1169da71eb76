//! `taut bench`: the program that measures, where it is installed.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::process::Command;

use taut_ipc::own_daemon::{OwnDaemonError, find_program};

use super::error::CliError;

const PROGRAM: &str = "taut-bench";

/// Shorten every problem of a folder and compare with the recorded answers of others, by the
/// program taut-bench
///
/// `taut bench --help` shows its options.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub(super) struct Arguments {
    /// What `taut-bench bench` takes
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

const NOT_INSTALLED: CliError = CliError::NoProgram {
    name: PROGRAM,
    install: "cargo install --path benches",
};

/// Becomes that program; comes back only where there is none, or it cannot be started.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let program = find_program(PROGRAM).ok_or(NOT_INSTALLED)?;
    let source = Command::new(&program)
        .arg("bench")
        .args(&arguments.arguments)
        .exec();
    Err(OwnDaemonError::Start { program, source }.into())
}
