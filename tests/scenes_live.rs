//! Scenes that change while they are used: diffs, versions, pins, events, watched paths, with the
//! real daemon.
#![cfg(feature = "daemon")]

mod common;

use std::fs;

use common::*;
use serde_json::{Value, json};
use taut_ipc::client::{Pending, Response};
use taut_ipc::control::{ControlReply, ControlRequest, RobotSource, SceneSummary, SceneText};
use taut_ipc::wire::{
    Code, Mode, RequestBody, RequestFlags, ResponseFlags, SceneEvent, SceneEventKind, label_id,
};
use taut_ipc::{Client, ClientError};

struct Live {
    place: Place,
    daemon: Daemon,
    client: Client,
}

impl Live {
    fn new() -> Self {
        let place = Place::new();
        let daemon = place.serve("");
        let client = place.client();
        Self {
            place,
            daemon,
            client,
        }
    }

    fn control(&self, message: &ControlRequest) -> Result<ControlReply, (Code, String)> {
        match self.client.control(message, PATIENCE).unwrap() {
            ControlReply::Refused(refusal) => {
                Err((Code::try_from(refusal.code).unwrap(), refusal.message))
            }
            reply => Ok(reply),
        }
    }

    fn summary(&self, message: &ControlRequest) -> Result<SceneSummary, (Code, String)> {
        self.control(message).map(|reply| match reply {
            ControlReply::Scene(scene) => scene,
            other => panic!("{other:?}"),
        })
    }

    fn diff_against(
        &self,
        base_version: u64,
        label: &str,
        fields: Value,
    ) -> Result<SceneSummary, (Code, String)> {
        let mut diff = fields;
        diff["is_diff"] = true.into();
        let label = label.to_owned();
        let json = diff.to_string();
        self.summary(&ControlRequest::DiffScene {
            label,
            json,
            base_dir: None,
            base_version,
            files: None,
            version: None,
        })
    }

    fn diff(&self, label: &str, fields: Value) -> Result<SceneSummary, (Code, String)> {
        self.diff_against(0, label, fields)
    }

    fn pin(&self, label: &str, version: u64, pinned: bool) -> Result<SceneSummary, (Code, String)> {
        self.summary(&ControlRequest::PinScene {
            label: label.to_owned(),
            version,
            pinned,
        })
    }

    fn text(
        &self,
        label: &str,
        version: u64,
        base_version: u64,
    ) -> Result<SceneText, (Code, String)> {
        let message = ControlRequest::ShowScene {
            label: label.to_owned(),
            version,
            base_version,
        };
        self.control(&message).map(|reply| match reply {
            ControlReply::SceneText(text) => text,
            other => panic!("{other:?}"),
        })
    }

    fn now(&self, label: &str) -> SceneSummary {
        Models::of(&self.client, label).scene
    }
}

fn moved(id: &str, position: [f64; 3]) -> Value {
    json!({ "objects": [{ "id": id, "operation": "MOVE", "pose": { "position": position } }] })
}

fn ball(id: &str, radius: f64, position: [f64; 3]) -> Value {
    json!({ "id": id, "operation": "ADD", "primitives": [{ "type": "sphere", "dimensions": [radius] }],
        "primitive_poses": [{ "position": position }] })
}

