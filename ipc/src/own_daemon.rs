//! A daemon of a program's own, in a private folder that goes with it: for demonstrations, measurements
//! and planners' tests, which meet no other daemon and leave nothing behind.

use std::fs::{self, DirBuilder, File};
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::client::{Client, ClientError};
use crate::control::ControlRequest;
use crate::instance::{INSTANCE_VARIABLE, Instance, InstanceError};
use crate::lock::{DaemonState, daemon_state};
use crate::server;
use crate::wire::Code;

const START_PATIENCE: Duration = Duration::from_secs(10);
const STOP_PATIENCE: Duration = Duration::from_secs(3);

/// Why there is no daemon of the program's own.
#[derive(Debug, thiserror::Error)]
pub enum OwnDaemonError {
    /// No folder for it.
    #[error(
        "no folder for the command's own daemon: {0}; set TMPDIR to a short path that can be written"
    )]
    NoFolder(String),
    /// A process cannot be started.
    #[error("{program}: {source}")]
    Start {
        /// Its file.
        program: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It ended, or does not come up.
    #[error("the command's own daemon {what}; it says: {log}")]
    Daemon {
        /// What it did.
        what: String,
        /// The end of its log.
        log: String,
    },
    /// It cannot be reached.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The instance.
    #[error(transparent)]
    Instance(#[from] InstanceError),
}

impl OwnDaemonError {
    /// Exit code of a command that ends with it.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::NoFolder(_) => 66,
            Self::Start { .. } => 67,
            Self::Daemon { .. } | Self::Instance(_) => Code::DaemonLost.exit_code(),
            Self::Client(error) => error.code().exit_code(),
        }
    }
}

/// A private folder; removed when dropped.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// In the folder for temporary files, or where sockets in there would have too long a path, in
    /// another. `name` is the instance's, too.
    ///
    /// # Errors
    /// No folder that can be written and has a short enough path.
    pub fn create(name: &str) -> Result<Self, OwnDaemonError> {
        let mut reason = String::new();
        for base in [std::env::temp_dir(), "/dev/shm".into(), "/tmp".into()] {
            let folder = base.join(format!("taut-{name}-{}", std::process::id()));
            // The instance checks the length of its root.
            if let Err(error) = Instance::new(name, folder.join("run")) {
                reason = error.to_string();
                continue;
            }
            match DirBuilder::new().mode(0o700).create(&folder) {
                Ok(()) => return Ok(Self(folder)),
                Err(error) => reason = format!("{}: {error}", folder.display()),
            }
        }
        Err(OwnDaemonError::NoFolder(reason))
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nobody is left to tell; what cannot be removed here lies in the folder for temporary
        // files.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The running daemon; stopped when dropped, the hard way if need be.
#[derive(Debug)]
pub struct OwnDaemon {
    child: Option<Child>,
    instance: Instance,
    // After the rest: fields are dropped in order.
    folder: Folder,
}

impl OwnDaemon {
    /// Makes the folder, lets `fill` put files into it, starts `program serve` with these arguments
    /// there, and waits until it serves. `program` is the `taut` binary.
    ///
    /// # Errors
    /// No folder, no such program, or a daemon that ends or does not come up.
    pub fn start(
        program: &Path,
        name: &str,
        arguments: &[&str],
        fill: impl FnOnce(&Path) -> std::io::Result<()>,
    ) -> Result<Self, OwnDaemonError> {
        let folder = Folder::create(name)?;
        fill(&folder.0).map_err(unwritable(&folder.0))?;
        let instance = Instance::new(name, folder.0.join("run"))?;
        let mut command = command(program, &instance);
        command.arg("serve").args(arguments);
        if !arguments.contains(&"--supervise") {
            // It ends with this process, however that ends.
            command.args(["--supervised-by", &std::process::id().to_string()]);
        }
        into_background(&mut command, &folder.0)?;
        let mut daemon = Self {
            child: Some(spawn(command)?),
            instance,
            folder,
        };
        daemon.wait_until_up()?;
        Ok(daemon)
    }

    /// The folder that `fill` filled.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder.0
    }

    /// Where it serves.
    #[must_use]
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Asks it to end, and waits.
    ///
    /// # Errors
    /// A daemon that cannot be reached, or does not end.
    pub fn stop(mut self) -> Result<(), OwnDaemonError> {
        let client = Client::connect(&self.instance)?;
        client.control(&ControlRequest::Shutdown, STOP_PATIENCE)?;
        drop(client);
        match self.ends_within(STOP_PATIENCE) {
            true => Ok(()),
            false => Err(self.failed("did not stop when asked")),
        }
    }

    fn wait_until_up(&mut self) -> Result<(), OwnDaemonError> {
        let end = Instant::now() + START_PATIENCE;
        while !matches!(
            daemon_state(&self.instance),
            Ok(DaemonState::Running { .. })
        ) {
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

    fn failed(&self, what: &str) -> OwnDaemonError {
        let log = fs::read_to_string(self.folder.0.join("daemon.log")).unwrap_or_default();
        let last = log
            .lines()
            .rev()
            .find(|line| !line.trim().is_empty())
            .unwrap_or("nothing");
        OwnDaemonError::Daemon {
            what: what.to_owned(),
            log: last.to_owned(),
        }
    }
}

impl Drop for OwnDaemon {
    fn drop(&mut self) {
        if let Some(pid) = self.child.as_ref().map(Pid::from_child) {
            // A child that is not reaped yet keeps its number, so that this cannot meet another
            // process.
            let _ = kill_process(pid, Signal::TERM);
            if !self.ends_within(STOP_PATIENCE)
                && let Some(mut child) = self.child.take()
            {
                let _ = child.kill();
                let _ = child.wait();
            }
        }
        // Planners that were killed leave shared memory behind, and so does a daemon; whoever takes
        // the instance next wipes it.
        drop(server::Server::create(&self.instance));
    }
}

/// Lets a daemon write its log into its folder, and lets Ctrl-C at the terminal go to its parent alone,
/// which stops things in order.
fn into_background(command: &mut Command, folder: &Path) -> Result<(), OwnDaemonError> {
    let log = File::create(folder.join("daemon.log")).map_err(unwritable(folder))?;
    let errors = log.try_clone().map_err(unwritable(folder))?;
    command
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(log)
        .stderr(errors)
        .process_group(0);
    Ok(())
}

/// A program that finds this instance in its environment.
#[must_use]
pub fn command(program: &Path, instance: &Instance) -> Command {
    let mut command = Command::new(program);
    command.env(
        INSTANCE_VARIABLE,
        format!("{}:{}", instance.name(), instance.root().display()),
    );
    command
}

fn unwritable(folder: &Path) -> impl Fn(std::io::Error) -> OwnDaemonError {
    move |error| OwnDaemonError::NoFolder(format!("{}: {error}", folder.display()))
}

/// Starts a program.
///
/// # Errors
/// What the system says where it cannot be started.
pub fn spawn(mut command: Command) -> Result<Child, OwnDaemonError> {
    command
        .spawn()
        .map_err(|source| OwnDaemonError::Start {
            program: command.get_program().into(),
            source,
        })
}

/// The file of one of taut's programs: beside the one that runs, else in the folders of `PATH`;
/// `None` where it is in none of them.
#[must_use]
pub fn find_program(name: &str) -> Option<PathBuf> {
    let own = std::env::current_exe().ok();
    let beside = own
        .as_deref()
        .and_then(Path::parent)
        .map(Path::to_owned);
    let search = std::env::var_os("PATH").unwrap_or_default();
    beside
        .into_iter()
        .chain(std::env::split_paths(&search))
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}
