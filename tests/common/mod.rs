//! The real daemon and the real command line, each test in an instance of its own.
#![allow(dead_code, missing_docs)]

pub mod pages;
pub mod python;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

use taut_ipc::client::LoanedRequest;
use taut_ipc::control::{ControlReply, ControlRequest, RobotDescription, SceneSummary, Stats};
use taut_ipc::wire::{Mode, RequestBody, RequestHeader};
use taut_ipc::{Client, DaemonState, Instance};

/// Every wait of a test ends by then.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// The seed that makes a worker panic where the configuration allows it.
pub const PANIC_SEED: u64 = 0xfa17_fa17_fa17_fa17;
/// The seed that stays at its first improvement until told to stop.
pub const HANG_SEED: u64 = 0x4a46_4a46_4a46_4a46;
/// The seed that ends the thread that computes it by a panic.
pub const BREAK_SEED: u64 = 0xb4ea_b4ea_b4ea_b4ea;

/// Problems of `config/` that the daemons of the tests have loaded, robot and scene under the
/// problem's name.
pub const PROBLEMS: [&str; 7] = [
    "arm_shelf",
    "arm_window",
    "corner",
    "ell_window",
    "exchange_arms",
    "rooms",
    "slalom",
];

/// An instance with its own root and its own names in shared memory; both are gone with it.
pub struct Place {
    pub instance: Instance,
    pub folder: tempfile::TempDir,
}

impl Place {
    pub fn new() -> Self {
        let folder = tempfile::Builder::new()
            .prefix("taut")
            .tempdir()
            .unwrap();
        let instance = Instance::new("test", folder.path().join("i")).unwrap();
        Self { instance, folder }
    }

    pub fn name(&self) -> String {
        format!(
            "{}:{}",
            self.instance.name(),
            self.instance.root().display()
        )
    }

    /// Writes a file into the folder.
    pub fn file(&self, name: &str, text: &str) -> String {
        let file = self.folder.path().join(name);
        fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_owned()
    }

    /// Starts a daemon with every shipped problem and these lines of configuration.
    pub fn serve(&self, lines: &str) -> Daemon {
        let mut text = format!("fault_injection = true\n{lines}\n");
        for name in PROBLEMS {
            let file = config(&format!("problems/{name}.json"));
            text += &format!("[[problems]]\nfile = {file:?}\nrobot = {name:?}\nscene = {name:?}\n");
        }
        let config = self.file("daemon.toml", &text);
        let mut command = self.command(&["serve", "--config", &config]);
        let out = fs::File::create(self.folder.path().join("daemon.out")).unwrap();
        let daemon = Daemon(command.stdout(out).spawn().unwrap());
        until(
            "daemon is up",
            || matches!(taut_ipc::daemon_state(&self.instance), Ok(DaemonState::Running { pid, .. }) if pid == daemon.0.id()),
        );
        daemon
    }

    /// What the daemon said at its start on the line that begins like this.
    pub fn said(&self, beginning: &str) -> String {
        let mut rest = None;
        until(beginning, || {
            let text = fs::read_to_string(self.folder.path().join("daemon.out")).unwrap();
            rest = text
                .lines()
                .find_map(|line| line.strip_prefix(beginning))
                .map(str::to_owned);
            rest.is_some()
        });
        rest.unwrap()
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_taut"));
        command
            .args(arguments)
            .env("TAUT_INSTANCE", self.name())
            .env_remove("TAUT_LOG");
        command
    }

    /// Runs the command line to its end.
    pub fn taut(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    pub fn client(&self) -> Client {
        Client::connect(&self.instance).unwrap()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        for file in taut_ipc::memory::shared_files(&self.instance) {
            let _ = fs::remove_file(file.path);
        }
    }
}

/// A daemon; killed when dropped.
pub struct Daemon(pub Child);

impl Daemon {
    pub fn pid(&self) -> u32 {
        self.0.id()
    }

