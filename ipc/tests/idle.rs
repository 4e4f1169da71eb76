//! A daemon that has nothing to do does nothing.

mod common;

use common::*;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::time::{Duration, Instant};
use taut_ipc::limits::MAX_CLIENTS;
use taut_ipc::wire::{Code, Mode};
use taut_ipc::{Client, ClientError};

const WINDOW: Duration = Duration::from_secs(5);

/// CPU time of all threads of a process.
fn cpu_time(pid: u32) -> Duration {
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task")).unwrap();
    let spent = tasks.flatten().map(|task| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
        text.split(' ').next().and_then(|ns| ns.parse::<u64>().ok()).unwrap_or(0)
    });
    Duration::from_nanos(spent.sum())
}

fn idle_share(pid: u32) -> f64 {
    let (start, before) = (Instant::now(), cpu_time(pid));
    std::thread::sleep(WINDOW);
    (cpu_time(pid) - before).as_secs_f64() / start.elapsed().as_secs_f64()
}

#[test]
fn one_client_too_many_is_told_so_and_room_comes_back() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let files = getrlimit(Resource::Nofile).maximum;
    setrlimit(Resource::Nofile, Rlimit { current: files, maximum: files }).unwrap();
    let sandbox = Sandbox::new();
    let _daemon = Process::start("one_client_too_many_is_told_so_and_room_comes_back", "daemon", &sandbox.instance);
    wait_for_daemon(&sandbox.instance);
    let mut clients: Vec<_> = (0..MAX_CLIENTS).map(|_| Client::connect(&sandbox.instance).unwrap()).collect();
    let error = Client::connect(&sandbox.instance).unwrap_err();
    assert!(matches!(error, ClientError::TooManyClients), "{error}");
    for client in &clients {
        let pending = request(client, Mode::Check, 4, 0.0).unwrap().send().unwrap();
        assert_eq!(pending.wait(PATIENCE).unwrap().code(), Code::Success);
    }
    clients.pop();
    Client::connect(&sandbox.instance).unwrap();
}

#[test]
fn an_idle_daemon_takes_no_processor() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let sandbox = Sandbox::new();
    let daemon = Process::start("an_idle_daemon_takes_no_processor", "daemon", &sandbox.instance);
    wait_for_daemon(&sandbox.instance);
    let alone = idle_share(daemon.0.id());
    let start = Instant::now();
    let clients: Vec<_> = (0..64).map(|_| Client::connect(&sandbox.instance).unwrap()).collect();
    let each = start.elapsed() / 64;
    std::thread::sleep(SECOND);
    let taken: u64 = taut_ipc::memory::shared_files(&sandbox.instance).iter().map(|file| file.taken).sum();
    let files = std::fs::read_dir(format!("/proc/{}/fd", daemon.0.id())).unwrap().count();
    println!(
        "64 clients: connecting {each:?} each, shared memory {} KiB, {files} files open in the daemon",
        taken >> 10
    );
    assert!(taken < 64 << 20, "{taken} bytes");
    let crowded = idle_share(daemon.0.id());
    println!(
        "idle daemon: {:.3} % of a core alone, {:.3} % with {} clients",
        alone * 100.0,
        crowded * 100.0,
        clients.len()
    );
    assert!(alone < 0.002 && crowded < 0.02, "{alone} {crowded}");
}
