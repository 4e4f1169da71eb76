//! The demo's own daemon: this program again, in a folder of its own that goes when the demo ends.

use std::fs::{self, DirBuilder, File};
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use taut_ipc::control::ControlRequest;
use taut_ipc::{Client, DaemonState, INSTANCE_VARIABLE, Instance, daemon_state, server};

use super::error::DemoError;

const START_PATIENCE: Duration = Duration::from_secs(10);
const STOP_PATIENCE: Duration = Duration::from_secs(3);
const NAME: &str = "demo";

/// A private folder; removed when dropped.
struct Folder(PathBuf);

impl Folder {
    /// In the folder for temporary files, or where sockets in there would have too long a path, in another.
    fn create() -> Result<Self, DemoError> {
        let mut reason = String::new();
        for base in [std::env::temp_dir(), "/dev/shm".into(), "/tmp".into()] {
            let folder = base.join(format!("taut-demo-{}", std::process::id()));
            // The instance checks the length of its root.
            if let Err(error) = Instance::new(NAME, folder.join("run")) {
                reason = error.to_string();
                continue;
            }
            match DirBuilder::new().mode(0o700).create(&folder) {
                Ok(()) => return Ok(Self(folder)),
                Err(error) => reason = format!("{}: {error}", folder.display()),
            }
        }
        Err(DemoError::NoFolder(reason))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nobody is left to tell; what cannot be removed here lies in the folder for temporary files.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The running daemon; stopped when dropped, the hard way if need be.
pub(super) struct Daemon {
    child: Option<Child>,
    instance: Instance,
    // After the rest: fields are dropped in order.
    folder: Folder,
}

impl Daemon {
    /// Makes the folder, lets `fill` put files into it, and starts the daemon.
    pub(super) fn start(fill: impl FnOnce(&Path) -> std::io::Result<()>) -> Result<Self, DemoError> {
        let folder = Folder::create()?;
        let unwritable = |error: std::io::Error| DemoError::NoFolder(format!("{}: {error}", folder.0.display()));
        fill(&folder.0).map_err(unwritable)?;
        let log = File::create(folder.0.join("daemon.log")).map_err(unwritable)?;
        let instance = Instance::new(NAME, folder.0.join("run"))?;
        let mut command = this_program(&instance)?;
        command.arg("serve").stdin(Stdio::null()).stderr(log.try_clone().map_err(unwritable)?).stdout(log);
        // Ctrl-C at the terminal then goes to the demo alone, which stops things in order.
        command.process_group(0);
        let child = Some(spawn(command)?);
        let mut daemon = Self { child, instance, folder };
        daemon.wait_until_up()?;
        Ok(daemon)
    }

    /// The folder that `fill` filled.
    pub(super) fn folder(&self) -> &Path {
        &self.folder.0
    }

    /// Where it serves.
    pub(super) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Asks it to end, and waits.
    pub(super) fn stop(mut self) -> Result<(), DemoError> {
        let client = Client::connect(&self.instance)?;
        client.control(&ControlRequest::Shutdown, STOP_PATIENCE)?;
        drop(client);
        match self.ends_within(STOP_PATIENCE) {
            true => Ok(()),
            false => Err(self.failed("did not stop when asked")),
        }
    }

    fn wait_until_up(&mut self) -> Result<(), DemoError> {
        let end = Instant::now() + START_PATIENCE;
        while !matches!(daemon_state(&self.instance), Ok(DaemonState::Running { .. })) {
            if self.ends_within(Duration::from_millis(2)) {
                return Err(self.failed("ended at once"));
            }
            if Instant::now() > end {
                return Err(self.failed("does not come up"));
            }
        }
        Ok(())
    }

    /// Whether the process ends in time; it is reaped then.
    fn ends_within(&mut self, patience: Duration) -> bool {
        let end = Instant::now() + patience;
        while let Some(child) = &mut self.child {
            if !matches!(child.try_wait(), Ok(None)) {
                self.child = None;
            } else if Instant::now() >= end {
                return false;
            } else {
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        true
    }

    fn failed(&self, what: &str) -> DemoError {
        let log = fs::read_to_string(self.folder.0.join("daemon.log")).unwrap_or_default();
        let last = log.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("nothing");
        DemoError::Daemon { what: what.to_owned(), log: last.to_owned() }
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        if let Some(pid) = self.child.as_ref().map(Pid::from_child) {
            // A child that is not reaped yet keeps its number, so that this cannot meet another process.
            let _ = kill_process(pid, Signal::TERM);
            if !self.ends_within(STOP_PATIENCE)
                && let Some(mut child) = self.child.take()
            {
                let _ = child.kill();
                let _ = child.wait();
            }
        }
        // Planners that were killed leave shared memory behind, and so does a daemon; whoever takes the
        // instance next wipes it.
        drop(server::Server::create(&self.instance));
    }
}

/// This program again, for this instance.
pub(super) fn this_program(instance: &Instance) -> Result<Command, DemoError> {
    let start = |source| DemoError::Start { program: "taut".into(), source };
    let mut command = Command::new(std::env::current_exe().map_err(start)?);
    command.env(INSTANCE_VARIABLE, format!("{}:{}", instance.name(), instance.root().display()));
    Ok(command)
}

/// Starts a program.
pub(super) fn spawn(mut command: Command) -> Result<Child, DemoError> {
    command.spawn().map_err(|source| DemoError::Start { program: command.get_program().into(), source })
}
