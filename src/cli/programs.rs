//! `taut bench` and `taut zenoh`: programs of packages of their own, where they are installed.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::process::Command;

use taut_ipc::own_daemon::{OwnDaemonError, find_program};

use super::error::CliError;

/// A program, and how to get it.
pub(super) struct Program {
    name: &'static str,
    /// What its command line begins with.
    words: &'static [&'static str],
    install: &'static str,
}

/// It measures.
pub(super) const BENCH: Program = Program {
    name: "taut-bench",
    words: &["bench"],
    install: "cargo install --path benches",
};

/// It reaches other machines.
pub(super) const ZENOH: Program = Program {
    name: "taut-zenoh",
    words: &[],
    install: "cargo install --path ipc/zenoh",
};

/// Shorten every problem of a folder and compare with the recorded answers of others, by the
/// program taut-bench
///
/// `taut bench --help` shows its options.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub(super) struct Bench {
    /// What `taut-bench bench` takes
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub(super) arguments: Vec<OsString>,
}

/// Reach daemons of other machines, or let those reach this one's, by the program taut-zenoh
///
/// `taut zenoh --help` shows its commands.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub(super) struct Zenoh {
    /// What `taut-zenoh` takes
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub(super) arguments: Vec<OsString>,
}

impl Program {
    /// Becomes that program; comes back only where there is none, or it cannot be started.
    pub(super) fn run(&self, arguments: &[OsString]) -> Result<u8, CliError> {
        let not_installed = CliError::NoProgram {
            name: self.name,
            install: self.install,
        };
        let program = find_program(self.name).ok_or(not_installed)?;
        let source = Command::new(&program)
            .args(self.words)
            .args(arguments)
            .exec();
        Err(OwnDaemonError::Start { program, source }.into())
    }
}
