//! `taut serve --supervise`: a small process that starts the daemon again whenever it dies or
//! hangs.
//!
//! It waits for its child's end, for signals and for signs of life, and does nothing else. The
//! daemon is told whose child it is and goes when that one goes, so that no daemon is left without
//! a supervisor.

use std::ffi::OsString;
use std::fs::DirEntry;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::os::unix::net::{UnixDatagram, UnixStream};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, getppid, pidfd_open, pidfd_send_signal};
use rustix::process::{set_parent_process_death_signal, test_kill_process};
use sd_notify::NotifyState;
use signal_hook::consts::{SIGINT, SIGTERM};
use taut_ipc::wire::Code;
use taut_ipc::{Instance, InstanceError};

/// A daemon that dies sooner than this after its start may do so again at once.
const QUICK: Duration = Duration::from_secs(10);
/// Quick deaths in a row after which it is not started again.
const MOST_QUICK: u32 = 5;
/// Pause after the second quick death in a row; it doubles with each. After the first there is
/// none.
const PAUSE: Duration = Duration::from_millis(100);
/// How long a daemon may take to be ready.
const START: Duration = Duration::from_secs(120);
/// How long a daemon that hangs has for its last words.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// Why there is no supervised daemon.
#[derive(Debug, thiserror::Error)]
pub enum SuperviseError {
    /// It dies again and again.
    #[error(
        "the daemon died {MOST_QUICK} times in a row within {QUICK:?} of its start, the last time of {last}; see its messages above, TAUT_LOG=debug has more"
    )]
    GaveUp {
        /// What it died of.
        last: String,
    },
    /// The supervisor has gone.
    #[error("the supervisor (process {0}) has gone; start `taut serve --supervise` again")]
    Orphan(u32),
    /// The instance.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// Processes and signals.
    #[error("the system gives no {what}: {source}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What it says.
        source: std::io::Error,
    },
}

impl SuperviseError {
    /// The code for the command line's exit.
    pub fn code(&self) -> Code {
        match self {
            Self::GaveUp { .. } => Code::Crash,
            Self::Orphan(_) | Self::Instance(_) => Code::DaemonLost,
            Self::System { .. } => Code::ResourceExhausted,
        }
    }
}

fn system<E: Into<std::io::Error>>(what: &'static str) -> impl Fn(E) -> SuperviseError {
    move |error| SuperviseError::System {
        what,
        source: error.into(),
    }
}

/// Binds a daemon to its supervisor: it is asked to end when that one goes.
///
/// # Errors
/// [`SuperviseError::Orphan`] if it has gone already.
pub fn bind_to_supervisor(pid: u32) -> Result<(), SuperviseError> {
    set_parent_process_death_signal(Some(Signal::TERM))
        .map_err(system("signal at a parent's death"))?;
    let parent = getppid().map_or(0, |parent| parent.as_raw_nonzero().get() as u32);
    if parent == pid {
        Ok(())
    } else {
        Err(SuperviseError::Orphan(pid))
    }
}

/// Starts this program with `arguments`, and again whenever it dies or gives no sign of life for
/// `patience`, until it ends in order or by a signal to the supervisor. Gives its exit code.
///
/// # Errors
/// [`SuperviseError::GaveUp`], or what the system refuses.
pub fn supervise(
    instance: &Instance,
    arguments: &[OsString],
    patience: Duration,
) -> Result<u8, SuperviseError> {
    instance.prepare()?;
    let mut supervisor = Supervisor::new(instance, patience)?;
    let mut quick = 0;
    loop {
        let started = Instant::now();
        let end = supervisor.run(arguments)?;
        if supervisor.is_last(&end) {
            return Ok(exit_code(end.status));
        }
        let is_quick = started.elapsed() < QUICK;
        quick = if is_quick { quick + 1 } else { 0 };
        supervisor.rest(&end, quick)?;
        if supervisor.is_stopping {
            return Ok(exit_code(end.status));
        }
    }
}

fn exit_code(status: ExitStatus) -> u8 {
    let by_signal = || 128 + status.signal().unwrap_or(0);
    u8::try_from(status.code().unwrap_or_else(by_signal)).unwrap_or(u8::MAX)
}

/// How a daemon ended.
struct End {
    status: ExitStatus,
    was_ready: bool,
    hung: bool,
}

impl End {
    fn describe(&self) -> String {
        match (self.status.signal(), self.status.code()) {
            (Some(_), _) if self.hung => "giving no sign of life".to_owned(),
            (Some(signal), _) => format!("signal {signal}"),
            (None, code) => format!("exit code {}", code.unwrap_or(-1)),
        }
    }
}

