//! Changes of the store, and what else control messages ask for.

use std::path::PathBuf;
use std::sync::Arc;

use taut::scene::Scene;
use taut::store::PreparedScene;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::wire::{Code, SceneEventKind};

use super::world::{MS, World};
use crate::daemon::config::Config;
use crate::daemon::durability::journal::{Content as Kept, Entry};
use crate::daemon::service::effect::Work;
use crate::daemon::service::event::{Content, Event, Loaded, Purpose, Ticket};
use crate::daemon::translate::Unread;

const BALL: &str = r#"{"is_diff": true, "world": {"collision_objects": [{"id": "ball", "header": {"frame_id": "world"},
    "primitives": [{"type": 2, "dimensions": [0.1]}], "primitive_poses": [{"position": {"x": 5.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}], "operation": 0}]}}"#;

fn diff(base_version: u64) -> ControlRequest {
    ControlRequest::DiffScene {
        label: "cell".to_owned(),
        json: BALL.to_owned(),
        base_dir: None,
        base_version,
        files: None,
        version: None,
    }
}

/// Puts a ball into the scene.
pub(super) fn change(world: &mut World) -> Ticket {
    let ticket = world.control(diff(0));
    if let Some(ControlReply::Refused(refusal)) = world.replies.get(&ticket) {
        panic!("{}", refusal.message);
    }
    ticket
}

/// Takes it out again.
pub(super) fn undo(world: &mut World) {
    world.control(ControlRequest::DiffScene {
        label: "cell".to_owned(),
        json:
            r#"{"is_diff": true, "world": {"collision_objects": [{"id": "ball", "operation": 1}]}}"#
                .to_owned(),
        base_dir: None,
        base_version: 0,
        files: None,
        version: None,
    });
}

fn world() -> World {
    World::new(&Config::default())
}

fn refusal(reply: &ControlReply) -> &Refusal {
    match reply {
        ControlReply::Refused(refusal) => refusal,
        other => panic!("not refused: {other:?}"),
    }
}

fn code(reply: &ControlReply) -> i32 {
    refusal(reply).code
}

#[test]
fn a_short_diff_is_made_at_once_and_told_to_all() {
    let mut world = world();
    let ticket = change(&mut world);
    let ControlReply::Scene(scene) = &world.replies[&ticket] else {
        panic!("no scene");
    };
    assert_eq!(scene.version, 2);
    let event = world.published[0];
    assert_eq!(event.kind, u32::from(SceneEventKind::Changed));
    assert_eq!(event.scene_version, 2);
    let stale = world.replied(diff(1));
    assert_eq!(code(&stale), i32::from(Code::VersionConflict));
}

#[test]
fn a_change_is_acknowledged_once_it_is_kept() {
    let mut world = World::keeping(&Config::default(), true);
    let first = change(&mut world);
    assert!(!world.replies.contains_key(&first) && world.published.is_empty());
    let header = world.header();
    let ticket = world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(
        world.of(ticket).code(),
        Some(Code::Success),
        "it is served from the moment it is made"
    );
    assert!(matches!(world.journal[0], Entry::Changed(1, ..)));
    world.happens(Event::Stop);
    assert!(!world.service.is_done(), "somebody waits for the journal");
    world.keep(None);
    assert!(matches!(world.replies[&first], ControlReply::Scene(_)));
    assert_eq!(world.published.len(), 1);
    assert!(world.service.is_done());
}

#[test]
fn what_cannot_be_kept_is_made_and_said_so() {
    let mut world = World::keeping(&Config::default(), true);
    let ticket = change(&mut world);
    world.keep(Some("no space"));
    let refusal = refusal(&world.replies[&ticket]);
    assert_eq!(refusal.code, i32::from(Code::ResourceExhausted));
    assert!(refusal.message.contains("no space"));
    assert_eq!(world.published.len(), 1, "it is served all the same");
}

#[test]
fn a_load_is_read_elsewhere_and_then_taken() {
    let mut world = world();
    let ticket = world.control(ControlRequest::LoadScene {
        label: "hall".to_owned(),
        json: "{}".to_owned(),
        base_dir: Some(PathBuf::from("/there")),
        replace: false,
        files: None,
        version: None,
    });
    assert!(matches!(
        &world.tasks[0].work,
        Work::Read { label, .. } if label == "hall"
    ));
    let mut header = world.header();
    header.scene_id = taut_ipc::wire::label_id("hall");
    let early = world.ask(1, header);
    assert_eq!(world.of(early).code(), Some(Code::Loading));
    world.happens(loaded(ticket, "hall", Ok(())));
    assert!(matches!(world.replies[&ticket], ControlReply::Scene(_)));
    let later = world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(world.of(later).code(), Some(Code::Success));
}

