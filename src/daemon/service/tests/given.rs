//! Files from other machines: what is wanted, given, compared and read.

use std::sync::Arc;

use sha2::{Digest, Sha256};
use taut_ipc::control::{ControlReply, ControlRequest, FileId, Files, RobotSource};
use taut_ipc::limits::{FILE_MAX, FILES_MAX, GIVE_MAX};
use taut_ipc::wire::Code;

use super::world::World;
use crate::daemon::config::Config;
use crate::daemon::service::effect::Work;
use crate::daemon::service::event::{Event, Loaded, Purpose, Ticket};
use crate::daemon::translate::Unread;

const URDF: &str = "/there/leg.urdf";

fn world() -> World {
    World::new(&Config {
        files_mb: 1,
        ..Config::default()
    })
}

fn id_of(bytes: &[u8]) -> FileId {
    FileId {
        sha256: Sha256::digest(bytes).into(),
        bytes: bytes.len() as u64,
    }
}

fn load(files: Files) -> ControlRequest {
    ControlRequest::LoadRobot {
        label: "leg".to_owned(),
        source: RobotSource {
            urdf: URDF.into(),
            ..RobotSource::default()
        },
        replace: false,
        files: Some(files),
    }
}

fn named(bytes: &[u8]) -> Files {
    [(URDF.to_owned(), id_of(bytes))].into()
}

fn give(file: FileId, offset: u64, bytes: &[u8]) -> ControlRequest {
    ControlRequest::Give {
        file,
        offset,
        bytes: bytes.to_vec(),
    }
}

fn code(reply: &ControlReply) -> i32 {
    match reply {
        ControlReply::Refused(refusal) => refusal.code,
        other => panic!("not refused: {other:?}"),
    }
}

/// The loader compares what it was given last.
fn compare(world: &mut World) {
    let Some(Work::Check { file, pieces }) = world.tasks.pop().map(|task| task.work) else {
        panic!("nothing is compared");
    };
    let bytes = pieces.concat();
    let content = (id_of(&bytes) == file).then(|| Arc::from(bytes));
    world.happens(Event::Checked { file, content });
}

/// Gives a file at once; gives the ticket.
fn given(world: &mut World, bytes: &[u8]) -> Ticket {
    let ticket = world.control(give(id_of(bytes), 0, bytes));
    compare(world);
    ticket
}

#[test]
fn what_is_missing_is_wanted_and_what_is_there_is_read() {
    let mut world = world();
    let bytes = b"<robot/>";
    assert_eq!(
        world.replied(load(named(bytes))),
        ControlReply::Wanted(vec![URDF.to_owned()])
    );
    assert!(world.tasks.is_empty(), "nothing is read before");
    let ticket = given(&mut world, bytes);
    assert_eq!(world.replies[&ticket], ControlReply::Given { bytes: 8 });
    let ticket = world.control(load(named(bytes)));
    let Some(Work::Read {
        given: Some(files), ..
    }) = world.tasks.last().map(|task| &task.work)
    else {
        panic!("nothing is read");
    };
    assert_eq!(&*files[URDF], bytes);
    // The robot names a mesh that the message does not.
    let wanted = vec!["package://leg/foot.stl".to_owned()];
    world.happens(Event::Loaded(Box::new(Loaded {
        ticket,
        label: "leg".to_owned(),
        purpose: Purpose::Load {
            replace: false,
            version: None,
        },
        content: Err(Unread::Wanted(wanted.clone())),
    })));
    assert_eq!(world.replies[&ticket], ControlReply::Wanted(wanted));
}

#[test]
fn pieces_may_come_twice_from_two_and_with_gaps() {
    let mut world = world();
    let bytes: Vec<u8> = (0..=255).collect();
    let file = id_of(&bytes);
    let given = |bytes| ControlReply::Given { bytes };
    assert_eq!(world.replied(give(file, 0, &bytes[..100])), given(100));
    assert_eq!(world.replied(give(file, 0, &bytes[..50])), given(100));
    assert_eq!(world.replied(give(file, 120, &bytes[120..])), given(100));
    assert_eq!(world.replied(give(file, 60, &bytes[60..200])), given(200));
    let first = world.control(give(file, 200, &bytes[200..]));
    let second = world.control(give(file, 0, &bytes[..100]));
    assert!(!world.replies.contains_key(&first), "it is compared first");
    compare(&mut world);
    assert_eq!(world.replies[&first], given(256));
    assert_eq!(world.replies[&second], given(256));
    assert_eq!(world.replied(give(file, 0, &bytes)), given(256));
    assert!(world.tasks.is_empty(), "nothing is compared twice");
}

