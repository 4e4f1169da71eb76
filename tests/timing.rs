//! Times for paths, as users ask for them on the command line.
#![cfg(feature = "daemon")]

mod common;

use common::waiter::{UPRIGHT, asks, path_file};
use common::{Place, Run, config};
use serde_json::{Value, json};

/// MoveIt's file for the arm of the configured problems.
const LIMITS: &str = "joint_limits:\n  joint1: {has_velocity_limits: true, max_velocity: 1.5, has_acceleration_limits: true, max_acceleration: 3.0}\n";

/// The fastest of its joints (rad/s).
const FASTEST: f64 = 2.61;

fn problem() -> String {
    config("problems/arm_window.json")
}

fn shortened(place: &Place) -> String {
    let path = place.file("path.json", "");
    let run = place.taut(&[
        "shorten",
        &problem(),
        "--local",
        "--budget",
        "20000",
        "-o",
        &path,
    ]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    path
}

fn time(place: &Place, path: &str, more: &[&str]) -> Run {
    let given = ["time", path, "--problem", &problem(), "--format", "json"];
    place.taut(&[&given, more].concat())
}

fn check(place: &Place, file: &str, more: &[&str]) -> Run {
    let given = [
        "check",
        file,
        "--timed",
        "--problem",
        &problem(),
        "--format",
        "json",
    ];
    place.taut(&[&given, more].concat())
}

fn floats(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values
        .map(|value| value.as_f64().unwrap())
        .collect()
}

fn seconds(point: &Value) -> f64 {
    let time = &point["time_from_start"];
    time["sec"].as_f64().unwrap() + time["nanosec"].as_f64().unwrap() * 1e-9
}

/// The largest velocity and acceleration of any column between points, by Hermite's basis.
fn largest(points: &[Value]) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for pair in points.windows(2) {
        let h = seconds(&pair[1]) - seconds(&pair[0]);
        let list = |end: usize, what: &str| floats(&pair[end][what]);
        let [p, q, v, w] = [
            list(0, "positions"),
            list(1, "positions"),
            list(0, "velocities"),
            list(1, "velocities"),
        ];
        for column in 0..p.len() {
            let step = q[column] - p[column];
            let [a, b] = [v[column] * h, w[column] * h];
            for look in 0..=16 {
                let u = f64::from(look) / 16.0;
                let velocity = 6.0 * u * (1.0 - u) * step
                    + (1.0 + u * (3.0 * u - 4.0)) * a
                    + u * (3.0 * u - 2.0) * b;
                let acceleration =
                    (6.0 - 12.0 * u) * step + (6.0 * u - 4.0) * a + (6.0 * u - 2.0) * b;
                most[0] = most[0].max((velocity / h).abs());
                most[1] = most[1].max((acceleration / (h * h)).abs());
            }
        }
    }
    most
}

#[test]
fn a_path_gets_times_that_are_proved_and_within_limits() {
    let place = Place::new();
    let path = shortened(&place);
    for ending in ["yaml", "json"] {
        let out = place.file(&format!("trajectory.{ending}"), "");
        let run = time(&place, &path, &["--acceleration", "2/s", "-o", &out]);
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        let answer = run.json();
        assert_eq!(answer["proved"], true);
        let duration_s = answer["duration_s"].as_f64().unwrap();
        assert!(duration_s >= answer["duration_bound_s"].as_f64().unwrap() - 1e-9);
        let stages = answer["stages"].as_array().unwrap();
        assert_eq!(stages[0]["name"], "stops");
        assert!(stages.len() > 1 && stages[0]["duration_s"].as_f64().unwrap() > duration_s);

        let points = answer["points"].as_array().unwrap();
        let rows: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let rows = rows["path"].as_array().unwrap();
        for (point, row) in [
            (&points[0], &rows[0]),
            (&points[points.len() - 1], &rows[rows.len() - 1]),
        ] {
            assert_eq!(
                (floats(&point["positions"]), floats(&point["velocities"])),
                (floats(row), vec![0.0; floats(row).len()])
            );
        }
        for kind in ["velocity", "acceleration"] {
            let used = &answer["most_used"][kind];
            assert!(used["part"].as_f64().unwrap() <= 1.0 + 1e-6, "{used}");
        }
        let [velocity, acceleration] = largest(points);
        assert!(velocity <= FASTEST * (1.0 + 1e-6), "{velocity}");
        assert!(
            acceleration <= 2.0 * FASTEST * (1.0 + 1e-6),
            "{acceleration}"
        );

        // What is written is what was proved.
        let run = check(
            &place,
            &out,
            &["--acceleration", "2/s", "--clearance", "0.9mm"],
        );
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        assert!((run.json()["duration_s"].as_f64().unwrap() - duration_s).abs() < 1e-12);
        // Half the acceleration it does not keep.
        let run = check(&place, &out, &["--acceleration", "1/s"]);
        let found = run.json();
        assert_eq!(
            (run.exit, &found["reason"], &found["limit"]),
            (2, &json!("LIMIT"), &json!("acceleration"))
        );
        assert!(
            (found["part"].as_f64().unwrap() - 2.0).abs() < 0.1,
            "{found}"
        );
    }
}