pub(super) fn loaded(ticket: Ticket, label: &str, read: Result<(), Refusal>) -> Event {
    let content =
        read.map(|()| Content::Scene(Arc::new(PreparedScene::new(Arc::new(Scene::default())))));
    Event::Loaded(Box::new(Loaded {
        ticket,
        label: label.to_owned(),
        purpose: Purpose::Load {
            replace: false,
            version: None,
        },
        content: content.map_err(Unread::from),
    }))
}

#[test]
fn what_cannot_be_read_is_refused() {
    let mut world = world();
    let refusal = Refusal::new(Code::UnreadableFile, "no such file");
    world.happens(loaded(77, "hall", Err(refusal)));
    assert_eq!(code(&world.replies[&77]), i32::from(Code::UnreadableFile));
}

#[test]
fn labels_and_files_are_checked_before_anything_is_read() {
    let mut world = world();
    let long = world.replied(ControlRequest::LoadScene {
        label: "x".repeat(300),
        json: String::new(),
        base_dir: None,
        replace: false,
        files: None,
        version: None,
    });
    assert_eq!(code(&long), i32::from(Code::MalformedRequest));
    let relative = world.replied(ControlRequest::Record {
        file: PathBuf::from("here.taut"),
    });
    assert_eq!(code(&relative), i32::from(Code::MalformedRequest));
    assert!(world.tasks.is_empty());
}

#[test]
fn unloading_forgets_and_refuses_what_is_pinned_or_unknown() {
    let mut world = world();
    let pin = |pinned| ControlRequest::PinScene {
        label: "cell".to_owned(),
        version: 1,
        pinned,
    };
    let unload = || ControlRequest::UnloadScene {
        label: "cell".to_owned(),
    };
    assert!(matches!(world.replied(pin(true)), ControlReply::Scene(_)));
    refusal(&world.replied(unload()));
    assert!(matches!(world.replied(pin(false)), ControlReply::Scene(_)));
    refusal(&world.replied(pin(false)));
    assert!(matches!(world.replied(unload()), ControlReply::Done));
    assert_eq!(world.published[0].kind, u32::from(SceneEventKind::Deleted));
    let robot = ControlRequest::UnloadRobot {
        label: "arm".to_owned(),
    };
    assert!(matches!(world.replied(robot.clone()), ControlReply::Done));
    assert_eq!(code(&world.replied(robot)), i32::from(Code::UnknownRobot));
}

#[test]
fn what_is_loaded_is_listed_and_described() {
    let mut world = world();
    let ControlReply::Listing(listing) = world.replied(ControlRequest::List) else {
        panic!("no listing");
    };
    assert_eq!((listing.robots.len(), listing.scenes.len()), (1, 1));
    let describe = |label: &str| ControlRequest::Describe {
        label: label.to_owned(),
    };
    assert!(matches!(
        world.replied(describe("arm")),
        ControlReply::Robot(_)
    ));
    assert_eq!(
        code(&world.replied(describe("leg"))),
        i32::from(Code::UnknownRobot)
    );
}

#[test]
fn the_text_of_a_scene_is_written_elsewhere() {
    let mut world = world();
    let show = |version| ControlRequest::ShowScene {
        label: "cell".to_owned(),
        version,
        base_version: 0,
    };
    let ticket = world.control(show(0));
    assert!(matches!(world.tasks[0].work, Work::Write { .. }));
    world.happens(Event::Written {
        ticket,
        answer: Box::new(ControlReply::Done),
    });
    assert!(matches!(world.replies[&ticket], ControlReply::Done));
    refusal(&world.replied(show(9)));
}

#[test]
fn a_recording_gets_what_is_asked_and_answered_until_it_ends() {
    let mut world = world();
    let file = PathBuf::from("/run.taut");
    let begun = world.control(ControlRequest::Record { file: file.clone() });
    assert!(!world.replies.contains_key(&begun), "the writer answers");
    let header = world.header();
    world.ask(1, header);
    world.pass(2 * MS);
    assert_eq!(world.lines, 3, "begin, question, answer");
    assert!(matches!(
        world.replied(ControlRequest::Record { file }),
        ControlReply::Recording(_)
    ));
    let other = ControlRequest::Record {
        file: PathBuf::from("/other.taut"),
    };
    assert_eq!(code(&world.replied(other)), i32::from(Code::LabelTaken));
    world.control(ControlRequest::EndRecording);
    assert_eq!(world.lines, 4);
    refusal(&world.replied(ControlRequest::EndRecording));
    let bundle = |id: &str| ControlRequest::Bundle {
        id: id.to_owned(),
        file: PathBuf::from("/one.taut"),
    };
    world.control(bundle("0"));
    assert_eq!(world.lines, 5);
    refusal(&world.replied(bundle("f00")));
}

