//! Frames of sensors, as the service sees them.

use taut_ipc::control::{CloudFrame, ControlReply, ControlRequest, PointField, PointLayout};
use taut_ipc::wire::{Code, Mode, RequestFlags, RequestHeader};

use super::changes::change;
use super::world::{MS, World};
use crate::daemon::config::Config;
use crate::daemon::durability::journal::{Content, Entry};
use crate::daemon::service::FRAMES_PER_ENTRY;
use crate::daemon::service::event::{Event, Framed, Ticket};
use crate::daemon::translate::read_frame;

/// A world in which `head` sees the scene.
fn world() -> World {
    let mut world = World::keeping(&Config::default(), true);
    let json = r#"{"is_diff": true, "objects": [{"id": "head", "operation": "ADD", "sensed": {"radius": 0.01}}]}"#;
    world.control(ControlRequest::DiffScene {
        label: "cell".to_owned(),
        json: json.to_owned(),
        base_dir: None,
        base_version: 0,
        files: None,
        version: None,
    });
    world.keep(None);
    world
}

/// When the sensor has seen something.
const SEEN_NS: u64 = 1_000 * MS;

/// A frame of one point comes; gives the ticket.
fn come(world: &mut World, taken_ns: u64) -> Ticket {
    world.control(ControlRequest::Frame {
        label: "cell".to_owned(),
        object: "head".to_owned(),
        frame: Box::new(CloudFrame {
            taken_ns,
            pose: [9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            layout: PointLayout::packed(1, PointField::FLOAT64),
            ..CloudFrame::default()
        }),
    })
}

/// What came is read, in order.
fn read(world: &mut World) {
    let body: Vec<u8> = [1.0f64, 2.0, 3.0]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    for task in std::mem::take(&mut world.frames) {
        let taken = read_frame(&task.scenery, &task.object, &task.frame, &body);
        world.happens(Event::Framed(Box::new(Framed {
            ticket: task.ticket,
            label: task.label,
            object: task.object,
            taken,
        })));
    }
}

fn version(world: &World, ticket: Ticket) -> u64 {
    match &world.replies[&ticket] {
        ControlReply::Framed(summary) => summary.scene_version,
        other => panic!("{other:?}"),
    }
}

#[test]
fn frames_are_told_at_once_and_only_some_are_kept() {
    let mut world = world();
    let before = world.journal.len();
    let mut waits = Vec::new();
    for taken_ns in 1..=FRAMES_PER_ENTRY {
        let ticket = come(&mut world, taken_ns);
        read(&mut world);
        if !world.replies.contains_key(&ticket) {
            waits.push(ticket);
        }
    }
    assert_eq!(world.published.len() as u64, FRAMES_PER_ENTRY);
    assert_eq!((waits.len(), world.journal.len() - before), (1, 1));
    let Some(Entry::Changed(_, _, state)) = world.journal.last() else {
        panic!("nothing is written")
    };
    let Content::Scene(written, scene) = &state.content else {
        panic!("no scene is written")
    };
    assert_eq!(*written, FRAMES_PER_ENTRY);
    assert_eq!(
        scene.awaited().collect::<Vec<_>>(),
        ["head"],
        "no point is written"
    );
    world.keep(None);
    assert_eq!(version(&world, waits[0]), FRAMES_PER_ENTRY);
}

#[test]
fn what_changed_while_a_frame_was_read_stays() {
    let mut world = world();
    let ticket = come(&mut world, 5);
    change(&mut world);
    read(&mut world);
    assert_eq!(version(&world, ticket), 4);
    let old = come(&mut world, 5);
    read(&mut world);
    let ControlReply::Refused(refusal) = &world.replies[&old] else {
        panic!("taken twice")
    };
    assert_eq!(refusal.code, i32::from(Code::Preempted));
    let store = world.service.into_store();
    let scene = &store.scene("cell").unwrap().scene;
    assert!(scene.object("ball").is_some());
    assert_eq!(scene.object("head").unwrap().shapes.len(), 1);
}

#[test]
fn nobody_is_answered_before_the_first_frame() {
    let mut world = world();
    let header = world.header();
    let early = world.ask(1, header);
    assert_eq!(world.of(early).code(), Some(Code::Loading));
    come(&mut world, 5);
    read(&mut world);
    let header = world.header();
    let seen = world.ask(1, header);
    assert_ne!(world.of(seen).code(), Some(Code::Loading));
}

/// A world that `head` has seen at its time `taken_ns`.
fn seen(taken_ns: u64) -> World {
    let mut world = world();
    world.now_ns = taken_ns;
    come(&mut world, taken_ns);
    read(&mut world);
    world
}

/// Nothing older than this may have been seen.
const MAX_AGE_NS: u64 = 100 * MS;

fn with_max_age(world: &World) -> RequestHeader {
    RequestHeader {
        max_age_ns: MAX_AGE_NS,
        ..world.header()
    }
}

#[test]
fn a_world_that_was_seen_too_long_ago_is_refused_and_every_answer_tells_its_age() {
    let mut world = seen(SEEN_NS);
    world.now_ns = SEEN_NS + MAX_AGE_NS;
    let header = with_max_age(&world);
    let fresh = world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(world.of(fresh).code(), Some(Code::Success));
    let (_, answered_ns) = world.of(fresh).last.unwrap();
    assert_eq!(world.of(fresh).age_ns, answered_ns - SEEN_NS);
    let header = with_max_age(&world);
    let late = world.ask(1, header);
    assert_eq!(world.of(late).code(), Some(Code::CloudTooOld));
    let header = world.header();
    let careless = world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(world.of(careless).code(), Some(Code::Success));
    come(&mut world, SEEN_NS + MAX_AGE_NS);
    read(&mut world);
    let header = with_max_age(&world);
    let again = world.ask(1, header);
    assert_ne!(world.of(again).code(), Some(Code::CloudTooOld));
}

#[test]
fn who_watches_hears_when_the_sensor_falls_silent_and_when_it_is_back() {
    let mut world = seen(SEEN_NS);
    let header = RequestHeader {
        mode: Mode::Check.into(),
        flags: RequestFlags::WATCH,
        ..with_max_age(&world)
    };
    let ticket = world.ask(1, header);
    world.pass(2 * MS);
    let success = i32::from(Code::Success);
    assert_eq!(world.of(ticket).told, [success]);
    world.pass(MAX_AGE_NS - 3 * MS);
    assert_eq!(world.of(ticket).told, [success], "not too old yet");
    let published = world.published.len();
    world.pass(2 * MS);
    let too_old = i32::from(Code::CloudTooOld);
    assert_eq!(world.of(ticket).told, [success, too_old]);
    assert_eq!(world.published.len(), published + 1);
    world.pass(3 * MAX_AGE_NS);
    assert_eq!(world.of(ticket).told.len(), 2, "told once");
    let taken_ns = world.now_ns;
    come(&mut world, taken_ns);
    read(&mut world);
    world.pass(2 * MS);
    assert_eq!(world.of(ticket).told, [success, too_old, success]);
}