/// A daemon that runs.
struct Watched {
    process: OwnedFd,
    was_ready: bool,
    hung: bool,
    /// When it has to have given a sign of life, or to have ended.
    until: Instant,
}

impl Watched {
    fn new(child: &Child) -> Result<Self, SuperviseError> {
        let process = pidfd_open(Pid::from_child(child), PidfdFlags::empty());
        Ok(Self {
            process: process.map_err(system("pidfd"))?,
            was_ready: false,
            hung: false,
            until: Instant::now() + START,
        })
    }

    fn left(&self) -> Duration {
        self.until
            .saturating_duration_since(Instant::now())
    }

    /// One that has ended needs no signal.
    fn send(&self, signal: Signal) {
        let _ = pidfd_send_signal(&self.process, signal);
    }

    fn gave_sign(&mut self, patience: Duration) {
        if !self.was_ready {
            tell(NotifyState::Ready);
        }
        tell(NotifyState::Watchdog);
        self.was_ready = true;
        if !self.hung {
            self.until = Instant::now() + patience;
        }
    }

    fn is_late(&self) -> bool {
        Instant::now() >= self.until
    }

    /// Asks for last words first, then ends it.
    fn end_if_late(&mut self) {
        if !self.is_late() {
            return;
        }
        self.send(if self.hung {
            Signal::KILL
        } else {
            Signal::ABORT
        });
        self.hung = true;
        self.until = Instant::now() + LAST_WORDS;
    }
}

struct Supervisor {
    instance: Instance,
    patience: Duration,
    /// One byte for each signal.
    signals: UnixStream,
    signs: UnixDatagram,
    socket: PathBuf,
    is_stopping: bool,
    starts: u32,
}

impl Supervisor {
    fn new(instance: &Instance, patience: Duration) -> Result<Self, SuperviseError> {
        let signals = signals()?;
        let root = instance.root();
        remove_stale(root);
        let socket = root.join(format!("{SOCKET}{}", std::process::id()));
        let signs = bound(&socket).map_err(system("socket"))?;
        Ok(Self {
            instance: instance.clone(),
            patience,
            signals,
            signs,
            socket,
            is_stopping: false,
            starts: 0,
        })
    }

    /// Whether a daemon that ended like this is not started again.
    fn is_last(&self, end: &End) -> bool {
        // What it cannot read or serve at its very start it has said itself.
        let never_served = self.starts == 1 && !end.was_ready && end.status.code().is_some();
        self.is_stopping || end.status.success() || never_served
    }

    /// Waits before the next start, the longer the more quick deaths there were in a row.
    fn rest(&mut self, end: &End, quick: u32) -> Result<(), SuperviseError> {
        let last = end.describe();
        if quick >= MOST_QUICK {
            return Err(SuperviseError::GaveUp { last });
        }
        eprintln!("taut: the daemon died of {last}; it is started again");
        match quick {
            0 | 1 => Ok(()),
            _ => self.pause(PAUSE * 2u32.pow(quick - 2)),
        }
    }

    /// One life of the daemon.
    fn run(&mut self, arguments: &[OsString]) -> Result<End, SuperviseError> {
        let mut child = self.start(arguments)?;
        self.starts += 1;
        let watched = self.watch(&child);
        if watched.is_err() {
            // Nobody would watch over it.
            let _ = child.kill();
        }
        let status = child
            .wait()
            .map_err(system("end of the daemon"))?;
        let Watched {
            was_ready, hung, ..
        } = watched?;
        Ok(End {
            status,
            was_ready,
            hung,
        })
    }

    fn start(&mut self, arguments: &[OsString]) -> Result<Child, SuperviseError> {
        self.bind_again()?;
        let program = std::env::current_exe().map_err(system("path of this program"))?;
        let mut command = Command::new(program);
        command
            .args(arguments)
            .arg("--supervised-by")
            .arg(std::process::id().to_string())
            .env("NOTIFY_SOCKET", &self.socket);
        command.spawn().map_err(system("process"))
    }

    /// Makes the socket anew where somebody removed it with the root; tells whether it did.
    fn bind_again(&mut self) -> Result<bool, SuperviseError> {
        if self.socket.exists() {
            return Ok(false);
        }
        self.instance.prepare_again()?;
        self.signs = bound(&self.socket).map_err(system("socket"))?;
        Ok(true)
    }

