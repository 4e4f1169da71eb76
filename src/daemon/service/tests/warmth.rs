//! Robots and scenes that are not made yet when somebody asks about them.

use std::path::PathBuf;

use taut_ipc::control::{ControlReply, ControlRequest, Listing, ModelState, Refusal, RobotSource};
use taut_ipc::wire::{Code, RequestHeader, label_id};

use super::changes;
use super::world::{MS, World};
use crate::daemon::config::Config;
use crate::daemon::service::effect::Work;
use crate::daemon::service::event::Ticket;

/// The least time (ns) in which the robot's solids are made: 250 for each of its four triangles.
const LEAST_NS: u64 = 1_000;

/// A world in which models are made when the test says so.
fn world() -> World {
    let mut world = World::new(&Config::default());
    world.makes_at_once = false;
    world
}

/// Asks with so much time (ns) left.
fn ask_within(world: &mut World, left_ns: u64) -> Ticket {
    let header = RequestHeader {
        deadline_ns: world.now_ns + left_ns,
        ..world.header()
    };
    world.ask(1, header)
}

fn listing(world: &mut World) -> Listing {
    match world.replied(ControlRequest::List) {
        ControlReply::Listing(listing) => listing,
        other => panic!("no listing: {other:?}"),
    }
}

fn state(world: &mut World, is_robot: bool, label: &str) -> ModelState {
    let models = listing(world).models;
    models
        .into_iter()
        .find(|state| state.is_robot == is_robot && state.label == label)
        .unwrap()
}

/// Has a robot read.
fn read_robot(world: &mut World, label: &str) {
    let source = RobotSource {
        urdf: PathBuf::from("/there/leg.urdf"),
        ..RobotSource::default()
    };
    world.control(ControlRequest::LoadRobot {
        label: label.to_owned(),
        source,
        replace: false,
        files: None,
    });
}

/// The loader has read the files, and makes this of them.
fn makes(world: &World, step: &str) {
    match &world.tasks.last().unwrap().work {
        Work::Read { reading, .. } => reading.makes(step.to_owned()),
        Work::Check { .. } | Work::Write { .. } => panic!("nothing is read"),
    }
}

#[test]
fn what_comes_while_a_robot_is_read_hears_what_is_made_of_it() {
    let mut world = world();
    read_robot(&mut world, "leg");
    let header = RequestHeader {
        robot_id: label_id("leg"),
        ..world.header()
    };
    world.pass(500 * MS);
    let early = world.ask(1, header);
    assert_eq!(world.of(early).code(), Some(Code::Loading));
    assert_eq!(
        world.of(early).message,
        "robot leg is still being made: its files are being read, 0.5 s so far; send again in 500 ms"
    );
    makes(&world, "solids of 3 links");
    world.pass(1_500 * MS);
    let later = world.ask(1, header);
    assert_eq!(world.of(later).code(), Some(Code::Loading));
    assert_eq!(
        world.of(later).message,
        "robot leg is still being made: solids of 3 links, 2.0 s so far; send again in 2000 ms"
    );
    let described = world.replied(ControlRequest::Describe {
        label: "leg".to_owned(),
    });
    let ControlReply::Refused(refusal) = described else {
        panic!("it is described");
    };
    assert_eq!(refusal.message, world.of(later).message);
    let coming = state(&mut world, true, "leg");
    assert_eq!(coming.missing, "solids of 3 links, 2.0 s so far");
}

#[test]
fn what_is_read_is_on_its_way_no_more() {
    let mut world = world();
    let ticket = world.control(ControlRequest::LoadScene {
        label: "hall".to_owned(),
        json: "{}".to_owned(),
        base_dir: None,
        replace: false,
        files: None,
        version: None,
    });
    let count = |world: &mut World| listing(world).models.len();
    assert_eq!(count(&mut world), 3, "arm, cell, and hall that is coming");
    assert!(
        !state(&mut world, false, "hall")
            .missing
            .is_empty()
    );
    let refusal = Refusal::new(Code::UnreadableFile, "no such file");
    world.happens(changes::loaded(ticket, "hall", Err(refusal)));
    assert_eq!(count(&mut world), 2);
}

#[test]
fn what_cannot_be_made_by_its_deadline_is_told_at_once_and_made_all_the_same() {
    let mut world = world();
    let now_ns = world.now_ns;
    let hopeless = ask_within(&mut world, LEAST_NS - 1);
    let heard = world.of(hopeless).clone();
    assert_eq!(heard.last, Some((Code::Loading.into(), now_ns)));
    assert_eq!(
        heard.message,
        format!(
            "robot {} in scene cell is still being made: solids of 1 link with 1 mesh, 4 triangles, waiting for their turn; send again in 100 ms",
            world.robot.name()
        )
    );
    assert_eq!(world.to_make.len(), 1, "for the next request");
    world.make();
    let next = ask_within(&mut world, 2 * MS);
    world.pass(2 * MS);
    assert_eq!(world.of(next).code(), Some(Code::Success));
}

#[test]
fn what_is_not_made_in_time_is_told_just_before_the_deadline() {
    let mut world = world();
    let came_ns = world.now_ns;
    let ticket = ask_within(&mut world, 800 * MS);
    world.begin_to_make();
    assert_eq!(world.of(ticket).last, None, "it may be made in time");
    world.pass(789 * MS);
    assert_eq!(world.of(ticket).last, None);
    world.pass(2 * MS);
    let heard = world.of(ticket);
    assert_eq!(
        heard.last,
        Some((Code::Loading.into(), came_ns + 790 * MS)),
        "10 ms before"
    );
}

#[test]
fn a_model_is_made_once_for_all_that_wait_and_they_are_computed_then() {
    let mut world = world();
    let hopeless = ask_within(&mut world, LEAST_NS - 1);
    let header = world.header();
    let waiting = [world.ask(1, header), world.ask(2, header)];
    let late = ask_within(&mut world, 800 * MS);
    assert_eq!(world.to_make.len(), 1, "whoever asks");
    world.pass(100 * MS);
    assert!(
        waiting
            .iter()
            .all(|ticket| world.of(*ticket).last.is_none())
    );
    world.make();
    world.pass(5 * MS);
    for ticket in [waiting[0], waiting[1], late] {
        assert_eq!(world.of(ticket).code(), Some(Code::Success));
    }
    assert_eq!(world.of(hopeless).code(), Some(Code::Loading));
    assert_eq!(state(&mut world, true, "arm").missing, "");
    assert!(world.to_make.is_empty());
}

#[test]
fn time_that_a_step_has_taken_counts_for_a_deadline() {
    let mut world = world();
    ask_within(&mut world, MS);
    world.begin_to_make();
    world.pass(LEAST_NS / 2);
    let let_in = ask_within(&mut world, LEAST_NS / 2);
    let hopeless = ask_within(&mut world, LEAST_NS / 2 - 1);
    assert_eq!(world.of(let_in).last, None);
    assert_eq!(world.of(hopeless).code(), Some(Code::Loading));
}
