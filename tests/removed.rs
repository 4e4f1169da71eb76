//! Files of an instance that somebody removes under a running daemon: it starts anew with every robot
//! and scene, and no request is without an end. `TAUT_REMOVALS` is how often each test removes them
//! (6).
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use common::*;
use taut_ipc::control::{ControlReply, ControlRequest, Listing};
use taut_ipc::memory::shared_files;
use taut_ipc::{Client, ClientError, DaemonState, Instance, deadline_after};

/// What may be gone: shared memory (RemoveIPC), the root, both, or a file.
const REMOVALS: [fn(&Instance); 6] = [
    remove_shared,
    remove_root,
    remove_both,
    remove_sockets,
    remove_lock,
    remove_a_service,
];

fn remove_shared(instance: &Instance) {
    for file in shared_files(instance) {
        let _ = fs::remove_file(file.path);
    }
}

fn remove_root(instance: &Instance) {
    // Clients may make files in there meanwhile.
    while instance.root().exists() {
        let _ = fs::remove_dir_all(instance.root());
    }
}

fn remove_both(instance: &Instance) {
    remove_shared(instance);
    remove_root(instance);
}

fn remove_sockets(instance: &Instance) {
    remove_some(instance, "", ".event", usize::MAX);
}

fn remove_lock(instance: &Instance) {
    remove_some(instance, "", ".lock", 1);
}

fn remove_a_service(instance: &Instance) {
    remove_some(instance, "services", ".service", 1);
}

fn remove_some(instance: &Instance, folder: &str, end: &str, count: usize) {
    let entries = fs::read_dir(instance.root().join(folder)).unwrap();
    let mut files: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|file| file.to_string_lossy().ends_with(end))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{folder}*{end}");
    for file in files.iter().take(count) {
        // A client may be faster with its own.
        let _ = fs::remove_file(file);
    }
}

fn removals() -> usize {
    let said = std::env::var("TAUT_REMOVALS").ok();
    said.map_or(REMOVALS.len(), |said| said.parse().unwrap())
}

/// Which start of the daemon serves; `None` where none does.
fn boot(place: &Place) -> Option<u64> {
    match taut_ipc::daemon_state(&place.instance) {
        Ok(DaemonState::Running { boot_id, .. }) => Some(boot_id),
        _ => None,
    }
}

fn start(place: &Place, arguments: &[&str]) -> Daemon {
    let file = config("problems/arm_shelf.json");
    let text = format!(
        "fault_injection = true\nwatchdog_s = 2.0\n[[problems]]\nfile = {file:?}\nrobot = \"arm_shelf\"\nscene = \"arm_shelf\"\n"
    );
    let config = place.file("removed.toml", &text);
    let messages = fs::File::create(place.folder.path().join("messages")).unwrap();
    let mut command = place.command(&[&["serve", "--config", &config], arguments].concat());
    let child = command
        .stdout(Stdio::null())
        .stderr(messages)
        .spawn()
        .unwrap();
    until("a daemon is up", || boot(place).is_some());
    Daemon(child)
}

fn load_scene(place: &Place, label: &str, file: &str) {
    let run = place.taut(&["load-scene", label, &config(file), "--replace"]);
    assert_eq!(run.exit, 0, "{}", run.err);
}

/// What is loaded, as a client sees it that comes now.
fn listing(place: &Place) -> Option<Listing> {
    let client = Client::connect(&place.instance).ok()?;
    match client.control(&ControlRequest::List, PATIENCE) {
        Ok(ControlReply::Listing(listing)) => Some(listing),
        _ => None,
    }
}

/// Requests that go on, some short and some without an end, and how they end.
struct Load<'a> {
    place: &'a Place,
    models: Models,
    stops: AtomicBool,
    answered: AtomicU64,
    lost: AtomicU64,
    longest_ms: AtomicU64,
}

impl<'a> Load<'a> {
    fn new(place: &'a Place) -> Self {
        Self {
            place,
            models: Models::of(&place.client(), "arm_shelf"),
            stops: AtomicBool::new(false),
            answered: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            longest_ms: AtomicU64::new(0),
        }
    }

    /// One client that lives through everything.
    fn ask_with_one_client(&self, client: &Client, is_endless: bool) {
        while !self.stops.load(Relaxed) {
            self.ask(client, is_endless);
        }
    }

    /// A client for each request.
    fn ask_with_new_clients(&self) {
        while !self.stops.load(Relaxed) {
            match Client::connect(&self.place.instance) {
                Ok(client) => self.ask(&client, false),
                Err(error) => self.lost(&error),
            }
        }
    }

    fn ask(&self, client: &Client, is_endless: bool) {
        let start = Instant::now();
        match self.answer(client, is_endless) {
            Ok(()) => self.answered.fetch_add(1, Relaxed),
            Err(error) => {
                self.lost(&error);
                0
            }
        };
        let took = start.elapsed().as_millis() as u64;
        self.longest_ms.fetch_max(took, Relaxed);
    }

    fn answer(&self, client: &Client, is_endless: bool) -> Result<(), ClientError> {
        let mut builder = client.request(0, 0);
        builder.header = self.models.header();
        if is_endless {
            patient(&mut builder.header);
            builder.header.deadline_ns = deadline_after(Duration::from_secs(3));
        }
        let mut loan = builder.loan()?;
        loan.path_mut()
            .copy_from_slice(&self.models.path);
        loan.send()?.wait(PATIENCE).map(drop)
    }

