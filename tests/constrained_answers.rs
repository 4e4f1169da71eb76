//! What answers say of constraints: what is left and where, what is proved of it, and what comes of
//! changes.
#![cfg(feature = "daemon")]

mod common;

use std::sync::Arc;

use common::waiter::{
    ROBOT, UPRIGHT, WORDS, asks, load, most_tilted, path_file, planners, request,
};
use common::{PATIENCE, Place, Run};
use serde_json::{Value, json};
use taut::collision::CollisionModel;
use taut::constraint::ConstraintsFile;
use taut::files::{Packages, Reader, ResultFile, RobotFiles};
use taut::optimize::{Settings, Workspace, run};
use taut::path::Path;
use taut::robot::RobotModel;
use taut::scene::Scene;
use taut_ipc::planner::{Planner, Request};
use taut_ipc::wire::{Code, Mode, RequirementKind};

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

/// The same of the library itself: nothing of it went over a wire.
fn by_the_library(place: &Place) -> ResultFile {
    let files = RobotFiles {
        urdf: place.file("waiter.urdf", ROBOT).into(),
        variables: Some(
            ["lean", "turn", "nod"]
                .map(str::to_owned)
                .to_vec(),
        ),
        ..RobotFiles::default()
    };
    let robot = Reader::new(Packages::default()).robot_of(&files);
    let robot = RobotModel::new(robot.unwrap()).unwrap();
    let model = CollisionModel::new(Arc::new(robot), Arc::new(Scene::default())).unwrap();
    let words = json!([WORDS, "keep hand@0.5,0,0.5 in box 3,3,3 at 0,0,0"]);
    let settings = Settings {
        constraints: ConstraintsFile::parse(&words.to_string()).unwrap(),
        work_budget: 50_000,
        ..Settings::default()
    };
    let path = Path::from_rows(3, UPRIGHT.concat()).unwrap();
    let mut workspace = Workspace::default();
    let outcome = run(
        &model,
        &path,
        &settings,
        &mut workspace,
        &mut || false,
        &mut |_| {},
    );
    ResultFile::of(&outcome.unwrap())
}

#[test]
fn what_came_over_the_wire_is_what_the_library_says_to_the_last_bit() {
    let place = Place::new();
    let file = place.file("path.json", &path_file(&UPRIGHT, &Value::Null));
    let here = shortened(&place, &file, &[&KEPT[..], &["--local"]].concat());
    let library = serde_json::to_value(by_the_library(&place)).unwrap();
    for field in [
        "certificate",
        "keeps",
        "holds",
        "smallest_clearance",
        "floors_lowered",
        "path",
    ] {
        assert_eq!(here[field], library[field], "{field}");
    }
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
        let run = asks(&place, command, &file, &[more, &["--local"]].concat());
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
