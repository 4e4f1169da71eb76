//! Requests that ask for times: the same trajectory everywhere, told of on the way, ended by deadlines and by
//! clients, with the limits of motors wherever a robot comes from.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::process::Stdio;
use std::time::Duration;

use common::waiter::{ROBOT, UPRIGHT, load, planners};
use common::*;
use serde_json::Value;
use taut::local::LocalService;
use taut_ipc::control::RobotSource;
use taut_ipc::planner::{Best, Planner, PlannerError, Request, Trajectory};
use taut_ipc::wire::{Code, Mode, Times};

/// What is asked in few words; its work is counted, so that answers are equal.
const TIMING: &str = "acceleration=2/s speed=0.5 work=30000";

fn request(timing: &str) -> Request {
    Request {
        work_budget: 20_000,
        timing: timing.to_owned(),
        ..Request::new("waiter", None)
    }
}

fn asked(planner: &Planner, request: &Request) -> Result<Best, PlannerError> {
    let answers = planner.ask(request, UPRIGHT.as_flattened())?;
    answers.result(PATIENCE)
}

/// All that comes of a request.
fn all(planner: &Planner, request: &Request) -> Vec<Best> {
    let mut answers = planner
        .ask(request, UPRIGHT.as_flattened())
        .unwrap();
    let mut found = Vec::new();
    while let Some(best) = answers.next(PATIENCE).unwrap() {
        found.push(best.into_own());
    }
    found
}

fn bits(trajectory: &Trajectory) -> Vec<u64> {
    let times = trajectory
        .times_ns
        .iter()
        .map(|ns| ns.cast_unsigned());
    let numbers = trajectory
        .positions
        .iter()
        .chain(&trajectory.velocities);
    times
        .chain(numbers.map(|number| number.to_bits()))
        .collect()
}

#[test]
fn a_daemon_and_this_process_give_the_same_trajectory_after_the_path() {
    let place = Place::new();
    let _daemon = place.serve("");
    let found = planners(&place).map(|planner| {
        let all = all(&planner, &request(TIMING));
        let first_timed = all
            .iter()
            .position(|best| best.times() == Times::Timed)
            .unwrap();
        let timed = &all[first_timed..];
        // First the path, then trajectories along the one that is the answer's, each faster.
        let last = timed[timed.len() - 1]
            .trajectory()
            .unwrap()
            .unwrap();
        let mut before_s = f64::INFINITY;
        for best in timed {
            assert_eq!(best.times(), Times::Timed);
            assert_eq!(best.path(), timed[timed.len() - 1].path());
            let duration_s = best.timed().unwrap().duration_s();
            assert!(duration_s <= before_s, "{duration_s} after {before_s}");
            before_s = duration_s;
        }
        let best = &timed[timed.len() - 1];
        assert!(best.is_final() && best.code() == Code::Success);
        check(&last, best.path());
        bits(&last)
    });
    assert_eq!(found[0], found[1]);
}

/// Whether it is what was asked for, as far as its numbers say.
fn check(trajectory: &Trajectory, path: &[f64]) {
    let width = trajectory.columns;
    let last = trajectory.positions.len() - width;
    assert_eq!(trajectory.positions[..width], path[..width]);
    assert_eq!(trajectory.positions[last..], path[path.len() - width..]);
    assert!(
        trajectory.velocities[..width]
            .iter()
            .all(|v| *v == 0.0)
    );
    assert!(
        trajectory.velocities[last..]
            .iter()
            .all(|v| *v == 0.0)
    );
    assert!(trajectory.times_ns.is_sorted_by(|a, b| a < b) && trajectory.times_ns[0] == 0);
    // Half speed: the URDF's 1 rad/s halved, twice that a second squared quartered.
    assert_eq!(trajectory.limits, [[-0.5, 0.5, -0.5, 0.5]; 3]);
    for used in &trajectory.used {
        assert!(
            used.velocity <= 1.0 + 1e-6 && used.acceleration <= 1.0 + 1e-6,
            "{used:?}"
        );
    }
    assert!(
        trajectory.bound_s <= trajectory.duration_s()
            && trajectory.duration_s() <= trajectory.stops_s
    );
    assert!(trajectory.decides.is_some() && trajectory.accelerations.is_empty());
}

#[test]
fn what_is_missing_is_told_by_joint_file_and_option() {
    let place = Place::new();
    let _daemon = place.serve("");
    let texts = [
        ("speed=0.5", ["lean", "acceleration", "--acceleration 2/s"]),
        (
            r#"{"file": "mine.yaml", "content": "joint_limits: {turn: {has_acceleration_limits: true, max_acceleration: 1.0}}"}"#,
            ["lean", "mine.yaml", "acceleration"],
        ),
        ("acceleration=2/s sped=1", ["sped", "valid words", "speed"]),
        ("acceleration=fast", ["fast", "2/s", "1.5"]),
        (
            "acceleration=2/s start_velocity=elbow:1",
            ["elbow", "lean", "no column"],
        ),
        (
            "acceleration=2/s controller=spline",
            ["spline", "quintic", "linear@100"],
        ),
    ];
    for planner in planners(&place) {
        for (text, words) in texts {
            let error = asked(&planner, &request(text)).unwrap_err();
            assert_eq!(error.code(), Code::InvalidTiming, "{text}: {error}");
            let told = error.to_string();
            assert!(
                words.iter().all(|word| told.contains(word)),
                "{text}: {told}"
            );
            assert!(!told.contains('\n'));
        }
    }
}

