//! What a path must keep besides clearance, as users ask for it: by name, of a daemon and in this
//! process, in files, by flags.
#![cfg(feature = "daemon")]

mod common;

use std::f64::consts::FRAC_PI_2;

use common::waiter::{ROBOT, UPRIGHT, WORDS, asked, load, most_tilted, planners, request, tilt};
use common::{PATIENCE, Place, Run};
use serde_json::{Value, json};
use taut_ipc::planner::{Planner, Request};
use taut_ipc::wire::{Code, Mode, RequirementKind, Unit};

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

fn path_file(rows: &[[f64; 3]], constraints: &Value) -> String {
    json!({ "variables": ["lean", "turn", "nod"], "path": rows, "path_constraints": constraints })
        .to_string()
}

/// Runs a command about the robot's path in a file.
fn asks(place: &Place, command: &str, file: &str, more: &[&str]) -> Run {
    let urdf = place.file("waiter.urdf", ROBOT);
    let given = [command, file, "--robot", &urdf];
    place.taut(&[&given, more].concat())
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
    let run = taut(&place, "check", &timed, &["--timed"]);
    assert_ne!(run.exit, 0, "{}{}", run.out, run.err);
    assert!(
        run.err.contains("path_constraints") || run.out.contains("OUTSIDE"),
        "{}{}",
        run.out,
        run.err
    );
}

/// An answer without what it cost and who gave it.
fn shortened(place: &Place, file: &str, more: &[&str]) -> Value {
    let run = asks(
        place,
        "shorten",
        file,
        &[more, &["--format", "json"]].concat(),
    );
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    assert!(!run.err.contains("clearances only"), "{}", run.err);
    let mut answer = run.json();
    let fields = answer.as_object_mut().unwrap();
    for cost in ["cpu_s", "time_s", "lengths_over_time", "request_id"] {
        fields.remove(cost);
    }
    answer
}

const KEPT: [&str; 6] = [
    "--keep-upright",
    "hand:z=0.1",
    "--keep",
    "hand@0.5,0,0.5 in box 3,3,3 at 0,0,0",
    "--budget",
    "50000",
];

#[test]
fn a_daemons_answer_is_that_of_this_process_with_all_that_it_keeps() {
    let place = Place::new();
    let _daemon = place.serve("");
    let file = place.file("path.json", &path_file(&UPRIGHT, &Value::Null));
    let here = shortened(&place, &file, &[&KEPT[..], &["--local"]].concat());
    assert_eq!(shortened(&place, &file, &KEPT), here);
    let claims = &here["certificate"]["constraints"];
    let segments = here["path"].as_array().unwrap().len() - 1;
    assert_eq!(claims["left"].as_array().unwrap().len(), segments);
    let [inside, within] = [0, 1].map(|index| &here["keeps"][index]);
    // Positions come first.
    assert_eq!(inside["names"], json!(["hand"]));
    assert_eq!(
        (&inside["kind"], &inside["asked"]),
        (&json!("position"), &Value::Null)
    );
    assert_eq!(within["names"], json!(["hand"]), "two names are none");
    assert_eq!(
        (&within["kind"], &within["asked"]),
        (&json!("orientation"), &json!(0.1))
    );
    let rows: Vec<Vec<f64>> = serde_json::from_value(here["path"].clone()).unwrap();
    let most = most_tilted(&rows.concat());
    let left = within["left"].as_f64().unwrap();
    assert!(left >= 0.0 && most <= 0.1 - left + 1e-9, "{most}, {within}");
    let found = within["amount"].as_f64().unwrap();
    assert!(
        found >= left && found < 0.1 - most + 1e-5,
        "{most}, {within}"
    );
    let holds = here["holds"].as_array().unwrap();
    assert!(
        holds
            .iter()
            .any(|hold| hold["kind"] == "orientation"),
        "{holds:?}"
    );
}

type Change = fn(&mut Value);

