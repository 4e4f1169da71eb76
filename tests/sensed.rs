//! Scenes that sensors see: frames of points become the shape of an object, with the real daemon.
#![cfg(feature = "daemon")]

mod common;

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};

use common::*;
use rustix::process::Signal;
use serde_json::{Value, json};
use taut_ipc::control::{
    CloudFrame, ControlReply, ControlRequest, FrameSummary, PointField, PointLayout, SceneSummary,
};
use taut_ipc::memory::shared_files;
use taut_ipc::planner::{Planner, PlannerError};
use taut_ipc::wire::{Code, Mode, RequestBody, RequestFlags, SceneEventKind};
use taut_ipc::{Client, Instance, monotonic_ns};

/// The problem whose robot looks on.
const ROBOT: &str = "arm_shelf";
/// Far from everything that the robot reaches.
const FAR: [f64; 3] = [30.0, 0.0, 0.0];

struct Watched {
    place: Place,
    daemon: Daemon,
    client: Client,
    planner: Planner,
}

impl Watched {
    /// The problem's robot, in a scene of which all is seen by the sensor `head`.
    fn new() -> Self {
        let place = Place::new();
        let daemon = place.serve("");
        let client = place.client();
        let planner = Planner::connect(&place.instance).unwrap();
        let watched = Self {
            place,
            daemon,
            client,
            planner,
        };
        watched.load(json!({ "radius": 0.005, "self_padding": 0.02 }));
        watched
    }

    fn load(&self, sensed: Value) {
        let scene = json!({ "name": "cell", "objects": [{ "id": "head", "sensed": sensed }] });
        let message = ControlRequest::LoadScene {
            label: "cell".to_owned(),
            json: scene.to_string(),
            base_dir: None,
            replace: true,
            files: None,
            version: None,
        };
        let reply = self.client.control(&message, PATIENCE).unwrap();
        assert!(matches!(reply, ControlReply::Scene(_)), "{reply:?}");
    }

    fn scene(&self) -> SceneSummary {
        let Ok(ControlReply::Listing(listing)) = self
            .client
            .control(&ControlRequest::List, PATIENCE)
        else {
            panic!("no listing")
        };
        let mut scenes = listing.scenes.into_iter();
        scenes
            .find(|scene| scene.label == "cell")
            .unwrap()
    }

    fn models(&self) -> Models {
        Models {
            scene: self.scene(),
            ..Models::of(&self.client, ROBOT)
        }
    }

    fn frame(&self, points: &[[f64; 3]]) -> (CloudFrame, Vec<u8>) {
        frame(&self.client, points)
    }

    fn see(&self, points: &[[f64; 3]]) -> FrameSummary {
        let (frame, bytes) = self.frame(points);
        self.planner
            .set_cloud("cell", "head", frame, &bytes)
            .unwrap()
    }

    fn refused(&self, change: impl FnOnce(&mut CloudFrame), points: &[[f64; 3]]) -> (Code, String) {
        let (mut frame, bytes) = self.frame(points);
        change(&mut frame);
        match self
            .planner
            .set_cloud("cell", "head", frame, &bytes)
        {
            Err(PlannerError::Refused(refused)) => (refused.code, refused.message),
            other => panic!("{other:?}"),
        }
    }

    /// The code and message of a check of the problem's path in what is seen.
    fn check(&self) -> (Code, String) {
        let loan = self
            .models()
            .request(&self.client, RequestBody::default(), |header| {
                header.mode = Mode::Check.into();
            });
        let answer = loan.send().unwrap().wait(PATIENCE).unwrap();
        let view = answer.view().unwrap();
        (view.code, format!("{} {}", view.message, view.names))
    }
}

/// The robot where its path begins, with points of f32.
fn frame(client: &Client, points: &[[f64; 3]]) -> (CloudFrame, Vec<u8>) {
    let models = Models::of(client, ROBOT);
    let names = models.robot.variables.iter();
    let joints = names
        .zip(&models.path)
        .map(|(variable, value)| (variable.name.clone(), *value));
    let frame = CloudFrame {
        taken_ns: monotonic_ns(),
        pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        robot: ROBOT.to_owned(),
        link: String::new(),
        joints: joints.collect(),
        layout: PointLayout::packed(points.len() as u32, PointField::FLOAT32),
    };
    let numbers = points.as_flattened().iter();
    let bytes = numbers.flat_map(|number| (*number as f32).to_le_bytes());
    (frame, bytes.collect())
}

/// Points on a grid about a place, this far apart.
fn block(center: [f64; 3], step: f64) -> Vec<[f64; 3]> {
    let steps = || (-2..=2).map(|index| f64::from(index) * step);
    let mut points = Vec::new();
    for x in steps() {
        for y in steps() {
            points.extend(steps().map(|z| [center[0] + x, center[1] + y, center[2] + z]));
        }
    }
    points
}

