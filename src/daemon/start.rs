//! Starting and ending the daemon.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::{Handle, Signals};
use taut::files::{FileError, Packages, Reader};
use taut::robot::RobotDescription;
use taut::scene::Scene;
use taut::shape::Shape;
use taut::store::{ModelStore, Wanted};
use taut_ipc::server::{Janitor, Server, ServerError};
use taut_ipc::wire::{Code, label_id};
use taut_ipc::{DaemonState, Instance, daemon_state, monotonic_ns};

use super::clients::Clients;
use super::config::Config;
use super::event::{Event, EventSender};
use super::event_loop::EventLoop;
use super::loader::{self, Loader};
use super::metrics::Metrics;
use super::poison::Poison;
use super::preparer;
use super::schedule::{self, Schedule};
use super::scrape::Scrape;
use super::story::Stories;
use super::translate::store_refusal;
use super::worker::Worker;

/// Why the daemon cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum DaemonError {
    /// A robot or scene to load.
    #[error(transparent)]
    File(#[from] FileError),
    /// Robots and scenes that do not go together, or two of one label.
    #[error("{message}")]
    Model {
        /// Its code.
        code: i32,
        /// What is wrong.
        message: String,
    },
    /// The instance.
    #[error(transparent)]
    Instance(#[from] taut_ipc::InstanceError),
    /// The ports.
    #[error(transparent)]
    Server(#[from] ServerError),
    /// Threads and signals.
    #[error("the system gives no {what}: {source}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What it says.
        source: std::io::Error,
    },
}

impl DaemonError {
    /// The code for the command line's exit.
    pub fn code(&self) -> Code {
        match self {
            Self::File(FileError::Unreadable { .. }) => Code::UnreadableFile,
            Self::File(_) => Code::InvalidModel,
            Self::Model { code, .. } => Code::try_from(*code).unwrap_or(Code::InvalidModel),
            Self::Instance(_) => Code::DaemonLost,
            Self::Server(error) => error.code(),
            Self::System { .. } => Code::ResourceExhausted,
        }
    }
}

fn system(what: &'static str) -> impl Fn(std::io::Error) -> DaemonError {
    move |source| DaemonError::System { what, source }
}

/// Serves an instance until SIGINT, SIGTERM or a client's shutdown; `out` gets the lines of the start.
///
/// # Errors
/// What could not be loaded or opened, or a port that stopped working.
pub fn serve(config: &Config, instance: &Instance, out: &mut dyn Write) -> Result<(), DaemonError> {
    if let DaemonState::Running { .. } = daemon_state(instance)? {
        // Creating the server says who serves; loading first would only take time.
        Server::create(instance)?;
    }
    let store = preload(config, out)?;
    let (mut event_loop, threads) = assemble(config, instance, store)?;
    let (name, workers) = (instance.name(), config.worker_count());
    if let Some(scrape) = &threads.scrape {
        say(out, &format!("metrics at http://{}/metrics", scrape.address()));
    }
    say(out, &format!("serving instance {name}  {workers} workers  clearance {} mm", config.clearance_m * 1e3));
    let served = event_loop.run();
    event_loop.close();
    threads.join();
    Ok(served?)
}

/// Every thread besides the I/O thread. Each can wake it, which keeps its ports open: they have to end before it.
struct Threads {
    signals: Handle,
    joined: Vec<JoinHandle<()>>,
    scrape: Option<Scrape>,
}

impl Threads {
    fn join(self) {
        self.signals.close();
        drop(self.scrape);
        for thread in self.joined {
            // Workers and loader catch their panics; one that ended all the same has nothing to say here.
            let _ = thread.join();
        }
    }
}

fn assemble(config: &Config, instance: &Instance, store: ModelStore) -> Result<(EventLoop, Threads), DaemonError> {
    let server = Server::create(instance)?;
    let (events, receiver) = EventSender::new(server.waker());
    let (signals, signal_thread) = stop_on_signals(events.clone()).map_err(system("signal handler"))?;
    let waker = server.waker();
    let janitor = Janitor::start(instance, move |_| waker.wake()).map_err(system("thread"))?;
    let (loader, loader_threads) = Loader::start(&events).map_err(system("thread"))?;
    let mut joined = vec![signal_thread];
    joined.extend(loader_threads);
    let workers = config.worker_count();
    let schedule = Arc::new(Schedule::new(workers));
    let (preparer, preparers) = preparer::start(&schedule).map_err(system("thread"))?;
    joined.extend(preparers);
    let mut mailboxes = Vec::new();
    for index in 0..schedule::threads(workers) {
        let mailbox = Arc::default();
        mailboxes.push(Arc::clone(&mailbox));
        let (schedule, events) = (schedule.clone(), events.clone());
        let worker = Worker { index, schedule, mailbox, events, fault_injection: config.fault_injection };
        joined.push(worker.start().map_err(system("thread"))?);
    }
    let metrics = Metrics::new();
    let scrape = config.metrics.map(|address| Scrape::start(address, metrics.registry())).transpose();
    let scrape = scrape.map_err(system("address for metrics"))?;
    let event_loop = EventLoop {
        server,
        janitor,
        store,
        schedule,
        preparer: Some(preparer),
        clients: Clients::new(config.quota, workers),
        stories: Stories::default(),
        poison: Poison::default(),
        workers,
        mailboxes,
        events: receiver,
        loader: Some(loader),
        metrics,
        default_clearance_m: config.clearance_m,
        queue_limit: config.queue,
        status_period_ns: (1e9 / config.status_rate_hz) as u64,
        open: HashMap::new(),
        watches: BTreeMap::new(),
        loads: BTreeMap::new(),
        loading: HashSet::new(),
        next_number: 0,
        next_status_ns: monotonic_ns(),
        is_draining: false,
        janitor_was_slow: false,
    };
    Ok((event_loop, Threads { signals, joined, scrape }))
}

/// The thread ends when the handle is closed.
fn stop_on_signals(events: EventSender) -> std::io::Result<(Handle, JoinHandle<()>)> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let handle = signals.handle();
    let thread = std::thread::Builder::new().name("taut-signals".into()).spawn(move || {
        for _ in signals.forever() {
            events.send(Event::Stop);
        }
    })?;
    Ok((handle, thread))
}

