//! What a path must keep besides clearance, as users ask for it: by name, of a daemon and in this
//! process, in files, by flags.
#![cfg(feature = "daemon")]

mod common;

use std::f64::consts::FRAC_PI_2;

use std::fs;

use common::waiter::{ROBOT, UPRIGHT, WORDS, asked, asks, most_tilted, path_file, planners, tilt};
use common::{Place, Run};
use serde_json::{Value, json};
use taut_ipc::wire::{Code, RequirementKind, Unit};

#[test]
fn a_request_with_constraints_is_answered_with_them() {
    let place = Place::new();
    let _daemon = place.serve("");
    let mut answers = Vec::new();
    for planner in planners(&place) {
        let plain = asked(&planner, "", &UPRIGHT).unwrap();
        assert!(most_tilted(plain.path()) > 0.2, "the test asks for nothing");
        let best = asked(&planner, WORDS, &UPRIGHT).unwrap();
        let header = best.header();
        assert!(best.view().unwrap().is_proved());
        assert!(header.length_after < header.length_before);
        assert!(most_tilted(best.path()) <= 0.1);
        answers.push(best.path().to_vec());
    }
    assert_eq!(answers[0], answers[1]);
}

#[test]
fn waypoints_that_are_upright_do_not_make_the_way_between_them_so() {
    let place = Place::new();
    let _daemon = place.serve("");
    let between = [UPRIGHT[0], UPRIGHT[3]];
    assert!(between.iter().all(|row| tilt(*row) < 1e-6));
    for planner in planners(&place) {
        let error = asked(&planner, WORDS, &between).unwrap_err();
        assert_eq!(error.code(), Code::InvalidMotionPlan, "{error}");
        let place = error.place().unwrap();
        assert_eq!(place.kind, RequirementKind::Orientation);
        assert_eq!(place.unit, Unit::Radian);
        assert_eq!(place.names, ["upright: hand"]);
        let at = std::array::from_fn(|q| between[0][q] + place.t * (between[1][q] - between[0][q]));
        assert!((place.amount - (0.1 - tilt(at))).abs() < 1e-6, "{error}");
        assert!(place.amount < 0.0);
    }
}

