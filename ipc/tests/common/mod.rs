//! Daemons and clients for the tests: in this process, or as children that run one test of this
//! binary.
#![allow(dead_code, missing_docs)]

use std::process::{Child, Command};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use taut_ipc::client::LoanedRequest;
use taut_ipc::control::{ControlReply, ControlRequest, Listing, Refusal};
use taut_ipc::memory::SHM_FOLDER;
use taut_ipc::server::{IncomingControl, IncomingRequest, Janitor, Server, Waker};
use taut_ipc::wire::{
    Code, Mode, ResponseBody, ResponseFlags, ResponseHeader, Status, StatusRecord, Termination,
};
use taut_ipc::{Client, ClientError, DaemonState, Instance};

pub const SECOND: Duration = Duration::from_secs(1);
/// Every wait of a test ends by then.
pub const PATIENCE: Duration = Duration::from_secs(20);

const ROLE: &str = "TAUT_TEST_ROLE";

/// An instance of its own, gone with the folder.
pub struct Sandbox {
    pub instance: Instance,
    _folder: tempfile::TempDir,
}

impl Sandbox {
    pub fn new() -> Self {
        let folder = tempfile::Builder::new()
            .prefix("taut")
            .tempdir()
            .unwrap();
        let instance = Instance::new("test", folder.path().join("i")).unwrap();
        Self {
            instance,
            _folder: folder,
        }
    }
}

impl Drop for Sandbox {
    fn drop(&mut self) {
        for file in taut_ipc::memory::shared_files(&self.instance) {
            let _ = std::fs::remove_file(file.path);
        }
    }
}

/// What this process is to do, if a test started it, and where.
pub fn role() -> Option<(String, Instance)> {
    let role = std::env::var(ROLE).ok()?;
    Some((role, Instance::from_environment().unwrap()))
}

/// A child process; killed when dropped.
pub struct Process(pub Child);

impl Process {
    /// Runs `test` of this binary in a child that plays `role`.
    pub fn start(test: &str, role: &str, instance: &Instance) -> Self {
        let place = format!("{}:{}", instance.name(), instance.root().display());
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", test, "--nocapture", "--test-threads=1"]);
        Self(
            command
                .env(ROLE, role)
                .env("TAUT_INSTANCE", place)
                .spawn()
                .unwrap(),
        )
    }

