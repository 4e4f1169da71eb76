//! What is looked at.

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::time::Duration;

use rustix::fs::{Access, access, statvfs};
use rustix::process::{PidfdFlags, Resource, getpid, getrlimit, pidfd_open};
use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::limits::SHM_RESERVE;
use taut_ipc::memory::{self, SHM_FOLDER, shared_files};
use taut_ipc::server::FILES_WANTED;
use taut_ipc::{Client, DaemonState, Instance, daemon_state};

use super::check::{Check, Verdict};
use crate::daemon::config::Config;
use crate::daemon::{inspect, state};

/// How long the daemon has to say who it is.
const PATIENCE: Duration = Duration::from_secs(5);
/// Free shared memory (bytes) below which some more clients fill it.
const LITTLE: u64 = 256 << 20;

/// All checks, in the order of what depends on what.
pub(super) fn all(instance: &Instance, config: &Config) -> Vec<Check> {
    let state = daemon_state(instance).unwrap_or(DaemonState::Absent);
    vec![
        check("kernel", kernel()),
        check("processors", processors(config)),
        check("shared memory", shared_memory()),
        check("open files", open_files()),
        check("instance", root(instance.root())),
        check("daemon", daemon(instance, state)),
        check("left behind", left_behind(instance, state)),
        check("state", kept(instance, config)),
    ]
}

fn check(what: &'static str, (verdict, seen): (Verdict, String)) -> Check {
    Check {
        what,
        verdict,
        seen,
    }
}

fn kernel() -> (Verdict, String) {
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    let release = release.trim();
    match pidfd_open(getpid(), PidfdFlags::empty()) {
        Ok(_) => (
            Verdict::Ok,
            format!("Linux {release}, tells of the death of processes (pidfd)"),
        ),
        Err(error) => {
            let text = format!(
                "Linux {release} has no pidfd ({error}): --supervise does not work; use Linux 5.3 or newer"
            );
            (Verdict::Fail, text)
        }
    }
}

fn processors(config: &Config) -> (Verdict, String) {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    match config.worker_count() {
        workers if workers > cores => {
            let text = format!(
                "{workers} workers on {cores} cores wait for each other; set workers to {cores} or 0"
            );
            (Verdict::Warn, text)
        }
        workers => (Verdict::Ok, format!("{cores} cores, {workers} workers")),
    }
}

fn shared_memory() -> (Verdict, String) {
    let mib = |bytes: u64| bytes >> 20;
    let Ok(stat) = statvfs(SHM_FOLDER) else {
        return (
            Verdict::Fail,
            format!("{SHM_FOLDER} is not there; mount a tmpfs on it"),
        );
    };
    let size = stat.f_blocks * stat.f_frsize;
    let free = memory::free_bytes();
    let seen = format!(
        "{SHM_FOLDER} has {} MiB, {} MiB free beside the reserve of {} MiB",
        mib(size),
        mib(free),
        mib(SHM_RESERVE.min(size / 8))
    );
    let step = "remove files there, or enlarge it: mount -o remount,size=1G /dev/shm";
    match free {
        0 => (
            Verdict::Fail,
            format!("{seen}: requests are refused; {step}"),
        ),
        free if free < LITTLE => (Verdict::Warn, format!("{seen}; {step}")),
        _ => (Verdict::Ok, seen),
    }
}

fn open_files() -> (Verdict, String) {
    let most = getrlimit(Resource::Nofile).maximum;
    match most {
        Some(most) if most < FILES_WANTED => {
            let text = format!(
                "a process may have {most}, a daemon with all its clients wants {FILES_WANTED}; raise it with ulimit -Hn or LimitNOFILE"
            );
            (Verdict::Warn, text)
        }
        Some(most) => (
            Verdict::Ok,
            format!("a process may have {most}, a daemon wants {FILES_WANTED}"),
        ),
        None => (
            Verdict::Ok,
            format!("no limit, a daemon wants {FILES_WANTED}"),
        ),
    }
}

