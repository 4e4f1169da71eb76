//! What is looked at.

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::time::Duration;

use rustix::fs::{Access, access, statvfs};
use rustix::process::{PidfdFlags, Resource, getpid, getrlimit, pidfd_open};
use taut_ipc::control::{ControlReply, ControlRequest, SceneSummary, SensedSummary, Stats};
use taut_ipc::limits::SHM_RESERVE;
use taut_ipc::memory::{self, SHM_FOLDER, shared_files};
use taut_ipc::server::FILES_WANTED;
use taut_ipc::{Client, DaemonState, Instance, daemon_state};

use super::check::{Check, Verdict};
use crate::daemon::config::Config;
use crate::daemon::{inspect, state};

/// How long the daemon has to say who it is.
const PATIENCE: Duration = Duration::from_secs(5);
/// A sensor that sends less often than this is asked about.
const SILENT: Duration = Duration::from_secs(2);
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
        check("sensors", sensors(instance, state)),
        check("left behind", left_behind(instance, state)),
        check("state", kept(instance, config)),
    ]
}

/// How something is, and what was seen of it.
type Finding = (Verdict, String);

fn fine(seen: impl Into<String>) -> Finding {
    (Verdict::Ok, seen.into())
}

fn warn(seen: impl Into<String>) -> Finding {
    (Verdict::Warn, seen.into())
}

fn fail(seen: impl Into<String>) -> Finding {
    (Verdict::Fail, seen.into())
}

fn check(what: &'static str, (verdict, seen): Finding) -> Check {
    Check {
        what,
        verdict,
        seen,
    }
}

fn kernel() -> Finding {
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    let release = release.trim();
    match pidfd_open(getpid(), PidfdFlags::empty()) {
        Ok(_) => fine(format!(
            "Linux {release}, tells of the death of processes (pidfd)"
        )),
        Err(error) => fail(format!(
            "Linux {release} has no pidfd ({error}): --supervise does not work; use Linux 5.3 or newer"
        )),
    }
}

fn processors(config: &Config) -> Finding {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    match config.worker_count() {
        workers if workers > cores => warn(format!(
            "{workers} workers on {cores} cores wait for each other; set workers to {cores} or 0"
        )),
        workers => fine(format!("{cores} cores, {workers} workers")),
    }
}

fn shared_memory() -> Finding {
    let Ok(stat) = statvfs(SHM_FOLDER) else {
        return fail(format!("{SHM_FOLDER} is not there; mount a tmpfs on it"));
    };
    let free = memory::free_bytes();
    let seen = memory_seen(stat.f_blocks * stat.f_frsize, free);
    let step = "remove files there, or enlarge it: mount -o remount,size=1G /dev/shm";
    match free {
        0 => fail(format!("{seen}: requests are refused; {step}")),
        free if free < LITTLE => warn(format!("{seen}; {step}")),
        _ => fine(seen),
    }
}

/// Shared memory of so many bytes, of which so many are free.
fn memory_seen(size: u64, free: u64) -> String {
    let mib = |bytes: u64| bytes >> 20;
    format!(
        "{SHM_FOLDER} has {} MiB, {} MiB free beside the reserve of {} MiB",
        mib(size),
        mib(free),
        mib(SHM_RESERVE.min(size / 8))
    )
}

fn open_files() -> Finding {
    match getrlimit(Resource::Nofile).maximum {
        Some(most) if most < FILES_WANTED => warn(format!(
            "a process may have {most}, a daemon with all its clients wants {FILES_WANTED}; raise it with ulimit -Hn or LimitNOFILE"
        )),
        Some(most) => fine(format!(
            "a process may have {most}, a daemon wants {FILES_WANTED}"
        )),
        None => fine(format!("no limit, a daemon wants {FILES_WANTED}")),
    }
}

fn root(root: &Path) -> Finding {
    let seen = root.display();
    let Ok(meta) = std::fs::metadata(root) else {
        return fine(format!("{seen} is made when a daemon starts"));
    };
    let uid = meta.uid();
    let mode = meta.permissions().mode() & 0o777;
    let me = rustix::process::geteuid().as_raw();
    if uid != me || mode & 0o077 != 0 {
        return fail(format!(
            "{seen} belongs to user {uid} with mode {mode:o}, not to user {me} with mode 700; remove it"
        ));
    }
    fine(format!("{seen} is private"))
}

fn daemon(instance: &Instance, state: DaemonState) -> Finding {
    match state {
        DaemonState::Running { pid, boot_id, .. } => {
            running(instance, &format!("process {pid}, boot {boot_id:016x}"))
        }
        DaemonState::Starting => warn("it is starting; look again soon"),
        DaemonState::Absent => warn("none is running; start one with `taut serve`"),
    }
}