#[test]
fn what_is_not_seen_yet_is_not_empty_and_what_is_seen_is_there() {
    let watched = Watched::new();
    let (code, message) = watched.check();
    assert_eq!(code, Code::Loading);
    assert!(
        message.contains("\"head\" is sensed, and no frame"),
        "{message}"
    );

    assert_eq!(watched.scene().sensed[0].last, None);
    let said = watched.place.taut(&["list"]).out;
    assert!(said.contains("\n  head   not seen yet"), "{said}");
    let said = watched.place.taut(&["doctor"]).out;
    let warned = "WARN  sensors         head of scene cell is not seen yet";
    assert!(said.contains(warned), "{said}");

    let feed = watched.client.scene_event_feed().unwrap();
    let before = watched.scene().version;
    let seen = watched.see(&[FAR, [f64::NAN, 0.0, 0.0], [0.0; 3]]);
    let counts = (seen.came, seen.not_finite, seen.on_robot, seen.points);
    assert_eq!(counts, (3, 2, 0, 1));
    assert_eq!(seen.scene_version, before + 1);
    let last = watched.scene().sensed[0].last.unwrap();
    assert_eq!((last.came, last.points, last.period_ns), (3, 1, 0));
    assert!(last.age_ns > 0);
    let mut event = None;
    until("the change is told", || {
        event = feed.next().unwrap();
        event.is_some()
    });
    let event = event.unwrap();
    assert_eq!(event.kind, u32::from(SceneEventKind::Changed));
    assert_eq!(event.scene_version, before + 1);
    assert_eq!(event.scene_hash, seen.scene_hash);
    assert_eq!(watched.check().0, Code::Success);

    // All around the shoulder, where the robot is and moves.
    let seen = watched.see(&block([0.0, 0.0, 0.6], 0.15));
    assert!(seen.on_robot > 0 && seen.points > 0, "{seen:?}");
    let said = watched.place.taut(&["list"]).out;
    let parts = [
        "\n  head   seen ",
        " frames a second",
        " on the robot left out",
    ];
    assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    let (code, message) = watched.check();
    assert_ne!(code, Code::Success);
    assert!(message.contains("head"), "{message}");
}

#[test]
fn the_robot_is_not_in_its_own_way() {
    let watched = Watched::new();
    // Everything about the robot, much finer than it is thick.
    let mut points = Vec::new();
    for x in -12..12 {
        for y in -12..12 {
            let column = (0..32).map(|z| [x, y, z].map(|step| f64::from(step) * 0.03));
            points.extend(column);
        }
    }
    let seen = watched.see(&points);
    assert!(seen.on_robot > 100 && seen.in_padding > 0, "{seen:?}");
    assert!(seen.in_padding < seen.on_robot, "{seen:?}");
    // Where it is, nothing is in its way: the padding is more than radius and clearance.
    let models = watched.models();
    let here = models.path[..models.nq()].to_vec();
    let standing = Models {
        path: [here.clone(), here].concat(),
        ..models
    };
    let loan = standing.request(&watched.client, RequestBody::default(), |header| {
        header.mode = Mode::Check.into();
    });
    let answer = loan.send().unwrap().wait(PATIENCE).unwrap();
    let view = answer.view().unwrap();
    assert_eq!(view.code, Code::Success, "{}", view.message);
}

#[test]
fn whoever_watches_a_path_hears_of_the_frame_that_ends_it() {
    let watched = Watched::new();
    watched.see(&[FAR]);
    let loan = watched
        .models()
        .request(&watched.client, RequestBody::default(), |header| {
            header.mode = Mode::Check.into();
            header.flags |= RequestFlags::WATCH;
        });
    let mut watch = loan.send().unwrap();
    let mut verdict = || {
        let answer = watch.next(PATIENCE).unwrap().unwrap();
        let view = answer.view().unwrap();
        (view.code, view.names.to_owned(), view.message.to_owned())
    };
    assert_eq!(verdict().0, Code::Success);
    watched.see(&block([0.0, 0.0, 0.6], 0.15));
    let (code, names, message) = verdict();
    assert_eq!(code, Code::InvalidatedByEnvironmentChange);
    assert!(names.contains("head"), "{names}");
    let parts = ["point ", " (counted from 0) of head at ("];
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    watched.see(&[FAR]);
    assert_eq!(verdict().0, Code::Success);
}