#[test]
fn every_change_is_a_version_with_its_hash_and_its_event() {
    let live = Live::new();
    let feed = live.client.scene_event_feed().unwrap();
    let first = live.now("arm_shelf");
    assert_eq!((first.version, first.kept_from, first.objects), (1, 1, 8));
    let attach = json!({ "attached_collision_objects": [{ "link_name": "hand", "touch_links": ["left_finger", "link7"],
        "object": { "id": "bottle", "operation": "ADD", "pose": { "position": [0, 0, 0.2] } } }] });
    let detach = json!({ "attached_collision_objects": [{ "object": { "id": "bottle", "operation": "REMOVE",
        "pose": { "position": [0.1, 0.2, 0.3] } } }] });
    let append = json!({ "objects": [{ "id": "bottle", "operation": "APPEND", "primitive_poses": [{}],
        "primitives": [{ "type": "sphere", "dimensions": [0.03] }] }] });
    let frame = json!({ "fixed_frame_transforms": [{ "child_frame_id": "tray", "transform": { "translation": [0, 0, 1] } }] });
    let changes = [
        moved("bottle", [0.0, 0.0, 0.01]),
        json!({ "objects": [ball("cup", 0.02, [0.5, 0.3, 0.3])] }),
        attach,
        detach,
        append,
        json!({ "allowed_collisions": [["hand", "cup"]] }),
        json!({ "forbidden_collisions": [["hand", "cup"]] }),
        json!({ "default_collisions": [["hand", "cup"]] }),
        json!({ "link_padding": { "hand": 0.001 } }),
        json!({ "link_scale": { "hand": 1.01 } }),
        frame,
        json!({ "objects": [{ "id": "cup", "operation": "REMOVE" }] }),
    ];
    let mut hashes = vec![first.scene_hash];
    for change in changes {
        let summary = live
            .diff("arm_shelf", change.clone())
            .unwrap_or_else(|error| panic!("{change}: {error:?}"));
        assert_eq!(summary.version, hashes.len() as u64 + 1, "{change}");
        assert_eq!(summary, live.now("arm_shelf"));
        hashes.push(summary.scene_hash);
        let mut event = None;
        until("the event is there", || {
            event = feed.next().unwrap();
            event.is_some()
        });
        let SceneEvent {
            kind,
            scene_id,
            scene_hash,
            scene_version,
            parent_hash,
            ..
        } = event.unwrap();
        assert_eq!(parent_hash, hashes[hashes.len() - 2], "{change}");
        assert_eq!(
            (kind, scene_id),
            (SceneEventKind::Changed.into(), label_id("arm_shelf"))
        );
        assert_eq!(
            (scene_version, scene_hash),
            (summary.version, summary.scene_hash)
        );
    }
    // The cleared pair leaves what there was before it was allowed; everything else is new.
    let pairs = hashes.remove(8);
    assert_eq!(pairs, hashes[5]);
    let count = hashes.len();
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), count);
    // What changes nothing is no version.
    let same = live
        .diff("arm_shelf", json!({ "allowed_collisions": [] }))
        .unwrap();
    assert_eq!(same, live.now("arm_shelf"));
    let once = live
        .diff("rooms", moved("pillar_a", [0.0, 0.0, 9.0]))
        .unwrap();
    until("the event is there", || feed.next().unwrap().is_some());
    assert_eq!(
        live.diff("rooms", moved("pillar_a", [0.0, 0.0, 9.0]))
            .unwrap(),
        once,
        "it stands there already"
    );
    assert!(feed.next().unwrap().is_none());
}

#[test]
fn wrong_diffs_change_nothing_and_have_their_codes() {
    let mut live = Live::new();
    let before = live
        .diff("arm_shelf", moved("bottle", [0.0, 0.0, 0.01]))
        .unwrap();
    let attach = |link: &str, touch: &str| {
        json!({ "attached_collision_objects": [{ "link_name": link, "touch_links": [touch],
            "object": { "id": "bottle", "operation": "ADD", "pose": {} } }] })
    };
    for (fields, code, part) in [
        (moved("vase", [0.0; 3]), Code::InvalidObjectName, "bottle"),
        (attach("claw", "hand"), Code::InvalidLinkName, "links: "),
        (attach("hand", "claw"), Code::InvalidObjectName, "\"claw\""),
        (
            json!({ "link_padding": { "claw": 0.1 } }),
            Code::InvalidObjectName,
            "\"claw\"",
        ),
        (
            json!({ "allowed_collisions": [["hand", "claw"]] }),
            Code::InvalidObjectName,
            "\"claw\"",
        ),
        (
            json!({ "link_padding": { "hand": -0.1 } }),
            Code::InvalidModel,
            "-0.1",
        ),
        (
            json!({ "objects": [ball("cup", -1.0, [0.0; 3])] }),
            Code::InvalidModel,
            "radius",
        ),
        (
            json!({ "object": [] }),
            Code::InvalidModel,
            "did you mean `objects`",
        ),
        // All or nothing: the first entry alone would do.
        (
            json!({ "objects": [ball("cup", 0.1, [9.0; 3]), { "id": "vase", "operation": "REMOVE" }] }),
            Code::InvalidObjectName,
            "vase",
        ),
    ] {
        let (found, message) = live
            .diff("arm_shelf", fields.clone())
            .unwrap_err();
        assert_eq!(found, code, "{fields}: {message}");
        assert!(
            message.contains(part) && !message.contains('\n'),
            "{fields}: {message}"
        );
        assert_eq!(live.now("arm_shelf"), before, "{fields}");
    }
    let (code, message) = live
        .diff("no_scene", moved("bottle", [0.0; 3]))
        .unwrap_err();
    assert!(
        code == Code::UnknownScene && message.contains("arm_shelf"),
        "{message}"
    );
    let (code, message) = live
        .diff_against(1, "arm_shelf", moved("bottle", [1.0; 3]))
        .unwrap_err();
    assert!(
        code == Code::VersionConflict
            && message.contains("version 2")
            && message.contains("version 1"),
        "{message}"
    );
    assert_eq!(
        live.diff_against(2, "arm_shelf", moved("bottle", [1.0; 3]))
            .unwrap()
            .version,
        3
    );
    let message = ControlRequest::DiffScene {
        label: "rooms".into(),
        json: "{".into(),
        base_dir: None,
        base_version: 0,
        files: None,
        version: None,
    };
    let (code, text) = live.control(&message).unwrap_err();
    assert!(
        code == Code::InvalidModel && text.contains("rooms: not a diff") && text.contains("line 1"),
        "{text}"
    );
    assert!(live.daemon.is_alive());
}

