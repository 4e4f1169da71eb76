//! Processes that are killed: nobody else is harmed, nothing is left behind.

mod common;

use common::*;
use std::time::{Duration, Instant};
use taut_ipc::control::ControlRequest;
use taut_ipc::memory::shared_files;
use taut_ipc::server::{Server, clean_dead_nodes};
use taut_ipc::wire::{Code, Mode};
use taut_ipc::{Client, ClientError, Instance};

/// Works until killed: a request is always in flight.
fn restless_client(instance: &Instance) {
    let client = Client::connect(instance).unwrap();
    for round in 0.. {
        let mode = if round % 3 == 0 {
            Mode::Hybrid
        } else {
            Mode::Gradient
        };
        let mut pending = request(&client, mode, 64, 0.0)
            .unwrap()
            .send()
            .unwrap();
        let _ = pending.next(Duration::from_millis(5));
    }
}

/// One pass to the end of a request, so that all memory of a client has been made.
fn round_trip(client: &Client) {
    let loan = request(client, Mode::Check, 64, 0.0).unwrap();
    assert_eq!(
        loan.send()
            .unwrap()
            .wait(PATIENCE)
            .unwrap()
            .code(),
        Code::Success
    );
}

/// Shared-memory files when everything between daemon and `client` has been made.
fn baseline(sandbox: &Sandbox, client: &Client) -> usize {
    round_trip(client);
    client
        .control(&ControlRequest::List, PATIENCE)
        .unwrap();
    shared_files(&sandbox.instance).len()
}

#[test]
fn killed_clients_are_cleaned_up_and_harm_nobody() {
    if let Some((_, instance)) = role() {
        return restless_client(&instance);
    }
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let witness = Client::connect(&sandbox.instance).unwrap();
    round_trip(&witness);
    let feed = witness.status_feed().unwrap();
    let baseline = shared_files(&sandbox.instance).len();
    let mut slowest = Duration::ZERO;
    for round in 0..8u64 {
        let child = Process::start(
            "killed_clients_are_cleaned_up_and_harm_nobody",
            "client",
            &sandbox.instance,
        );
        until("child connects", || {
            round_trip(&witness);
            feed.latest()
                .unwrap()
                .is_some_and(|status| status.clients == 2)
        });
        std::thread::sleep(Duration::from_millis(3 * round));
        child.kill();
        let killed = Instant::now();
        until("dead client is cleaned up", || {
            round_trip(&witness);
            shared_files(&sandbox.instance).len() <= baseline
        });
        slowest = slowest.max(killed.elapsed());
    }
    println!("killed -> shared memory back to {baseline} files: at most {slowest:?}");
    assert!(slowest < Duration::from_secs(4), "{slowest:?}");
}

#[test]
fn a_settled_clients_death_is_noticed_at_once() {
    if let Some((_, instance)) = role() {
        let client = Client::connect(&instance).unwrap();
        let _held = request(&client, Mode::Hybrid, 4, 0.0)
            .unwrap()
            .send()
            .unwrap();
        return std::thread::sleep(PATIENCE);
    }
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let witness = Client::connect(&sandbox.instance).unwrap();
    let feed = witness.status_feed().unwrap();
    let child = Process::start(
        "a_settled_clients_death_is_noticed_at_once",
        "client",
        &sandbox.instance,
    );
    until("request is held", || {
        round_trip(&witness);
        feed.latest()
            .unwrap()
            .is_some_and(|status| status.running == 1)
    });
    std::thread::sleep(SECOND);
    child.kill();
    let took = until("its request ends", || {
        feed.latest()
            .unwrap()
            .is_some_and(|status| status.running == 0)
    });
    println!("settled client killed -> request disconnected: {took:?}");
    assert!(took < Duration::from_millis(200), "{took:?}");
}

#[test]
fn clients_killed_while_connecting_leave_nothing() {
    if let Some((_, instance)) = role() {
        return restless_client(&instance);
    }
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let witness = Client::connect(&sandbox.instance).unwrap();
    let baseline = baseline(&sandbox, &witness);
    let seed = u64::from(std::process::id());
    println!("seed {seed}");
    let mut random = seed;
    for _ in 0..40 {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let test = "clients_killed_while_connecting_leave_nothing";
        let child = Process::start(test, "client", &sandbox.instance);
        std::thread::sleep(Duration::from_micros(random >> 32 & 0x7fff));
        child.kill();
        round_trip(&witness);
    }
    let took = until("all are cleaned up", || {
        round_trip(&witness);
        shared_files(&sandbox.instance).len() <= baseline
    });
    println!(
        "40 clients killed within 33 ms of their start -> back to {baseline} files after {took:?}"
    );
}

