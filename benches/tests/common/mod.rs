//! `taut-bench` of this build and the `taut` beside it, each test in an instance of its own.
#![allow(dead_code, missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::sync::OnceLock;
use std::time::{Duration, Instant, SystemTime};

use taut_ipc::{DaemonState, Instance};

/// Every wait of a test ends by then.
const PATIENCE: Duration = Duration::from_secs(30);

/// The program that is tested.
pub const TAUT_BENCH: &str = env!("CARGO_BIN_EXE_taut-bench");

/// The `taut` that it starts: beside it, of the same sources. Cargo makes it with the whole workspace's
/// tests, but not with this package's alone; then it is made here.
pub fn taut() -> &'static Path {
    static TAUT: OnceLock<PathBuf> = OnceLock::new();
    TAUT.get_or_init(|| {
        let file = Path::new(TAUT_BENCH).with_file_name("taut");
        if !is_fresh(&file) {
            build(&file);
        }
        file
    })
}

/// What it is made of, below the workspace.
const SOURCES: [&str; 6] = [
    "Cargo.lock",
    "Cargo.toml",
    "config",
    "examples/planner",
    "ipc/src",
    "src",
];

/// Whether it is younger than all of its sources.
fn is_fresh(program: &Path) -> bool {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let newest = SOURCES.map(|source| newest(&workspace.join(source)));
    modified(program).is_some_and(|made| newest.iter().max() < Some(&Some(made)))
}

/// When a file, or the last file of a folder, was changed.
fn newest(path: &Path) -> Option<SystemTime> {
    let entries = fs::read_dir(path)
        .into_iter()
        .flatten()
        .flatten();
    let within = entries
        .filter_map(|entry| newest(&entry.path()))
        .max();
    within.max(modified(path).filter(|_| path.is_file()))
}

fn modified(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).ok()?.modified().ok()
}

fn build(program: &Path) {
    let profile = match program.parent().and_then(Path::file_name) {
        Some(folder) if folder != "debug" => folder.to_str().unwrap(),
        _ => "dev",
    };
    let status = Command::new(env!("CARGO"))
        .args(["build", "--locked", "-p", "taut", "--bin", "taut"])
        .args(["--profile", profile])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status()
        .unwrap();
    assert!(
        status.success() && program.is_file(),
        "no {}; `cargo build -p taut` makes it",
        program.display()
    );
}

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

    /// `taut-bench` with these arguments, for this instance.
    pub fn command(&self, arguments: &[&str]) -> Command {
        taut();
        let mut command = Command::new(TAUT_BENCH);
        command.args(arguments);
        self.enter(&mut command);
        command
    }

    fn enter(&self, command: &mut Command) {
        let name = self.instance.name();
        let root = self.instance.root().display();
        command
            .env("TAUT_INSTANCE", format!("{name}:{root}"))
            .env_remove("TAUT_LOG");
    }

    /// Runs `taut-bench` to its end.
    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    /// Starts a daemon with nothing loaded.
    pub fn serve(&self) -> Daemon {
        let mut command = Command::new(taut());
        command.args(["serve", "--no-state"]);
        self.enter(&mut command);
        let log = fs::File::create(self.folder.path().join("daemon.out")).unwrap();
        let daemon = Daemon(command.stdout(log).spawn().unwrap());
        let start = Instant::now();
        while !self.is_served() {
            assert!(start.elapsed() < PATIENCE, "the daemon does not come up");
            std::thread::sleep(Duration::from_millis(1));
        }
        daemon
    }

    fn is_served(&self) -> bool {
        let state = taut_ipc::daemon_state(&self.instance);
        matches!(state, Ok(DaemonState::Running { .. }))
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
pub struct Daemon(Child);

impl Daemon {
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
    format!("{}/../config/{name}", env!("CARGO_MANIFEST_DIR"))
}
