//! The command line as people and scripts use it: exit codes, one-line errors, JSON.
#![cfg(feature = "daemon")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Run {
    exit: i32,
    out: String,
    err: String,
}

impl Run {
    fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            exit: output.status.code().unwrap(),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }
}

fn taut(arguments: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taut"));
    Run::of(command.args(arguments).output().unwrap())
}

fn config(name: &str) -> String {
    let file: PathBuf = [env!("CARGO_MANIFEST_DIR"), "config", name]
        .iter()
        .collect();
    file.to_str().unwrap().to_owned()
}

/// Writes a path of the shelf's arm that goes straight from its first waypoint to its last.
fn straight_line(folder: &Path) -> String {
    let text = fs::read_to_string(config("problems/arm_shelf.json")).unwrap();
    let problem: serde_json::Value = serde_json::from_str(&text).unwrap();
    let path = problem["path"].as_array().unwrap();
    let line = serde_json::json!({ "variables": problem["variables"], "path": [path.first(), path.last()] });
    let file = folder.join("line.json");
    fs::write(&file, line.to_string()).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn a_proved_path_exits_with_0_and_a_colliding_one_with_1_and_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let problem = config("problems/arm_shelf.json");
    let run = taut(&["check", &problem, "--local"]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""));
    assert!(
        run.out.starts_with("proved   clearance ≥ ") && run.out.lines().count() == 2,
        "{}",
        run.out
    );
    assert!(
        run.out
            .lines()
            .nth(1)
            .unwrap()
            .starts_with("  nearest  link6 × shelf_middle, 5."),
        "{}",
        run.out
    );

    let line = straight_line(folder.path());
    for source in [
        vec!["--problem", problem.as_str()],
        vec![
            "--robot",
            &config("robots/panda_like.urdf"),
            "--scene",
            &config("scenes/arm_shelf.json"),
        ],
    ] {
        let run = taut(&[&["check", line.as_str(), "--local"], source.as_slice()].concat());
        assert_eq!(run.exit, 1, "{}", run.err);
        assert!(
            run.out
                .starts_with("COLLISION segment 1 of 1, t = 0.")
                && run.out.contains(" × shelf_middle, depth ")
        );
    }
    let several = taut(&["check", &problem, &config("problems/rooms.json"), "--local"]);
    assert_eq!((several.exit, several.out.lines().count()), (0, 2));
    assert!(
        several.out.contains("arm_shelf: proved") && several.out.contains("rooms: proved"),
        "{}",
        several.out
    );
}