/// What each controller is told is what it is proved for, and `taut check` judges what it makes of that.
#[test]
fn every_controller_is_told_what_was_proved() {
    let place = Place::new();
    let path = shortened(&place);
    for (controller, says) in [
        ("cubic", ["velocities", ""]),
        ("quintic", ["velocities", "accelerations"]),
        ("linear@250", ["", ""]),
    ] {
        let out = place.file("controlled.yaml", "");
        let more = [
            "--acceleration",
            "2/s",
            "--controller",
            controller,
            "-o",
            &out,
        ];
        let run = time(&place, &path, &more);
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        let answer = run.json();
        assert_eq!(answer["controller"], controller);
        let point = answer["points"][1].as_object().unwrap();
        for what in ["velocities", "accelerations"] {
            assert_eq!(
                point.contains_key(what),
                says.contains(&what),
                "{controller}: {what}"
            );
        }
        let checked = ["--acceleration", "2/s", "--clearance", "0.9mm"];
        let run = check(&place, &out, &checked);
        assert_eq!(run.exit, 0, "{controller}: {}{}", run.out, run.err);
        assert!(
            (run.json()["duration_s"].as_f64().unwrap() - answer["duration_s"].as_f64().unwrap())
                .abs()
                < 1e-9
        );
        // Half the acceleration none of them keeps: of straight lines it is the differences.
        let run = check(&place, &out, &["--acceleration", "1/s"]);
        let part = run.json()["part"].as_f64().unwrap();
        assert!((1.8..2.001).contains(&part), "{controller}: {part}");
    }
    let run = time(
        &place,
        &path,
        &["--acceleration", "2/s", "--controller", "spline"],
    );
    assert!(
        run.exit == 64
            && run
                .err
                .contains("give cubic, quintic, or linear@250"),
        "{}",
        run.err
    );
}

#[test]
fn an_answer_says_who_decides_what_is_used_and_where_it_is_nearest() {
    let place = Place::new();
    let path = shortened(&place);
    let answer = time(&place, &path, &["--acceleration", "2/s"]).json();
    let columns = answer["joint_names"].as_array().unwrap();
    assert!(columns.contains(&answer["bound_by"]));
    let usage = answer["usage"].as_array().unwrap();
    assert_eq!(usage.len(), columns.len());
    let duration_s = answer["duration_s"].as_f64().unwrap();
    let largest = |kind: &str| {
        let parts = usage
            .iter()
            .map(|used| used[kind]["part"].as_f64().unwrap());
        parts.fold(0.0, f64::max)
    };
    for kind in ["velocity", "acceleration"] {
        assert_eq!(
            answer["most_used"][kind]["part"]
                .as_f64()
                .unwrap(),
            largest(kind)
        );
        for (used, column) in usage.iter().zip(columns) {
            assert_eq!(&used[kind]["variable"], column);
            assert!((0.0..=duration_s).contains(&used[kind]["at_s"].as_f64().unwrap()));
        }
    }
    let nearest = &answer["nearest"];
    assert!(
        (0.0..=duration_s).contains(&nearest["time_s"].as_f64().unwrap()),
        "{nearest}"
    );
    let amount = nearest["amount"].as_f64().unwrap();
    assert!(
        amount >= answer["clearance_m"].as_f64().unwrap() && amount < 0.02,
        "{nearest}"
    );
    assert_eq!(nearest["names"].as_array().unwrap().len(), 2);
}

#[test]
fn fixed_waypoints_are_passed() {
    let place = Place::new();
    let path = shortened(&place);
    let rows: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let rows = rows["path"].as_array().unwrap().clone();
    let passed = |fix: &str| {
        let run = time(&place, &path, &["--acceleration", "2/s", "--fix", fix]);
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        let answer = run.json();
        let points = answer["points"].as_array().unwrap();
        let is_passed = |row: &&Value| {
            points
                .iter()
                .any(|point| floats(&point["positions"]) == floats(row))
        };
        rows.iter().filter(is_passed).count()
    };
    assert_eq!(passed("all"), rows.len());
    assert!(passed("1") >= 3);
    let run = time(&place, &path, &["--acceleration", "2/s", "--fix", "99"]);
    assert!(
        run.exit == 65
            && run
                .err
                .contains("waypoint 99 is to be fixed; the path has waypoints 0 to"),
        "{}",
        run.err
    );
}