    /// Waits for the end of a daemon.
    fn watch(&mut self, child: &Child) -> Result<Watched, SuperviseError> {
        let mut daemon = Watched::new(child)?;
        loop {
            let happened = self.wait(Some(&daemon.process), daemon.left())?;
            if happened.signal {
                self.is_stopping = true;
                daemon.send(Signal::TERM);
            }
            if happened.sign {
                daemon.gave_sign(self.patience);
            }
            if happened.end {
                return Ok(daemon);
            }
            // What it cannot tell it is not blamed for.
            if daemon.is_late() && self.bind_again()? {
                daemon.until = Instant::now() + self.patience;
            }
            daemon.end_if_late();
        }
    }

    /// Lets time pass, unless a signal comes.
    fn pause(&mut self, pause: Duration) -> Result<(), SuperviseError> {
        let end = Instant::now() + pause;
        while !self.is_stopping && Instant::now() < end {
            let left = end.saturating_duration_since(Instant::now());
            self.is_stopping = self.wait(None, left)?.signal;
        }
        Ok(())
    }

    fn wait(
        &mut self,
        process: Option<&OwnedFd>,
        timeout: Duration,
    ) -> Result<Happened, SuperviseError> {
        let end = self
            .poll(process, timeout)
            .map_err(system("poll"))?;
        let signal = self.had_signal();
        let sign = self.had_sign();
        Ok(Happened { signal, sign, end })
    }

    fn had_signal(&self) -> bool {
        matches!((&self.signals).read(&mut [0; 256]), Ok(1..))
    }

    /// Reads all signs of life that came.
    fn had_sign(&self) -> bool {
        let mut sign = false;
        while matches!(self.signs.recv(&mut [0; 256]), Ok(1..)) {
            sign = true;
        }
        sign
    }

    /// Waits for anything to happen; tells whether the process has ended.
    fn poll(
        &self,
        process: Option<&OwnedFd>,
        timeout: Duration,
    ) -> Result<bool, rustix::io::Errno> {
        let mut watched = vec![
            PollFd::new(&self.signals, PollFlags::IN),
            PollFd::new(&self.signs, PollFlags::IN),
        ];
        watched.extend(process.map(|process| PollFd::new(process, PollFlags::IN)));
        poll_for(&mut watched, timeout)?;
        let process = watched.get(2);
        Ok(process.is_some_and(|process| !process.revents().is_empty()))
    }
}

/// A signal only ends the wait.
fn poll_for(watched: &mut [PollFd], timeout: Duration) -> Result<(), rustix::io::Errno> {
    let timeout = Timespec::try_from(timeout).ok();
    match poll(watched, timeout.as_ref()) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error),
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.socket);
    }
}

struct Happened {
    signal: bool,
    sign: bool,
    end: bool,
}

/// A supervisor may itself be a service of systemd.
fn tell(state: NotifyState) {
    // Where that does not listen, it says so.
    let _ = sd_notify::notify(&[state]);
}

/// How the name of the socket for signs of life starts; the supervisor's process number follows.
const SOCKET: &str = "supervisor-";

/// Removes the sockets of supervisors that were killed.
fn remove_stale(root: &Path) {
    for entry in stale(root) {
        let _ = std::fs::remove_file(entry.path());
    }
}

fn stale(root: &Path) -> impl Iterator<Item = DirEntry> {
    let entries = std::fs::read_dir(root)
        .into_iter()
        .flatten()
        .flatten();
    entries.filter(|entry| supervisor_of(entry).is_some_and(is_gone))
}

/// The supervisor whose socket this is.
fn supervisor_of(entry: &DirEntry) -> Option<Pid> {
    let name = entry.file_name();
    let pid = name.to_str()?.strip_prefix(SOCKET)?;
    Pid::from_raw(pid.parse().ok()?)
}

/// Whether no other process has this number.
fn is_gone(pid: Pid) -> bool {
    let is_own = pid.as_raw_nonzero().get() as u32 == std::process::id();
    is_own || test_kill_process(pid).is_err()
}

/// Where a byte comes for each signal that asks to end.
fn signals() -> Result<UnixStream, SuperviseError> {
    let (signals, sender) = UnixStream::pair().map_err(system("socket"))?;
    for signal in [SIGTERM, SIGINT] {
        let sender = sender.try_clone().map_err(system("socket"))?;
        let registered = signal_hook::low_level::pipe::register(signal, sender);
        registered.map_err(system("signal handler"))?;
    }
    signals
        .set_nonblocking(true)
        .map_err(system("socket"))?;
    Ok(signals)
}

fn bound(socket: &Path) -> std::io::Result<UnixDatagram> {
    let signs = UnixDatagram::bind(socket)?;
    signs.set_nonblocking(true)?;
    Ok(signs)
}