#[test]
fn json_is_one_object_with_every_field() {
    let folder = tempfile::tempdir().unwrap();
    let problem = config("problems/arm_shelf.json");
    let out = folder.path().join("answer.json");
    let run = taut(&[
        "shorten",
        &problem,
        "--local",
        "--format",
        "json",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(run.exit, 0, "{}", run.err);
    let answer: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(fs::read_to_string(&out).unwrap(), run.out);
    for field in [
        "name",
        "mode",
        "geometry",
        "proved",
        "code",
        "length_before",
        "length_after",
        "lower_bound",
        "gap",
        "metric",
        "searched_m",
        "smallest_clearance",
        "holds",
        "pinched",
        "stage",
        "stages",
        "variables",
        "path",
        "weights",
        "clearance_m",
        "floor_m",
        "floors_lowered",
        "cpu_s",
        "time_s",
        "iterations",
        "work",
        "termination",
        "certificate",
        "warnings",
    ] {
        assert!(answer.get(field).is_some(), "no {field}");
    }
    assert_eq!(
        (answer["code"].as_i64(), answer["proved"].as_bool()),
        (Some(1), Some(true))
    );
    assert!(answer["length_after"].as_f64() <= answer["length_before"].as_f64());
    let number = |field: &str| answer[field].as_f64().unwrap();
    assert_eq!(
        number("gap"),
        number("length_after") / number("lower_bound") - 1.0
    );
    let gained: f64 = answer["stages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|stage| stage["gain"].as_f64().unwrap())
        .sum();
    assert!(
        (gained - (number("length_before") - number("length_after"))).abs() < 1e-9,
        "{gained}"
    );
    let smallest = &answer["smallest_clearance"];
    for hold in answer["holds"].as_array().unwrap() {
        assert!(hold["amount"].as_f64() >= smallest["amount"].as_f64());
        let [a, b] = [0, 1].map(|i| [0, 1, 2].map(|k| hold["points"][i][k].as_f64().unwrap()));
        let apart = [0, 1, 2]
            .map(|k| a[k] - b[k])
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt();
        assert!(
            (apart - hold["amount"].as_f64().unwrap()).abs() < 1e-9,
            "{hold}"
        );
    }
    assert_eq!(
        taut(&[
            "check",
            out.to_str().unwrap(),
            "--problem",
            &problem,
            "--local"
        ])
        .exit,
        0
    );
    // An answer is a bare path itself.
    assert_eq!(
        taut(&[
            "check",
            out.to_str().unwrap(),
            "--problem",
            &problem,
            "--local"
        ])
        .exit,
        0
    );

    // And a file of its own kind, that says what it is about and loses nothing when it is read.
    let result = taut::files::ResultFile::read(&out).unwrap();
    let written: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!(serde_json::to_value(&result).unwrap(), written);
    let given: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&problem).unwrap()).unwrap();
    assert_eq!(
        (&written["path_before"], &written["format"]),
        (&given["path"], &"taut-result/1".into())
    );
    let last = result.lengths_over_time.last().unwrap();
    let after = result.length_after;
    assert!(
        result
            .lengths_over_time
            .is_sorted_by(|a, b| a.0 <= b.0 && a.1 > b.1)
            && last.1 == after,
        "{last:?}"
    );
    let content = result.subject.scene.content.clone().unwrap();
    let scene = content
        .build(&mut |name, _| panic!("the mesh {name} is not in the result"))
        .unwrap();
    assert_eq!(format!("{:016x}", scene.hash()), result.subject.scene.hash);
    assert!(
        result
            .subject
            .robot
            .files
            .as_ref()
            .is_some_and(|files| files.urdf.is_absolute())
    );

    let line = straight_line(folder.path());
    let run = taut(&[
        "check",
        &line,
        "--problem",
        &problem,
        "--format",
        "json",
        "--local",
    ]);
    let refused: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(
        (refused["code"].as_i64(), refused["segment"].as_u64()),
        (Some(-2), Some(0))
    );
    for field in [
        "t",
        "kind",
        "names",
        "amount",
        "allowed",
        "unit",
        "points",
        "normal",
        "proved_prefix",
    ] {
        assert!(refused.get(field).is_some(), "no {field}");
    }
}

#[test]
fn errors_are_one_line_with_their_own_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let line = straight_line(folder.path());
    let broken = folder.path().join("broken.json");
    fs::write(&broken, "{ \"format\": \"taut-problem/1\",\n \"name\": }").unwrap();
    let no_robot = folder.path().join("none.urdf");
    for (arguments, exit, parts) in [
        (
            vec!["check", "nowhere.json"],
            66,
            ["nowhere.json", "No such file"],
        ),
        (
            vec!["check", broken.to_str().unwrap()],
            65,
            ["broken.json", "line 2"],
        ),
        (vec!["check", &line], 64, ["bare path", "--robot"]),
        (
            vec!["check", &line, "--robot", no_robot.to_str().unwrap()],
            66,
            ["none.urdf", "No such file"],
        ),
        (
            vec!["check", &line, "--robot", &config("robots/disc.urdf")],
            65,
            ["line.json", "joint1"],
        ),
        (
            vec!["check", &line, "--problem", &config("problems/rooms.json")],
            65,
            ["line.json", "valid: x, y"],
        ),
    ] {
        let run = taut(&[&arguments[..], &["--local"]].concat());
        assert_eq!(
            (run.exit, run.out.as_str()),
            (exit, ""),
            "{arguments:?}: {}",
            run.err
        );
        assert!(
            run.err.lines().count() == 1 && parts.iter().all(|part| run.err.contains(part)),
            "{}",
            run.err
        );
    }
    assert_eq!(taut(&["shorten", &line, "--mode", "best"]).exit, 64);
    assert_eq!(taut(&["check", &line, "--clearance", "1 inch"]).exit, 64);
    assert_eq!(taut(&["--help"]).exit, 0);
}