    fn lost(&self, error: &ClientError) {
        assert!(
            error.is_passing() || matches!(error, ClientError::Transport { .. }),
            "{error}"
        );
        self.lost.fetch_add(1, Relaxed);
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn heals(arguments: &[&str]) {
    let place = Place::new();
    let daemon = start(&place, arguments);
    load_scene(&place, "cell", "scenes/arm_window.json");
    load_scene(&place, "cell", "scenes/arm_shelf.json");
    load_scene(&place, "arm_shelf", "scenes/arm_window.json");
    load_scene(&place, "arm_shelf", "scenes/arm_shelf.json");
    let before = listing(&place).unwrap();
    let load = Load::new(&place);
    let planner = taut_ipc::planner::Planner::connect(&place.instance).unwrap();
    let clients = [place.client(), place.client()];
    std::thread::scope(|scope| {
        scope.spawn(|| load.ask_with_one_client(&clients[0], false));
        scope.spawn(|| load.ask_with_one_client(&clients[1], true));
        scope.spawn(|| load.ask_with_new_clients());
        for round in 0..removals() {
            let served = boot(&place);
            REMOVALS[round % REMOVALS.len()](&place.instance);
            let healed = until("another start serves", || {
                boot(&place).is_some_and(|boot| Some(boot) != served)
            });
            let mut after = None;
            let back = until("a new client is served", || {
                after = listing(&place);
                after.is_some()
            });
            println!(
                "{round}: healed after {healed:?}, a new client served after another {back:?}"
            );
            assert_eq!(after.as_ref(), Some(&before), "round {round}");
            // The planner asks for what it has not asked for yet.
            planner.control(&ControlRequest::List).unwrap();
        }
        load.stops.store(true, Relaxed);
    });
    println!(
        "{arguments:?}: {} answered, {} lost, the longest took {} ms",
        load.answered.load(Relaxed),
        load.lost.load(Relaxed),
        load.longest_ms.load(Relaxed)
    );
    assert!(load.answered.load(Relaxed) > 0 && load.lost.load(Relaxed) > 0);
    let messages = fs::read_to_string(place.folder.path().join("messages")).unwrap();
    assert!(
        messages.contains("is gone, by which clients find"),
        "{messages}"
    );
    assert!(
        !messages.contains("started again"),
        "it never died: {messages}"
    );
    drop((planner, clients));
    assert_eq!(place.taut(&["stop"]).exit, 0);
    assert_eq!(daemon.wait(), 0);
}

#[test]
fn a_daemon_whose_files_are_removed_under_load_serves_again_what_it_had() {
    heals(&[]);
}

#[test]
fn so_does_one_that_keeps_nothing_on_disk() {
    heals(&["--no-state"]);
}

#[test]
fn so_does_one_that_is_supervised() {
    heals(&["--supervise"]);
}

#[test]
fn a_command_waits_for_a_daemon_that_starts_anew() {
    let place = Place::new();
    let daemon = start(&place, &[]);
    remove_a_service(&place.instance);
    let run = place.taut(&["list"]);
    assert_eq!(run.exit, 0, "{}", run.err);
    drop(daemon);
}

#[test]
fn what_was_kept_among_the_removed_files_is_kept_again() {
    let place = Place::new();
    let daemon = start(&place, &[]);
    load_scene(&place, "cell", "scenes/arm_window.json");
    load_scene(&place, "cell", "scenes/arm_shelf.json");
    let before = listing(&place).unwrap();
    let served = boot(&place);
    remove_both(&place.instance);
    until("another start serves", || {
        boot(&place).is_some_and(|boot| Some(boot) != served)
    });
    let journal = place.instance.root().join("state/journal");
    until("the journal is written", || {
        fs::read(&journal).is_ok_and(|bytes| bytes.len() > 1000)
    });
    daemon.kill();
    let _daemon = start(&place, &[]);
    let mut after = listing(&place).unwrap();
    // Only the newest versions come back, and the next numbers leave room.
    for (scene, before) in after.scenes.iter_mut().zip(&before.scenes) {
        scene.kept_from = before.kept_from;
    }
    assert_eq!(after, before);
}

#[test]
fn a_second_daemon_on_the_removed_instance_and_the_first_never_both_stay() {
    for pause_ms in [0, 150, 300, 450] {
        let place = Place::new();
        let mut first = start(&place, &[]);
        remove_both(&place.instance);
        std::thread::sleep(Duration::from_millis(pause_ms));
        let messages = place.folder.path().join("second");
        let mut second = Daemon(
            place
                .command(&["serve"])
                .stdout(Stdio::null())
                .stderr(fs::File::create(&messages).unwrap())
                .spawn()
                .unwrap(),
        );
        until("one of them has ended", || {
            first.is_alive() != second.is_alive()
        });
        let (winner, loser, said) = match first.is_alive() {
            true => (first, second, messages),
            false => (second, first, place.folder.path().join("messages")),
        };
        assert_eq!(loser.wait(), 69);
        let said = fs::read_to_string(said).unwrap();
        assert!(said.contains("another daemon"), "{said}");
        until("the other serves", || listing(&place).is_some());
        let serving = boot(&place);
        std::thread::sleep(Duration::from_millis(1200));
        assert_eq!(boot(&place), serving, "and stays");
        drop(winner);
    }
}
