//! The daemon's answers are those of `--local`, bit for bit, whoever else asks.
#![cfg(feature = "daemon")]

mod common;

use common::*;
use serde_json::Value;
use taut_ipc::wire::{Code, Mode, RequestBody, ResponseFlags};

const MODES: [&str; 3] = ["gradient", "random-shortcut", "partial-shortcut"];

/// An answer without what it cost.
fn shorten(place: &Place, name: &str, mode: &str, local: bool) -> Value {
    let file = config(&format!("problems/{name}.json"));
    let mut arguments = vec!["shorten", file.as_str(), "--mode", mode, "--seed", "11", "--format", "json"];
    arguments.extend(local.then_some("--local"));
    let run = place.taut(&arguments);
    assert_eq!(run.exit, 0, "{name} {mode}: {}", run.err);
    let mut answer = run.json();
    for cost in ["cpu_s", "time_s"] {
        assert!(answer.as_object_mut().unwrap().remove(cost).is_some());
    }
    answer
}

#[test]
fn answers_are_bit_equal_to_local_ones_whatever_ran_before() {
    let nowhere = Place::new();
    let asked: Vec<(&str, &str)> = PROBLEMS.iter().flat_map(|name| MODES.map(|mode| (*name, mode))).collect();
    let local: Vec<Value> = asked.iter().map(|(name, mode)| shorten(&nowhere, name, mode, true)).collect();
    for workers in [1, 2] {
        let place = Place::new();
        let _daemon = place.serve(&format!("workers = {workers}"));
        // Forwards, backwards: each is asked after another one.
        for index in (0..asked.len()).chain((0..asked.len()).rev()) {
            let (name, mode) = asked[index];
            assert_eq!(shorten(&place, name, mode, false), local[index], "{name} {mode}, {workers} workers");
        }
    }
}

#[test]
fn four_clients_at_once_get_their_own_answers() {
    let place = Place::new();
    let mut daemon = place.serve("workers = 2");
    let names = ["arm_shelf", "rooms", "ell_window", "slalom"];
    let local = names.map(|name| shorten(&place, name, "gradient", true));
    std::thread::scope(|scope| {
        for (name, local) in names.iter().zip(&local) {
            let place = &place;
            scope.spawn(move || {
                for _ in 0..8 {
                    assert_eq!(&shorten(place, name, "gradient", false), local, "{name}");
                }
            });
        }
    });
    assert!(daemon.is_alive());
}

#[test]
fn check_and_watch_and_labels_go_through_the_daemon_too() {
    let place = Place::new();
    let _daemon = place.serve("");
    let file = config("problems/arm_shelf.json");
    let run = place.taut(&["check", &file]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""));
    assert!(run.out.starts_with("proved   clearance ≥ "), "{}", run.out);
    let watched = place.taut(&["shorten", &file, "--watch"]);
    assert_eq!(watched.exit, 0);
    assert!(watched.err.lines().all(|line| line.contains("  length ")) && !watched.err.is_empty(), "{}", watched.err);

    // A bare path for what is loaded under labels; a problem file is a path of its columns too.
    let out = place.folder.path().join("answer.json");
    place.taut(&["shorten", &file, "--out", out.to_str().unwrap()]);
    let labelled = ["check", out.to_str().unwrap(), "--robot", "arm_shelf", "--scene", "arm_shelf"];
    let run = place.taut(&labelled);
    assert_eq!(run.exit, 0, "{}", run.err);
    let run = place.taut(&["check", out.to_str().unwrap(), "--robot", "arm_shelf", "--scene", "nowhere"]);
    assert_eq!(run.exit, 66, "{}", run.err);
    assert!(run.err.contains("UNKNOWN_SCENE") && run.err.contains("slalom"), "{}", run.err);
    // A file that was not loaded goes under its name and hash.
    let text = std::fs::read_to_string(&file).unwrap().replace("\"shelf_middle\"", "\"shelf_center\"");
    let other = place.folder.path().join("other.json");
    std::fs::write(&other, text.replace("../robots", &config("robots"))).unwrap();
    assert_eq!(place.taut(&["check", other.to_str().unwrap()]).exit, 0);
    assert!(place.taut(&["list"]).out.contains("scene arm_shelf@"));
}

#[test]
fn sections_of_a_request_are_heard() {
    let place = Place::new();
    let _daemon = place.serve("");
    let client = place.client();
    let models = Models::of(&client, "arm_shelf");
    let nq = models.nq();
    let answer = |body: RequestBody<'_>, group: Option<u32>| {
        let loan = models.request(&client, body, |header| {
            header.mode = Mode::PartialShortcut.into();
            header.group = group.unwrap_or(header.group);
        });
        let response = loan.send().unwrap().wait(PATIENCE).unwrap();
        assert_eq!(response.code(), Code::Success, "{}", response.message());
        let header = *response.header();
        assert_eq!((header.robot_hash, header.scene_hash), (models.robot.robot_hash, models.scene.scene_hash));
        assert_eq!(
            (header.scene_id, header.scene_version, header.flags),
            (models.scene.scene_id, 1, ResponseFlags::PROVED)
        );
        (header, response.path().to_vec())
    };
    let (free, path) = answer(RequestBody::default(), None);
    assert!(free.length_after < free.length_before && free.lower_bound <= free.length_after);
    assert_eq!(path[..nq], models.path[..nq]);
    // The group of all joints is no restriction.
    assert_eq!(answer(RequestBody::default(), Some(0)).1, path);
    let none = vec![0; nq];
    assert_eq!(answer(RequestBody { group_mask: &none, ..Default::default() }, None).1, models.path);
    let fixed = vec![1; models.path.len() / nq];
    let (_, kept) = answer(RequestBody { fixed_waypoints: &fixed, ..Default::default() }, None);
    for waypoint in models.path.chunks(nq) {
        assert!(kept.chunks(nq).any(|row| row == waypoint), "a fixed waypoint is gone");
    }
    let weights = vec![1.0; nq];
    let (ones, _) = answer(RequestBody { weights: &weights, ..Default::default() }, None);
    assert_ne!(ones.length_before, free.length_before);
}
