//! The daemon under test: one of the test's own, or one that serves already.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use taut::files::Reader;
use taut_ipc::memory::shared_files;
use taut_ipc::own_daemon::{Folder, OwnDaemon};
use taut_ipc::{Client, DaemonState, Instance, daemon_state};

use super::interrupt;
use super::jobs::{job, label};
use super::orders::Job;
use super::problems::Problem;
use crate::error::Error;
use crate::{program, shipped};

/// Name of the instance and of the folder.
const NAME: &str = "load";
const CONFIG: &str = "daemon.toml";

/// A daemon, and what is sent to it.
pub(super) struct Site {
    // Before the folder: fields are dropped in order.
    daemon: Option<OwnDaemon>,
    _folder: Option<Folder>,
    instance: Instance,
    /// The process that served when the test began.
    served_by: Option<u32>,
    /// The problem files.
    pub files: Vec<PathBuf>,
    /// What is sent, as the optimizer takes it.
    pub problems: Vec<Problem>,
    /// The same as requests.
    pub jobs: Vec<Job>,
}

/// How a daemon of the test's own is set up.
#[derive(Clone, Debug, Default)]
pub(super) struct Setup {
    /// Worker threads; 0 = one per core.
    pub workers: usize,
    /// Problem files; empty = those that travel in the program.
    pub files: Vec<PathBuf>,
    /// Waypoints that each path has at least, by cutting its segments into equal parts.
    pub waypoints: usize,
    /// More lines of the configuration.
    pub lines: String,
    /// Start it under its supervisor, which starts it again.
    pub supervise: bool,
}

impl Site {
    /// Starts a daemon of the test's own with the problems loaded.
    pub(super) fn own(setup: &Setup) -> Result<Self, Error> {
        let arguments = ["--config", CONFIG, "--supervise"];
        let arguments = &arguments[..if setup.supervise { 3 } else { 2 }];
        let fill = |folder: &Path| {
            shipped::unpack(folder)?;
            let files = setup.files(folder);
            std::fs::write(folder.join(CONFIG), setup.configuration(&files)?)
        };
        let daemon = OwnDaemon::start(&program::taut()?, NAME, arguments, fill)?;
        let instance = daemon.instance().clone();
        let files = setup.files(daemon.folder());
        let site = Self {
            daemon: Some(daemon),
            ..Self::at(instance, files)
        };
        site.with_jobs(setup.waypoints)
    }

    /// The same with the shipped problems and so many workers.
    pub(super) fn of_workers(workers: usize) -> Result<Self, Error> {
        Self::own(&Setup {
            workers,
            ..Setup::default()
        })
    }

    /// Uses the daemon that serves this instance, and loads the problems there.
    pub(super) fn existing(instance: Instance, setup: &Setup) -> Result<Self, Error> {
        let folder = Folder::create(NAME)?;
        shipped::unpack(folder.path()).map_err(|source| Error::Output {
            file: folder.path().display().to_string(),
            source,
        })?;
        let files = setup.files(folder.path());
        let site = Self {
            _folder: Some(folder),
            ..Self::at(instance, files)
        };
        site.with_jobs(setup.waypoints)
    }

    fn at(instance: Instance, files: Vec<PathBuf>) -> Self {
        Self {
            daemon: None,
            _folder: None,
            served_by: pid(&instance),
            instance,
            files,
            problems: Vec::new(),
            jobs: Vec::new(),
        }
    }

    fn with_jobs(mut self, waypoints: usize) -> Result<Self, Error> {
        let client = self.client()?;
        let mut reader = Reader::default();
        for file in &self.files {
            let problem = Problem::read(&mut reader, file, waypoints)?;
            let job = job(&client, &mut reader, file, &problem)?;
            self.jobs.push(job);
            self.problems.push(problem);
        }
        Ok(self)
    }

    /// Where it serves.
    pub(super) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// A folder of the test's own.
    pub(super) fn folder(&self) -> Option<&Path> {
        self.daemon.as_ref().map(OwnDaemon::folder)
    }

    /// A connection.
    pub(super) fn client(&self) -> Result<Client, Error> {
        Ok(Client::connect(&self.instance)?)
    }

    /// The process that serves now; `None` while there is none.
    pub(super) fn pid(&self) -> Option<u32> {
        pid(&self.instance)
    }

    /// Whether the process that served when the test began still does.
    pub(super) fn is_alive(&self) -> bool {
        self.served_by.is_some() && self.pid() == self.served_by
    }

    /// Kills the process that serves (SIGKILL) and waits until its supervisor has another one
    /// serve.
    pub(super) fn kill_and_wait(&self, patience: Duration) -> Result<(), Error> {
        let serves = self.pid();
        if let Some(pid) = serves.and_then(|pid| Pid::from_raw(pid as i32)) {
            // Whoever holds the lock of this test's own instance is the daemon that the test's
            // supervisor started.
            let _ = kill_process(pid, Signal::KILL);
        }
        let is_another = || {
            self.pid()
                .is_some_and(|pid| Some(pid) != serves)
        };
        match until(patience, || Ok(is_another()))? {
            Some(_) => Ok(()),
            None => Err(self.gone()),
        }
    }

    /// The process that serves; an error where there is none.
    pub(super) fn serving(&self) -> Result<u32, Error> {
        self.pid().ok_or_else(|| self.gone())
    }

    /// Files and bytes of the instance in shared memory.
    pub(super) fn shared_memory(&self) -> (usize, u64) {
        let files = shared_files(&self.instance);
        (files.len(), files.iter().map(|file| file.taken).sum())
    }

    /// The end of the daemon's log, for an error.
    pub(super) fn gone(&self) -> Error {
        let log = self
            .folder()
            .map(|folder| folder.join("daemon.log"));
        let text = log
            .and_then(|log| std::fs::read_to_string(log).ok())
            .unwrap_or_default();
        Error::DaemonGone(
            text.lines()
                .last()
                .unwrap_or("nothing")
                .to_owned(),
        )
    }
}

impl Setup {
    /// The files named, or those that `unpack` wrote into this folder.
    fn files(&self, folder: &Path) -> Vec<PathBuf> {
        match self.files.is_empty() {
            true => shipped::PROBLEMS
                .iter()
                .map(|name| shipped::problem_file(folder, name))
                .collect(),
            false => self.files.clone(),
        }
    }

    /// The daemon's, with these problems.
    fn configuration(&self, files: &[PathBuf]) -> std::io::Result<String> {
        let mut text = format!("workers = {}\n{}\n", self.workers, self.lines);
        for file in files {
            let label = label(file);
            let file = std::path::absolute(file)?;
            text +=
                &format!("[[problems]]\nfile = {file:?}\nrobot = {label:?}\nscene = {label:?}\n");
        }
        Ok(text)
    }
}

/// The process that serves an instance now.
fn pid(instance: &Instance) -> Option<u32> {
    match daemon_state(instance) {
        Ok(DaemonState::Running { pid, .. }) => Some(pid),
        _ => None,
    }
}

/// Asks until it is so, at most so long; tells how long it took.
pub(super) fn until(
    within: Duration,
    mut so: impl FnMut() -> Result<bool, Error>,
) -> Result<Option<Duration>, Error> {
    let start = Instant::now();
    while !so()? {
        interrupt::check()?;
        if start.elapsed() > within {
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(Some(start.elapsed()))
}