#[test]
fn a_shortened_path_says_how_good_it_is_and_what_holds_it() {
    let run = taut(&["shorten", &config("problems/arm_shelf.json"), "--local"]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""));
    let heads: Vec<&str> = run
        .out
        .lines()
        .skip(1)
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    for head in ["bound", "nearest", "held", "stages", "ended"] {
        assert!(heads.contains(&head), "no {head}: {}", run.out);
    }
    assert!(
        run.out.contains(", gap ") && run.out.contains("lengths in metres of reach"),
        "{}",
        run.out
    );
    assert!(
        run.out.contains(" × shelf_") && run.out.contains("converged, found by "),
        "{}",
        run.out
    );
}

#[test]
fn names_and_numbers_that_do_not_exist_are_told_with_the_valid_ones() {
    let arms = config("problems/exchange_arms.json");
    for (arguments, exit, parts) in [
        (
            ["--group", "legs"],
            65,
            [
                "\"legs\" is no group",
                "valid: base, torso, left_arm, right_arm, arms",
            ],
        ),
        (
            ["--fix", "0,99"],
            65,
            ["names waypoint 99", "waypoints 0 to "],
        ),
        (
            ["--joint-weight", "elbow=2"],
            65,
            ["\"elbow\" is no joint", "valid: base_joint/x, base_joint/y"],
        ),
        (
            ["--hold", "torso_lift=0"],
            65,
            ["it is a column of the path", "valid: none"],
        ),
        (["--hold", "torso_lift"], 64, ["NAME=VALUE", "--hold"]),
        (
            ["--joint-weight", "torso_lift=0"],
            64,
            ["greater than 0", "--joint-weight"],
        ),
        (["--fix", "3-1"], 64, ["0,3,7-9", "--fix"]),
        (["--budget", "0"], 64, ["--budget", "1"]),
    ] {
        let run = taut(&[&["shorten", &arms, "--local"], &arguments[..]].concat());
        assert_eq!(
            (run.exit, run.out.as_str()),
            (exit, ""),
            "{arguments:?}: {}",
            run.err
        );
        assert!(
            run.err.lines().count() == 1 && parts.iter().all(|part| run.err.contains(part)),
            "{}",
            run.err
        );
    }
}

/// A folder with nothing but this build's `taut`.
fn alone() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(env!("CARGO_BIN_EXE_taut"), folder.path().join("taut")).unwrap();
    folder
}

fn bench(folder: &Path) -> Run {
    let mut command = Command::new(folder.join("taut"));
    command
        .args(["bench", "FOLDER", "--at", "1ms", "--help"])
        .env("PATH", "");
    Run::of(command.output().unwrap())
}

#[test]
fn a_bench_is_the_program_beside_or_one_line_says_how_to_get_it() {
    let folder = alone();
    let run = bench(folder.path());
    assert_eq!(
        (run.exit, run.out.as_str(), run.err.lines().count()),
        (67, "", 1)
    );
    assert!(
        run.err.contains("taut-bench")
            && run
                .err
                .contains("`cargo install --path benches`"),
        "{}",
        run.err
    );

    let program = folder.path().join("taut-bench");
    fs::write(&program, "#!/bin/sh\necho \"$@\"\nexit 3\n").unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let run = bench(folder.path());
    assert_eq!(
        (run.exit, run.out.as_str()),
        (3, "bench FOLDER --at 1ms --help\n"),
        "{}",
        run.err
    );
}