#[test]
fn a_forgotten_recording_ends_by_itself() {
    let mut world = world();
    world.control(ControlRequest::Record {
        file: PathBuf::from("/run.taut"),
    });
    world.pass(7_000 * MS);
    assert_eq!(world.lines, 2, "begin and end");
}

#[test]
fn a_client_can_stop_the_daemon() {
    let mut world = world();
    assert!(matches!(
        world.replied(ControlRequest::Shutdown),
        ControlReply::Done
    ));
    assert!(world.service.is_done());
}

/// Who speaks for somebody else says so once; it is shown until the connection is forgotten, also
/// after it was away for long.
#[test]
fn a_client_is_shown_by_the_name_that_it_gives_itself() {
    let mut world = world();
    let introduce = |name: &str| ControlRequest::Introduce {
        name: name.to_owned(),
    };
    for wrong in ["", "two\nlines", &"x".repeat(129)] {
        let reply = world.replied(introduce(wrong));
        assert_eq!(code(&reply), i32::from(Code::MalformedRequest), "{wrong:?}");
    }
    assert_eq!(
        world.replied(introduce("robot7/planner[12]")),
        ControlReply::Done
    );
    world.pass(120_000 * MS);
    let named = world.ask(1, world.header());
    world.ask(2, world.header());
    world.pass(10 * MS);
    assert_eq!(world.of(named).code(), Some(Code::Success));
    let ControlReply::Clients(clients) = world.replied(ControlRequest::Clients) else {
        panic!("no clients");
    };
    let names = clients
        .iter()
        .map(|client| client.name.as_str());
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    assert_eq!(names, ["", "robot7/planner[12]"]);
    let id = String::new();
    let ControlReply::Stories(stories) = world.replied(ControlRequest::Stories { id }) else {
        panic!("no stories");
    };
    let names: Vec<&str> = stories
        .iter()
        .map(|story| story.client.as_str())
        .collect();
    assert_eq!(names, ["", "robot7/planner[12]"]);
}

/// A copy of a scene whose versions are counted elsewhere: the number comes with the content, and
/// only upwards.
#[test]
fn a_scene_takes_the_version_that_it_has_at_home() {
    let mut world = World::keeping(&Config::default(), true);
    let at = |base_version, version, json: &str| ControlRequest::DiffScene {
        label: "cell".to_owned(),
        json: json.to_owned(),
        base_dir: None,
        base_version,
        files: None,
        version: Some(version),
    };
    let first = world.control(at(1, 7, BALL));
    world.keep(None);
    let ControlReply::Scene(scene) = &world.replies[&first] else {
        panic!("{:?}", world.replies[&first]);
    };
    assert_eq!(scene.version, 7);
    let hash = scene.scene_hash;
    let kept = |world: &World| match world.journal.last() {
        Some(Entry::Changed(_, _, state)) => match &state.content {
            Kept::Scene(version, scene) => (*version, scene.hash()),
            _ => panic!("no scene"),
        },
        _ => panic!("no change"),
    };
    assert_eq!(kept(&world), (7, hash));
    // Other content at that version, or below it.
    let gone =
        r#"{"is_diff": true, "world": {"collision_objects": [{"id": "ball", "operation": 1}]}}"#;
    for version in [7, 6, 0] {
        let reply = world.replied(at(0, version, gone));
        assert_eq!(code(&reply), i32::from(Code::VersionConflict), "{version}");
    }
    // The same again is nothing; the same content at a later version is one.
    let moved = r#"{"is_diff": true, "allowed_collisions": []}"#;
    let again = world.control(at(0, 7, moved));
    world.keep(None);
    assert!(matches!(&world.replies[&again], ControlReply::Scene(scene) if scene.version == 7));
    assert_eq!(world.published.len(), 1);
    let later = world.control(at(0, 9, moved));
    world.keep(None);
    assert!(matches!(&world.replies[&later], ControlReply::Scene(scene) if scene.version == 9));
    assert_eq!(kept(&world), (9, hash));
    let event = world.published.last().unwrap();
    assert_eq!((event.scene_version, event.parent_hash), (9, hash));
    // Without one, it counts on from there.
    undo(&mut world);
    world.keep(None);
    let event = world.published.last().unwrap();
    assert_eq!((event.scene_version, event.parent_hash), (10, hash));
    // The highest of all is no overflow.
    let reply = world.control(at(0, u64::MAX, BALL));
    world.keep(None);
    assert!(
        matches!(&world.replies[&reply], ControlReply::Scene(scene) if scene.version == u64::MAX)
    );
}