#[test]
fn a_client_killed_with_responses_unread_frees_its_slot() {
    if let Some((_, instance)) = role() {
        let client = Client::connect(&instance).unwrap();
        let mut builder = client.request(4, 8);
        builder.header.mode = Mode::Gradient.into();
        builder.header.work_budget = 1000;
        let _pending = builder.loan().unwrap().send().unwrap();
        let _held = request(&client, Mode::Hybrid, 4, 0.0)
            .unwrap()
            .send()
            .unwrap();
        return std::thread::sleep(PATIENCE);
    }
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let witness = Client::connect(&sandbox.instance).unwrap();
    let feed = witness.status_feed().unwrap();
    let seen = |running| {
        feed.latest()
            .unwrap()
            .is_some_and(|status| status.running == running)
    };
    let child = Process::start(
        "a_client_killed_with_responses_unread_frees_its_slot",
        "client",
        &sandbox.instance,
    );
    until("request is held", || {
        round_trip(&witness);
        seen(1)
    });
    child.kill();
    let took = until("its request ends", || seen(0));
    println!("killed -> request disconnected: {took:?}");
    assert!(took < SECOND, "{took:?}");
}

#[test]
fn a_waiting_client_notices_the_daemons_death() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let sandbox = Sandbox::new();
    let start = || {
        let child = Process::start(
            "a_waiting_client_notices_the_daemons_death",
            "daemon",
            &sandbox.instance,
        );
        wait_for_daemon(&sandbox.instance);
        child
    };
    let daemon = start();
    let client = Client::connect(&sandbox.instance).unwrap();
    round_trip(&client);
    let mut daemon = Some(daemon);
    for _ in 0..3 {
        let pending = request(&client, Mode::Hybrid, 4, 0.0)
            .unwrap()
            .send()
            .unwrap();
        std::thread::sleep(Duration::from_millis(37));
        daemon.take().unwrap().kill();
        let killed = Instant::now();
        let error = pending.wait(PATIENCE).unwrap_err();
        let took = killed.elapsed();
        // How soon is what `taut-bench promises` measures.
        assert_eq!(error.code(), Code::DaemonLost, "{error}");
        println!("daemon killed -> client knows: {took:?}");
        let refused = request(&client, Mode::Check, 4, 0.0)
            .unwrap()
            .send()
            .unwrap_err();
        assert_eq!(refused.code(), Code::DaemonLost, "{refused}");

        let restart = Instant::now();
        daemon = Some(start());
        round_trip(&client);
        println!(
            "restart -> the old client's first answer: {:?}",
            restart.elapsed()
        );
    }
}

#[test]
fn a_client_that_waits_in_small_pieces_notices_the_daemons_death() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let sandbox = Sandbox::new();
    let test = "a_client_that_waits_in_small_pieces_notices_the_daemons_death";
    let daemon = Process::start(test, "daemon", &sandbox.instance);
    wait_for_daemon(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let mut pending = request(&client, Mode::Hybrid, 4, 0.0)
        .unwrap()
        .send()
        .unwrap();
    daemon.kill();
    let killed = Instant::now();
    let error = loop {
        match pending.next(Duration::from_millis(5)) {
            Err(ClientError::Timeout(_)) => {
                assert!(killed.elapsed() < PATIENCE, "it is still waiting")
            }
            Err(error) => break error,
            Ok(_) => (),
        }
    };
    assert!(matches!(error, ClientError::DaemonLost { .. }), "{error}");
}

#[test]
fn a_daemon_that_died_alone_leaves_nothing_to_the_next() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let sandbox = Sandbox::new();
    for _ in 0..3 {
        let child = Process::start(
            "a_daemon_that_died_alone_leaves_nothing_to_the_next",
            "daemon",
            &sandbox.instance,
        );
        wait_for_daemon(&sandbox.instance);
        child.kill();
    }
    let left = shared_files(&sandbox.instance).len();
    drop(Server::create(&sandbox.instance).unwrap());
    let after = shared_files(&sandbox.instance);
    println!("files left by the killed daemon: {left}, after the next one: {after:?}");
    assert!(after.is_empty(), "{after:?}");
}