#[test]
fn a_running_request_keeps_the_version_that_it_began_with() {
    let live = Live::new();
    let arm = Models::of(&live.client, "arm_shelf");
    let pending = arm
        .request(&live.client, RequestBody::default(), endless)
        .send()
        .unwrap();
    until("it runs", || {
        stats(&live.client).numbers["requests_running"] == 1.0
    });
    let changed = live
        .diff("arm_shelf", moved("shelf_high", [0.0, 0.0, 0.01]))
        .unwrap();
    pending.finish_early();
    let response = pending.wait(PATIENCE).unwrap();
    let header = response.header();
    assert_eq!(
        (header.scene_version, header.scene_hash),
        (1, arm.scene.scene_hash)
    );
    assert_ne!(header.flags & ResponseFlags::SUPERSEDED, 0);
    let ask = |version: u64, hash: u64| {
        let loan = arm.request(&live.client, RequestBody::default(), |header| {
            header.scene_version = version;
            header.scene_hash = hash;
        });
        loan.send().unwrap().wait(PATIENCE).unwrap()
    };
    let new = ask(0, 0);
    assert_eq!(
        (new.header().scene_version, new.header().scene_hash),
        (2, changed.scene_hash)
    );
    assert_eq!(new.header().flags & ResponseFlags::SUPERSEDED, 0);
    // The version before is still there for who names it.
    let old = ask(1, arm.scene.scene_hash);
    assert_eq!(
        (old.header().scene_version, old.header().scene_hash),
        (1, arm.scene.scene_hash)
    );
    assert_ne!(old.header().flags & ResponseFlags::SUPERSEDED, 0);
    assert_eq!(ask(1, changed.scene_hash).code(), Code::VersionConflict);
    let unknown = ask(3, 0);
    assert_eq!(unknown.code(), Code::VersionConflict);
    assert!(
        unknown.message().contains("versions 1, 2") || unknown.message().contains("version 1, 2"),
        "{}",
        unknown.message()
    );
}

/// Memory that a process has of its own (bytes).
fn memory_of(pid: u32) -> u64 {
    let text = fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("RssAnon:"))
        .unwrap();
    line.trim()
        .trim_end_matches(" kB")
        .parse::<u64>()
        .unwrap()
        * 1024
}

