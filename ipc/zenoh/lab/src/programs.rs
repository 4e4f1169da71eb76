//! The programs that are measured.

use std::path::PathBuf;

use taut_ipc::own_daemon::find_program;

use crate::error::Error;

/// A program of the project, and how it comes to be.
pub(crate) struct Program {
    name: &'static str,
    /// Variable that may name its file.
    variable: &'static str,
    build: &'static str,
}

/// The daemon and command line. It belongs to another workspace.
pub(crate) const TAUT: Program = Program {
    name: "taut",
    variable: "TAUT_BIN",
    build: "build it with `cargo build --release --bin taut` in the project's folder and give its file",
};

/// The gateway.
pub(crate) const GATEWAY: Program = Program {
    name: "taut-zenoh",
    variable: "TAUT_ZENOH_BIN",
    build: "build it with `cargo build --release --manifest-path ipc/zenoh/Cargo.toml`",
};

impl Program {
    /// Its file: the variable's, else beside this program or on PATH, else where the project's own
    /// build puts it.
    pub(crate) fn find(&self) -> Result<PathBuf, Error> {
        let named = std::env::var_os(self.variable).map(PathBuf::from);
        let found = named
            .filter(|file| file.is_file())
            .or_else(|| find_program(self.name))
            .or_else(|| self.built());
        found.ok_or(Error::NoProgram {
            name: self.name,
            variable: self.variable,
            build: self.build,
        })
    }

    fn built(&self) -> Option<PathBuf> {
        let file = project().join("target/release").join(self.name);
        file.is_file().then_some(file)
    }
}

/// The project's folder.
pub(crate) fn project() -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");
    std::fs::canonicalize(folder).unwrap_or_else(|_| folder.into())
}

/// This program.
pub(crate) fn own() -> Result<PathBuf, Error> {
    std::env::current_exe().map_err(|source| Error::System {
        what: "this program's file",
        source,
    })
}

/// What a language's program needs, where its build puts it; the variable may name another place.
pub(crate) fn built(variable: &str, places: &[&str]) -> Option<PathBuf> {
    let named = std::env::var_os(variable).map(PathBuf::from);
    let usual = places.iter().map(|place| project().join(place));
    named
        .into_iter()
        .chain(usual)
        .find(|place| place.exists())
}
