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
        text.split(' ')
            .next()
            .and_then(|ns| ns.parse::<u64>().ok())
            .unwrap_or(0)
    });
    Duration::from_nanos(spent.sum())
}

/// Times that the threads of a process have waited for something and been woken.
fn wakes(pid: u32) -> u64 {
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task")).unwrap();
    let woken = tasks.flatten().map(|task| {
        let text = std::fs::read_to_string(task.path().join("status")).unwrap_or_default();
        let line = text
            .lines()
            .find_map(|line| line.strip_prefix("voluntary_ctxt_switches:"));
        line.and_then(|count| count.trim().parse::<u64>().ok())
            .unwrap_or(0)
    });
    woken.sum()
}

/// Wakes per second of a process that is left alone, which a busy machine does not change, and its
/// share of a core, which it does.
fn idle(pid: u32) -> (f64, f64) {
    let start = Instant::now();
    let woken = wakes(pid);
    let spent = cpu_time(pid);
    std::thread::sleep(WINDOW);
    let seconds = start.elapsed().as_secs_f64();
    (
        (wakes(pid) - woken) as f64 / seconds,
        (cpu_time(pid) - spent).as_secs_f64() / seconds,
    )
}

#[test]
fn one_client_too_many_is_told_so_and_room_comes_back() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let files = getrlimit(Resource::Nofile).maximum;
    setrlimit(
        Resource::Nofile,
        Rlimit {
            current: files,
            maximum: files,
        },
    )
    .unwrap();
    let sandbox = Sandbox::new();
    let _daemon = Process::start(
        "one_client_too_many_is_told_so_and_room_comes_back",
        "daemon",
        &sandbox.instance,
    );
    wait_for_daemon(&sandbox.instance);
    let mut clients: Vec<_> = (0..MAX_CLIENTS)
        .map(|_| Client::connect(&sandbox.instance).unwrap())
        .collect();
    let error = Client::connect(&sandbox.instance).unwrap_err();
    assert!(matches!(error, ClientError::TooManyClients), "{error}");
    for client in &clients {
        let pending = request(client, Mode::Check, 4, 0.0)
            .unwrap()
            .send()
            .unwrap();
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
    let daemon = Process::start(
        "an_idle_daemon_takes_no_processor",
        "daemon",
        &sandbox.instance,
    );
    wait_for_daemon(&sandbox.instance);
    let alone = idle(daemon.0.id());
    let start = Instant::now();
    let clients: Vec<_> = (0..64)
        .map(|_| Client::connect(&sandbox.instance).unwrap())
        .collect();
    let each = start.elapsed() / 64;
    std::thread::sleep(SECOND);
    let taken: u64 = taut_ipc::memory::shared_files(&sandbox.instance)
        .iter()
        .map(|file| file.taken)
        .sum();
    let files = std::fs::read_dir(format!("/proc/{}/fd", daemon.0.id()))
        .unwrap()
        .count();
    println!(
        "64 clients: connecting {each:?} each, shared memory {} KiB, {files} files open in the daemon",
        taken >> 10
    );
    assert!(taken < 64 << 20, "{taken} bytes");
    let crowded = idle(daemon.0.id());
    for (name, (woken, share)) in [("alone", alone), ("with 64 clients", crowded)] {
        println!(
            "idle daemon {name}: {woken:.1} wakes a second, {:.3} % of a core",
            share * 100.0
        );
        assert!(woken <= 15.0, "{woken} wakes a second {name}");
        // Far above what a quiet machine shows: only a loop that does not wait gets there.
        assert!(share <= 0.05, "{share} of a core {name}");
    }
    drop(clients);
}
