//! `taut record`, `taut replay --verify`, `taut why --bundle`: what a daemon answered is computed
//! again, bit by bit.
#![cfg(feature = "daemon")]

mod common;

use std::process::{Child, Stdio};
use std::time::Duration;

use common::*;
use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::deadline_after;
use taut_ipc::wire::{Code, Mode, RequestBody, RequestHeader};

/// A recording that runs; the daemon has begun it.
fn record(place: &Place, file: &str) -> Child {
    let mut command = place.command(&["record", "-o", file, "--format", "json"]);
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    until("the recording begins", || {
        std::path::Path::new(file).is_file()
    });
    child
}

/// Ends it as Ctrl-C does, and gives what it says.
fn end(recording: Child) -> serde_json::Value {
    let pid = rustix::process::Pid::from_raw(recording.id() as i32).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let run = Run::of(recording.wait_with_output().unwrap());
    assert_eq!(run.exit, 0, "{}", run.err);
    run.json()
}

fn replay(place: &Place, file: &str, exit: i32) -> (serde_json::Value, String) {
    let run = place.taut(&["replay", file, "--verify", "--format", "json"]);
    assert_eq!(run.exit, exit, "{}{}", run.out, run.err);
    (run.json(), run.err)
}

/// Sends requests for every shipped problem from four clients at once, over paths of at least so many
/// waypoints.
fn load(place: &Place, waypoints: usize, change: fn(&mut RequestHeader)) {
    std::thread::scope(|scope| {
        for seed in 0..4 {
            scope.spawn(move || {
                let client = place.client();
                for name in PROBLEMS.iter().cycle().take(5 * PROBLEMS.len()) {
                    let given = Models::of(&client, name);
                    let count = waypoints.max(given.path.len() / given.nq());
                    let request =
                        given
                            .long(count)
                            .request(&client, RequestBody::default(), |header| {
                                header.mode = Mode::Hybrid.into();
                                header.seed = seed;
                                change(header);
                            });
                    request.send().unwrap().wait(PATIENCE).unwrap();
                }
            });
        }
    });
}

#[test]
fn a_recorded_load_run_with_scenes_that_change_is_replayed_bit_by_bit() {
    let place = Place::new();
    let _daemon = place.serve("workers = 2");
    let file = place
        .folder
        .path()
        .join("run.taut")
        .display()
        .to_string();
    let recording = record(&place, &file);
    load(&place, 0, |header| {
        header.deadline_ns = deadline_after(Duration::from_millis(3));
    });
    load(&place, 0, |header| header.mode = Mode::Check.into());
    load(&place, 40, |header| header.work_budget = 6_000);
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let mut stopped = 0;
    for x in 0..30 {
        let moved = place.taut(&[
            "scene",
            "move",
            "arm_shelf",
            "bottle",
            &format!("{}", f64::from(x) * 0.1),
            "0",
            "3",
        ]);
        assert_eq!(moved.exit, 0, "{}", moved.err);
        let pending = arm
            .request(&client, RequestBody::default(), |_| {})
            .send()
            .unwrap();
        if x % 3 == 0 {
            pending.finish_early();
            stopped += 1;
        }
        pending.wait(PATIENCE).unwrap();
        // Dropped at once: it has no answer, or one that nobody took.
        drop(
            arm.request(&client, RequestBody::default(), patient)
                .send()
                .unwrap(),
        );
    }
    let state = end(recording);
    assert!(
        state["requests"].as_u64() > Some(60) && state["missed"] == 0 && stopped > 0,
        "{state}"
    );
    let (report, warnings) = replay(&place, &file, 0);
    assert_eq!(report["requests"], state["requests"]);
    assert_eq!(
        (&report["different"], warnings.as_str()),
        (&0.into(), ""),
        "{report}"
    );
    let [equal, compared] = ["equal", "not_compared"].map(|name| report[name].as_u64().unwrap());
    assert!(
        equal > 50 && equal + compared == report["requests"].as_u64().unwrap(),
        "{report}"
    );
    let answers = report["answers"].as_array().unwrap();
    let timed_out = answers
        .iter()
        .filter(|answer| answer["verdict"] == "equal" && answer["mode"] == "hybrid")
        .count();
    assert!(timed_out > 20, "{report}");
}