#[test]
fn a_thousand_moves_leave_the_last_versions_and_no_memory() {
    let live = Live::new();
    let arm = Models::of(&live.client, "arm_shelf");
    let step = |number: u64| {
        let position = [0.0, 0.0, 1e-5 * number as f64];
        live.diff("arm_shelf", moved("shelf_high", position))
            .unwrap();
        if number.is_multiple_of(10) {
            let loan = arm.request(&live.client, RequestBody::default(), |header| {
                header.mode = Mode::Check.into()
            });
            assert_eq!(
                loan.send()
                    .unwrap()
                    .wait(PATIENCE)
                    .unwrap()
                    .header()
                    .scene_version,
                number + 1
            );
        }
    };
    (1..=300).for_each(step);
    let before = memory_of(live.daemon.pid());
    (301..=1300).for_each(step);
    let now = live.now("arm_shelf");
    assert_eq!((now.version, now.kept_from), (1301, 1301 - 64));
    let grown = memory_of(live.daemon.pid()).saturating_sub(before);
    assert!(grown < 16 << 20, "{grown} bytes more after 1000 moves");
}

#[test]
fn pinned_versions_stay_and_keep_their_scene() {
    let live = Live::new();
    let first = live.now("rooms").scene_hash;
    assert_eq!(live.pin("rooms", 1, true).unwrap().pinned, [1]);
    for number in 1..=70 {
        live.diff("rooms", moved("pillar_a", [0.0, 0.0, f64::from(number)]))
            .unwrap();
    }
    let now = live.now("rooms");
    assert_eq!(
        (now.version, now.kept_from, &now.pinned[..]),
        (71, 7, &[1][..])
    );
    assert_eq!(live.text("rooms", 1, 0).unwrap().scene_hash, first);
    let (code, message) = live.text("rooms", 2, 0).unwrap_err();
    assert!(
        code == Code::VersionConflict && message.contains("1, 7 to 71"),
        "{message}"
    );
    let unload = ControlRequest::UnloadScene {
        label: "rooms".to_owned(),
    };
    let (code, message) = live.control(&unload).unwrap_err();
    assert!(
        code == Code::VersionConflict && message.contains("unpin"),
        "{message}"
    );
    assert_eq!(
        live.pin("rooms", 2, true).unwrap_err().0,
        Code::VersionConflict
    );
    assert_eq!(
        live.pin("rooms", 7, false).unwrap_err().0,
        Code::VersionConflict
    );
    assert!(
        live.pin("rooms", 1, false)
            .unwrap()
            .pinned
            .is_empty()
    );
    assert!(live.text("rooms", 1, 0).is_err());
    assert_eq!(live.control(&unload), Ok(ControlReply::Done));
    // The label goes on counting: a version never names two contents.
    let run = live.place.taut(&[
        "load-scene",
        "rooms",
        &config("problems/rooms.json"),
        "--format",
        "json",
    ]);
    assert_eq!(run.json()["version"].as_u64(), Some(72), "{}", run.err);
}

#[test]
fn the_text_between_two_versions_leads_from_one_to_the_other() {
    let live = Live::new();
    live.diff(
        "arm_shelf",
        json!({ "objects": [ball("cup", 0.02, [0.5, 0.3, 0.3]), ball("pot", 0.1, [3.0, 0.0, 0.0])] }),
    )
    .unwrap();
    let attach = json!({ "attached_collision_objects": [{ "link_name": "hand", "touch_links": ["left_finger"],
        "object": { "id": "cup", "operation": "ADD", "pose": { "position": [0, 0, 0.2] } } }],
        "objects": [{ "id": "shelf_low", "operation": "REMOVE" }], "link_padding": { "pot": 0.01 } });
    live.diff("arm_shelf", attach).unwrap();
    let last = live
        .diff("arm_shelf", moved("bottle", [0.0, 0.1, 0.2]))
        .unwrap();
    let whole = live.text("arm_shelf", 1, 0).unwrap();
    let load = ControlRequest::LoadScene {
        label: "copy".into(),
        json: whole.json,
        base_dir: None,
        replace: false,
        files: None,
        version: None,
    };
    assert_eq!(
        live.summary(&load).unwrap().scene_hash,
        live.text("arm_shelf", 1, 0).unwrap().scene_hash
    );
    for (from, to) in [(1, last.version), (last.version, 1), (1, 3), (3, 2), (2, 2)] {
        let start = live.text("arm_shelf", from, 0).unwrap();
        let load = ControlRequest::LoadScene {
            label: "copy".into(),
            json: start.json,
            base_dir: None,
            replace: true,
            files: None,
            version: None,
        };
        live.summary(&load).unwrap();
        let text = live.text("arm_shelf", to, from).unwrap();
        assert_eq!((text.version, text.base_version), (to, from));
        let message = ControlRequest::DiffScene {
            label: "copy".into(),
            json: text.json,
            base_dir: None,
            base_version: 0,
            files: None,
            version: None,
        };
        assert_eq!(
            live.summary(&message).unwrap().scene_hash,
            text.scene_hash,
            "{from} to {to}"
        );
    }
}

