//! A request's way.

use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::wire::{Code, RequestHeader, ResponseFlags};

use super::world::{MS, World};
use crate::daemon::config::{Config, Quota};
use crate::daemon::service::event::Event;

fn config(workers: usize) -> Config {
    Config {
        workers,
        ..Config::default()
    }
}

fn world() -> World {
    World::new(&config(1))
}

#[test]
fn a_request_is_computed_and_answered_once() {
    let mut world = world();
    let header = world.header();
    let ticket = world.ask(1, header);
    world.improves(ticket);
    assert_eq!(world.of(ticket).last, None);
    world.pass(MS);
    let heard = world.of(ticket);
    assert_eq!((heard.code(), heard.improved), (Some(Code::Success), 1));
    world.improves(ticket);
    assert_eq!(
        world.of(ticket).improved,
        1,
        "nothing after the last response"
    );
}

/// Changes a header so that it cannot be served.
type Change<'a> = &'a dyn Fn(&mut RequestHeader);

#[test]
fn what_cannot_be_served_is_refused_with_its_code() {
    let refused = |change: Change| {
        let mut world = world();
        let mut header = world.header();
        change(&mut header);
        let ticket = world.ask(1, header);
        world.of(ticket).code()
    };
    let cases: [(Code, Change); 5] = [
        (Code::UnknownRobot, &|header| header.robot_id = 1),
        (Code::UnknownScene, &|header| header.scene_id = 1),
        (Code::VersionConflict, &|header| header.scene_version = 9),
        (Code::VersionConflict, &|header| header.robot_hash = 1),
        (Code::InvalidRobotState, &|header| header.layout_hash = 1),
    ];
    for (code, change) in cases {
        assert_eq!(refused(change), Some(code));
    }
    let mut world = world();
    let header = world.header();
    let wrong = Err(Refusal::new(Code::MalformedRequest, "cut off"));
    let ticket = world.ask_with(1, header, wrong);
    assert_eq!(world.of(ticket).code(), Some(Code::MalformedRequest));
    let ControlReply::Clients(clients) = world.replied(ControlRequest::Clients) else {
        panic!("no clients");
    };
    assert_eq!(
        (clients[0].in_flight, clients[0].bytes, clients[0].refused),
        (0, 0, 1),
        "what is refused is on nobody's account"
    );
}

#[test]
fn a_payload_that_is_wrong_is_refused() {
    let mut world = world();
    let header = world.header();
    let ticket = world.ask(1, header);
    world.pass(2 * MS);
    let refusal = Refusal::new(Code::InvalidRobotState, "7 columns");
    // Nobody waits for this one any more.
    world.happens(Event::Read {
        ticket,
        read: Err(refusal),
    });
    assert_eq!(world.of(ticket).code(), Some(Code::Success));
}

#[test]
fn a_full_queue_and_a_hopeless_deadline_are_refused_at_once() {
    let mut world = World::new(&Config {
        queue: 2,
        ..config(1)
    });
    let header = world.header();
    let tickets: Vec<_> = (0..4)
        .map(|client| world.ask(client, header))
        .collect();
    let heard = world.of(tickets[3]);
    assert_eq!(heard.code(), Some(Code::Overloaded));
    assert!(
        heard.message.contains("2 requests wait"),
        "{}",
        heard.message
    );
    world.pass(10 * MS);
    assert!(
        tickets[..3]
            .iter()
            .all(|ticket| world.of(*ticket).code() == Some(Code::Success))
    );
}

#[test]
fn a_quota_refuses_and_frees_itself() {
    let mut world = World::new(&Config {
        quota: Quota {
            in_flight: 1,
            ..Quota::default()
        },
        ..config(1)
    });
    let header = world.header();
    let first = world.ask(1, header);
    let second = world.ask(1, header);
    let other = world.ask(2, header);
    assert_eq!(world.of(second).code(), Some(Code::Quota));
    world.pass(3 * MS);
    let third = world.ask(1, header);
    world.pass(3 * MS);
    for ticket in [first, other, third] {
        assert_eq!(world.of(ticket).code(), Some(Code::Success));
    }
}

