//! Files of an instance that somebody removes while its daemon serves.
#![allow(missing_docs)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::*;
use taut_ipc::client::Loss;
use taut_ipc::control::ControlRequest;
use taut_ipc::memory::shared_files;
use taut_ipc::planner::Planner;
use taut_ipc::server::Server;
use taut_ipc::wire::{Code, Mode};
use taut_ipc::{Client, ClientError, Instance, services};

/// Every file of an instance but the one that is read at the start only.
fn files(instance: &Instance) -> Vec<PathBuf> {
    let mut files = below(instance.root());
    files.retain(|file| !file.ends_with("iceoryx2.toml"));
    files.extend(
        shared_files(instance)
            .into_iter()
            .map(|file| file.path),
    );
    files.sort();
    files
}

fn below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    entries
        .flat_map(|entry| match entry.file_type().unwrap().is_dir() {
            true => below(&entry.path()),
            false => vec![entry.path()],
        })
        .collect()
}

/// What the daemon does not need itself: a counter that is made when it is next needed, and what
/// says of a living process that it lives.
fn is_needless(file: &Path) -> bool {
    let name = file.to_string_lossy();
    name.ends_with(".global_mgmt") || name.ends_with("_owner_lock") || name.ends_with("_context")
}

#[test]
fn a_server_misses_each_of_its_files_and_the_next_one_none() {
    let sandbox = Sandbox::new();
    let instance = &sandbox.instance;
    let count = files(instance_with_server(instance).0).len();
    assert!(count > 30, "{count}");
    for index in 0..count {
        let server = Server::create(instance).unwrap();
        assert_eq!(server.missing_file(), None);
        let file = files(instance)[index].clone();
        fs::remove_file(&file).unwrap();
        match is_needless(&file) {
            true => assert_eq!(server.missing_file(), None),
            false => assert_eq!(server.missing_file(), Some(&*file)),
        }
        drop(server);
        let next = Server::create(instance).unwrap();
        assert_eq!(next.missing_file(), None, "after {}", file.display());
    }
    assert!(shared_files(instance).is_empty(), "and leaves nothing");
}

fn instance_with_server(instance: &Instance) -> (&Instance, Server) {
    (instance, Server::create(instance).unwrap())
}

#[test]
fn clients_come_and_go_and_no_file_is_missed() {
    let sandbox = Sandbox::new();
    let server = Server::create(&sandbox.instance).unwrap();
    for _ in 0..3 {
        let client = Client::connect(&sandbox.instance).unwrap();
        let pending = send(&client, 1.0);
        assert!(server.receive().unwrap().is_some());
        drop((pending, client));
        assert_eq!(server.missing_file(), None);
    }
    // One that lives through a restart, whose services the next daemon takes over.
    let client = Client::connect(&sandbox.instance).unwrap();
    drop(server);
    let next = Server::create(&sandbox.instance).unwrap();
    let _pending = send(&client, 1.0);
    assert!(next.receive().unwrap().is_some(), "its ports work on");
    drop(client);
    assert_eq!(next.missing_file(), None);
}

fn send(client: &Client, first: f64) -> taut_ipc::Pending {
    request(client, Mode::Check, 4, first)
        .and_then(|loan| loan.send())
        .unwrap()
}

fn remove_shared(instance: &Instance) {
    for file in shared_files(instance) {
        fs::remove_file(file.path).unwrap();
    }
}

fn remove_root(instance: &Instance) {
    fs::remove_dir_all(instance.root()).unwrap();
}

fn remove_both(instance: &Instance) {
    remove_shared(instance);
    remove_root(instance);
}

fn is_removed(error: &ClientError) -> bool {
    matches!(
        error,
        ClientError::DaemonLost {
            loss: Loss::Removed,
            ..
        }
    )
}

#[test]
fn a_client_hears_of_the_removal_and_works_on_with_the_next_daemon() {
    for remove in [remove_shared, remove_root, remove_both] {
        let sandbox = Sandbox::new();
        let instance = &sandbox.instance;
        let server = Server::create(instance).unwrap();
        let old = Client::connect(instance).unwrap();
        let pending = send(&old, 1.0);
        remove(instance);
        assert!(server.missing_file().is_some());
        drop(server);
        let next = Server::create_again(instance).unwrap();
        let error = pending.wait(PATIENCE).unwrap_err();
        assert!(is_removed(&error), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("were removed") && !text.contains("release"),
            "{text}"
        );
        let _pending = send(&old, 2.0);
        assert!(next.receive().unwrap().is_some());
        // What the client had of the old services goes now, by name.
        drop(old);
        assert_eq!(next.missing_file(), None);
        let other = Client::connect(instance).unwrap();
        let _pending = send(&other, 3.0);
        assert!(next.receive().unwrap().is_some());
    }
}

#[test]
fn who_comes_before_the_daemon_has_noticed_hears_of_the_removal() {
    for (remove, loss) in [
        (remove_shared as fn(&Instance), Loss::Removed),
        (remove_both, Loss::NeverStarted),
    ] {
        let sandbox = Sandbox::new();
        let _server = Server::create(&sandbox.instance).unwrap();
        remove(&sandbox.instance);
        let error = Client::connect(&sandbox.instance).unwrap_err();
        assert_eq!(error.code(), Code::DaemonLost);
        assert!(
            matches!(&error, ClientError::DaemonLost { loss: seen, .. } if *seen == loss),
            "{error}"
        );
    }
}

#[test]
fn a_planner_outlives_a_removal_without_a_word() {
    let sandbox = Sandbox::new();
    let instance = &sandbox.instance;
    let first = Echo::start(instance);
    let planner = Planner::connect(instance).unwrap();
    planner.control(&ControlRequest::List).unwrap();
    remove_both(instance);
    drop(first);
    let _second = Echo::start(instance);
    planner.control(&ControlRequest::List).unwrap();
}

#[test]
fn services_are_of_one_generation_as_long_as_clients_live_on_them() {
    let sandbox = Sandbox::new();
    let generation = || match taut_ipc::daemon_state(&sandbox.instance).unwrap() {
        taut_ipc::DaemonState::Running { generation, .. } => generation,
        other => panic!("{other:?}"),
    };
    let server = Server::create(&sandbox.instance).unwrap();
    let first = generation();
    let client = Client::connect(&sandbox.instance).unwrap();
    drop(server);
    let server = Server::create(&sandbox.instance).unwrap();
    assert_eq!(generation(), first);
    drop((server, client));
    let server = Server::create(&sandbox.instance).unwrap();
    let second = generation();
    assert_ne!(second, first, "nobody lived");
    let _client = Client::connect(&sandbox.instance).unwrap();
    remove_shared(&sandbox.instance);
    drop(server);
    let _server = Server::create(&sandbox.instance).unwrap();
    assert_ne!(generation(), second, "nobody could live on them");
    assert_eq!(
        services::name(services::STATUS, 10),
        "taut/v1/status/000000000000000a"
    );
}