/// Loads what the configuration names.
fn preload(config: &Config, out: &mut dyn Write) -> Result<ModelStore, DaemonError> {
    let mut store = ModelStore::new(label_id);
    let mut reader = Reader::new(Packages::with_environment(BTreeMap::new()));
    for robot in &config.robots {
        let start = Instant::now();
        let description = reader.robot_of(&robot.files())?;
        add_robot(&mut store, &robot.label, description, &robot.urdf, start, out)?;
    }
    for scene in &config.scenes {
        let read = reader.scene(&scene.file)?;
        add_scene(&mut store, &scene.label, read, out)?;
    }
    for problem in &config.problems {
        let start = Instant::now();
        let read = reader.problem(&problem.file, problem.geometry.into())?;
        let robot = problem.robot.as_ref().unwrap_or(&read.robot.name).clone();
        let scene = problem.scene.as_ref().unwrap_or(&read.name).clone();
        add_robot(&mut store, &robot, read.robot, &read.robot_files.urdf, start, out)?;
        add_scene(&mut store, &scene, read.scene, out)?;
        warm(&mut store, &robot, &scene)?;
    }
    Ok(store)
}

fn model(error: &taut_ipc::control::Refusal) -> DaemonError {
    DaemonError::Model { code: error.code, message: error.message.clone() }
}

fn add_robot(
    store: &mut ModelStore,
    label: &str,
    description: RobotDescription,
    urdf: &Path,
    start: Instant,
    out: &mut dyn Write,
) -> Result<(), DaemonError> {
    let (robot, weights) = loader::prepared(description, urdf).map_err(|refusal| model(&refusal))?;
    let shapes = || robot.links().iter().flat_map(|link| &link.shapes);
    let triangles: usize = shapes().map(|placed| triangles(&placed.shape)).sum();
    let bodies = robot.links().iter().filter(|link| !link.shapes.is_empty()).count();
    let line = format!(
        "robot {label}  {} dof  {bodies} links  {triangles} triangles  hash {:016x}  warm in {:.0} ms",
        robot.space().nv(),
        robot.hash(),
        start.elapsed().as_secs_f64() * 1e3,
    );
    store.insert_robot(label, robot, weights, false).map_err(|error| model(&store_refusal(&error)))?;
    say(out, &line);
    Ok(())
}

fn triangles(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh(mesh) => mesh.triangles().len(),
        _ => 0,
    }
}

fn add_scene(store: &mut ModelStore, label: &str, scene: Scene, out: &mut dyn Write) -> Result<(), DaemonError> {
    let (objects, hash) = (scene.obstacles().len() + scene.attached().len(), scene.hash());
    store.insert_scene(label, Arc::new(scene), false).map_err(|error| model(&store_refusal(&error)))?;
    say(out, &format!("scene {label} v1  {objects} objects  hash {hash:016x}"));
    Ok(())
}

/// Makes the collision model of a problem now, so that its first request need not.
fn warm(store: &mut ModelStore, robot: &str, scene: &str) -> Result<(), DaemonError> {
    let wanted = Wanted { robot_id: label_id(robot), scene_id: label_id(scene), ..Wanted::default() };
    let snapshot = store.snapshot(&wanted).map_err(|error| model(&store_refusal(&error)))?;
    match snapshot.model.get() {
        Ok(_) => Ok(()),
        Err(error) => Err(model(&super::translate::model_refusal(error, &snapshot.robot))),
    }
}

/// Prints a line of the start. A daemon whose terminal is gone serves all the same.
fn say(out: &mut dyn Write, line: &str) {
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