/// A path of `rooms` that is watched.
fn watch(client: &Client, rooms: &Models) -> Pending {
    let loan = rooms.request(client, RequestBody::default(), |header| {
        header.mode = Mode::Check.into();
        header.flags = RequestFlags::WATCH;
    });
    loan.send().unwrap()
}

fn next(pending: &mut Pending) -> Response {
    pending
        .next(PATIENCE)
        .unwrap()
        .expect("the watch goes on")
}

#[test]
fn a_watched_path_is_told_when_a_change_makes_it_unsafe_and_where() {
    let live = Live::new();
    let other = live.place.client();
    let rooms = Models::of(&other, "rooms");
    let feed = live.client.scene_event_feed().unwrap();
    let mut watched = watch(&other, &rooms);
    let first = next(&mut watched);
    assert_eq!((first.code(), first.is_final()), (Code::Success, false));
    assert!(first.view().unwrap().is_proved());
    assert_eq!(
        (first.header().scene_version, first.path()),
        (1, &rooms.path[..])
    );
    assert_eq!(
        stats(&live.client).numbers["requests_running"],
        0.0,
        "what waits holds no worker"
    );

    // Far away: nothing is told. On the way: bodies and place.
    let nq = rooms.nq();
    let [x, y] =
        [0, 1].map(|column| 0.5 * (rooms.path[5 * nq + column] + rooms.path[6 * nq + column]));
    live.diff(
        "rooms",
        json!({ "objects": [ball("box", 0.05, [9.0, 9.0, 0.0])] }),
    )
    .unwrap();
    let unsafe_in = live
        .diff("rooms", moved("box", [x, y, 0.0]))
        .unwrap();
    let told = next(&mut watched);
    assert_eq!(
        (told.code(), told.is_final()),
        (Code::InvalidatedByEnvironmentChange, false)
    );
    assert_eq!(
        (told.header().scene_version, told.header().scene_hash),
        (unsafe_in.version, unsafe_in.scene_hash)
    );
    let view = told.view().unwrap();
    let refusal = view.refusal.unwrap();
    let names = refusal.requirement.names(view.names).unwrap();
    assert!(
        ["box", "disc"]
            .iter()
            .all(|body| names.iter().any(|name| name == body)),
        "{names:?}"
    );
    // The disc is wider than the path: the end of the segment before may be the first to touch.
    assert!(
        (4..=5).contains(&refusal.segment),
        "segment {}",
        refusal.segment
    );
    let mut event = SceneEvent::default();
    until("the event is there", || {
        event = feed.next().unwrap().unwrap_or_default();
        event.kind == u32::from(SceneEventKind::PathUnsafe)
    });
    let published = (event.subscription, event.segment, event.scene_version);
    assert_eq!(
        published,
        (watched.request_id(), refusal.segment, unsafe_in.version)
    );
    // A client holds at most two responses of a request.
    drop((first, told));

    // Still unsafe: nothing is told. Safe again: told.
    live.diff("rooms", moved("box", [x, y, 0.01]))
        .unwrap();
    let safe_in = live
        .diff("rooms", moved("box", [9.0, 9.0, 0.0]))
        .unwrap();
    let again = next(&mut watched);
    assert_eq!(
        (again.code(), again.header().scene_version),
        (Code::Success, safe_in.version)
    );
    assert_eq!(again.header().seq, 2, "three responses in all");

    // Another scene is none of its business; the end of its own is its end.
    live.diff("arm_shelf", moved("bottle", [0.0, 0.0, 0.01]))
        .unwrap();
    assert_eq!(
        live.control(&ControlRequest::UnloadScene {
            label: "rooms".into()
        }),
        Ok(ControlReply::Done)
    );
    let last = next(&mut watched);
    assert_eq!((last.code(), last.is_final()), (Code::UnknownScene, true));
}

