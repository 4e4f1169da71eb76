//! What a step of an angle column means, on small inputs that once gave proofs of another motion
//! than the one that a controller makes of the numbers.
#![cfg(feature = "daemon")]

mod common;

use common::{Place, Run};
use serde_json::Value;

/// Half a turn, and what files round it by.
const LONGEST_STEP: f64 = std::f64::consts::PI + 1e-3;

fn case(file: &str) -> String {
    format!("{}/tests/cases/{file}", env!("CARGO_MANIFEST_DIR"))
}

/// A verb on a path of a case's folder, in this process or by a daemon.
fn ask(
    place: &Place,
    verb: &str,
    folder: &str,
    [robot, path, scene]: [&str; 3],
    options: &[&str],
) -> Run {
    let [robot, path, scene] = [robot, path, scene].map(|file| case(&format!("{folder}/{file}")));
    place.taut(
        &[
            &[
                verb,
                path.as_str(),
                "--robot",
                robot.as_str(),
                "--scene",
                scene.as_str(),
            ],
            options,
        ]
        .concat(),
    )
}

fn answer(run: &Run) -> Value {
    serde_json::from_str(&run.out)
        .unwrap_or_else(|error| panic!("{error}: {} {}", run.out, run.err))
}

fn column(answer: &Value, column: usize) -> Vec<f64> {
    answer["path"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row[column].as_f64().unwrap())
        .collect()
}

#[test]
fn half_a_turn_goes_the_way_of_its_numbers() {
    let place = Place::new();
    let daemon = place.serve("");
    for path in ["p.csv", "rounded.csv"] {
        for options in [&["--local", "--format", "json"][..], &["--format", "json"]] {
            let run = ask(
                &place,
                "check",
                "half-turn",
                ["turn.urdf", path, "front.json"],
                options,
            );
            let answer = answer(&run);
            assert_eq!(
                (run.exit, answer["reason"].as_str()),
                (1, Some("COLLISION")),
                "{path}: {answer}"
            );
            // The arm, 0.03 m to either side of its axis, meets the pole's edge at 0.38, 0.02.
            let t = 0.5 - 0.13 / std::f64::consts::PI;
            assert!(
                (answer["t"].as_f64().unwrap() - t).abs() < 0.02,
                "{path}: {answer}"
            );
        }
    }
    drop(daemon);
}

#[test]
fn an_answer_winds_as_its_numbers_say() {
    let place = Place::new();
    let daemon = place.serve("");
    let files = ["turn.urdf", "p.csv", "pole.json"];
    for local in [&["--local"][..], &[]] {
        let table = ask(&place, "shorten", "winding-of-answer", files, local);
        assert!(
            table
                .out
                .contains("proved as unrolled, column j −1 turn   "),
            "{}",
            table.out
        );
        let out = place.folder.path().join("result.json");
        let json = ["--format", "json", "-o", out.to_str().unwrap()];
        let run = ask(
            &place,
            "shorten",
            "winding-of-answer",
            files,
            &[local, &json[..]].concat(),
        );
        let short = answer(&run);
        let turns = column(&short, 0);
        assert_eq!(
            (run.exit, short["proved"].as_bool()),
            (0, Some(true)),
            "{short}"
        );
        assert_eq!(
            turns.last(),
            Some(&(6.0 - std::f64::consts::TAU)),
            "{turns:?}"
        );
        assert_eq!(
            short["turned"],
            serde_json::json!([{ "variable": "j", "turns": -1 }])
        );
        assert!(
            short["certificate"]["segments"]
                .as_array()
                .is_some_and(|claims| claims.len() == turns.len() - 1)
        );

        let csv = place.folder.path().join("path.csv");
        let export = place.taut(&["export", out.to_str().unwrap(), "-o", csv.to_str().unwrap()]);
        let text = std::fs::read_to_string(&csv).unwrap();
        assert_eq!(export.exit, 0, "{}", export.err);
        assert!(
            text.contains("; j ends -1 turns from the goal that was given"),
            "{text}"
        );
        // What is written means itself, to whoever reads it as angles or as numbers.
        for meaning in [&["--local"][..], &["--local", "--unwrapped"]] {
            let robot = case("winding-of-answer/turn.urdf");
            let scene = case("winding-of-answer/pole.json");
            let again = [
                "check",
                csv.to_str().unwrap(),
                "--robot",
                &robot,
                "--scene",
                &scene,
            ];
            let again = place.taut(&[&again[..], meaning].concat());
            assert!(
                again.exit == 0 && !again.out.contains("unrolled"),
                "{}",
                again.out
            );
        }

        let keep = ["--format", "json", "--keep-goal"];
        let kept = answer(&ask(
            &place,
            "shorten",
            "winding-of-answer",
            files,
            &[local, &keep[..]].concat(),
        ));
        let turns = column(&kept, 0);
        assert_eq!(kept["proved"].as_bool(), Some(true), "{kept}");
        assert_eq!((turns.first(), turns.last()), (Some(&0.0), Some(&6.0)));
        assert!(
            turns
                .windows(2)
                .all(|step| (step[1] - step[0]).abs() <= LONGEST_STEP),
            "{turns:?}"
        );
        assert!(kept["turned"].as_array().unwrap().is_empty());
    }
    drop(daemon);
}