#[test]
fn what_is_not_as_its_name_says_is_dropped() {
    let mut world = world();
    let file = id_of(b"honest");
    let ticket = world.control(give(file, 0, b"forged"));
    compare(&mut world);
    assert_eq!(
        code(&world.replies[&ticket]),
        i32::from(Code::MalformedRequest)
    );
    let ticket = given(&mut world, b"honest");
    assert_eq!(world.replies[&ticket], ControlReply::Given { bytes: 6 });
}

#[test]
fn sizes_counts_and_names_are_checked_first() {
    let mut world = world();
    let huge = FileId {
        sha256: [7; 32],
        bytes: FILE_MAX + 1,
    };
    let large = FileId {
        bytes: 1_000_001,
        ..huge
    };
    let small = FileId { bytes: 10, ..huge };
    for (message, refused) in [
        (give(huge, 0, b"x"), Code::ResourceExhausted),
        (give(large, 0, b"x"), Code::ResourceExhausted),
        (
            give(small, 0, &vec![0; GIVE_MAX + 1]),
            Code::MalformedRequest,
        ),
        (
            load([("x".repeat(901), small)].into()),
            Code::MalformedRequest,
        ),
        (
            load(
                (0..=FILES_MAX)
                    .map(|i| (i.to_string(), small))
                    .collect(),
            ),
            Code::ResourceExhausted,
        ),
        (
            load(
                (0_u8..101)
                    .map(|i| {
                        let file = FileId {
                            sha256: [i; 32],
                            bytes: 10_000,
                        };
                        (i.to_string(), file)
                    })
                    .collect(),
            ),
            Code::ResourceExhausted,
        ),
    ] {
        assert_eq!(code(&world.replied(message)), i32::from(refused));
    }
    // A relative name is one of the client's.
    assert!(matches!(
        world.replied(ControlRequest::LoadRobot {
            label: "leg".to_owned(),
            source: RobotSource {
                urdf: "leg.urdf".into(),
                ..RobotSource::default()
            },
            replace: false,
            files: Some([("leg.urdf".to_owned(), small)].into()),
        }),
        ControlReply::Wanted(_)
    ));
}

/// A megabyte is kept: of three files of 0.4, the one that nobody has asked for longest is gone,
/// and of what is half there it takes what it has.
#[test]
fn what_nobody_asks_for_makes_room() {
    let mut world = world();
    let files: Vec<Vec<u8>> = (0_u8..3).map(|i| vec![i; 400_000]).collect();
    given(&mut world, &files[0]);
    given(&mut world, &files[1]);
    world.control(load(named(&files[0])));
    assert!(matches!(world.tasks.pop().unwrap().work, Work::Read { .. }));
    let half = world.control(give(id_of(&files[2]), 0, &files[2][..300_000]));
    assert_eq!(world.replies[&half], ControlReply::Given { bytes: 300_000 });
    assert!(matches!(
        world.replied(load(named(&files[1]))),
        ControlReply::Wanted(_)
    ));
    world.control(load(named(&files[0])));
    assert!(matches!(world.tasks.pop().unwrap().work, Work::Read { .. }));
    // The half one is oldest now.
    given(&mut world, &files[1]);
    let again = world.control(give(id_of(&files[2]), 300_000, &files[2][300_000..]));
    assert_eq!(world.replies[&again], ControlReply::Given { bytes: 0 });
}

/// What a loader reads from has not gone by being forgotten: others wait for its memory.
#[test]
fn what_is_being_read_leaves_no_room_for_others() {
    let mut world = world();
    let files: Vec<Vec<u8>> = (0_u8..2).map(|i| vec![i; 600_000]).collect();
    given(&mut world, &files[0]);
    world.control(load(named(&files[0])));
    let other = give(id_of(&files[1]), 0, &files[1]);
    let ControlReply::Refused(refusal) = world.replied(other.clone()) else {
        panic!("it is taken");
    };
    assert_eq!(refusal.code, i32::from(Code::Overloaded));
    assert!(refusal.retry_after_ms > 0);
    world.tasks.clear();
    let ticket = world.control(other);
    compare(&mut world);
    assert_eq!(
        world.replies[&ticket],
        ControlReply::Given { bytes: 600_000 }
    );
}