#[test]
fn the_command_line_watches_a_path() {
    let live = Live::new();
    let rooms = problem("rooms");
    let path = json!({ "variables": ["x", "y"], "path": rooms["path"] });
    let file = live.place.file("path.json", &path.to_string());
    let before = stats(&live.client).numbers["requests_received"];
    let arguments = [
        "check", &file, "--robot", "rooms", "--scene", "rooms", "--watch", "--count", "2",
        "--format", "json",
    ];
    let child = live
        .place
        .command(&arguments)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    until("it watches", || {
        stats(&live.client).numbers["requests_received"] > before
    });
    let [x, y] = [0, 1].map(|column| rooms["path"][5][column].as_f64().unwrap());
    live.diff(
        "rooms",
        json!({ "objects": [ball("box", 0.05, [x, y, 0.0])] }),
    )
    .unwrap();
    let run = Run::of(child.wait_with_output().unwrap());
    let lines: Vec<Value> = run
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!((run.exit, lines.len()), (1, 2), "{}{}", run.out, run.err);
    let facts = |line: &Value| {
        (
            line["proved"].as_bool(),
            line["code"].as_i64(),
            line["scene_version"].as_u64(),
        )
    };
    assert_eq!(facts(&lines[0]), (Some(true), Some(1), Some(1)));
    assert_eq!(facts(&lines[1]), (Some(false), Some(-3), Some(2)));
    assert!(
        lines[1]["names"]
            .as_array()
            .unwrap()
            .contains(&json!("box")),
        "{}",
        lines[1]
    );
    let run = live.place.taut(&[
        "check", &file, "--robot", "rooms", "--scene", "rooms", "--watch", "--local",
    ]);
    assert_eq!(run.exit, 64, "{}", run.err);
}

#[test]
fn watches_end_as_their_client_wants_and_leave_nothing() {
    let live = Live::new();
    let other = live.place.client();
    let rooms = Models::of(&other, "rooms");
    let mut first = watch(&other, &rooms);
    next(&mut first);
    first.finish_early();
    let last = next(&mut first);
    assert_eq!((last.code(), last.is_final()), (Code::Preempted, true));
    drop((first, last));
    // As many as a client may have, again and again: each that is dropped frees its place.
    for _ in 0..20 {
        let mut watches: Vec<Pending> = (0..4).map(|_| watch(&other, &rooms)).collect();
        watches
            .iter_mut()
            .for_each(|pending| assert_eq!(next(pending).code(), Code::Success));
        drop(watches);
        until("their places are free", || {
            let loan = rooms.request(&other, RequestBody::default(), |header| {
                header.mode = Mode::Check.into()
            });
            match loan.send() {
                Ok(pending) => pending.wait(PATIENCE).unwrap().code() == Code::Success,
                Err(ClientError::TooManyRequests | ClientError::Overloaded) => false,
                Err(error) => panic!("{error}"),
            }
        });
    }
    // A change finds nobody to tell, and the daemon ends at once though one still watches.
    let mut last = watch(&other, &rooms);
    next(&mut last);
    live.diff("rooms", moved("pillar_a", [9.0, 9.0, 0.0]))
        .unwrap();
    assert_eq!(
        live.control(&ControlRequest::Shutdown),
        Ok(ControlReply::Done)
    );
    let ended = next(&mut last);
    // Its check of the new version may have come to its end before the daemon's.
    let ends = [Code::Preempted, Code::Overloaded, Code::Success];
    assert!(
        ended.is_final() && ends.contains(&ended.code()),
        "{}",
        ended.code()
    );
    assert_eq!(live.daemon.wait(), 0);
}