/// `check --certificate` of an answer that holds its path.
fn verified(place: &Place, answer: &Value) -> Run {
    let proof = place.file("answer.json", &answer.to_string());
    asks(place, "check", &proof, &["--certificate", &proof])
}

#[test]
fn a_daemons_certificate_is_verified_with_its_constraints_and_not_without() {
    let place = Place::new();
    let daemon = place.serve("");
    let file = place.file("path.json", &path_file(&UPRIGHT, &Value::Null));
    let answer = shortened(&place, &file, &KEPT);
    daemon.kill();
    let run = verified(&place, &answer);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    assert!(
        run.out.contains(", left: hand ") && run.out.contains(" rad "),
        "{}",
        run.out
    );

    let changes: [(&str, Change, &str); 4] = [
        (
            "more is left",
            |c| c["left"][0][1] = json!(0.09),
            "changed after the proof",
        ),
        (
            "less was asked",
            |c| c["asked"]["orientation_constraints"][0]["tolerance_rad"] = json!(0.2),
            "it claims nothing of the constraint \"hand\"",
        ),
        (
            "nothing is claimed",
            |c| *c = Value::Null,
            "it claims nothing of",
        ),
        (
            "another thing was asked",
            |c| c["asked"]["position_constraints"][0]["link_name"] = json!("elbow"),
            "it claims nothing of the constraint \"hand\"",
        ),
    ];
    for (what, change, reason) in changes {
        let mut forged = answer.clone();
        change(&mut forged["certificate"]["constraints"]);
        let run = verified(&place, &forged);
        assert_eq!(
            (run.exit, run.out.lines().count()),
            (2, 1),
            "{what}: {}{}",
            run.out,
            run.err
        );
        assert!(run.out.contains(reason), "{what}: {}", run.out);
    }
    // Who also seals what he forged is found out by looking.
    let mut forged: taut::validation::Certificate =
        serde_json::from_value(answer["certificate"].clone()).unwrap();
    forged.constraints.as_mut().unwrap().left[0][1] = 0.0999;
    let mut resealed = answer.clone();
    resealed["certificate"] = serde_json::to_value(forged.sealed()).unwrap();
    let run = verified(&place, &resealed);
    assert_eq!(run.exit, 2, "{}{}", run.out, run.err);
    assert!(run.out.contains("claimed 0.0999 rad"), "{}", run.out);
}

#[test]
fn people_are_told_what_is_kept_and_where_it_is_tightest() {
    let place = Place::new();
    let file = place.file("path.json", &path_file(&UPRIGHT, &Value::Null));
    for (command, more) in [
        ("shorten", &KEPT[..]),
        ("check", &["--keep-upright", "hand:z=0.1"]),
    ] {
        let run = taut(&place, command, &file, more);
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        let kept: Vec<&str> = run
            .out
            .lines()
            .filter(|line| line.contains("tightest at segment "))
            .collect();
        assert!(kept[0].starts_with("  keeps    "), "{}", run.out);
        let (_, most) = kept[kept.len() - 1]
            .split_once("hand tilts at most ")
            .unwrap();
        let (most, rest) = most.split_once(" of 0.1 rad (").unwrap();
        assert!(most.parse::<f64>().unwrap() <= 0.1, "{}", run.out);
        assert!(rest.ends_with(" rad found)"), "{}", run.out);
    }
}

