//! Requests by name: the same to a daemon and in this process, columns in any order, robots that
//! change meanwhile.

mod common;

use common::{PATIENCE, Place, config, problem};
use taut::local::LocalService;
use taut_ipc::control::RobotSource;
use taut_ipc::planner::{Best, Planner, Request, words};
use taut_ipc::wire::{Code, Mode};

fn source(variables: &[String]) -> RobotSource {
    let file = |name: &str| config(&format!("robots/{name}")).into();
    RobotSource {
        urdf: file("panda_like.urdf"),
        srdf: Some(file("panda_like.srdf")),
        variables: variables.to_vec(),
        ..RobotSource::default()
    }
}

/// Columns and numbers of the shipped path.
fn path() -> (Vec<String>, Vec<f64>) {
    let problem = problem("arm_shelf");
    let names = problem["variables"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap().to_owned());
    let rows = problem["path"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row.as_array().unwrap());
    (
        names.collect(),
        rows.map(|number| number.as_f64().unwrap())
            .collect(),
    )
}

fn load(planner: &Planner, columns: &[String]) {
    planner
        .load_robot("arm", &source(columns), true)
        .unwrap();
    let text = taut::files::scene_text(config("problems/arm_shelf.json").as_ref()).unwrap();
    planner
        .load_scene("shelf", &text, None, true)
        .unwrap();
}

fn shortened(planner: &Planner, request: &Request, path: &[f64]) -> Best {
    planner
        .ask(request, path)
        .unwrap()
        .result(PATIENCE)
        .unwrap()
}

fn request() -> Request {
    Request {
        work_budget: 20_000,
        seed: 5,
        ..Request::new("arm", Some("shelf"))
    }
}

#[test]
fn this_process_answers_as_the_daemon_does() {
    let place = Place::new();
    let _daemon = place.serve("");
    let (columns, path) = path();
    let mut answers = Vec::new();
    for planner in [
        Planner::connect(&place.instance).unwrap(),
        Planner::in_process(LocalService::default()),
    ] {
        load(&planner, &columns);
        let best = shortened(&planner, &request(), &path);
        let header = best.header();
        let view = best.view().unwrap();
        assert!(view.is_proved() && header.length_after < header.length_before);
        answers.push((
            best.path().to_vec(),
            header.work,
            header.clearance_m,
            view.certificate.to_vec(),
        ));
        let straight = [&path[..7], &path[path.len() - 7..]].concat();
        let refused = planner
            .ask(&request(), &straight)
            .unwrap()
            .result(PATIENCE)
            .unwrap_err();
        assert!(
            refused
                .place()
                .is_some_and(|place| place.segment == 0),
            "{refused}"
        );
        let changed = planner
            .change_scene("shelf", &words::removed("nothing"), None, 0)
            .unwrap_err();
        assert_eq!(changed.code(), Code::InvalidObjectName);
    }
    assert_eq!(answers[0], answers[1]);
}

/// Asked by name, the corridor of an answer is the one that result files have.
#[test]
fn a_corridor_is_asked_for_and_told_by_name() {
    let place = Place::new();
    let _daemon = place.serve("");
    let (columns, path) = path();
    for planner in [
        Planner::connect(&place.instance).unwrap(),
        Planner::in_process(LocalService::default()),
    ] {
        load(&planner, &columns);
        let plain = shortened(&planner, &request(), &path);
        assert_eq!(plain.corridor().unwrap(), None);
        let request = Request {
            corridor: true,
            ..request()
        };
        let best = shortened(&planner, &request, &path);
        assert_eq!(best.path(), plain.path());
        let told = best.corridor().unwrap().unwrap();
        let robot = planner.robot("arm").unwrap();
        let (outcome, _) =
            taut::translate::outcome(&best.view().unwrap(), &request, &robot).unwrap();
        let corridor = outcome.corridor.unwrap();
        assert_eq!(told.floor_m, corridor.floor_m);
        assert_eq!(told.reach, corridor.reach);
        assert_eq!(told.slack_m, corridor.slack_m);
        assert_eq!(told.slack_m.len() + 1, best.waypoints());
    }
}

#[test]
fn columns_keep_their_names_when_the_robot_changes_under_its_label() {
    let place = Place::new();
    let _daemon = place.serve("");
    let planner = Planner::connect(&place.instance).unwrap();
    let (columns, path) = path();
    load(&planner, &columns);
    let request = Request {
        columns: columns.clone(),
        mode: Mode::Check,
        ..request()
    };
    let before = shortened(&planner, &request, &path);
    // Another connection gives the label to a robot whose variables come in another order.
    let turned: Vec<String> = columns.iter().rev().cloned().collect();
    load(&Planner::connect(&place.instance).unwrap(), &turned);
    let after = shortened(&planner, &request, &path);
    assert_eq!((&*before.rows(), &*after.rows()), (&*path, &*path));
    assert_eq!(
        after.path()[..7],
        path[..7]
            .iter()
            .rev()
            .copied()
            .collect::<Vec<_>>()[..]
    );
}