#[test]
fn a_watch_is_a_check_without_a_deadline() {
    let live = Live::new();
    let rooms = Models::of(&live.client, "rooms");
    for (mode, deadline_ns, part) in [
        (Mode::Hybrid, 0, "mode 5"),
        (Mode::Check, u64::MAX, "deadline"),
    ] {
        let loan = rooms.request(&live.client, RequestBody::default(), |header| {
            header.mode = mode.into();
            header.deadline_ns = deadline_ns;
            header.flags = RequestFlags::WATCH;
        });
        let response = loan.send().unwrap().wait(PATIENCE).unwrap();
        assert_eq!(response.code(), Code::MalformedRequest);
        assert!(response.message().contains(part), "{}", response.message());
    }
}

#[test]
fn a_change_to_a_scene_does_not_wait_until_a_robot_is_read() {
    let live = Live::new();
    let fifo = live.place.folder.path().join("slow.urdf");
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&fifo)
            .status()
            .unwrap()
            .success()
    );
    let other = live.place.client();
    let source = RobotSource {
        urdf: fifo.clone(),
        ..RobotSource::default()
    };
    let load = ControlRequest::LoadRobot {
        label: "slow".into(),
        source,
        replace: false,
        files: None,
    };
    std::thread::scope(|scope| {
        // The loader waits until somebody writes.
        let slow = scope.spawn(|| other.control(&load, PATIENCE).unwrap());
        let rooms = Models::of(&live.client, "rooms");
        until("the robot is being loaded", || {
            let loan = rooms.request(&live.client, RequestBody::default(), |header| {
                header.robot_id = label_id("slow")
            });
            loan.send()
                .unwrap()
                .wait(PATIENCE)
                .unwrap()
                .code()
                == Code::Loading
        });
        live.diff("rooms", moved("pillar_a", [0.0, 0.0, 0.1]))
            .unwrap();
        let many: Vec<Value> = (0..500)
            .map(|i| ball(&format!("ball {i}"), 0.01, [9.0, 9.0, f64::from(i)]))
            .collect();
        let long = json!({ "objects": many });
        assert!(long.to_string().len() > 32 * 1024);
        assert_eq!(live.diff("rooms", long).unwrap().version, 3);
        fs::write(&fifo, "no robot").unwrap();
        assert!(matches!(slow.join().unwrap(), ControlReply::Refused(_)));
    });
}