#[test]
fn whoever_watches_a_path_hears_that_its_sensor_is_silent() {
    let watched = Watched::new();
    watched.see(&[FAR]);
    let ask = |flags| {
        let models = watched.models();
        let loan = models.request(&watched.client, RequestBody::default(), |header| {
            header.mode = Mode::Check.into();
            header.flags |= flags;
            header.max_age_ns = 1_000_000_000;
        });
        loan.send().unwrap()
    };
    let mut watch = ask(RequestFlags::WATCH);
    let mut verdict = || {
        let answer = watch.next(PATIENCE).unwrap().unwrap();
        let view = answer.view().unwrap();
        (view.code, view.header.world_age_ns, view.message.to_owned())
    };
    let (code, age_ns, _) = verdict();
    assert_eq!(code, Code::Success);
    assert!((1..1_000_000_000).contains(&age_ns), "{age_ns}");
    let (code, age_ns, message) = verdict();
    assert_eq!(code, Code::CloudTooOld);
    assert!(age_ns > 1_000_000_000, "{age_ns}");
    let parts = ["\"head\" was seen ", " ms ago, max_age is 1000 ms"];
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    let refused = ask(0).wait(PATIENCE).unwrap();
    assert_eq!(refused.code(), Code::CloudTooOld);
    watched.see(&[FAR]);
    assert_eq!(verdict().0, Code::Success);
}

