//! `taut-zenoh` on a host: beside a daemon, or as a planner's local instance.

use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use taut_ipc::Instance;
use taut_ipc::memory::shared_files;

use crate::daemon::Daemon;
use crate::error::Error;
use crate::network::Host;
use crate::process::Process;
use crate::programs::GATEWAY;

/// The port of every gateway.
const PORT: u16 = 7447;
const PATIENCE: Duration = Duration::from_secs(20);

/// Where a host's gateway listens.
pub(crate) fn endpoint(host: &Host) -> String {
    format!("tcp/{}:{PORT}", host.address())
}

/// A daemon with a gateway beside it.
#[derive(Debug)]
pub(crate) struct Station {
    // Before the daemon: fields are dropped in order.
    pub gateway: Process,
    pub daemon: Daemon,
}

impl Station {
    /// Starts both on a host; `more` are arguments of the gateway's.
    pub(crate) fn start(host: &Host, workers: usize, more: &[&str]) -> Result<Self, Error> {
        let daemon = Daemon::start(host, "daemon", workers)?;
        Ok(Self {
            gateway: serve(host, &daemon, more)?,
            daemon,
        })
    }
}

/// A gateway beside a daemon.
pub(crate) fn serve(host: &Host, daemon: &Daemon, more: &[&str]) -> Result<Process, Error> {
    let mut command = host.command(&GATEWAY.find()?, daemon.instance());
    command
        .args(["serve", "--name", host.name(), "--listen", &endpoint(host)])
        .args(more);
    ready(host, &format!("serve-{}", host.name()), command)
}

/// A local instance that is one of daemons on other hosts.
#[derive(Debug)]
pub(crate) struct Attached {
    process: Process,
    instance: Instance,
}

impl Attached {
    /// Starts it, and waits until it is ready.
    pub(crate) fn start(
        host: &Host,
        name: &str,
        connect: &[String],
        more: &[&str],
    ) -> Result<Self, Error> {
        let instance = host.instance(name)?;
        let mut command = host.command(&GATEWAY.find()?, &instance);
        command.args(["attach", &format!("{name}:{}", instance.root().display())]);
        for endpoint in connect {
            command.args(["--connect", endpoint]);
        }
        command.args(more);
        Ok(Self {
            process: ready(host, &format!("attach-{name}"), command)?,
            instance,
        })
    }

    /// Where it serves.
    pub(crate) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// The process.
    pub(crate) fn process(&mut self) -> &mut Process {
        &mut self.process
    }
}

impl Drop for Attached {
    fn drop(&mut self) {
        self.process.end();
        for file in shared_files(&self.instance) {
            let _ = fs::remove_file(file.path);
        }
    }
}

/// Starts it with its log in the host's folder, and waits until it says that it is ready.
pub(crate) fn ready(host: &Host, name: &str, mut command: Command) -> Result<Process, Error> {
    let log = host.folder().join(format!("{name}.log"));
    let opened = File::options()
        .create(true)
        .append(true)
        .open(&log)
        .map_err(|source| Error::System {
            what: "a gateway's log",
            source,
        })?;
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(opened);
    let mut process = Process::start(name, command)?;
    let (say, said) = channel();
    let pipes = process.pipes();
    // Ends when the process does, which closes the pipe.
    std::thread::spawn(move || {
        let (stdin, out) = pipes?;
        let lines = BufReader::new(out).lines();
        lines
            .map_while(Result::ok)
            // Only the first is waited for.
            .for_each(|line| _ = say.send(line));
        drop(stdin);
        Some(())
    });
    match said.recv_timeout(PATIENCE) {
        Ok(line) if line.starts_with("ready") => Ok(process),
        _ => Err(process.failed(format!("is not ready; it says: {}", last_line(&log)))),
    }
}

fn last_line(log: &std::path::Path) -> String {
    let text = fs::read_to_string(log).unwrap_or_default();
    text.lines()
        .last()
        .unwrap_or("nothing")
        .to_owned()
}
