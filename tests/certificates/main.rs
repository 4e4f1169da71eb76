//! Certificates as files: written by one process, verified by another, refused once anything is
//! changed.
#![cfg(feature = "daemon")]

#[path = "../common/mod.rs"]
mod common;
mod trajectories;

use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::*;
use serde_json::Value;

fn data(name: &str) -> String {
    let file: std::path::PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests/data", name]
        .iter()
        .collect();
    file.to_str().unwrap().to_owned()
}

fn problem(name: &str) -> String {
    config(&format!("problems/{name}.json"))
}

fn read(file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

/// A problem of `config/` after a change, with its robot where it was.
fn changed_problem(place: &Place, name: &str, change: impl FnOnce(&mut Value)) -> String {
    let mut value = read(&problem(name));
    for file in ["urdf", "srdf"] {
        let relative = value["robot"][file].as_str().unwrap();
        value["robot"][file] = config(&format!("problems/{relative}")).into();
    }
    change(&mut value);
    static CHANGED: AtomicUsize = AtomicUsize::new(0);
    let number = CHANGED.fetch_add(1, Ordering::Relaxed);
    place.file(&format!("changed_{number}.json"), &value.to_string())
}

fn move_waypoint(value: &mut Value) {
    let number = &mut value["path"][2][0];
    *number = (number.as_f64().unwrap() + 1e-6).into();
}

#[test]
fn every_shipped_problem_and_its_shortened_path_is_verified() {
    let place = Place::new();
    for name in PROBLEMS {
        let proof = place.file("proof.json", "");
        let file = problem(name);
        assert_eq!(
            place
                .taut(&["check", &file, "--local", "--write-certificate", &proof])
                .exit,
            0
        );
        let run = place.taut(&["check", &file, "--certificate", &proof]);
        assert_eq!((run.exit, run.err.as_str()), (0, ""), "{name}: {}", run.out);
        assert!(
            run.out.starts_with("verified   ") && run.out.contains(" segments, clearance ≥ "),
            "{}",
            run.out
        );

        for command in ["check", "shorten"] {
            let answer = place.taut(&[command, &file, "--local", "--format", "json"]);
            let proof = place.file("answer.json", &answer.out);
            let run = place.taut(&["check", &file, "--certificate", &proof, "--format", "json"]);
            assert_eq!(
                (run.exit, run.json()["verified"].as_bool()),
                (0, Some(true)),
                "{name}: {}",
                run.out
            );
            assert_eq!(
                run.json()["segments"].as_u64(),
                answer.json()["path"]
                    .as_array()
                    .map(|p| p.len() as u64 - 1)
            );
        }
    }
}

#[test]
fn a_certificate_that_came_through_the_daemon_is_verified_without_it() {
    let place = Place::new();
    let daemon = place.serve("");
    let answer = place.taut(&["shorten", &problem("arm_window"), "--format", "json"]);
    let proof = place.file("answer.json", &answer.out);
    daemon.kill();
    let run = place.taut(&["check", &problem("arm_window"), "--certificate", &proof]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
}

/// These files were made once and stay as they are: a build that refuses them breaks what it
/// promised.
#[test]
fn certificates_of_an_earlier_build_are_verified() {
    let place = Place::new();
    for (name, proof) in [
        ("arm_shelf", "arm_shelf.certificate.json"),
        ("corner", "corner.shortened.json"),
    ] {
        let run = place.taut(&["check", &problem(name), "--certificate", &data(proof)]);
        assert_eq!((run.exit, run.err.as_str()), (0, ""), "{name}: {}", run.out);
    }
    // Checker version 1 knew no digest.
    let mut old = read(&data("arm_shelf.certificate.json"));
    old["checker_version"] = 1.into();
    old.as_object_mut()
        .unwrap()
        .remove("digest")
        .unwrap();
    let old = place.file("old.json", &old.to_string());
    assert_eq!(
        place
            .taut(&["check", &problem("arm_shelf"), "--certificate", &old])
            .exit,
        0
    );
}

#[test]
fn a_forged_certificate_is_refused_in_one_line_that_says_why() {
    let place = Place::new();
    let file = problem("arm_shelf");
    let honest = data("arm_shelf.certificate.json");
    let changes: [(&str, Change, &str); 8] = [
        (
            "raised",
            |c| c["segments"][3]["clearance_m"] = 0.05.into(),
            "changed after the proof",
        ),
        (
            "raised a little",
            |c| c["segments"][3]["clearance_m"] = raised(c, 1e-6),
            "changed after the proof",
        ),
        (
            "floor",
            |c| c["clearance_m"] = 0.0011.into(),
            "changed after the proof",
        ),
        (
            "dropped",
            |c| drop(c["segments"].as_array_mut().unwrap().remove(2)),
            "changed after the proof",
        ),
        (
            "swapped",
            |c| c["segments"].as_array_mut().unwrap().swap(0, 1),
            "changed after the proof",
        ),
        (
            "newer",
            |c| c["checker_version"] = 99.into(),
            "checker version 99",
        ),
        // As someone does who gets rid of the digest: what is left is measured.
        (
            "measured",
            |c| old(c, |c| c["segments"][3]["clearance_m"] = 0.05.into()),
            " m apart, claimed 0.05 m",
        ),
        (
            "nothing near",
            |c| old(c, |c| c["segments"][3]["clearance_m"] = Value::Null),
            "nothing can collide",
        ),
    ];
    for (what, change, reason) in changes {
        let mut forged = read(&honest);
        change(&mut forged);
        let forged = place.file("forged.json", &forged.to_string());
        let run = place.taut(&["check", &file, "--certificate", &forged]);
        assert_eq!((run.exit, run.err.as_str()), (2, ""), "{what}: {}", run.out);
        assert!(
            run.out.starts_with("UNCERTIFIED ") && run.out.contains(reason),
            "{what}: {}",
            run.out
        );
        assert_eq!(run.out.lines().count(), 1, "{}", run.out);
        let run = place.taut(&["check", &file, "--certificate", &forged, "--format", "json"]);
        assert_eq!(
            (run.exit, run.json()["code"].as_i64()),
            (2, Some(-1001)),
            "{what}: {}",
            run.out
        );
        assert!(
            run.json()["reason"]
                .as_str()
                .unwrap()
                .contains(reason),
            "{what}: {}",
            run.out
        );
    }
}

type Change = fn(&mut Value);

fn raised(certificate: &Value, by: f64) -> Value {
    (certificate["segments"][3]["clearance_m"]
        .as_f64()
        .unwrap()
        + by)
        .into()
}

fn old(certificate: &mut Value, change: impl FnOnce(&mut Value)) {
    certificate["checker_version"] = 1.into();
    certificate
        .as_object_mut()
        .unwrap()
        .remove("digest")
        .unwrap();
    change(certificate);
}

#[test]
fn a_certificate_of_another_path_robot_or_scene_is_refused() {
    let place = Place::new();
    let honest = data("arm_shelf.certificate.json");
    let refused = |file: &str, proof: &str, reason: &str| {
        let run = place.taut(&["check", file, "--certificate", proof]);
        assert_eq!((run.exit, run.err.as_str()), (2, ""), "{}", run.out);
        assert!(
            run.out.starts_with("UNCERTIFIED ") && run.out.contains(reason),
            "{reason}: {}",
            run.out
        );
    };
    let moved = changed_problem(&place, "arm_shelf", move_waypoint);
    refused(&moved, &honest, "about the path with hash");
    let scene = changed_problem(&place, "arm_shelf", |problem| {
        let position = &mut problem["scene"]["objects"][0]["primitive_poses"][0]["position"][0];
        *position = (position.as_f64().unwrap() - 1e-6).into();
    });
    refused(&scene, &honest, "about the scene with hash");
    refused(&problem("corner"), &honest, "about the robot with hash");
    // An answer's own path, too.
    let mut answer = read(&data("corner.shortened.json"));
    move_waypoint(&mut answer);
    refused(
        &problem("corner"),
        &place.file("answer.json", &answer.to_string()),
        "about the path with hash",
    );
    // Its ends are the problem's: another problem of the same robot and scene is not answered by
    // it.
    let ends = changed_problem(&place, "corner", |problem| {
        problem["path"].as_array_mut().unwrap().pop();
    });
    refused(&ends, &data("corner.shortened.json"), "other ends");
    // A problem whose path was changed is not what the check's answer was about.
    let answer = place
        .taut(&[
            "check",
            &problem("arm_shelf"),
            "--local",
            "--format",
            "json",
        ])
        .out;
    refused(
        &moved,
        &place.file("answer.json", &answer),
        "about the path with hash",
    );
}

#[test]
fn what_cannot_be_verified_is_an_error_and_not_a_verdict() {
    let place = Place::new();
    let file = problem("arm_shelf");
    let honest = data("arm_shelf.certificate.json");
    let unproved = place.file("unproved.json", r#"{"mode": "check", "certificate": null}"#);
    let garbage = place.file("garbage.json", "{");
    for (arguments, exit, part) in [
        (vec!["--certificate", "nowhere.json"], 66, "nowhere.json: "),
        (
            vec!["--certificate", &garbage],
            65,
            "garbage.json: not a certificate",
        ),
        (
            vec!["--certificate", &file],
            65,
            "missing field `checker_version`",
        ),
        (
            vec!["--certificate", &unproved],
            65,
            "its path was not proved",
        ),
        (
            vec!["--certificate", &honest, &problem("corner")],
            64,
            "give one",
        ),
        (
            vec!["--certificate", &honest, "--clearance", "2mm"],
            64,
            "cannot be used with",
        ),
        (
            vec!["--write-certificate", "proof.json", &problem("corner")],
            64,
            "give one",
        ),
    ] {
        let run = place.taut(&[&["check", file.as_str()], &arguments[..]].concat());
        assert_eq!(
            (run.exit, run.out.as_str(), run.err.lines().count()),
            (exit, "", 1),
            "{arguments:?}: {}",
            run.err
        );
        assert!(run.err.contains(part), "{}", run.err);
    }
    let run = place.taut(&[
        "check",
        &file,
        "--certificate",
        &honest,
        "--deadline",
        "1us",
    ]);
    assert_eq!(run.exit, 2, "{}{}", run.out, run.err);
    assert!(
        run.out.starts_with("TIMED_OUT ") && run.out.contains("stopped before"),
        "{}",
        run.out
    );
}

/// A segment between equal waypoints is a segment: each has its claim, and the path may be the
/// caller's, bit for bit.
#[test]
fn repeated_waypoints_have_claims_of_their_own() {
    let place = Place::new();
    let repeated = changed_problem(&place, "arm_shelf", |problem| {
        let path = problem["path"].as_array_mut().unwrap();
        for index in [path.len() - 1, 3, 3, 0] {
            let same = path[index].clone();
            path.insert(index, same);
        }
    });
    let proof = place.file("proof.json", "");
    let run = place.taut(&["check", &repeated, "--local", "--write-certificate", &proof]);
    assert_eq!(run.exit, 0, "{}", run.err);
    let segments = read(&proof)["segments"].clone();
    let plain = read(&data("arm_shelf.certificate.json"));
    assert_eq!(
        segments.as_array().unwrap().len(),
        plain["segments"].as_array().unwrap().len() + 4
    );
    let run = place.taut(&["check", &repeated, "--certificate", &proof]);
    assert_eq!(run.exit, 0, "{}", run.out);
}