#[test]
fn a_restart_under_a_waiting_client_is_noticed() {
    if let Some((_, instance)) = role() {
        serve_for_ever(&instance);
    }
    let sandbox = Sandbox::new();
    let start = || {
        Process::start(
            "a_restart_under_a_waiting_client_is_noticed",
            "daemon",
            &sandbox.instance,
        )
    };
    let first = start();
    wait_for_daemon(&sandbox.instance);
    let client = Client::connect(&sandbox.instance).unwrap();
    let pending = request(&client, Mode::Hybrid, 4, 0.0)
        .unwrap()
        .send()
        .unwrap();
    first.kill();
    let _second = start();
    let error = pending.wait(PATIENCE).unwrap_err();
    assert!(matches!(error, ClientError::DaemonLost { .. }), "{error}");
    wait_for_daemon(&sandbox.instance);
    round_trip(&client);
}

#[test]
fn empty_files_of_the_dead_are_removed_only_when_old() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    assert_eq!(clean_dead_nodes(&sandbox.instance).cleaned, 0);
    let path = format!("/dev/shm/{}123.data", sandbox.instance.prefix());
    std::fs::write(&path, []).unwrap();
    let done = clean_dead_nodes(&sandbox.instance);
    assert_eq!(
        (done.alive, done.files, done.postponed),
        (1, 0, 0),
        "nobody is dead: nothing to do"
    );
    assert!(std::fs::exists(&path).unwrap());
    drop(server);
}

#[test]
fn a_client_killed_inside_its_first_steps_does_not_stop_the_janitor() {
    if let Some((_, instance)) = role() {
        // An empty shared-memory file as a process leaves it that dies between creating and sizing.
        let client = Client::connect(&instance).unwrap();
        std::fs::write(format!("/dev/shm/{}777.data", instance.prefix()), []).unwrap();
        let _held = request(&client, Mode::Hybrid, 4, 0.0)
            .unwrap()
            .send()
            .unwrap();
        return std::thread::sleep(PATIENCE);
    }
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let witness = Client::connect(&sandbox.instance).unwrap();
    let feed = witness.status_feed().unwrap();
    let test = "a_client_killed_inside_its_first_steps_does_not_stop_the_janitor";
    let child = Process::start(test, "client", &sandbox.instance);
    until("request is held", || {
        round_trip(&witness);
        feed.latest()
            .unwrap()
            .is_some_and(|status| status.running == 1)
    });
    child.kill();
    let took = until("its request ends", || {
        feed.latest()
            .unwrap()
            .is_some_and(|status| status.running == 0)
    });
    println!("killed beside an empty file -> request disconnected: {took:?}");
    assert!(took < Duration::from_secs(4), "{took:?}");
    assert!(
        shared_files(&sandbox.instance)
            .iter()
            .all(|file| file.bytes > 0)
    );
}

/// Sends, and ends without waiting for the answer.
fn hasty_client(instance: &Instance) {
    let client = Client::connect(instance).unwrap();
    round_trip(&client);
    let loan = request(&client, Mode::Check, 64, 0.0).unwrap();
    let _pending = loan.send().unwrap();
}

#[test]
fn processes_that_send_and_end_at_once_leave_nothing_open() {
    if let Some((_, instance)) = role() {
        return hasty_client(&instance);
    }
    let sandbox = Sandbox::new();
    let _daemon = Echo::start(&sandbox.instance);
    let witness = Client::connect(&sandbox.instance).unwrap();
    round_trip(&witness);
    let before = open_memory(&sandbox.instance);
    for _ in 0..12 {
        let mut child = Process::start(
            "processes_that_send_and_end_at_once_leave_nothing_open",
            "client",
            &sandbox.instance,
        );
        assert!(child.0.wait().unwrap().success());
        round_trip(&witness);
    }
    until("their connections are closed", || {
        round_trip(&witness);
        open_memory(&sandbox.instance) <= before
    });
}