#[test]
fn a_long_step_of_an_input_is_unrolled_and_said_and_keep_goal_refuses_it() {
    let place = Place::new();
    let daemon = place.serve("");
    let robot = case("half-turn/turn.urdf");
    let scene = case("half-turn/front.json");
    // By the short way, over the back: +2 to +4.28; the numbers go over the pole.
    let path = place.file("long.csv", "j\n2\n-2\n");
    for local in [&["--local"][..], &[]] {
        let ask = |options: &[&str]| {
            let words = ["check", &path, "--robot", &robot, "--scene", &scene];
            place.taut(&[&words[..], local, options].concat())
        };
        let table = ask(&[]);
        assert!(
            table.exit == 0
                && table
                    .out
                    .starts_with("proved as unrolled, column j +1 turn   "),
            "{}",
            table.out
        );
        let turns = column(&answer(&ask(&["--format", "json"])), 0);
        assert_eq!(turns, [2.0, -2.0 + std::f64::consts::TAU]);
        let kept = ask(&["--keep-goal"]);
        assert_eq!(kept.exit, 65, "{} {}", kept.out, kept.err);
        for part in ["waypoint 1: j steps from 2 to -2", "+1 turns", "unwrapped"] {
            assert!(kept.err.contains(part), "{part}: {}", kept.err);
        }
        assert_eq!(ask(&["--unwrapped"]).exit, 1);
    }
    // The certificate is about the numbers that were proved, and says so of the file's.
    let proof = place.folder.path().join("proof.json");
    let words = ["check", &path, "--robot", &robot, "--scene", &scene];
    let made = place.taut(
        &[
            &words[..],
            &["--local", "--write-certificate", proof.to_str().unwrap()],
        ]
        .concat(),
    );
    assert_eq!(made.exit, 0, "{}", made.err);
    let verified = place.taut(&[&words[..], &["--certificate", proof.to_str().unwrap()]].concat());
    assert_eq!(verified.exit, 0, "{} {}", verified.out, verified.err);
    drop(daemon);
}

#[test]
fn a_joint_that_a_screw_follows_is_no_angle() {
    let place = Place::new();
    let daemon = place.serve("");
    for local in [&["--local"][..], &[]] {
        for files in [
            ["rack.urdf", "rack_path.csv", "post.json"],
            ["rack.urdf", "at_end.csv", "post.json"],
            ["rack.urdf", "reverse.csv", "post.json"],
            ["half.urdf", "reverse.csv", "post.json"],
            ["gear.urdf", "p.csv", "front.json"],
        ] {
            let run = ask(&place, "check", "mimic-of-continuous", files, local);
            assert!(
                run.exit == 1 && run.out.starts_with("COLLISION"),
                "{files:?}: {} {}",
                run.out,
                run.err
            );
        }
        let over = ["gantry.urdf", "over.csv", "wall.json"];
        let options = [local, &["--format", "json"][..]].concat();
        let lifted = answer(&ask(
            &place,
            "shorten",
            "mimic-of-continuous",
            over,
            &options,
        ));
        let unwrapped = [&options[..], &["--unwrapped"]].concat();
        let unwrapped = answer(&ask(
            &place,
            "shorten",
            "mimic-of-continuous",
            over,
            &unwrapped,
        ));
        assert_eq!(lifted["path"], unwrapped["path"]);
        assert_eq!(
            (lifted["proved"].as_bool(), column(&lifted, 0).last()),
            (Some(true), Some(&40.0)),
            "{lifted}"
        );
        let length = lifted["length_after"].as_f64().unwrap();
        assert!((length - 0.5353).abs() < 2e-3, "{length}");
        assert!(
            lifted["smallest_clearance"]["amount"]
                .as_f64()
                .unwrap()
                > 1e-3,
            "{lifted}"
        );
    }
    drop(daemon);
}

#[test]
fn ends_and_fixed_waypoints_keep_their_bits_where_no_turn_is_left() {
    let place = Place::new();
    let robot = case("half-turn/turn.urdf");
    // The second step is a long one, so that what follows is a turn on: and back again where the
    // answer goes straight.
    let path = place.file("back.csv", "j\n0.5\n3\n-3\n-0.9\n-0.3\n");
    for (fixed, kept) in [("0", &[-0.3][..]), ("0,3", &[-0.9, -0.3])] {
        for mode in [
            "hybrid",
            "contact",
            "gradient",
            "random-shortcut",
            "partial-shortcut",
        ] {
            let words = [
                "shorten", &path, "--robot", &robot, "--local", "--format", "json",
            ];
            let short =
                answer(&place.taut(&[&words[..], &["--fix", fixed, "--mode", mode]].concat()));
            let turns = column(&short, 0);
            assert_eq!(
                (turns.first(), short["proved"].as_bool()),
                (Some(&0.5), Some(true)),
                "{mode}: {short}"
            );
            for kept in kept {
                let whole = |x: &f64| {
                    *x == kept
                        + ((x - kept) / std::f64::consts::TAU).round() * std::f64::consts::TAU
                };
                assert!(
                    turns.iter().any(whole),
                    "{mode}: {kept} is not in {turns:?}"
                );
            }
            assert!(
                !mode.ends_with("shortcut") || turns.ends_with(kept),
                "{mode}: {turns:?}"
            );
        }
    }
}