#[test]
fn a_crash_in_a_bundle_is_told_apart_from_an_answer() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let client = place.client();
    let arm = Models::of(&client, "arm_shelf");
    let good = arm
        .request(&client, RequestBody::default(), |_| {})
        .send()
        .unwrap()
        .wait(PATIENCE)
        .unwrap();
    let injected = |header: &mut taut_ipc::wire::RequestHeader| header.seed = PANIC_SEED;
    let bad = arm
        .request(&client, RequestBody::default(), injected)
        .send()
        .unwrap()
        .wait(PATIENCE)
        .unwrap();
    assert_eq!(bad.code(), Code::Crash);
    let bundle = |id: u64, name: &str| {
        let file = place
            .folder
            .path()
            .join(name)
            .display()
            .to_string();
        let run = place.taut(&["why", &format!("{id:016x}"), "--bundle", &file]);
        assert_eq!(run.exit, 0, "{}", run.err);
        assert!(
            run.err.contains("1 request") && run.out.starts_with("request "),
            "{}{}",
            run.out,
            run.err
        );
        file
    };
    let (report, _) = replay(&place, &bundle(good.header().request_id, "good.taut"), 0);
    assert_eq!(
        (&report["equal"], &report["requests"]),
        (&1.into(), &1.into())
    );
    // Nothing is injected where it is computed again.
    let (report, _) = replay(&place, &bundle(bad.header().request_id, "bad.taut"), 1);
    let verdict = report["answers"][0]["verdict"]
        .as_str()
        .unwrap();
    assert_eq!(verdict, "code was CRASH, is SUCCESS");
    let run = place.taut(&["replay", &bundle(good.header().request_id, "good.taut")]);
    assert!(
        run.exit == 0 && run.out.contains("   check ") && run.out.contains("--verify compares"),
        "{}",
        run.out
    );
}

#[test]
fn a_recording_ends_with_its_process_or_says_why_it_cannot_begin() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let file = place
        .folder
        .path()
        .join("run.taut")
        .display()
        .to_string();
    let mut recording = record(&place, &file);
    let second = place.taut(&["record", "-o", "other.taut", "--for", "100ms"]);
    assert_eq!(
        (second.exit, second.err.lines().count()),
        (66, 1),
        "{}",
        second.err
    );
    assert!(
        second.err.contains("records to") && second.err.contains("run.taut"),
        "{}",
        second.err
    );
    recording.kill().unwrap();
    recording.wait().unwrap();
    let client = place.client();
    until("the daemon ends it", || {
        let message = ControlRequest::Record {
            file: place.folder.path().join("next.taut"),
        };
        matches!(
            client.control(&message, PATIENCE),
            Ok(ControlReply::Recording(_))
        )
    });
    let (report, warnings) = replay(&place, &file, 0);
    assert_eq!(
        (&report["requests"], warnings.as_str()),
        (&0.into(), ""),
        "it ended in order"
    );
    client
        .control(&ControlRequest::EndRecording, PATIENCE)
        .unwrap();
    let nowhere = place.taut(&["record", "-o", "/nowhere/run.taut", "--for", "100ms"]);
    assert_eq!(nowhere.exit, 66, "{}", nowhere.err);
    assert!(
        nowhere
            .err
            .contains("/nowhere/run.taut: No such file"),
        "{}",
        nowhere.err
    );
    let again = place.taut(&["record", "-o", &file, "--for", "100ms"]);
    assert_eq!(
        again.exit, 0,
        "a recording that could not begin keeps nobody from the next: {}",
        again.err
    );
    for (arguments, exit, text) in [
        (&["replay", "/nowhere"][..], 66, "No such file"),
        (
            &["replay", &config("scenes/corner.json")],
            65,
            "no recorded run",
        ),
        (&["why", "--bundle", "x"], 64, "needs the id"),
        (&["why", "zz", "--bundle", "x"], 64, "hexadecimal"),
        (&["replay", &file, "--only", "123"], 65, "no request 123"),
    ] {
        let run = place.taut(arguments);
        assert_eq!(
            (run.exit, run.err.lines().count()),
            (exit, 1),
            "{arguments:?}: {}",
            run.err
        );
        assert!(run.err.contains(text), "{arguments:?}: {}", run.err);
    }
}