/// Whether those that see scenes still send.
fn sensors(instance: &Instance, state: DaemonState) -> Finding {
    if !matches!(state, DaemonState::Running { .. }) {
        return fine("no daemon that hears any");
    }
    let reply = Client::connect(instance)
        .and_then(|client| client.control(&ControlRequest::List, PATIENCE));
    let Ok(ControlReply::Listing(listing)) = reply else {
        return warn("the daemon does not say what it hears; see above");
    };
    let of_scene = |scene: &SceneSummary| -> Vec<_> {
        let named = |sensed: &SensedSummary| (scene.label.clone(), sensed.clone());
        scene.sensed.iter().map(named).collect()
    };
    let all: Vec<_> = listing
        .scenes
        .iter()
        .flat_map(of_scene)
        .collect();
    let silent = all
        .iter()
        .filter_map(|(scene, sensed)| silence(scene, sensed));
    let silent: Vec<_> = silent.collect();
    match silent.is_empty() {
        true => fine(format!("{} objects of scenes are sensed", all.len())),
        false => warn(silent.join("; ")),
    }
}

/// What is said of a sensor that has not sent for long.
fn silence(scene: &str, sensed: &SensedSummary) -> Option<String> {
    let object = &sensed.object;
    match &sensed.last {
        None => Some(format!(
            "{object} of scene {scene} is not seen yet: requests there wait; start its sensor"
        )),
        Some(last) => {
            let age = Duration::from_nanos(last.age_ns);
            (age > SILENT).then(|| {
                format!(
                    "{object} of scene {scene} was seen {:.1} s ago: see whether its sensor sends; --max-age refuses what is too old",
                    age.as_secs_f64()
                )
            })
        }
    }
}

/// What a daemon that runs says of itself.
fn running(instance: &Instance, seen: &str) -> Finding {
    let reply = Client::connect(instance)
        .and_then(|client| client.control(&ControlRequest::Stats, PATIENCE));
    match reply {
        Ok(ControlReply::Stats(stats)) => release(seen, &stats),
        Ok(other) => fail(format!(
            "{seen} answers {other:?}; restart it with this release"
        )),
        Err(error) => fail(format!("{seen} does not answer: {error}")),
    }
}

/// Whether a daemon is of this release.
fn release(seen: &str, stats: &Stats) -> Finding {
    let own = env!("CARGO_PKG_VERSION");
    if stats.daemon_version == own {
        return panics(seen, stats);
    }
    fail(format!(
        "{seen} is of release {}, this program of {own}; restart it",
        stats.daemon_version
    ))
}

/// Whether workers of a daemon of this release had panics.
fn panics(seen: &str, stats: &Stats) -> Finding {
    let number = |name: &str| {
        stats
            .numbers
            .get(name)
            .copied()
            .unwrap_or_default()
    };
    let seen = format!(
        "{seen}, release {}, {} clients",
        stats.daemon_version,
        number("clients")
    );
    match number("worker_panics") {
        0.0 => fine(seen),
        panics => warn(format!(
            "{seen}, {panics} panics of workers; report what its messages say"
        )),
    }
}

fn left_behind(instance: &Instance, state: DaemonState) -> Finding {
    let files = shared_files(instance);
    let taken = files.iter().map(|file| file.taken).sum::<u64>() >> 20;
    let seen = format!("{} files with {taken} MiB in {SHM_FOLDER}", files.len());
    match state {
        DaemonState::Absent if !files.is_empty() => warn(format!(
            "{seen} of a daemon or clients that died; the next `taut serve` removes them"
        )),
        DaemonState::Absent => fine("nothing"),
        _ => fine(format!("{seen}, of the daemon and its clients")),
    }
}

fn kept(instance: &Instance, config: &Config) -> Finding {
    match state::folder(config, instance) {
        Ok(Some(folder)) => state_folder(&folder),
        Ok(None) => fine("nothing is kept: a daemon begins with its configuration"),
        Err(error) => fail(error.to_string()),
    }
}

/// Whether a folder can hold what a daemon keeps.
fn state_folder(folder: &Path) -> Finding {
    let seen = folder.display();
    if !folder.exists() {
        return fine(format!("{seen} is made when a daemon starts"));
    }
    if let Err(error) = access(folder, Access::WRITE_OK | Access::EXEC_OK) {
        return fail(format!(
            "{seen} cannot be written ({error}); set its owner, or name another with --state"
        ));
    }
    state_content(folder)
}

/// Whether a folder gives back what a daemon kept in it.
fn state_content(folder: &Path) -> Finding {
    let seen = folder.display();
    match inspect(folder) {
        Err(error) => fail(error.to_string()),
        Ok(found) if !found.wrong.is_empty() => fail(format!(
            "{seen} does not give back {}; load it again",
            listed(&found.wrong)
        )),
        Ok(found) => fine(format!(
            "{seen} has {} robots and {} scenes in {} KiB, each with its hash",
            found.robots,
            found.scenes,
            found.bytes >> 10
        )),
    }
}

fn listed(wrong: &[(String, String)]) -> String {
    let each = wrong
        .iter()
        .map(|(label, why)| format!("{label}: {why}"));
    each.collect::<Vec<_>>().join("; ")
}