#[test]
fn ends_outside_and_texts_that_are_none_have_codes_of_their_own() {
    let place = Place::new();
    let _daemon = place.serve("");
    let leaning = [0.3, 0.0, 0.0];
    for planner in planners(&place) {
        let code = |constraints: &str, rows: &[[f64; 3]]| {
            let error = asked(&planner, constraints, rows).unwrap_err();
            assert!(!error.to_string().contains('\n'), "{error}");
            (error.code(), error.to_string())
        };
        let start = code(WORDS, &[leaning, UPRIGHT[1]]).0;
        assert_eq!(start, Code::StartStateViolatesPathConstraints);
        let goal = code(WORDS, &[UPRIGHT[1], leaning]).0;
        assert_eq!(goal, Code::GoalViolatesPathConstraints);
        for (text, part) in [
            ("upright arm:z=0.1", "links: base, shoulder, elbow, hand"),
            ("upright hand:w=0.1", "-x, -y, -z"),
            ("upright hand:z=2", "π/2"),
            ("{", "not MoveIt's Constraints"),
            (r#"{"orientations": []}"#, "orientation_constraints"),
            (
                r#"{"visibility_constraints": [{"cone_sides": 4}]}"#,
                "visibility_constraints",
            ),
        ] {
            let (code, error) = code(text, &UPRIGHT);
            assert_eq!(code, Code::InvalidConstraint, "{text}: {error}");
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}

#[test]
fn a_direction_may_be_the_one_that_the_path_starts_with() {
    let place = Place::new();
    let _daemon = place.serve("");
    // Leaning all the way, the cup keeps its direction.
    let rows = [[0.8, 0.0, -0.5], [0.3, 0.0, 0.0]];
    for planner in planners(&place) {
        assert!(asked(&planner, WORDS, &rows).is_err());
        assert!(asked(&planner, "upright hand:z=0.1@start", &rows).is_ok());
        let away = [rows[0], [0.5, 0.0, 0.0]];
        let error = asked(&planner, "upright hand:z=0.1@start", &away).unwrap_err();
        assert_eq!(error.code(), Code::GoalViolatesPathConstraints, "{error}");
    }
}

fn taut(place: &Place, command: &str, file: &str, more: &[&str]) -> Run {
    asks(place, command, file, &[more, &["--local"]].concat())
}

#[test]
fn files_and_flags_ask_for_the_same() {
    let place = Place::new();
    let moveit = json!({ "name": "cup", "orientation_constraints": [{ "link_name": "hand",
        "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 }, "absolute_x_axis_tolerance": 0.1, "absolute_y_axis_tolerance": 0.1,
        "absolute_z_axis_tolerance": 3.15 }] });
    let between = [UPRIGHT[0], UPRIGHT[3]];
    let plain = place.file("plain.json", &path_file(&between, &Value::Null));
    let asking = place.file("asking.json", &path_file(&between, &moveit));
    let constraints = place.file("cup.json", &moveit.to_string());
    assert_eq!(taut(&place, "check", &plain, &[]).exit, 0);
    let text = moveit.to_string();
    for (file, flags) in [
        (&plain, vec!["--keep-upright", "hand:z=0.1"]),
        (&plain, vec!["--keep-upright", "hand:z=6deg"]),
        (&plain, vec!["--path-constraints", &constraints]),
        (&plain, vec!["--path-constraints", &text]),
        (&plain, vec!["--path-constraints", &asking]),
        (
            &plain,
            vec!["--keep", "hand@0,0,1 in box 0.2,0.2,2 at 0,0,1"],
        ),
        (&asking, vec![]),
    ] {
        let run = taut(&place, "check", file, &flags);
        assert_eq!(run.exit, 1, "{flags:?}: {}{}", run.out, run.err);
        assert!(
            run.out.starts_with("OUTSIDE segment 1 of 1") && run.out.contains("outside by"),
            "{}",
            run.out
        );
    }
    // All of them hold: of two, either refuses.
    let both = [
        "--keep-upright",
        "hand:z=1.5",
        "--keep",
        "hand in ball 0.01 at 0,0,0",
    ];
    assert_eq!(taut(&place, "check", &plain, &both).exit, 0);
    let bad = taut(&place, "check", &plain, &["--keep-upright", "hand=0.1"]);
    assert_eq!(bad.exit, 64);
    assert!(bad.err.contains("LINK:AXIS=ANGLE"), "{}", bad.err);
}

#[test]
fn an_answer_says_what_it_keeps_and_is_checked_with_it() {
    let place = Place::new();
    let file = place.file("path.json", &path_file(&UPRIGHT, &Value::Null));
    let result = place.folder.path().join("result.json");
    let result = result.to_str().unwrap();
    let flags = [
        "--keep-upright",
        "hand:z=0.1",
        "--format",
        "json",
        "-o",
        result,
    ];
    let run = taut(&place, "shorten", &file, &flags);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let answer: Value = serde_json::from_str(&run.out).unwrap();
    let kept = &answer["path_constraints"]["orientation_constraints"][0];
    assert_eq!(kept["link_name"], "hand");
    assert_eq!(kept["tolerance_rad"], 0.1);
    // The answer is a path that asks to be kept upright.
    let again = taut(&place, "check", result, &["--format", "json"]);
    assert_eq!(again.exit, 0, "{}{}", again.out, again.err);
    let again: Value = serde_json::from_str(&again.out).unwrap();
    assert_eq!(again["path_constraints"], answer["path_constraints"]);
    let mut spoilt: Value =
        serde_json::from_str(&std::fs::read_to_string(result).unwrap()).unwrap();
    spoilt["path"] = json!([[0.5, 0.0, -0.5], [0.5, FRAC_PI_2, 0.0]]);
    let spoilt = place.file("spoilt.json", &spoilt.to_string());
    assert_eq!(taut(&place, "check", &spoilt, &[]).exit, 1);
}

#[test]
fn a_request_of_moveit_keeps_what_it_says() {
    let place = Place::new();
    let joints = |name: &str, position: f64| json!({ "joint_name": name, "position": position });
    let names = ["lean", "turn", "nod"];
    let goal: Vec<Value> = (0..3)
        .map(|q| joints(names[q], UPRIGHT[3][q]))
        .collect();
    let tilt = json!({ "link_name": "hand", "axis": [0, 0, 1], "reference": [0, 0, 1], "tolerance_rad": 0.1 });
    let request = json!({
        "start_state": { "joint_state": { "name": names, "position": UPRIGHT[0] } },
        "goal_constraints": [{ "joint_constraints": goal }],
        "path_constraints": { "name": "cup", "orientation_constraints": [tilt] },
    });
    let file = place.file("request.yaml", &request.to_string());
    let run = taut(&place, "check", &file, &[]);
    assert_eq!(run.exit, 1, "{}{}", run.out, run.err);
    assert!(run.out.contains("cup: hand"), "{}", run.out);
    let timed = place.file("timed.yaml", &json!({ "path_constraints": request["path_constraints"],
        "joint_trajectory": { "joint_names": names, "points": [
            { "positions": UPRIGHT[0], "time_from_start": 0.0 }, { "positions": UPRIGHT[3], "time_from_start": 1.0 }] } }).to_string());
    let run = timed_check(&place, &timed, &[]);
    assert_eq!(run.exit, 1, "{}{}", run.out, run.err);
    assert!(run.out.contains("OUTSIDE at"), "{}{}", run.out, run.err);
}

fn timed_check(place: &Place, file: &str, more: &[&str]) -> Run {
    let urdf = place.file("waiter.urdf", ROBOT);
    let given = ["check", file, "--timed", "--robot", &urdf];
    place.taut(&[&given, more].concat())
}

/// Between points that keep a constraint a controller's curve may not: lean and nod cancel each other only
/// where they are as fast.
#[test]
fn what_is_executed_between_points_keeps_constraints_or_is_refused() {
    let place = Place::new();
    let trajectory = |nod: f64| {
        let point = |row: [f64; 3], velocities: [f64; 3], time: f64| json!({ "positions": row, "velocities": velocities, "time_from_start": time });
        let message = json!({ "joint_names": ["lean", "turn", "nod"], "points": [
            point(UPRIGHT[0], [0.0, 0.0, 0.0], 0.0), point(UPRIGHT[1], [-0.5, 0.0, nod], 1.0)] });
        place.file("timed.json", &message.to_string())
    };
    let keep = ["--keep-upright", "hand:z=0.1"];
    let run = timed_check(&place, &trajectory(0.5), &keep);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    // Nod comes back to where it is to be from another side: it is off by 4/27 of 1.5 on the way.
    let run = timed_check(&place, &trajectory(-1.0), &keep);
    assert_eq!(run.exit, 1, "{}{}", run.out, run.err);
    assert!(run.out.contains("OUTSIDE at"), "{}", run.out);
    let run = timed_check(&place, &trajectory(-1.0), &[]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
}

/// `taut time` takes directions as they are where the path starts, and claims them so.
#[test]
fn a_path_that_keeps_the_direction_it_starts_with_gets_times() {
    let place = Place::new();
    let start = json!({ "orientation_constraints": [{ "link_name": "hand", "axis": [0, 0, 1],
        "reference": "start", "tolerance_rad": 0.1 }] });
    // Leaning at first, the cup keeps its direction on the one path and loses it on the other.
    let timed = |end: [f64; 3], more: &[&str]| {
        let rows = [[0.8, 0.0, -0.5], end];
        let file = place.file("start.json", &path_file(&rows, &start));
        asks(
            &place,
            "time",
            &file,
            &[&["--acceleration", "2"], more].concat(),
        )
    };
    let certificate = place.file("certificate.json", "");
    let run = timed([0.3, 0.0, 0.0], &["--write-certificate", &certificate]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let claimed = fs::read_to_string(&certificate).unwrap();
    assert!(!claimed.contains("\"start\""), "{claimed}");
    let run = timed([0.5, 0.0, 0.0], &[]);
    assert_eq!(run.exit, 1, "{}{}", run.out, run.err);
}
