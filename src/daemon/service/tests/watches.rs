//! Paths that are watched.

use taut_ipc::control::ControlRequest;
use taut_ipc::wire::{Code, Mode, RequestFlags, RequestHeader, SceneEventKind, label_id};

use super::changes::{change, undo};
use super::world::{MS, World};
use crate::daemon::config::Config;
use crate::daemon::service::event::{Event, Ticket};

/// A world with a path that is watched and proved.
fn watched() -> (World, Ticket) {
    let mut world = World::new(&Config::default());
    let header = watch(&world);
    let ticket = world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(world.of(ticket).told, [i32::from(Code::Success)]);
    (world, ticket)
}

fn watch(world: &World) -> RequestHeader {
    RequestHeader {
        mode: Mode::Check.into(),
        flags: RequestFlags::WATCH,
        request_id: 42,
        ..world.header()
    }
}

#[test]
fn each_other_verdict_is_told_and_no_other() {
    let (mut world, ticket) = watched();
    change(&mut world);
    world.pass(2 * MS);
    assert_eq!(world.of(ticket).told.len(), 1, "still proved");
    world.proved = false;
    undo(&mut world);
    world.pass(2 * MS);
    let invalidated = i32::from(Code::InvalidatedByEnvironmentChange);
    assert_eq!(world.of(ticket).told[1..], [invalidated]);
    let unsafe_path = world.published.last().unwrap();
    assert_eq!(unsafe_path.kind, u32::from(SceneEventKind::PathUnsafe));
    assert_eq!(unsafe_path.subscription, 42);
    world.proved = true;
    change(&mut world);
    world.pass(2 * MS);
    assert_eq!(world.of(ticket).told[2..], [i32::from(Code::Success)]);
}

#[test]
fn what_changes_during_a_check_is_checked_again() {
    let mut world = World::new(&Config::default());
    let header = watch(&world);
    let ticket = world.ask(1, header);
    change(&mut world);
    world.pass(MS);
    world.proved = false;
    world.pass(2 * MS);
    let invalidated = i32::from(Code::InvalidatedByEnvironmentChange);
    assert_eq!(
        world.of(ticket).told,
        [i32::from(Code::Success), invalidated]
    );
}

#[test]
fn what_could_not_be_told_is_told_after_the_next_check() {
    let (mut world, ticket) = watched();
    world.proved = false;
    world.deaf.insert(ticket);
    change(&mut world);
    world.pass(2 * MS);
    assert_eq!(world.of(ticket).told.len(), 1);
    world.deaf.clear();
    undo(&mut world);
    world.pass(2 * MS);
    assert_eq!(world.of(ticket).told.len(), 2);
}

#[test]
fn what_could_not_be_told_is_told_although_nothing_changes_any_more() {
    let (mut world, ticket) = watched();
    world.proved = false;
    world.deaf.insert(ticket);
    change(&mut world);
    world.pass(250 * MS);
    assert_eq!(world.of(ticket).told.len(), 1);
    world.deaf.clear();
    world.pass(110 * MS);
    let invalidated = i32::from(Code::InvalidatedByEnvironmentChange);
    assert_eq!(world.of(ticket).told[1..], [invalidated]);
    world.pass(500 * MS);
    assert_eq!(world.of(ticket).told.len(), 2, "told once");
}

#[test]
fn a_watch_ends_with_its_scene_its_client_and_the_daemon() {
    let (mut world, ticket) = watched();
    world.control(ControlRequest::UnloadScene {
        label: "cell".to_owned(),
    });
    assert_eq!(world.of(ticket).code(), Some(Code::UnknownScene));

    let (mut world, ticket) = watched();
    world.happens(Event::Gone(ticket));
    assert!(world.of(ticket).dropped);

    let (mut world, ticket) = watched();
    world.happens(Event::Hinted(ticket));
    assert_eq!(world.of(ticket).code(), Some(Code::Preempted));

    let (mut world, ticket) = watched();
    world.happens(Event::Stop);
    assert_eq!(world.of(ticket).code(), Some(Code::Preempted));
    assert!(world.service.is_done());
}

#[test]
fn a_watch_that_is_wanted_no_more_during_a_check_ends_with_its_verdict() {
    let (mut world, ticket) = watched();
    change(&mut world);
    world.happens(Event::Hinted(ticket));
    world.pass(2 * MS);
    assert!(world.of(ticket).last.is_some());
}

#[test]
fn a_watch_neither_optimizes_nor_has_a_deadline() {
    let mut world = World::new(&Config::default());
    let optimizes = RequestHeader {
        mode: Mode::Hybrid.into(),
        ..watch(&world)
    };
    let ends = RequestHeader {
        deadline_ns: u64::MAX,
        ..watch(&world)
    };
    for header in [optimizes, ends] {
        let ticket = world.ask(1, header);
        assert_eq!(world.of(ticket).code(), Some(Code::MalformedRequest));
    }
    assert_eq!(world.header().scene_id, label_id("cell"));
}