#[test]
fn a_start_velocity_is_gone_on_from_or_refused() {
    let place = Place::new();
    let path = shortened(&place);
    let start = |velocity: &str| {
        let given = ["--acceleration", "2/s", "--start-velocity", velocity];
        time(&place, &path, &given)
    };
    let run = start("joint1=0.1,joint2=-0.05");
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let first = floats(&run.json()["points"][0]["velocities"]);
    assert_eq!(first[..2], [0.1, -0.05]);
    let run = start("joint1=99");
    assert!(
        run.exit == 65
            && run
                .err
                .contains("the start velocity of joint1 is 99; its limits are"),
        "{}",
        run.err
    );
    let run = start("elbow=1");
    assert!(
        run.exit == 65
            && run
                .err
                .contains("is no column of the robot; valid: joint1"),
        "{}",
        run.err
    );
}

#[test]
fn half_the_speed_takes_twice_as_long() {
    let place = Place::new();
    let path = shortened(&place);
    let duration = |more: &[&str]| {
        let run = time(&place, &path, &[&["--acceleration", "2/s"], more].concat());
        run.json()["duration_s"].as_f64().unwrap()
    };
    let ratio = duration(&["--speed", "0.5"]) / duration(&[]);
    assert!((1.9..2.1).contains(&ratio), "{ratio}");
}

#[test]
fn a_missing_limit_is_an_error_that_names_joint_file_and_option() {
    let place = Place::new();
    let path = shortened(&place);
    let run = time(&place, &path, &[]);
    assert_eq!(run.exit, 65, "{}{}", run.out, run.err);
    for words in [
        "moves and has no acceleration limit",
        "--limits FILE",
        "joint_limits.yaml",
        "--acceleration 2/s",
    ] {
        assert!(run.err.contains(words), "{}", run.err);
    }
    let limits = place.file("joint_limits.yaml", LIMITS);
    let run = time(&place, &path, &["--limits", &limits]);
    assert!(
        run.exit != 0 && run.err.contains("joint_limits.yaml"),
        "{}",
        run.err
    );
    let bad = place.file(
        "bad.yaml",
        "joint_limits: {joint1: {has_velocity_limits: true, max_velocity: -1}}",
    );
    let run = time(&place, &path, &["--limits", &bad]);
    assert!(
        run.exit == 65 && run.err.contains("max_velocity is -1"),
        "{}",
        run.err
    );
    let none = place.file("none.yaml", "joints: {}");
    let run = time(&place, &path, &["--limits", &none]);
    assert!(
        run.exit == 65 && run.err.contains("no joint_limits"),
        "{}",
        run.err
    );
}

#[test]
fn a_path_that_collides_gets_no_times() {
    let place = Place::new();
    let problem = common::problem("arm_window");
    let rows = problem["path"].as_array().unwrap();
    let straight =
        json!({ "variables": problem["variables"], "path": [rows[0], rows[rows.len() - 1]] });
    let file = place.file("straight.json", &straight.to_string());
    let run = time(&place, &file, &["--acceleration", "2/s"]);
    assert_eq!(
        (run.exit, &run.json()["proved"]),
        (1, &json!(false)),
        "{}{}",
        run.out,
        run.err
    );
    assert!(
        run.json()["message"]
            .as_str()
            .unwrap()
            .contains("with a stop at each waypoint")
    );
}

/// A proof of what moves does not see what stands in a wall; the names of both are told.
#[test]
fn a_robot_that_stands_in_a_wall_gets_no_times() {
    let place = Place::new();
    let file = place.file("path.json", &path_file(&UPRIGHT, &Value::Null));
    let wall = json!({ "name": "wall", "objects": [{ "id": "wall",
        "primitives": [{ "type": "box", "dimensions": [0.1, 0.1, 0.1] }],
        "primitive_poses": [{ "position": [0.0, 0.0, -0.08] }] }] });
    let scene = place.file("wall.json", &wall.to_string());
    let flags = ["--acceleration", "2", "--scene", &scene];
    let run = asks(&place, "time", &file, &flags);
    assert_eq!(run.exit, 1, "{}{}", run.out, run.err);
    let told = [run.out, run.err].concat();
    assert!(
        told.contains("base overlaps wall") || told.contains("wall overlaps base"),
        "{told}"
    );
    assert!(told.contains("no joint moves them"), "{told}");
}