#[test]
fn frames_that_are_none_are_refused_and_change_nothing() {
    type Case = (fn(&mut CloudFrame), &'static str);
    let watched = Watched::new();
    let seen = watched.see(&[FAR]);
    let cases: [Case; 9] = [
        (|frame| frame.taken_ns = 1, "not newer than its last"),
        (|frame| frame.taken_ns = u64::MAX, "in the future"),
        (|frame| frame.pose[6] = 0.5, "unit quaternion"),
        (|frame| frame.robot = "nobody".to_owned(), "nobody"),
        (|frame| frame.link = "nothing".to_owned(), "the robot has: "),
        (|frame| _ = frame.joints.pop(), "no value of joint7"),
        (|frame| frame.joints[0].0 = "knee".to_owned(), "\"knee\""),
        (|frame| frame.layout.height = 2, "take 24 bytes"),
        (|frame| frame.layout.fields.truncate(2), "no field \"z\""),
    ];
    for (change, said) in cases {
        let (_, message) = watched.refused(change, &[FAR]);
        assert!(message.contains(said), "{message}");
    }
    let nothing = [[f64::NAN; 3], [f64::INFINITY, 0.0, 0.0]];
    let (_, message) = watched.refused(|_| (), &nothing);
    assert!(
        message.contains("of 2 points none is left (2 not finite"),
        "{message}"
    );
    let (frame, bytes) = watched.frame(&[FAR]);
    let other = watched
        .planner
        .set_cloud("cell", "tail", frame, &bytes);
    let message = other.unwrap_err().to_string();
    assert!(
        message.contains("not sensed") && message.contains("head"),
        "{message}"
    );
    assert_eq!(watched.scene().version, seen.scene_version);
    assert_eq!(watched.check().0, Code::Success);
}

#[test]
fn a_daemon_that_is_started_again_waits_for_the_next_frame_and_names_no_version_twice() {
    let watched = Watched::new();
    let seen = watched.see(&[FAR]);
    let Watched {
        place,
        daemon,
        client,
        planner,
    } = watched;
    daemon.kill();
    let daemon = place.serve("");
    let watched = Watched {
        place,
        daemon,
        client,
        planner,
    };
    assert_eq!(watched.check().0, Code::Loading);
    let again = watched.see(&[FAR]);
    assert!(again.scene_version > seen.scene_version + 100, "{again:?}");
    assert_eq!(watched.check().0, Code::Success);
    assert!(watched.daemon.pid() > 0);
}

#[test]
fn points_that_are_thinned_are_paid_for_and_wide_ones_are_told() {
    let watched = Watched::new();
    watched.load(json!({ "radius": 0.005, "thin": 0.1 }));
    let seen = watched.see(&block(FAR, 0.03));
    assert_eq!(seen.came, 125);
    assert!(
        seen.points < 30 && seen.points + seen.thinned == 125,
        "{seen:?}"
    );
    assert!(
        seen.warnings[0].contains("30.0 mm or more apart"),
        "{seen:?}"
    );
    assert!(
        watched
            .see(&block(FAR, 0.03))
            .warnings
            .is_empty()
    );
}

/// A sensor's process, which has written half of a frame into the daemon's memory.
struct Sender(Child);

impl Sender {
    fn in_mid_loan(watched: &Watched) -> Self {
        let mut command = Command::new(std::env::current_exe().unwrap());
        let child = command
            .args([
                "--exact",
                "a_sender_in_mid_loan",
                "--ignored",
                "--nocapture",
            ])
            .env("TAUT_INSTANCE", watched.place.name())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut sender = Self(child);
        let out = sender.0.stdout.as_mut().unwrap();
        let mut lines = BufReader::new(out)
            .lines()
            .map_while(Result::ok);
        assert!(lines.any(|line| line.contains(LOANED)), "it ended before");
        sender
    }

    fn signal(&self, signal: Signal) {
        let pid = rustix::process::Pid::from_raw(self.0.id() as i32).unwrap();
        rustix::process::kill_process(pid, signal).unwrap();
    }

    fn end(mut self) -> ExitStatus {
        let mut status = None;
        until("the sender ends", || {
            status = self.0.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap()
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a sender says when it has written half of its frame.
const LOANED: &str = "half of it is written";

/// The process of a [`Sender`]: it goes on when its input ends, and its frame is too old then.
#[test]
#[ignore = "other tests run it, in a process of its own"]
fn a_sender_in_mid_loan() {
    let Ok(instance) = std::env::var("TAUT_INSTANCE") else {
        return;
    };
    let instance = Instance::parse(&instance).unwrap();
    let planner = Planner::connect(&instance).unwrap();
    let client = planner.client().unwrap();
    let (frame, bytes) = frame(client, &block([0.0, 0.0, 0.6], 0.15));
    let mut loan = planner
        .loan_frame("cell", "head", frame, bytes.len())
        .unwrap();
    let half = bytes.len() / 2;
    loan.body_mut()[..half].copy_from_slice(&bytes[..half]);
    println!("{LOANED}");
    std::io::stdin()
        .read_to_end(&mut Vec::new())
        .unwrap();
    loan.body_mut()[half..].copy_from_slice(&bytes[half..]);
    match planner.send_frame(loan) {
        Err(PlannerError::Refused(refused)) => assert_eq!(refused.code, Code::Preempted),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sender_that_is_killed_in_mid_loan_leaves_nothing_behind() {
    let watched = Watched::new();
    watched.see(&[FAR]);
    let files = || shared_files(&watched.place.instance).len();
    let before = files();
    let sender = Sender::in_mid_loan(&watched);
    assert!(files() > before);
    sender.signal(Signal::KILL);
    assert!(!sender.end().success());
    until("its shared memory is reclaimed", || {
        watched.see(&[FAR]);
        assert_eq!(watched.check().0, Code::Success, "nothing of it is seen");
        files() <= before
    });
}

#[test]
fn a_sender_that_is_stopped_in_mid_loan_holds_nobody_up() {
    let watched = Watched::new();
    let sender = Sender::in_mid_loan(&watched);
    sender.signal(Signal::STOP);
    for _ in 0..3 {
        watched.see(&[FAR]);
        assert_eq!(watched.check().0, Code::Success);
    }
    sender.signal(Signal::CONT);
    let mut sender = sender;
    drop(sender.0.stdin.take());
    assert!(sender.end().success(), "its frame is refused as an old one");
    assert_eq!(watched.check().0, Code::Success);
}

#[test]
fn a_recording_keeps_the_frames_that_its_requests_used_and_no_others() {
    let watched = Watched::new();
    let file = watched.place.folder.path().join("run.taut");
    let message = ControlRequest::Record { file: file.clone() };
    let reply = watched.client.control(&message, PATIENCE);
    assert!(matches!(reply, Ok(ControlReply::Recording(_))), "{reply:?}");
    let far = |count: u32| -> Vec<[f64; 3]> {
        let place = |index: u32| [30.0, 0.01 * f64::from(index), 0.0];
        (0..count).map(place).collect()
    };
    let mut codes = Vec::new();
    for points in [far(300), block([0.0, 0.0, 0.6], 0.15), far(400)] {
        watched.see(&points);
        codes.push(watched.check().0);
    }
    assert_eq!([codes[0], codes[2]], [Code::Success; 2]);
    assert_ne!(codes[1], Code::Success);
    // Nobody asks among these.
    const UNUSED: u32 = 60_000;
    for count in 0..4 {
        watched.see(&far(UNUSED + count));
    }
    let reply = watched
        .client
        .control(&ControlRequest::EndRecording, PATIENCE);
    assert!(reply.is_ok(), "{reply:?}");
    let Watched { place, daemon, .. } = watched;
    daemon.kill();
    let bytes = std::fs::metadata(&file).unwrap().len();
    assert!(bytes < 12 * u64::from(UNUSED), "{bytes} bytes");
    let file = file.to_str().unwrap();
    let run = place.taut(&["replay", file, "--verify", "--format", "json"]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""), "{}", run.out);
    let report = run.json();
    assert_eq!(
        (&report["requests"], &report["equal"]),
        (&3.into(), &3.into())
    );
}
