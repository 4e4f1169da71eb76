//! The verdict is the worst thing on the path, wherever it is asked for: a link that slides half a
//! micrometre beside another, which no proof can tell from touching, hides no collision of other
//! links.

mod common;

use std::process::Command;

use common::{Place, python::python};

/// What must be said of a path of `tests/cases/proved-prefix`: the collision, and how much of the
/// path is proved.
struct Right {
    path: &'static str,
    segment: u64,
    t: f64,
    proved_prefix: f64,
}

/// The carriage touches the wall when `jb` is 0.9; before that `a` stands beside the base,
/// unprovable, in all but one.
const RIGHT: [Right; 3] = [
    Right {
        path: "path.json",
        segment: 0,
        t: 0.9,
        proved_prefix: 0.0,
    },
    Right {
        path: "one_segment.json",
        segment: 0,
        t: 0.9,
        proved_prefix: 0.0,
    },
    Right {
        path: "without_a.json",
        segment: 0,
        t: 0.9,
        proved_prefix: 0.9,
    },
];

/// To within which the place of a first contact is known, as a ratio of its segment.
const PLACE: f64 = 1.0 / 2048.0;

fn case(name: &str) -> String {
    format!(
        "{}/tests/cases/proved-prefix/{name}",
        env!("CARGO_MANIFEST_DIR")
    )
}

fn says_what_is_right(place: &Place, right: &Right, options: &[&str]) {
    let path = case(right.path);
    let robot = case("r.urdf");
    let srdf = case("r.srdf");
    let asked = [
        "check", &path, "--robot", &robot, "--srdf", &srdf, "--format", "json",
    ];
    let run = place.taut(&[&asked[..], options].concat());
    let answer = run.json();
    let what = format!("{} {options:?}: {answer}", right.path);
    assert_eq!(run.exit, 1, "{what}");
    assert_eq!(answer["reason"].as_str(), Some("COLLISION"), "{what}");
    assert_eq!(answer["segment"].as_u64(), Some(right.segment), "{what}");
    let number = |field: &str| answer[field].as_f64().unwrap();
    assert!((number("t") - right.t).abs() <= PLACE, "{what}");
    assert!(
        (-2e-3..=1e-9).contains(&number("amount")),
        "first contact is shallow: {what}"
    );
    assert_eq!(
        answer["code_name"].as_str(),
        Some("GOAL_IN_COLLISION"),
        "`b` stays in the wall: {what}"
    );
    // What is proved ends where `b` comes closer than 1.5 of its floors, or where `a` cannot be
    // proved.
    let prefix = number("proved_prefix");
    let too_close = if options.contains(&"--strict") {
        1.5e-3
    } else {
        0.0
    };
    let least = right.proved_prefix - too_close - 4.0 * PLACE;
    assert!(
        prefix <= right.proved_prefix && prefix >= least.max(0.0),
        "{what}"
    );
    assert_eq!(answer["names"], serde_json::json!(["wall", "b"]), "{what}");
}

#[test]
fn a_collision_is_told_before_what_is_too_close_and_the_first_one() {
    let place = Place::new();
    let _daemon = place.serve("");
    for right in &RIGHT {
        for options in [
            &["--local"][..],
            &[],
            &["--local", "--strict"],
            &["--strict"],
        ] {
            says_what_is_right(&place, right, options);
        }
    }
}

