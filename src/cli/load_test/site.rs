//! The daemon under test: one of the test's own, or one that serves already.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use taut::files::Reader;
use taut_ipc::control::{ControlReply, ControlRequest, Stats};
use taut_ipc::memory::shared_files;
use taut_ipc::{Client, DaemonState, Instance, daemon_state};

use super::error::LoadError;
use super::orders::Job;
use super::problems::Problem;
use crate::cli::demo::world;
use crate::cli::error::CliError;
use crate::cli::error::unexpected;
use crate::cli::own_daemon::{Daemon, Folder};
use crate::cli::place::Place;
use crate::cli::prepare;
use taut_ipc::planner::Planner;

/// Name of the instance and of the folder.
const NAME: &str = "load";
const CONFIG: &str = "daemon.toml";

/// A daemon, and what is sent to it.
pub(super) struct Site {
    // Before the folder: fields are dropped in order.
    daemon: Option<Daemon>,
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
    pub(super) fn own(setup: &Setup) -> Result<Self, CliError> {
        let arguments = ["--config", CONFIG, "--supervise"];
        let arguments = &arguments[..if setup.supervise { 3 } else { 2 }];
        let daemon = Daemon::start(NAME, arguments, |folder| {
            world::unpack(folder)?;
            let mut text = format!("workers = {}\n{}\n", setup.workers, setup.lines);
            for file in files(setup, folder) {
                let label = label(&file);
                let file = std::path::absolute(file)?;
                text += &format!(
                    "[[problems]]\nfile = {file:?}\nrobot = {label:?}\nscene = {label:?}\n"
                );
            }
            std::fs::write(folder.join(CONFIG), text)
        })?;
        let instance = daemon.instance().clone();
        let files = files(setup, daemon.folder());
        Self::with_jobs(Some(daemon), None, instance, files, setup.waypoints)
    }

    /// Uses the daemon that serves this instance, and loads the problems there.
    pub(super) fn existing(instance: Instance, setup: &Setup) -> Result<Self, CliError> {
        let folder = Folder::create(NAME)?;
        if setup.files.is_empty() {
            let written = world::unpack(folder.path());
            written.map_err(|source| CliError::Output {
                file: folder.path().display().to_string(),
                source,
            })?;
        }
        let files = files(setup, folder.path());
        Self::with_jobs(None, Some(folder), instance, files, setup.waypoints)
    }

    fn with_jobs(
        daemon: Option<Daemon>,
        folder: Option<Folder>,
        instance: Instance,
        files: Vec<PathBuf>,
        waypoints: usize,
    ) -> Result<Self, CliError> {
        let served_by = None;
        let problems = Vec::new();
        let jobs = Vec::new();
        let mut site = Self {
            daemon,
            _folder: folder,
            instance,
            served_by,
            files,
            problems,
            jobs,
        };
        site.served_by = site.pid();
        site.read_jobs(waypoints)?;
        Ok(site)
    }

    fn read_jobs(&mut self, waypoints: usize) -> Result<(), CliError> {
        let place = Place::Daemon(Planner::new(self.client()?));
        let mut reader = Reader::default();
        for file in &self.files {
            let problem = Problem::read(&mut reader, file, waypoints)?;
            let loaded = prepare::prepare(&place, &mut reader, file, &Problem::source(), &[])?;
            self.jobs.push(Job {
                name: label(file),
                robot_id: loaded.robot.robot_id,
                robot_hash: loaded.robot.robot_hash,
                layout_hash: loaded.robot.layout_hash,
                scene_id: loaded.scene.scene_id,
                scene_hash: loaded.scene.scene_hash,
                variables: loaded.robot.nq,
                path: problem.path.as_flat().to_vec(),
                weights: loaded.weights.unwrap_or_default(),
            });
            self.problems.push(problem);
        }
        Ok(())
    }

    /// Where it serves.
    pub(super) fn instance(&self) -> &Instance {
        &self.instance
    }

    /// A folder of the test's own.
    pub(super) fn folder(&self) -> Option<&Path> {
        self.daemon.as_ref().map(Daemon::folder)
    }

    /// A connection.
    pub(super) fn client(&self) -> Result<Client, CliError> {
        Ok(Client::connect(&self.instance)?)
    }

    /// The process that serves now; `None` while there is none.
    pub(super) fn pid(&self) -> Option<u32> {
        match daemon_state(&self.instance) {
            Ok(DaemonState::Running { pid, .. }) => Some(pid),
            _ => None,
        }
    }

    /// Whether the process that served when the test began still does.
    pub(super) fn is_alive(&self) -> bool {
        self.served_by.is_some() && self.pid() == self.served_by
    }

    /// Kills the process that serves (SIGKILL) and waits until its supervisor has another one
    /// serve.
    pub(super) fn kill_and_wait(&self, patience: Duration) -> Result<(), CliError> {
        let serves = self.pid();
        if let Some(pid) = serves.and_then(|pid| Pid::from_raw(pid as i32)) {
            // Whoever holds the lock of this test's own instance is the daemon that the test's
            // supervisor started.
            let _ = kill_process(pid, Signal::KILL);
        }
        match until(patience, || {
            Ok(self.pid().is_some_and(|pid| Some(pid) != serves))
        })? {
            Some(_) => Ok(()),
            None => Err(self.gone().into()),
        }
    }

    /// Files and bytes of the instance in shared memory.
    pub(super) fn shared_memory(&self) -> (usize, u64) {
        let files = shared_files(&self.instance);
        (files.len(), files.iter().map(|file| file.taken).sum())
    }

    /// The end of the daemon's log, for an error.
    pub(super) fn gone(&self) -> LoadError {
        let log = self.folder().map(|folder| folder.join("daemon.log"));
        let text = log
            .and_then(|log| std::fs::read_to_string(log).ok())
            .unwrap_or_default();
        LoadError::DaemonGone(text.lines().last().unwrap_or("nothing").to_owned())
    }
}

/// Counters and times of the daemon.
pub(super) fn stats(client: &Client) -> Result<Stats, CliError> {
    match Planner::new(client.clone()).control(&ControlRequest::Stats)? {
        ControlReply::Stats(stats) => Ok(stats),
        other => Err(unexpected(&other)),
    }
}

/// One number of [`stats`]; 0 where the daemon has none of that name.
pub(super) fn number(client: &Client, name: &str) -> Result<f64, CliError> {
    Ok(stats(client)?.numbers.get(name).copied().unwrap_or(0.0))
}

/// Asks until it is so, at most so long; tells how long it took.
pub(super) fn until(
    within: Duration,
    mut so: impl FnMut() -> Result<bool, CliError>,
) -> Result<Option<Duration>, CliError> {
    let start = std::time::Instant::now();
    while !so()? {
        super::interrupt::check()?;
        if start.elapsed() > within {
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(Some(start.elapsed()))
}

fn files(setup: &Setup, folder: &Path) -> Vec<PathBuf> {
    match setup.files.is_empty() {
        true => world::PROBLEMS
            .iter()
            .map(|name| world::problem_file(folder, name))
            .collect(),
        false => setup.files.clone(),
    }
}

fn label(file: &Path) -> String {
    file.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