#[test]
fn who_asks_for_no_times_gets_none_and_hears_so() {
    let planner = Planner::in_process(LocalService::default());
    load(&Place::new(), &planner);
    let best = asked(&planner, &request("")).unwrap();
    assert_eq!(
        (best.times(), best.trajectory().unwrap()),
        (Times::NotAsked, None)
    );
    let error = best.timed().unwrap_err();
    assert_eq!(error.code(), Code::Untimed);
    assert!(error.to_string().contains("asked for no times"), "{error}");
}

#[test]
fn a_deadline_before_the_first_trajectory_leaves_the_path_and_says_so() {
    let place = Place::new();
    let _daemon = place.serve("");
    for planner in planners(&place) {
        // Deadlines from hopeless to ample: whatever comes first, nothing is silent.
        for deadline_us in [1, 50, 200, 1_000, 5_000, 1_000_000] {
            let request = Request {
                deadline: Some(Duration::from_micros(deadline_us)),
                ..request(TIMING)
            };
            let best = all(&planner, &request).pop().unwrap();
            let has_trajectory = best.trajectory().unwrap().is_some();
            assert_eq!(has_trajectory, best.times() == Times::Timed);
            match best.times() {
                Times::Timed => assert_eq!(best.code(), Code::Success),
                Times::NotReached => {
                    assert_eq!(best.code(), Code::Untimed);
                    assert!(
                        best.message().contains("no times yet"),
                        "{}",
                        best.message()
                    );
                    assert!(!best.path().is_empty());
                }
                // The input was not even proved.
                Times::NoPath | Times::NotAsked => assert_eq!(best.code(), Code::TimedOut),
                Times::Refused => panic!("{}", best.message()),
            }
            assert!(
                has_trajectory || deadline_us < 1_000_000,
                "{}",
                best.message()
            );
        }
    }
}

/// Whoever leaves, or has enough, at any of the answers before the last.
#[test]
fn who_leaves_while_times_are_sought_holds_nobody_up() {
    let place = Place::new();
    let _daemon = place.serve("workers = 1");
    let planner = Planner::connect(&place.instance).unwrap();
    load(&place, &planner);
    let expected = bits(
        &asked(&planner, &request(TIMING))
            .unwrap()
            .timed()
            .unwrap(),
    );
    let sought = request("acceleration=2/s");
    for after in 0..all(&planner, &sought).len() {
        for has_enough in [false, true] {
            let mut answers = planner
                .ask(&sought, UPRIGHT.as_flattened())
                .unwrap();
            for _ in 0..after {
                answers.next(PATIENCE).unwrap();
            }
            if has_enough {
                answers.finish_early();
                let last = answers.result(PATIENCE).unwrap();
                assert_eq!(
                    last.trajectory().unwrap().is_some(),
                    last.times() == Times::Timed
                );
            }
        }
        let next = asked(&planner, &request(TIMING)).unwrap();
        assert_eq!(bits(&next.timed().unwrap()), expected);
    }
}

#[test]
fn a_check_gives_the_path_as_it_is_times() {
    let planner = Planner::in_process(LocalService::default());
    load(&Place::new(), &planner);
    let checked = Request {
        mode: Mode::Check,
        ..request("acceleration=2/s work=1")
    };
    let best = asked(&planner, &checked).unwrap();
    assert_eq!(best.path(), UPRIGHT.as_flattened());
    let trajectory = best.timed().unwrap();
    assert!(trajectory.duration_s() >= trajectory.bound_s);
}

#[test]
fn fixed_waypoints_are_passed_to_the_last_bit() {
    let planner = Planner::in_process(LocalService::default());
    load(&Place::new(), &planner);
    let fixed = Request {
        fixed_waypoints: vec![1, 2],
        ..request(TIMING)
    };
    let best = asked(&planner, &fixed).unwrap();
    let trajectory = best.timed().unwrap();
    let rows: Vec<&[f64]> = trajectory.positions.chunks(3).collect();
    for waypoint in &UPRIGHT[1..3] {
        assert!(
            rows.contains(&waypoint.as_slice()),
            "{waypoint:?} in {rows:?}"
        );
    }
}