#[test]
fn a_watched_path_is_told_when_its_constraint_moves_away_with_what_it_is_about() {
    let place = Place::new();
    let _daemon = place.serve("");
    let planner = Planner::connect(&place.instance).unwrap();
    load(&place, &planner);
    let stand = json!({ "id": "stand", "operation": "ADD", "primitives": [{ "type": "box", "dimensions": [1, 1, 0.1] }],
        "primitive_poses": [{ "position": [0, 0, -3] }] });
    let scene = json!({ "name": "bar", "objects": [stand] }).to_string();
    planner
        .load_scene("bar", &scene, None, false)
        .unwrap();
    let request = Request {
        mode: Mode::Check,
        watch: true,
        scene: Some("bar".to_owned()),
        ..request("keep hand@0.5,0,0.5 in ball 2 at 0,0,3 of stand")
    };
    let mut watched = planner
        .ask(&request, UPRIGHT.as_flattened())
        .unwrap();
    let mut next = || {
        let best = watched.next(PATIENCE).unwrap().unwrap();
        let names = best.view().unwrap().refusal.map(|refusal| {
            let names = best.view().unwrap().names.to_owned();
            (
                refusal.requirement.kind,
                refusal.requirement.names(&names).unwrap(),
            )
        });
        (
            best.code(),
            names,
            best.keeps().unwrap().len(),
            best.message().to_owned(),
        )
    };
    assert_eq!(next(), (Code::Success, None, 1, String::new()));
    let change = |change: Value| {
        let diff = json!({ "is_diff": true, "objects": [change] }).to_string();
        planner
            .change_scene("bar", &diff, None, 0)
            .unwrap();
    };
    change(json!({ "id": "stand", "operation": "MOVE", "pose": { "position": [5, 0, -3] } }));
    let (code, refused, keeps, _) = next();
    assert_eq!((code, keeps), (Code::InvalidatedByEnvironmentChange, 0));
    let kind = u32::from(RequirementKind::Position);
    assert_eq!(refused, Some((kind, vec!["hand".to_owned()])));
    change(json!({ "id": "stand", "operation": "MOVE", "pose": { "position": [0.1, 0, -3] } }));
    assert_eq!(next().0, Code::Success);
    change(json!({ "id": "stand", "operation": "REMOVE" }));
    let (code, _, _, message) = next();
    assert_eq!(code, Code::InvalidConstraint);
    assert!(message.contains("\"stand\""), "{message}");
}

#[test]
fn why_tells_what_a_path_must_keep_and_that_it_does_not() {
    let place = Place::new();
    let _daemon = place.serve("");
    let planner = Planner::connect(&place.instance).unwrap();
    load(&place, &planner);
    let between = [UPRIGHT[0], UPRIGHT[3]];
    let answers = planner
        .ask(&request(WORDS), between.as_flattened())
        .unwrap();
    let id = format!("{:016x}", answers.request_id());
    assert!(answers.result(PATIENCE).is_err());
    let run = place.taut(&["why", &id]);
    assert_eq!(run.exit, 0, "{}", run.err);
    for part in [
        "must keep upright: hand\n",
        "INVALID_MOTION_PLAN (outside), ended by Refused",
    ] {
        assert!(run.out.contains(part), "{}", run.out);
    }
}

#[test]
fn a_corridor_with_constraints_and_claims_that_no_answer_has_room_for_are_refused_by_name() {
    let place = Place::new();
    let _daemon = place.serve("");
    for planner in planners(&place) {
        let corridor = Request {
            corridor: true,
            ..request(WORDS)
        };
        let refused = |request: &Request, rows: &[[f64; 3]]| {
            let answers = planner.ask(request, rows.as_flattened());
            let error = answers
                .and_then(|answers| answers.result(PATIENCE))
                .unwrap_err();
            (error.code(), error.to_string())
        };
        let (code, text) = refused(&corridor, &UPRIGHT);
        assert_eq!(code, Code::MalformedRequest);
        assert!(
            text.contains("corridor") && text.contains("constraints"),
            "{text}"
        );
        let words = (0..30).map(|number| format!("\"upright hand:z=0.1{number:02}\""));
        let many = format!("[{}]", words.collect::<Vec<_>>().join(", "));
        let (code, text) = refused(&request(&many), &[UPRIGHT[1]; 5000]);
        assert_eq!(code, Code::ResourceExhausted);
        assert!(
            text.contains("5000 waypoints with 60 constraints"),
            "{text}"
        );
    }
}