fn root(root: &Path) -> (Verdict, String) {
    let seen = root.display();
    let Ok(meta) = std::fs::metadata(root) else {
        return (Verdict::Ok, format!("{seen} is made when a daemon starts"));
    };
    let uid = meta.uid();
    let mode = meta.permissions().mode() & 0o777;
    let me = rustix::process::geteuid().as_raw();
    if uid != me || mode & 0o077 != 0 {
        let text = format!(
            "{seen} belongs to user {uid} with mode {mode:o}, not to user {me} with mode 700; remove it"
        );
        return (Verdict::Fail, text);
    }
    (Verdict::Ok, format!("{seen} is private"))
}

fn daemon(instance: &Instance, state: DaemonState) -> (Verdict, String) {
    let (pid, boot_id) = match state {
        DaemonState::Running { pid, boot_id } => (pid, boot_id),
        DaemonState::Starting => {
            return (Verdict::Warn, "it is starting; look again soon".to_owned());
        }
        DaemonState::Absent => {
            return (
                Verdict::Warn,
                "none is running; start one with `taut serve`".to_owned(),
            );
        }
    };
    let own = env!("CARGO_PKG_VERSION");
    let seen = format!("process {pid}, boot {boot_id:016x}");
    let reply = Client::connect(instance)
        .and_then(|client| client.control(&ControlRequest::Stats, PATIENCE));
    match reply {
        Ok(ControlReply::Stats(stats)) if stats.daemon_version == own => {
            let clients = stats.numbers.get("clients");
            let panics = stats.numbers.get("worker_panics");
            let number = |value: Option<&f64>| value.copied().unwrap_or_default();
            let seen = format!("{seen}, release {own}, {} clients", number(clients));
            match number(panics) {
                0.0 => (Verdict::Ok, seen),
                panics => (
                    Verdict::Warn,
                    format!("{seen}, {panics} panics of workers; report what its messages say"),
                ),
            }
        }
        Ok(ControlReply::Stats(stats)) => {
            let text = format!(
                "{seen} is of release {}, this program of {own}; restart it",
                stats.daemon_version
            );
            (Verdict::Fail, text)
        }
        Ok(other) => (
            Verdict::Fail,
            format!("{seen} answers {other:?}; restart it with this release"),
        ),
        Err(error) => (Verdict::Fail, format!("{seen} does not answer: {error}")),
    }
}

fn left_behind(instance: &Instance, state: DaemonState) -> (Verdict, String) {
    let files = shared_files(instance);
    let taken = files.iter().map(|file| file.taken).sum::<u64>() >> 20;
    let seen = format!("{} files with {taken} MiB in {SHM_FOLDER}", files.len());
    match state {
        DaemonState::Absent if !files.is_empty() => (
            Verdict::Warn,
            format!("{seen} of a daemon or clients that died; the next `taut serve` removes them"),
        ),
        DaemonState::Absent => (Verdict::Ok, "nothing".to_owned()),
        _ => (
            Verdict::Ok,
            format!("{seen}, of the daemon and its clients"),
        ),
    }
}

fn kept(instance: &Instance, config: &Config) -> (Verdict, String) {
    let folder = match state::folder(config, instance) {
        Ok(Some(folder)) => folder,
        Ok(None) => {
            return (
                Verdict::Ok,
                "nothing is kept: a daemon begins with its configuration".to_owned(),
            );
        }
        Err(error) => return (Verdict::Fail, error.to_string()),
    };
    let seen = folder.display();
    if !folder.exists() {
        return (Verdict::Ok, format!("{seen} is made when a daemon starts"));
    }
    if let Err(error) = access(&folder, Access::WRITE_OK | Access::EXEC_OK) {
        return (
            Verdict::Fail,
            format!(
                "{seen} cannot be written ({error}); set its owner, or name another with --state"
            ),
        );
    }
    match inspect(&folder) {
        Err(error) => (Verdict::Fail, error.to_string()),
        Ok(found) if !found.wrong.is_empty() => {
            let wrong: Vec<String> = found
                .wrong
                .iter()
                .map(|(label, why)| format!("{label}: {why}"))
                .collect();
            (
                Verdict::Fail,
                format!(
                    "{seen} does not give back {}; load it again",
                    wrong.join("; ")
                ),
            )
        }
        Ok(found) => {
            let robots = found.robots;
            let scenes = found.scenes;
            let kib = found.bytes >> 10;
            (
                Verdict::Ok,
                format!(
                    "{seen} has {robots} robots and {scenes} scenes in {kib} KiB, each with its hash"
                ),
            )
        }
    }
}