#[test]
fn nothing_waits_past_its_deadline() {
    let mut world = world();
    let header = world.header();
    world.ask_that_costs(1, header, 50 * MS);
    let deadline_ns = world.now_ns + 3 * MS;
    let late = world.ask(
        1,
        RequestHeader {
            deadline_ns,
            ..header
        },
    );
    world.pass(20 * MS);
    assert_eq!(
        world.of(late).last,
        Some((Code::TimedOut.into(), deadline_ns))
    );
}

#[test]
fn who_is_gone_frees_its_slot_wherever_its_request_is() {
    let mut world = world();
    let header = world.header();
    let running = world.ask(1, header);
    let waiting = world.ask(2, header);
    let other = world.ask(3, header);
    world.happens(Event::Gone(waiting));
    world.happens(Event::Gone(running));
    world.happens(Event::Gone(running));
    assert!(world.of(running).dropped && world.of(waiting).dropped);
    world.pass(2 * MS);
    assert_eq!(world.of(other).code(), Some(Code::Success));
    assert_eq!(world.of(running).last, None, "nobody is there to hear it");
    let ControlReply::Stats(stats) = world.replied(ControlRequest::Stats) else {
        panic!("no stats");
    };
    assert_eq!(stats.numbers["requests_cancelled"], 2.0);
}

#[test]
fn a_hint_ends_early_what_waits_and_what_is_computed() {
    let mut world = world();
    let header = world.header();
    let running = world.ask_that_costs(1, header, 500 * MS);
    let waiting = world.ask(2, header);
    world.happens(Event::Hinted(waiting));
    assert_eq!(world.of(waiting).code(), Some(Code::Preempted));
    world.happens(Event::Hinted(running));
    world.pass(MS);
    assert_eq!(
        world.of(running).code(),
        Some(Code::Success),
        "with the best so far"
    );
}

#[test]
fn what_crashed_twice_is_not_tried_again() {
    let mut world = world();
    let header = world.header();
    for _ in 0..2 {
        let ticket = world.ask(1, header);
        world.panics(ticket);
        assert_eq!(world.of(ticket).code(), Some(Code::Crash));
    }
    let third = world.ask(1, header);
    assert!(
        world
            .of(third)
            .message
            .contains("crashed its worker 2 times")
    );
}

#[test]
fn an_answer_says_when_its_scene_is_no_longer_the_newest() {
    let mut world = world();
    let header = world.header();
    let ticket = world.ask(1, header);
    super::changes::change(&mut world);
    world.improves(ticket);
    world.pass(2 * MS);
    assert_ne!(world.of(ticket).flags & ResponseFlags::SUPERSEDED, 0);
    let next = world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(world.of(next).flags & ResponseFlags::SUPERSEDED, 0);
}

#[test]
fn a_story_tells_what_happened_to_a_request() {
    let mut world = world();
    let header = RequestHeader {
        request_id: 0xabc,
        ..world.header()
    };
    world.ask(1, header);
    world.pass(2 * MS);
    let asked = ControlRequest::Stories {
        id: "abc".to_owned(),
    };
    let ControlReply::Stories(stories) = world.replied(asked) else {
        panic!("no stories");
    };
    let story = &stories[0];
    assert_eq!((&*story.robot, &*story.scene), ("arm", "cell"));
    assert_eq!((story.pid, story.code), (100, Code::Success.into()));
    let what: Vec<_> = story
        .events
        .iter()
        .map(|event| (event.after_ns, event.what.split(',').next().unwrap()))
        .collect();
    assert_eq!(what.first(), Some(&(0, "let in")));
    assert_eq!(what.last(), Some(&(MS, "SUCCESS")));
}

#[test]
fn the_status_comes_in_its_time_and_counts() {
    let mut world = world();
    let header = world.header();
    world.pass(2_000 * MS);
    let before = world.statuses.len();
    world.ask(1, header);
    world.pass(1_000 * MS);
    let status = world.statuses.last().unwrap();
    assert_eq!(world.statuses.len(), before + 2, "two a second");
    assert_eq!(
        (status.received, status.answered, status.running),
        (1, 1, 0)
    );
    assert_eq!((status.robots, status.scenes, status.workers), (1, 1, 1));
}