    pub fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    pub fn wait(mut self) -> i32 {
        let mut status = None;
        until("daemon ends", || {
            status = self.0.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap().code().unwrap_or(-1)
    }

    pub fn is_alive(&mut self) -> bool {
        self.0.try_wait().unwrap().is_none()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a command printed.
pub struct Run {
    pub exit: i32,
    pub out: String,
    pub err: String,
}

impl Run {
    pub fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            exit: output.status.code().unwrap_or(-1),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out)
            .unwrap_or_else(|error| panic!("{error}: {} {}", self.out, self.err))
    }
}

/// A file of `config/`.
pub fn config(name: &str) -> String {
    let file: PathBuf = [env!("CARGO_MANIFEST_DIR"), "config", name]
        .iter()
        .collect();
    file.to_str().unwrap().to_owned()
}

pub fn problem(name: &str) -> serde_json::Value {
    let file = config(&format!("problems/{name}.json"));
    serde_json::from_str(&fs::read_to_string(Path::new(&file)).unwrap()).unwrap()
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

/// A loaded problem as a client knows it.
#[derive(Clone)]
pub struct Models {
    pub robot: RobotDescription,
    pub scene: SceneSummary,
    /// The problem's path, row by row.
    pub path: Vec<f64>,
}

impl Models {
    pub fn of(client: &Client, name: &str) -> Self {
        let robot = match client.control(
            &ControlRequest::Describe {
                label: name.to_owned(),
            },
            PATIENCE,
        ) {
            Ok(ControlReply::Robot(robot)) => *robot,
            other => panic!("{other:?}"),
        };
        let scenes = match client.control(&ControlRequest::List, PATIENCE) {
            Ok(ControlReply::Listing(listing)) => listing.scenes,
            other => panic!("{other:?}"),
        };
        let scene = scenes
            .into_iter()
            .find(|scene| scene.label == name)
            .unwrap();
        let problem = problem(name);
        let rows = problem["path"].as_array().unwrap().iter();
        let path = rows
            .flat_map(|row| {
                row.as_array()
                    .unwrap()
                    .iter()
                    .map(|x| x.as_f64().unwrap())
            })
            .collect();
        Self { robot, scene, path }
    }

    pub fn nq(&self) -> usize {
        self.robot.nq as usize
    }

    /// The path there and back, until it has so many waypoints: as much work as a test needs.
    pub fn long(&self, waypoints: usize) -> Self {
        let there: Vec<&[f64]> = self.path.chunks(self.nq()).collect();
        let back: Vec<&[f64]> = there
            .iter()
            .rev()
            .skip(1)
            .take(there.len() - 2)
            .copied()
            .collect();
        let round = there
            .iter()
            .chain(&back)
            .cycle()
            .take(waypoints);
        Self {
            path: round.flat_map(|row| row.to_vec()).collect(),
            ..self.clone()
        }
    }

    pub fn header(&self) -> RequestHeader {
        RequestHeader {
            waypoints: (self.path.len() / self.nq()) as u32,
            variables: self.robot.nq,
            robot_id: self.robot.robot_id,
            layout_hash: self.robot.layout_hash,
            scene_id: self.scene.scene_id,
            group: taut_ipc::wire::NO_GROUP,
            ..RequestHeader::default()
        }
    }

    /// A request whose header and sections are changed before it is sent.
    pub fn request(
        &self,
        client: &Client,
        body: RequestBody<'_>,
        change: impl FnOnce(&mut RequestHeader),
    ) -> LoanedRequest {
        let mut builder = client.request(0, 0).with_body(body);
        builder.header = self.header();
        change(&mut builder.header);
        let mut loan = builder.loan().unwrap();
        let slots = loan.path_mut();
        let count = slots.len().min(self.path.len());
        slots[..count].copy_from_slice(&self.path[..count]);
        loan
    }
}

/// Work without an end that makes room for nobody: it stays at its first improvement, and others
/// are of a lower class.
pub fn endless(header: &mut RequestHeader) {
    patient(header);
    header.priority = 1;
}

/// Work without an end that makes room for others.
pub fn patient(header: &mut RequestHeader) {
    header.mode = Mode::RandomShortcut.into();
    header.seed = HANG_SEED;
}

pub fn stats(client: &Client) -> Stats {
    match client.control(&ControlRequest::Stats, PATIENCE) {
        Ok(ControlReply::Stats(stats)) => stats,
        other => panic!("{other:?}"),
    }
}

/// CPU time of all threads of a process.
pub fn cpu_time(pid: u32) -> Duration {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).unwrap();
    let spent = tasks.flatten().map(|task| {
        let text = fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        text.split(' ')
            .next()
            .and_then(|ns| ns.parse::<u64>().ok())
            .unwrap_or(0)
    });
    Duration::from_nanos(spent.sum())
}

/// Times that the threads of a process have waited for something and been woken.
pub fn wakes(pid: u32) -> u64 {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).unwrap();
    let woken = tasks.flatten().map(|task| {
        let text = fs::read_to_string(task.path().join("status")).unwrap_or_default();
        let line = text
            .lines()
            .find_map(|line| line.strip_prefix("voluntary_ctxt_switches:"));
        line.and_then(|count| count.trim().parse::<u64>().ok())
            .unwrap_or(0)
    });
    woken.sum()
}
