//! The programs that are started: `taut`, which serves, and this one again, which asks.

use std::path::PathBuf;
use std::process::Command;

use taut_ipc::Instance;
use taut_ipc::own_daemon::{command, find_program};

use crate::error::Error;

/// The file of `taut`.
pub(crate) fn taut() -> Result<PathBuf, Error> {
    find_program("taut").ok_or(Error::NoTaut)
}

/// The file of this program.
pub(crate) fn own() -> Result<PathBuf, Error> {
    std::env::current_exe().map_err(|source| Error::System {
        what: "this program's file",
        source,
    })
}

/// This program again, for an instance.
pub(crate) fn again(instance: &Instance) -> Result<Command, Error> {
    Ok(command(&own()?, instance))
}