#[test]
fn what_is_refused_says_that_it_was_read_as_unrolled() {
    let place = Place::new();
    let daemon = place.serve("");
    let robot = case("half-turn/turn.urdf");
    let scene = case("half-turn/front.json");
    // By the short way it goes down over the pole.
    let path = place.file("over.csv", "j\n1\n5.5\n");
    for local in [&["--local"][..], &[]] {
        let run = place.taut(
            &[
                &["check", &path, "--robot", &robot, "--scene", &scene],
                local,
            ]
            .concat(),
        );
        let says = run.out.starts_with("COLLISION")
            && run
                .out
                .contains("   read as unrolled, column j −1 turn   ");
        assert!(run.exit == 1 && says, "{}", run.out);
    }
    drop(daemon);
}

#[test]
fn a_motion_that_no_proof_ends_of_is_refused_in_words() {
    let place = Place::new();
    let daemon = place.serve("");
    let far = place.file("far.csv", "j\n0\n2e9\n");
    let turn = case("half-turn/turn.urdf");
    let rack = case("mimic-of-continuous/rack.urdf");
    for (robot, unwrapped) in [(&turn, &["--unwrapped"][..]), (&rack, &[])] {
        for local in [&["--local"][..], &[]] {
            let run = place.taut(&[&["check", &far, "--robot", robot], unwrapped, local].concat());
            assert_eq!(run.exit, 65, "{} {}", run.out, run.err);
            for part in [
                "waypoint 1",
                "by then j has moved by 2e9",
                "more than 1e6 rad or m",
                "split the path",
            ] {
                assert!(run.err.contains(part), "{part}: {}", run.err);
            }
        }
    }
    let angle = place.taut(&["check", &far, "--robot", &turn, "--local"]);
    assert!(
        angle.exit == 65 && angle.err.contains("beyond 1e9 rad"),
        "{}",
        angle.err
    );
    drop(daemon);
}

#[test]
fn only_numbers_that_were_proved_are_written_as_proved() {
    let place = Place::new();
    let files = ["turn.urdf", "p.csv", "pole.json"];
    let out = place.folder.path().join("result.json");
    let out = out.to_str().unwrap();
    let run = ask(
        &place,
        "shorten",
        "winding-of-answer",
        files,
        &["--local", "-o", out],
    );
    assert_eq!(run.exit, 0, "{}", run.err);
    let proved: Value = serde_json::from_str(&std::fs::read_to_string(out).unwrap()).unwrap();
    // As it was written before a step meant its numbers, and by someone who puts the goal back.
    let mut before = proved.clone();
    before["certificate"]["checker_version"] = 2.into();
    let mut changed = proved.clone();
    *changed["path"]
        .as_array_mut()
        .unwrap()
        .last_mut()
        .unwrap() = serde_json::json!([6.0, 0.0]);
    for (result, part) in [
        (before, "by checker version 2"),
        (changed, "not the one that its certificate is about"),
    ] {
        let file = place.file("changed.json", &result.to_string());
        for form in ["csv", "yaml", "mcap"] {
            let written = place.folder.path().join(format!("path.{form}"));
            let export = place.taut(&["export", &file, "-o", written.to_str().unwrap()]);
            assert!(
                export.exit == 65 && export.err.contains(part),
                "{form}: {} {}",
                export.exit,
                export.err
            );
            assert!(!written.exists(), "{form}");
        }
    }
}

#[test]
fn a_path_that_comes_back_to_its_start_is_shortened() {
    let place = Place::new();
    let robot = case("half-turn/turn.urdf");
    let scene = case("half-turn/front.json");
    // By angles that need no turn; by the short way, which a long step is.
    for path in ["j\n2\n3\n2\n", "j\n2\n-2\n2\n"] {
        let path = place.file("loop.csv", path);
        for mode in [
            "check",
            "hybrid",
            "contact",
            "gradient",
            "random-shortcut",
            "partial-shortcut",
        ] {
            let words = [
                "shorten",
                &path,
                "--robot",
                &robot,
                "--scene",
                &scene,
                "--local",
                "--keep-goal",
            ];
            let run = place.taut(&[&words[..], &["--mode", mode, "--format", "json"]].concat());
            let short = answer(&run);
            let turns = column(&short, 0);
            assert_eq!(
                (run.exit, short["proved"].as_bool()),
                (0, Some(true)),
                "{mode}: {short}"
            );
            assert_eq!(
                (turns.first(), turns.last()),
                (Some(&2.0), Some(&2.0)),
                "{mode}"
            );
            let length = short["length_after"].as_f64().unwrap();
            assert!(
                mode == "check" || mode == "gradient" || length == 0.0,
                "{mode}: {length}"
            );
        }
    }
}