#[test]
fn the_command_line_lists_shows_compares_and_changes_scenes() {
    let live = Live::new();
    let scene = |arguments: &[&str]| {
        live.place
            .taut(&[&["scene"], arguments].concat())
    };
    let said = |arguments: &[&str], parts: &[&str]| {
        let run = scene(arguments);
        assert_eq!(run.exit, 0, "{arguments:?}: {}", run.err);
        assert!(
            parts.iter().all(|part| run.out.contains(part)),
            "{arguments:?}: {}",
            run.out
        );
    };
    said(
        &["move", "arm_shelf", "bottle", "0", "-0.1", "0"],
        &["scene arm_shelf v2"],
    );
    said(
        &[
            "attach",
            "arm_shelf",
            "bottle",
            "hand",
            "0",
            "0",
            "0.2",
            "0",
            "0",
            "0",
            "1",
            "--touch",
            "left_finger,link7",
        ],
        &["v3"],
    );
    said(
        &["show", "arm_shelf"],
        &[
            "v3",
            "bottle",
            "on hand",
            "at 0 0 0.2",
            "cylinder 0.2 × 0.04",
            "may touch left_finger, link7",
        ],
    );
    said(
        &["show", "arm_shelf", "--version", "v1"],
        &["arm_shelf v1", "shelf_low", "box 0.35 × 0.9 × 0.02 at 0."],
    );
    said(
        &[
            "move",
            "arm_shelf",
            "bottle",
            "0",
            "0",
            "0.1",
            "--link",
            "hand",
        ],
        &["v4"],
    );
    said(&["detach", "arm_shelf", "bottle", "1", "0", "0.5"], &["v5"]);
    said(
        &["diff", "arm_shelf", "v1", "v2"],
        &["v1 → v2", "bottle", "at 0 -0.1 0"],
    );
    said(
        &["diff", "arm_shelf", "2", "3"],
        &["ATTACH", "bottle", "on hand"],
    );
    said(
        &["diff", "arm_shelf", "v3"],
        &["v3 → v5", "DETACH", "at 1 0 0.5"],
    );
    said(&["diff", "arm_shelf", "v4", "v4"], &["the same"]);
    said(&["pin", "arm_shelf", "v2"], &["pinned v2"]);
    said(
        &["list"],
        &[
            "scene arm_shelf v5",
            "kept from v1",
            "pinned v2",
            "scene rooms v1",
        ],
    );
    said(&["unpin", "arm_shelf", "2"], &["v5"]);

    // A diff that a version's difference says, with a mesh that is read beside it.
    let difference = scene(&["diff", "arm_shelf", "v5", "v1", "--format", "json"]).json();
    let back = live
        .place
        .file("back.json", &difference.to_string());
    let run = scene(&["apply", "arm_shelf", &back, "--base", "v4"]);
    assert_eq!(run.exit, 66, "{}", run.out);
    assert!(
        run.err.contains("VERSION_CONFLICT") && run.err.contains("version 5"),
        "{}",
        run.err
    );
    said(&["apply", "arm_shelf", &back, "--base", "v5"], &["v6"]);
    let first = scene(&["show", "arm_shelf", "--version", "1", "--format", "json"]).json();
    assert_eq!(
        scene(&["show", "arm_shelf", "--format", "json"]).json(),
        first
    );
    live.place.file(
        "wedge.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    );
    let mesh = json!({ "is_diff": true, "objects": [{ "id": "wedge", "operation": "ADD",
        "meshes": [{ "file": "wedge.obj" }], "mesh_poses": [{ "position": [9, 9, 9] }] }] });
    said(
        &[
            "apply",
            "arm_shelf",
            &live.place.file("mesh.json", &mesh.to_string()),
        ],
        &["v7"],
    );
    said(&["show", "arm_shelf"], &["mesh wedge.obj of 4 triangles"]);

    for (arguments, exit, part) in [
        (
            &["move", "arm_shelf", "vase", "0", "0", "0"][..],
            65,
            "INVALID_OBJECT_NAME",
        ),
        (
            &["move", "arm_shelf", "bottle", "0", "0", "0", "1"],
            64,
            "4 numbers",
        ),
        (
            &["attach", "arm_shelf", "bottle", "claw", "0", "0", "0"],
            65,
            "INVALID_LINK_NAME",
        ),
        (&["show", "no_scene"], 66, "UNKNOWN_SCENE"),
        (&["diff", "arm_shelf", "v99"], 66, "VERSION_CONFLICT"),
        (&["diff", "arm_shelf", "latest"], 64, "v12"),
        (&["apply", "arm_shelf", "/nowhere.json"], 66, "nowhere.json"),
        (
            &["apply", "arm_shelf", &config("problems/rooms.json")],
            65,
            "not a diff",
        ),
    ] {
        let run = scene(arguments);
        assert_eq!(run.exit, exit, "{arguments:?}: {}{}", run.out, run.err);
        assert!(
            run.err.contains(part) && run.err.lines().count() == 1,
            "{arguments:?}: {}",
            run.err
        );
    }
    assert_eq!(Place::new().taut(&["scene", "list"]).exit, 69);
}

#[test]
fn the_command_line_prints_changes_as_they_happen() {
    let live = Live::new();
    let mut command = live.place.command(&[
        "scene", "watch", "rooms", "--count", "2", "--format", "json",
    ]);
    let child = command
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let printed = std::thread::spawn(move || child.wait_with_output().unwrap());
    // It hears what happens from its start on: changed until it has heard enough.
    let mut number = 0.0;
    until("both changes are printed", || {
        number += 1.0;
        live.diff("arm_shelf", moved("bottle", [0.0, 0.0, 1e-3 * number]))
            .unwrap();
        live.diff("rooms", moved("pillar_a", [0.0, 0.0, number]))
            .unwrap();
        printed.is_finished()
    });
    let run = Run::of(printed.join().unwrap());
    let lines: Vec<Value> = run
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!((run.exit, lines.len()), (0, 2));
    assert!(
        lines
            .iter()
            .all(|line| line["event"] == "changed" && line["scene"] == "rooms"),
        "{lines:?}"
    );
    assert_eq!(
        lines[1]["version"].as_u64(),
        lines[0]["version"]
            .as_u64()
            .map(|version| version + 1)
    );
}
