//! The daemon's answers are those of `--local`, bit for bit, whoever else asks.
#![cfg(feature = "daemon")]

mod common;

use common::*;
use serde_json::Value;
use taut_ipc::wire::{Code, Mode, RequestBody, ResponseFlags};

const MODES: [&str; 5] = [
    "gradient",
    "random-shortcut",
    "partial-shortcut",
    "contact",
    "hybrid",
];

/// An answer without what it cost.
fn answer(place: &Place, arguments: &[&str], local: bool) -> Value {
    let mut arguments = [arguments, &["--seed", "11", "--format", "json"]].concat();
    arguments.extend(local.then_some("--local"));
    let run = place.taut(&arguments);
    assert_eq!(run.exit, 0, "{arguments:?}: {}", run.err);
    let mut answer = run.json();
    let fields = answer.as_object_mut().unwrap();
    for cost in ["cpu_s", "time_s", "lengths_over_time"] {
        assert!(fields.remove(cost).is_some());
    }
    // For `taut why`.
    assert_eq!(fields.remove("request_id").is_some(), !local);
    answer
}

fn shorten(place: &Place, name: &str, mode: &str, local: bool) -> Value {
    answer(
        place,
        &[
            "shorten",
            &config(&format!("problems/{name}.json")),
            "--mode",
            mode,
        ],
        local,
    )
}

