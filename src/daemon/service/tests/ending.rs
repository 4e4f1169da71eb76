//! The end, and the end to start anew.

use std::path::PathBuf;

use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::wire::{Code, Mode, RequestFlags, RequestHeader};

use super::world::{MS, World};
use crate::daemon::config::Config;
use crate::daemon::service::event::{Event, Ticket};

/// Longest time until the daemon looks for its files again.
const LOOK_NS: u64 = 500 * MS;

/// A daemon with one worker that keeps its changes.
fn world() -> World {
    let config = Config {
        workers: 1,
        ..Config::default()
    };
    World::keeping(&config, true)
}

/// Somebody removes a file; the daemon notices by itself.
fn remove(world: &mut World) {
    world.missing = Some(PathBuf::from("/run/daemon.lock"));
    world.pass(LOOK_NS + 2 * MS);
}

/// Two requests without an end, which take turns, and a watched path.
fn open(world: &mut World) -> [Ticket; 3] {
    let header = world.header();
    let watch = RequestHeader {
        mode: Mode::Check.into(),
        flags: RequestFlags::WATCH,
        ..header
    };
    let watched = world.ask(3, watch);
    world.pass(2 * MS);
    let one = world.ask_that_costs(1, header, u64::MAX);
    let other = world.ask_that_costs(2, header, u64::MAX);
    [one, other, watched]
}

fn codes(world: &World, tickets: [Ticket; 3]) -> [Option<Code>; 3] {
    tickets.map(|ticket| world.of(ticket).code())
}

const ENDED: [Option<Code>; 3] = [
    Some(Code::Success),
    Some(Code::Success),
    Some(Code::Preempted),
];

#[test]
fn a_stop_ends_all_and_lets_nothing_in() {
    let mut world = world();
    let header = world.header();
    let running = world.ask(1, header);
    let waiting = world.ask(2, header);
    world.happens(Event::Stop);
    assert_eq!(world.of(waiting).code(), Some(Code::Preempted));
    let late = world.ask(3, header);
    assert_eq!(world.of(late).code(), Some(Code::Overloaded));
    assert!(!world.service.is_done());
    world.pass(MS);
    assert_eq!(world.of(running).code(), Some(Code::Success));
    assert!(world.service.is_done());
}

#[test]
fn what_is_open_ends_with_the_best_so_far_when_files_are_gone() {
    let mut world = world();
    let tickets = open(&mut world);
    world.pass(2 * LOOK_NS);
    assert_eq!(codes(&world, tickets), [None; 3], "all files are there");
    remove(&mut world);
    assert_eq!(codes(&world, tickets), ENDED);
    assert!(world.service.is_done() && world.service.is_removed());
}

#[test]
fn who_comes_after_the_files_are_gone_is_to_send_again() {
    let mut world = world();
    remove(&mut world);
    let header = world.header();
    let late = world.ask(1, header);
    let code = world.of(late).code().unwrap();
    assert!(code.is_retryable(), "{code:?}");
}

#[test]
fn a_change_is_waited_for_that_is_not_kept_yet_when_files_are_gone() {
    let mut world = world();
    let change = super::changes::change(&mut world);
    remove(&mut world);
    assert!(!world.service.is_done(), "somebody waits for the journal");
    world.keep(None);
    assert!(matches!(world.replies[&change], ControlReply::Scene(_)));
    assert!(world.service.is_done() && world.service.is_removed());
}

#[test]
fn a_stop_is_a_stop_before_and_after_files_are_gone() {
    let stops: [fn(&mut World); 2] = [
        |world| world.happens(Event::Stop),
        |world| {
            world.control(ControlRequest::Shutdown);
        },
    ];
    for stop in stops {
        let mut first = world();
        stop(&mut first);
        remove(&mut first);
        assert!(first.service.is_done() && !first.service.is_removed());
        let mut later = world();
        remove(&mut later);
        assert!(later.service.is_removed());
        stop(&mut later);
        assert!(later.service.is_done() && !later.service.is_removed());
    }
}

#[test]
fn what_is_loaded_goes_on_with_its_versions() {
    let mut world = world();
    super::changes::change(&mut world);
    world.keep(None);
    remove(&mut world);
    let store = world.service.into_store();
    assert_eq!(store.scenes()["cell"].version, 2);
    assert!(store.robots().contains_key("arm"));
}
