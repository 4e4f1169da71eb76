//! A daemon on a host.

use std::fs::{self, File};
use std::process::Stdio;
use std::time::Duration;

use taut_ipc::control::{ControlReply, ControlRequest, Stats};
use taut_ipc::memory::shared_files;
use taut_ipc::{Client, DaemonState, Instance, daemon_state};

use crate::error::Error;
use crate::jobs::{self, PROBLEMS};
use crate::network::Host;
use crate::process::{Process, until};
use crate::programs::TAUT;

const PATIENCE: Duration = Duration::from_secs(20);

/// A daemon with the problems loaded; gone when this is dropped, with its shared memory.
#[derive(Debug)]
pub(crate) struct Daemon {
    process: Process,
    instance: Instance,
}

impl Daemon {
    /// Starts it on a host, as the instance `name`, with so many workers, and waits until it serves.
    pub(crate) fn start(host: &Host, name: &str, workers: usize) -> Result<Self, Error> {
        let instance = host.instance(name)?;
        let config = host.folder().join(format!("{name}.toml"));
        fs::write(&config, configuration(workers)).map_err(unwritable)?;
        let log = File::create(host.folder().join(format!("{name}.log"))).map_err(unwritable)?;
        let mut command = host.command(&TAUT.find()?, &instance);
        command
            .args(["serve", "--config"])
            .arg(&config)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log);
        let mut daemon = Self {
            process: Process::start(&format!("daemon {name} of {}", host.name()), command)?,
            instance,
        };
        daemon.wait_until_up()?;
        Ok(daemon)
    }

    fn wait_until_up(&mut self) -> Result<(), Error> {
        let is_up = until(PATIENCE, || {
            !self.process.is_alive()
                || matches!(
                    daemon_state(&self.instance),
                    Ok(DaemonState::Running { .. })
                )
        });
        match is_up.is_some() && self.process.is_alive() {
            true => Ok(()),
            false => Err(self.process.failed("does not come up")),
        }
    }

    /// Where it serves.
    pub(crate) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Whether the process that was started serves.
    pub(crate) fn is_alive(&mut self) -> bool {
        self.process.is_alive()
    }

    /// A connection on its own host.
    pub(crate) fn client(&self) -> Result<Client, Error> {
        Ok(Client::connect(&self.instance)?)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        self.process.end();
        for file in shared_files(&self.instance) {
            let _ = fs::remove_file(file.path);
        }
    }
}

/// A number that a daemon tells of itself.
pub(crate) fn number(client: &Client, name: &str) -> Result<f64, Error> {
    let stats = stats(client)?;
    Ok(stats.numbers.get(name).copied().unwrap_or(0.0))
}

fn stats(client: &Client) -> Result<Stats, Error> {
    match client.control(&ControlRequest::Stats, PATIENCE)? {
        ControlReply::Stats(stats) => Ok(stats),
        other => Err(Error::Process {
            what: "daemon".to_owned(),
            reason: format!("answers {other:?}"),
        }),
    }
}

fn configuration(workers: usize) -> String {
    let mut text = format!("workers = {workers}\nfault_injection = true\n");
    for name in PROBLEMS {
        let file = jobs::file(name);
        text += &format!("[[problems]]\nfile = {file:?}\nrobot = {name:?}\nscene = {name:?}\n");
    }
    text
}

fn unwritable(source: std::io::Error) -> Error {
    Error::System {
        what: "a daemon's folder",
        source,
    }
}