#[test]
fn a_path_of_one_waypoint_has_a_verdict() {
    let place = Place::new();
    let path = |name: &str, waypoint: &str| {
        place.file(
            name,
            &format!(r#"{{"variables":["ja","jb"],"path":[{waypoint}]}}"#),
        )
    };
    let robot = case("r.urdf");
    let srdf = case("r.srdf");
    // Free; half a micrometre apart; that and a collision of another pair.
    let rights = [
        ("[0.2, 0]", 0, "SUCCESS"),
        ("[0, 0]", 2, "UNCERTIFIED"),
        ("[0, 1]", 1, "START_STATE_IN_COLLISION"),
    ];
    for (waypoint, exit, code) in rights {
        let file = path("one.json", waypoint);
        let run = place.taut(&[
            "check", &file, "--robot", &robot, "--srdf", &srdf, "--format", "json", "--local",
        ]);
        let answer = run.json();
        assert_eq!(
            (run.exit, answer["code_name"].as_str()),
            (exit, Some(code)),
            "{waypoint}: {answer}"
        );
        if exit != 0 {
            let place = [&answer["t"], &answer["proved_prefix"]].map(serde_json::Value::as_f64);
            assert_eq!(
                (answer["segment"].as_u64(), place[1]),
                (Some(0), Some(0.0)),
                "{waypoint}: {answer}"
            );
            assert!(exit == 2 || place[0] == Some(0.0), "{waypoint}: {answer}");
        }
    }
}

/// A controller's way through the same points is judged alike.
#[test]
fn a_timed_trajectory_has_the_same_verdict() {
    let place = Place::new();
    let robot = case("r.urdf");
    let srdf = case("r.srdf");
    let points = [(0, [0.0, 0.0]), (1, [0.3, 1.0]), (2, [0.3, 1.05])].map(|(sec, positions)| {
        serde_json::json!({ "positions": positions, "time_from_start": { "sec": sec, "nanosec": 0 } })
    });
    let text = serde_json::json!({ "joint_names": ["ja", "jb"], "points": points }).to_string();
    let file = place.file("timed.json", &text);
    for strict in [&[][..], &["--strict"]] {
        let asked = [
            "check", "--timed", &file, "--robot", &robot, "--srdf", &srdf,
        ];
        let run = place.taut(&[&asked[..], strict].concat());
        assert_eq!(run.exit, 1, "{} {}", run.out, run.err);
        assert!(
            run.out.contains("COLLISION") && run.out.contains("wall × b"),
            "{}",
            run.out
        );
    }
}

/// A path of a thousand waypoints whose last is inside of a shelf is refused with less work than it
/// takes to prove the others one by one, and yet all before the shelf is proved.
#[test]
fn a_long_path_that_ends_inside_of_something_is_refused_cheaply() {
    let place = Place::new();
    let problem = common::config("problems/arm_shelf.json");
    let shipped = common::problem("arm_shelf");
    let rows: Vec<Vec<f64>> = serde_json::from_value(shipped["path"].clone()).unwrap();
    let between = |a: &[f64], b: &[f64], t: f64| -> Vec<f64> {
        a.iter()
            .zip(b)
            .map(|(a, b)| a + t * (b - a))
            .collect()
    };
    let steps = 998 / (rows.len() - 1);
    let mut path: Vec<Vec<f64>> = rows
        .windows(2)
        .flat_map(|ends| {
            (0..steps)
                .map(|k| between(&ends[0], &ends[1], k as f64 / steps as f64))
                .collect::<Vec<_>>()
        })
        .collect();
    path.push(rows[rows.len() - 1].clone());
    let check = |path: &[Vec<f64>]| {
        let file = place.file(
            "long.json",
            &serde_json::json!({ "variables": shipped["variables"], "path": path }).to_string(),
        );
        place
            .taut(&[
                "check",
                &file,
                "--problem",
                &problem,
                "--local",
                "--no-contacts",
                "--format",
                "json",
            ])
            .json()
    };
    let proof = check(&path);
    assert_eq!(proof["code_name"].as_str(), Some("SUCCESS"), "{proof}");
    // On the straight way from start to goal the arm is 3 cm deep in the shelf.
    path.push(between(&rows[0], &rows[rows.len() - 1], 0.3));
    let refusal = check(&path);
    assert_eq!(
        refusal["code_name"].as_str(),
        Some("GOAL_IN_COLLISION"),
        "{refusal}"
    );
    assert_eq!(refusal["segment"].as_u64(), Some(path.len() as u64 - 2));
    let prefix = refusal["proved_prefix"].as_f64().unwrap() - (path.len() - 2) as f64;
    assert!(
        prefix > 0.0 && prefix <= refusal["t"].as_f64().unwrap(),
        "{prefix}"
    );
    let work = [&refusal, &proof].map(|answer| answer["work"].as_u64().unwrap());
    println!("{work:?}");
    assert!(work[0] < work[1], "{work:?}");
}

const SCRIPT: &str = r#"
import os, sys, taut
folder, instance = sys.argv[1:3]
made = [taut.local(), taut.connect(instance)]
for planner in made:
    with planner:
        planner.load_robot("prefix", f"{folder}/r.urdf", f"{folder}/r.srdf")
        for path in ([[0, 0], [0.3, 1.0], [0.3, 1.05]], [[0, 0], [0.3, 1.0]], [[0.2, 0], [0.3, 1.0]]):
            for strict in (False, True):
                verdict = planner.check(path, "prefix", strict=strict)
                problem = verdict.problem
                assert not verdict and isinstance(problem, taut.InCollision), problem
                assert problem.segment == 0 and abs(problem.t - 0.9) <= 1 / 2048, problem.t
                assert set(problem.names) == {"wall", "b"}, problem.names
"#;

#[test]
fn python_is_told_the_same() {
    let Some(python) = python(&[]) else { return };
    let place = Place::new();
    let _daemon = place.serve("");
    let script = place.file("verdict.py", SCRIPT);
    let output = Command::new(&python)
        .args([&script, &case(""), &place.name()])
        .current_dir(place.folder.path())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