    pub fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Files in shared memory that this process has open for an instance.
pub fn open_memory(instance: &Instance) -> usize {
    let prefix = std::path::Path::new(SHM_FOLDER).join(instance.prefix());
    let prefix = prefix.to_str().unwrap();
    let open = std::fs::read_dir("/proc/self/fd").unwrap();
    open.flatten()
        .filter_map(|file| std::fs::read_link(file.path()).ok())
        .filter(|path| {
            path.to_str()
                .is_some_and(|path| path.starts_with(prefix))
        })
        .count()
}

/// Asks until it is so; fails the test after [`PATIENCE`].
pub fn until(what: &str, mut so: impl FnMut() -> bool) -> Duration {
    let start = Instant::now();
    while !so() {
        assert!(
            start.elapsed() < PATIENCE,
            "not within {PATIENCE:?}: {what}"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    start.elapsed()
}

pub fn wait_for_daemon(instance: &Instance) {
    until("daemon is up", || {
        matches!(
            taut_ipc::daemon_state(instance),
            Ok(DaemonState::Running { .. })
        )
    });
}

/// A daemon in this process.
pub struct Echo {
    stop: Arc<AtomicBool>,
    waker: Waker,
    thread: Option<JoinHandle<()>>,
}

impl Echo {
    pub fn start(instance: &Instance) -> Self {
        let server = Server::create(instance).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let waker = server.waker();
        let stopped = stop.clone();
        let place = instance.clone();
        let thread =
            std::thread::spawn(move || serve(server, &place, &|| stopped.load(Ordering::Relaxed)));
        Self {
            stop,
            waker,
            thread: Some(thread),
        }
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.waker.wake();
        self.thread.take().unwrap().join().unwrap();
    }
}

/// Serves for ever in this process; for children.
pub fn serve_for_ever(instance: &Instance) -> ! {
    serve(Server::create(instance).unwrap(), instance, &|| false);
    unreachable!()
}

/// Mode check: the path comes back. Mode gradient: `work_budget` improvements and a final one. Mode
/// hybrid: nothing until the client asks to finish.
fn serve(server: Server, instance: &Instance, stop: &dyn Fn() -> bool) {
    let waker = server.waker();
    let janitor = Janitor::start(instance, move |_| waker.wake()).unwrap();
    let mut held: Vec<IncomingRequest> = Vec::new();
    while !stop() {
        server.wait(SECOND).unwrap();
        while let Some(request) = server.receive().unwrap() {
            held.extend(answer(request));
        }
        while let Some(control) = server.receive_control().unwrap() {
            answer_control(control);
        }
        held.retain_mut(|request| {
            if request.has_disconnect_hint() {
                send(request, 1.0, Status::Final);
                return false;
            }
            request.is_connected()
        });
        let status = StatusRecord {
            running: held.len() as u32,
            cleaned_nodes: janitor.cleaned(),
            clients: server.clients() as u32,
            ..Default::default()
        };
        server.publish_status(&status).unwrap();
    }
}

fn answer(mut request: IncomingRequest) -> Option<IncomingRequest> {
    let checked = request.view().map(|view| view.mode);
    match checked {
        Err(error) => request
            .refuse(error.code(), &error.to_string(), 0)
            .unwrap(),
        Ok(Mode::Check) => send(&mut request, 1.0, Status::Final),
        Ok(Mode::Gradient) => {
            let improvements = request.header().work_budget;
            (0..improvements)
                .for_each(|i| send(&mut request, 1.0 - 0.01 * i as f64, Status::Progress));
            send(&mut request, 0.5, Status::Final);
        }
        Ok(Mode::Contact) => drop(request),
        Ok(Mode::PartialShortcut) => request
            .refuse(Code::Overloaded, "queue full, 3 wait", 7)
            .unwrap(),
        Ok(_) => return Some(request),
    }
    None
}

/// The path of the request, scaled.
pub fn send(request: &mut IncomingRequest, scale: f64, status: Status) {
    let view = request.view().unwrap();
    let path: Vec<f64> = view.path.iter().map(|x| x * scale).collect();
    let header = ResponseHeader {
        status: status.into(),
        code: Code::Success.into(),
        flags: ResponseFlags::PROVED,
        termination: Termination::Checked.into(),
        waypoints: view.header.waypoints,
        variables: view.header.variables,
        length_before: 1.0,
        length_after: scale,
        ..Default::default()
    };
    request
        .send(
            &header,
            &ResponseBody {
                path: &path,
                ..Default::default()
            },
        )
        .unwrap();
}

pub fn answer_control(control: IncomingControl) {
    let reply = match control.message() {
        Ok(ControlRequest::List) => ControlReply::Listing(Listing::default()),
        Ok(_) => ControlReply::Refused(Refusal::new(
            Code::UnknownRobot,
            "no robot; `taut list` shows all",
        )),
        Err(refusal) => ControlReply::Refused(refusal),
    };
    control.reply(&reply).unwrap();
}

/// A loaned request whose path counts up from `first`.
pub fn request(
    client: &Client,
    mode: Mode,
    waypoints: u32,
    first: f64,
) -> Result<LoanedRequest, ClientError> {
    let mut builder = client.request(waypoints, 8);
    builder.header.mode = mode.into();
    let mut loan = builder.loan()?;
    (0..)
        .zip(loan.path_mut())
        .for_each(|(i, x)| *x = first + f64::from(i));
    Ok(loan)
}