#[test]
fn robots_have_their_motors_after_a_restart_and_when_they_are_brought() {
    let place = Place::new();
    let daemon = place.serve("");
    let planner = Planner::connect(&place.instance).unwrap();
    load(&place, &planner);
    let before = asked(&planner, &request(TIMING)).unwrap();
    let expected = bits(&before.timed().unwrap());
    drop(before);
    // Another limit under the same label: the same robot but for its motors.
    let slower = place.file(
        "slower.urdf",
        &ROBOT.replace("velocity=\"1\"", "velocity=\"0.5\""),
    );
    let source = RobotSource {
        urdf: slower.into(),
        ..RobotSource::default()
    };
    let error = planner
        .load_robot("waiter", &source, false)
        .unwrap_err();
    assert_eq!(error.code(), Code::LabelTaken, "{error}");
    assert!(error.to_string().contains("other limits"), "{error}");
    daemon.kill();
    let _next = place.serve("");
    let planner = Planner::connect(&place.instance).unwrap();
    let after = asked(&planner, &request(TIMING)).unwrap();
    assert_eq!(bits(&after.timed().unwrap()), expected);
    drop(after);
    planner
        .load_robot("waiter", &source, true)
        .unwrap();
    let slower = asked(&planner, &request(TIMING)).unwrap();
    assert_eq!(
        slower.timed().unwrap().limits,
        [[-0.25, 0.25, -0.25, 0.25]; 3]
    );
}

#[test]
fn recorded_times_come_again_to_the_last_bit() {
    let place = Place::new();
    let _daemon = place.serve("");
    let planner = Planner::connect(&place.instance).unwrap();
    load(&place, &planner);
    let file = place
        .folder
        .path()
        .join("run.taut")
        .to_str()
        .unwrap()
        .to_owned();
    let mut command = place.command(&["record", "-o", &file, "--format", "json"]);
    let recording = command.stdout(Stdio::piped()).spawn().unwrap();
    until("the recording begins", || fs::exists(&file).unwrap());
    asked(&planner, &request(TIMING)).unwrap();
    for deadline_us in [300, 2_000, 8_000] {
        let hurried = Request {
            deadline: Some(Duration::from_micros(deadline_us)),
            ..request("acceleration=2/s")
        };
        all(&planner, &hurried);
    }
    let pid = rustix::process::Pid::from_raw(recording.id() as i32).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    recording.wait_with_output().unwrap();
    let run = place.taut(&["replay", &file, "--verify", "--format", "json"]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
}

/// `taut shorten --time`, and what other commands make of its answer.
#[test]
fn the_command_line_times_shows_and_exports() {
    let place = Place::new();
    let limits = place.file(
        "joint_limits.yaml",
        "joint_limits:\n  joint1: {has_acceleration_limits: true, max_acceleration: 3.0, min_acceleration: -2.0}\n",
    );
    let answer = place.folder.path().join("answer.json");
    let [problem, answer] = [
        config("problems/arm_window.json"),
        answer.display().to_string(),
    ];
    let flags = [
        "--time",
        "--limits",
        &limits,
        "--acceleration",
        "2/s",
        "--budget",
        "20000",
    ];
    let shorten = ["shorten", &problem, "--local", "-o", &answer];
    let run = place.taut(&[&shorten[..], &flags].concat());
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let line = run
        .out
        .lines()
        .find(|line| line.trim_start().starts_with("time "))
        .unwrap();
    assert!(
        ["→", "bound", "gap", "proved"]
            .iter()
            .all(|word| line.contains(word)),
        "{line}"
    );
    let result: Value = serde_json::from_str(&fs::read_to_string(&answer).unwrap()).unwrap();
    let trajectory = &result["times"]["trajectory"];
    assert_eq!(
        trajectory["motors"][0]["acceleration"],
        serde_json::json!([-2.0, 3.0])
    );
    for (file, words) in [
        ("t.yaml", "time_from_start"),
        ("t.mcap", "MovingJointState"),
    ] {
        let file = place
            .folder
            .path()
            .join(file)
            .display()
            .to_string();
        let run = place.taut(&["export", &answer, "-o", &file]);
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        let bytes = fs::read(&file).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains(words));
    }
    // What was written is what was proved.
    let yaml = place
        .folder
        .path()
        .join("t.yaml")
        .display()
        .to_string();
    let run = place.taut(&["check", &yaml, "--timed", "--problem", &problem]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let again = place.taut(&[
        "time",
        &answer,
        "--problem",
        &problem,
        "--acceleration",
        "2/s",
    ]);
    assert_eq!(again.exit, 0, "{}{}", again.out, again.err);
    let forgotten = place.taut(&["shorten", &problem, "--local", "--speed", "0.5"]);
    assert_eq!(forgotten.exit, 64);
    assert!(forgotten.err.contains("--time"), "{}", forgotten.err);
    let lacking = place.taut(&["shorten", &problem, "--local", "--time"]);
    assert_eq!(lacking.exit, 65, "{}{}", lacking.out, lacking.err);
    assert!(lacking.err.contains("joint1"), "{}", lacking.err);
}