#[test]
fn answers_are_bit_equal_to_local_ones_whatever_ran_before() {
    let nowhere = Place::new();
    let asked: Vec<(&str, &str)> = PROBLEMS
        .iter()
        .flat_map(|name| MODES.map(|mode| (*name, mode)))
        .collect();
    let local: Vec<Value> = asked
        .iter()
        .map(|(name, mode)| shorten(&nowhere, name, mode, true))
        .collect();
    for workers in [1, 2] {
        let place = Place::new();
        let _daemon = place.serve(&format!("workers = {workers}"));
        // Forwards, backwards: each is asked after another one.
        for index in (0..asked.len()).chain((0..asked.len()).rev()) {
            let (name, mode) = asked[index];
            assert_eq!(
                shorten(&place, name, mode, false),
                local[index],
                "{name} {mode}, {workers} workers"
            );
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
    assert!(
        watched
            .err
            .lines()
            .all(|line| line.contains("  length "))
            && !watched.err.is_empty(),
        "{}",
        watched.err
    );

    // A bare path for what is loaded under labels; a problem file is a path of its columns too.
    let out = place.folder.path().join("answer.json");
    place.taut(&["shorten", &file, "--out", out.to_str().unwrap()]);
    let labelled = [
        "check",
        out.to_str().unwrap(),
        "--robot",
        "arm_shelf",
        "--scene",
        "arm_shelf",
    ];
    let run = place.taut(&labelled);
    assert_eq!(run.exit, 0, "{}", run.err);
    let run = place.taut(&[
        "check",
        out.to_str().unwrap(),
        "--robot",
        "arm_shelf",
        "--scene",
        "nowhere",
    ]);
    assert_eq!(run.exit, 66, "{}", run.err);
    assert!(
        run.err.contains("UNKNOWN_SCENE") && run.err.contains("slalom"),
        "{}",
        run.err
    );
    // A file that was not loaded goes under its name and hash.
    let text = std::fs::read_to_string(&file)
        .unwrap()
        .replace("\"shelf_middle\"", "\"shelf_center\"");
    let other = place.folder.path().join("other.json");
    std::fs::write(&other, text.replace("../robots", &config("robots"))).unwrap();
    assert_eq!(
        place
            .taut(&["check", other.to_str().unwrap()])
            .exit,
        0
    );
    assert!(
        place
            .taut(&["list"])
            .out
            .contains("scene arm_shelf@")
    );
}

/// Columns of an answer's path.
fn columns(answer: &Value, columns: &[&str]) -> Vec<Vec<f64>> {
    let names = answer["variables"].as_array().unwrap();
    let index = |column: &&str| {
        names
            .iter()
            .position(|name| name == column)
            .unwrap()
    };
    let indices: Vec<usize> = columns.iter().map(index).collect();
    let rows = answer["path"].as_array().unwrap().iter();
    rows.map(|row| {
        indices
            .iter()
            .map(|&i| row[i].as_f64().unwrap())
            .collect()
    })
    .collect()
}

/// How far each row of some columns is from the one before, in all.
fn travel(rows: &[Vec<f64>]) -> f64 {
    let step = |pair: &[Vec<f64>]| {
        pair[0]
            .iter()
            .zip(&pair[1])
            .map(|(a, b)| (b - a).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    rows.windows(2).map(step).sum()
}

#[test]
fn groups_fixed_waypoints_weights_and_budgets_are_the_same_with_a_daemon() {
    let place = Place::new();
    let _daemon = place.serve("workers = 2");
    let both = |arguments: &[&str]| {
        let local = answer(&place, arguments, true);
        let remote = answer(&place, arguments, false);
        assert_eq!(local, remote, "{arguments:?}");
        remote
    };
    let arms = config("problems/exchange_arms.json");
    let free = both(&["shorten", &arms]);
    let given = both(&["check", &arms]);
    // Only the arms may move: the base and the torso travel as they did.
    let still = [
        "base_joint/x",
        "base_joint/y",
        "base_joint/theta",
        "torso_lift",
    ];
    let group = both(&["shorten", &arms, "--group", "arms"]);
    let before = travel(&columns(&given, &still));
    let after = travel(&columns(&group, &still));
    assert!(
        (before - after).abs() < 1e-9 && travel(&columns(&free, &still)) < 0.5 * before,
        "{before} {after}"
    );
    assert!(group["length_after"].as_f64() < group["length_before"].as_f64());

    let shelf = config("problems/arm_shelf.json");
    let fixed = both(&["shorten", &shelf, "--fix", "2,5-6"]);
    let given = both(&["check", &shelf]);
    let rows = fixed["path"].as_array().unwrap();
    let all = given["path"].as_array().unwrap();
    assert!(fixed["length_after"].as_f64() < fixed["length_before"].as_f64());
    let mut rest = rows.iter();
    for waypoint in [0, 2, 5, 6, all.len() - 1] {
        assert!(
            rest.any(|row| row == &all[waypoint]),
            "waypoint {waypoint} is gone"
        );
    }

    let heavy = both(&[
        "shorten",
        &arms,
        "--weights",
        "reach",
        "--joint-weight",
        "base_joint=40",
    ]);
    let plain = both(&["shorten", &arms, "--weights", "reach"]);
    let weights = |answer: &Value| answer["weights"].as_array().unwrap().clone();
    assert_eq!(weights(&heavy)[..3], [40.0, 40.0, 40.0]);
    assert_eq!(weights(&heavy)[3..], weights(&plain)[3..]);
    assert!(
        heavy["metric"]
            .as_str()
            .unwrap()
            .ends_with(", base_joint 40")
    );

    let bare = both(&["shorten", &arms, "--no-contacts"]);
    assert!(
        bare["searched_m"].is_null() && bare["holds"].is_null() && bare["path"] == free["path"]
    );

    let small = both(&["shorten", &arms, "--budget", "500"]);
    assert_eq!(small["termination"], "work-budget");
    assert!(small["work"].as_u64() < plain["work"].as_u64());
}

/// A path without a column for the torso: it stands where the request says, and the certificate
/// says so too.
#[test]
fn held_joints_stand_where_the_request_says_with_a_daemon_too() {
    let place = Place::new();
    let _daemon = place.serve("");
    let given = problem("exchange_arms");
    let names: Vec<&str> = given["variables"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap())
        .collect();
    let torso = names
        .iter()
        .position(|name| *name == "torso_lift")
        .unwrap();
    let held = given["path"][0][torso].as_f64().unwrap();
    let row = |row: &Value| {
        let row = row
            .as_array()
            .unwrap()
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != torso);
        row.map(|(_, value)| value.to_string())
            .collect::<Vec<_>>()
            .join(",")
    };
    let mut lines = vec![
        names
            .iter()
            .filter(|name| **name != "torso_lift")
            .copied()
            .collect::<Vec<_>>()
            .join(","),
    ];
    lines.extend(
        given["path"].as_array().unwrap()[..2]
            .iter()
            .map(row),
    );
    let path = place.file("held.csv", &lines.join("\n"));
    let urdf = config("robots/duo.urdf");
    for value in [held, 0.11] {
        let hold = format!("torso_lift={value}");
        for command in ["check", "shorten"] {
            let arguments = [command, &path, "--robot", &urdf, "--hold", &hold];
            let local = answer(&place, &arguments, true);
            let remote = answer(&place, &arguments, false);
            assert_eq!(local, remote, "{hold}");
            assert_eq!(remote["certificate"]["held"], serde_json::json!([value]));
        }
    }
    let unknown = ["check", &path, "--robot", &urdf, "--hold", "neck=1"];
    for local in [&["--local"][..], &[]] {
        let run = place.taut(&[&unknown[..], local].concat());
        assert_eq!((run.exit, run.err.lines().count()), (65, 1), "{}", run.err);
        assert!(
            run.err.contains("\"neck\"") && run.err.contains("valid: torso_lift"),
            "{}",
            run.err
        );
    }
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
        assert_eq!(
            (header.robot_hash, header.scene_hash),
            (models.robot.robot_hash, models.scene.scene_hash)
        );
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
    assert_eq!(
        answer(
            RequestBody {
                group_mask: &none,
                ..Default::default()
            },
            None
        )
        .1,
        models.path
    );
    let fixed = vec![1; models.path.len() / nq];
    let (_, kept) = answer(
        RequestBody {
            fixed_waypoints: &fixed,
            ..Default::default()
        },
        None,
    );
    for waypoint in models.path.chunks(nq) {
        assert!(
            kept.chunks(nq).any(|row| row == waypoint),
            "a fixed waypoint is gone"
        );
    }
    let weights = vec![1.0; nq];
    let (ones, _) = answer(
        RequestBody {
            weights: &weights,
            ..Default::default()
        },
        None,
    );
    assert_ne!(ones.length_before, free.length_before);
}
