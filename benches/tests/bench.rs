//! `taut-bench bench` on the shipped problems: its figures agree with each other, and with those of a
//! run before.

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{Run, TAUT_BENCH, config, taut};
use serde_json::Value;

fn bench(arguments: &[&str]) -> Run {
    Run::of(
        Command::new(TAUT_BENCH)
            .arg("bench")
            .args(arguments)
            .output()
            .unwrap(),
    )
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn list(value: &Value) -> &Vec<Value> {
    value
        .as_array()
        .unwrap_or_else(|| panic!("{value} is no list"))
}

/// A folder with two sets of one family, with recorded answers of two peers: one much shorter, one
/// as given.
fn family() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (set, name) in [("tiny_a", "corner"), ("tiny_b", "rooms")] {
        let mut problem = problem(name);
        let rows = list(&problem["path"]).clone();
        // The robot's and the meshes' files lie where they lay.
        problem["robot"]["urdf"] = Value::from(config(&format!(
            "problems/{}",
            problem["robot"]["urdf"].as_str().unwrap()
        )));
        if let Some(srdf) = problem["robot"]["srdf"].as_str() {
            problem["robot"]["srdf"] = Value::from(config(&format!("problems/{srdf}")));
        }
        let length = input_length(&format!("problems/{name}.json"));
        problem["peers"] = serde_json::json!({
            "short/one": { "length": 0.01 * length, "cpu_s": 0.5, "honest": false },
            "same/path": { "length": length, "cpu_s": 0.002, "honest": true, "path": rows },
        });
        problem["best_honest_peer"] =
            serde_json::json!({ "name": "same/path", "length": length, "cpu_s": 0.002 });
        problem["mesh_check"] =
            serde_json::json!({ "raw": { "samples_in_collision": 3, "samples": 9 } });
        fs::create_dir(folder.path().join(set)).unwrap();
        fs::write(folder.path().join(set).join("0.json"), problem.to_string()).unwrap();
    }
    folder
}

/// A shipped problem.
fn problem(name: &str) -> Value {
    let text = fs::read_to_string(config(&format!("problems/{name}.json"))).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Length of a shipped problem's path in its own metric.
fn input_length(problem: &str) -> f64 {
    let run = Command::new(taut())
        .args(["check", &config(problem), "--local", "--format", "json"])
        .output()
        .unwrap();
    number(&Run::of(run).json()["length_before"])
}

#[test]
fn every_curve_falls_from_the_input_to_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("curves.svg");
    let budgets = [
        "--at",
        "0us,1ms,1000s",
        "--repeat",
        "2",
        "--svg",
        picture.to_str().unwrap(),
    ];
    let run = bench(
        &[
            &[config("problems").as_str(), "--format", "json"],
            &budgets[..],
        ]
        .concat(),
    );
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    let report = run.json();
    assert!(number(&report["calibration_s"]) > 0.0);
    assert_eq!(report["budgets_s"], serde_json::json!([0.0, 1e-3, 1000.0]));
    let rows = list(&report["rows"]);
    assert!(rows.len() > 2);
    let mut improvements = 0;
    for (row, mode, answer) in rows.iter().flat_map(|row| {
        row["answers"]
            .as_object()
            .unwrap()
            .iter()
            .map(move |(mode, answer)| (row, mode, answer))
    }) {
        let what = format!("{} {mode}", row["name"]);
        let curve: Vec<[f64; 2]> = list(&answer["curve"])
            .iter()
            .map(|step| [number(&step[0]), number(&step[1])])
            .collect();
        assert_eq!(curve[0], [0.0, number(&row["length_before"])], "{what}");
        assert!(
            curve
                .windows(2)
                .all(|pair| pair[0][0] <= pair[1][0] && pair[0][1] > pair[1][1]),
            "{what}: {curve:?}"
        );
        let [end_s, length] = curve[curve.len() - 1];
        assert_eq!(length, number(&answer["length"]), "{what}");
        assert!(end_s <= number(&answer["time_s"]), "{what}");
        let at: Vec<f64> = list(&answer["ratio_at"])
            .iter()
            .map(number)
            .collect();
        assert_eq!((at[0], at[2]), (1.0, number(&answer["ratio"])), "{what}");
        assert_eq!(
            answer["first_improvement_s"].as_f64(),
            curve.get(1).map(|step| step[0]),
            "{what}"
        );
        assert_eq!(
            (
                number(&answer["runs"]),
                answer["path_hash"].as_str().unwrap().len()
            ),
            (2.0, 16),
            "{what}"
        );
        assert!(
            number(&answer["idle_travel"]) <= number(&answer["idle_travel_before"]) + 1e-9,
            "{what}"
        );
        improvements += curve.len() - 1;
        // The base ends where it starts; its planner sent it around.
        if row["name"] == "exchange_arms" && mode == "gradient" {
            let [before, after] =
                ["idle_travel_before", "idle_travel"].map(|name| number(&answer[name]));
            assert!(before > 2.0 && after < 0.2 * before, "{before} → {after}");
        }
    }
    assert!(improvements > 10);
    let modes = report["sets"][0]["modes"].as_object().unwrap();
    assert!(!modes.contains_key("check") && modes.contains_key("gradient"));
    for figures in modes.values() {
        assert_eq!(figures["ratio_at"][2]["median"], figures["ratio"]);
    }

    let text = fs::read_to_string(&picture).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let has_class = |class: &str| {
        document
            .descendants()
            .any(|node| node.attribute("class") == Some(class))
    };
    assert!((0..modes.len()).all(|mode| has_class(&format!("mode m{mode}"))));
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

#[test]
fn peers_are_compared_by_path_by_set_and_by_family() {
    let folder = family();
    let folder = folder.path().to_str().unwrap();
    let modes = ["--repeat", "1", "--modes", "gradient,partial-shortcut"];
    let report = bench(
        &[
            &[folder, "--format", "json", "--geometry", "given"],
            &modes[..],
        ]
        .concat(),
    )
    .json();
    let names = |list: &Value| -> Vec<String> {
        self::list(list)
            .iter()
            .map(|summary| summary["set"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(names(&report["sets"]), ["tiny_a", "tiny_b"]);
    assert_eq!(names(&report["pooled"]), ["tiny (pooled)"]);
    let pooled = &report["pooled"][0];
    let [short, same] = ["short/one", "same/path"].map(|name| &pooled["peers"][name]);
    assert_eq!(
        (
            number(&short["answers"]),
            number(&short["valid"]),
            number(&same["valid"])
        ),
        (2.0, 0.0, 2.0)
    );
    assert!(
        (number(&same["ratio"]) - 1.0).abs() < 1e-9
            && (number(&short["ratio_mean"]) - 0.01).abs() < 1e-9
    );
    let tally = |counts: &Value| ["wins", "ties", "losses"].map(|name| number(&counts[name]));
    assert_eq!(tally(&short["ours"]["gradient"]["end"]), [0.0, 0.0, 2.0]);
    assert_eq!(tally(&same["ours"]["gradient"]["end"]), [2.0, 0.0, 0.0]);
    let versus = &pooled["modes"]["gradient"]["over_best_honest_peer"]["end"];
    assert_eq!(tally(versus), [2.0, 0.0, 0.0]);
    assert!(
        number(&versus["worst"]["value"]) < 1.0
            && versus["worst"]["problem"]
                .as_str()
                .unwrap()
                .ends_with("/0")
    );
    assert_eq!(
        pooled["mesh_check"]["recorded"]["raw"],
        serde_json::json!({ "collide": 2, "of": 2 })
    );
    assert_eq!(
        pooled["mesh_check"]["ours"]["gradient"],
        serde_json::json!({ "collide": 0, "of": 2 })
    );

    let table = bench(&[&[folder], &modes[..]].concat());
    assert_eq!(table.exit, 0, "{}", table.err);
    for part in [
        "tiny_a/0",
        "same/path",
        "━━ tiny (pooled): 2 problems",
        "ours ÷ best honest peer",
        "at its CPU ÷ 20",
    ] {
        assert!(table.out.contains(part), "no {part} in\n{}", table.out);
    }
}

#[test]
fn under_a_deadline_runs_may_differ_and_one_of_them_counts() {
    let arguments = [
        "--deadline",
        "2ms",
        "--repeat",
        "3",
        "--filter",
        "arm_",
        "--format",
        "json",
    ];
    let run = bench(&[&[config("problems").as_str()], &arguments[..]].concat());
    assert_eq!(run.exit, 0, "{}", run.err);
    let report = run.json();
    assert_eq!(number(&report["deadline_s"]), 2e-3);
    for answer in list(&report["rows"])
        .iter()
        .flat_map(|row| row["answers"].as_object().unwrap().values())
    {
        assert_eq!(number(&answer["runs"]), 3.0);
        assert_eq!(list(&answer["curve"]).last().unwrap()[1], answer["length"]);
    }
}

#[test]
fn a_peers_path_can_take_the_planners_place() {
    let folder = family();
    let folder = folder.path().to_str().unwrap();
    let from = |name: &str| {
        bench(&[
            folder, "--repeat", "1", "--modes", "gradient", "--from", name,
        ])
    };
    let run = from("same/path");
    assert_eq!(run.exit, 0, "{}", run.err);
    assert!(
        run.out.contains("the path of same/path") && run.out.contains("shortened by"),
        "{}",
        run.out
    );
    let run = from("short/one");
    assert_eq!(
        (run.exit, run.out.as_str(), run.err.lines().count()),
        (64, "", 1)
    );
    assert!(
        run.err.contains("\"short/one\"") && run.err.contains("valid: same/path"),
        "{}",
        run.err
    );
}

#[test]
fn a_bench_has_a_row_for_every_problem_and_bad_ones_do_not_end_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("bad.json"),
        "{ \"format\": \"taut-problem/1\" }",
    )
    .unwrap();
    let run = bench(&[folder.path().to_str().unwrap()]);
    assert_eq!(run.exit, 65);
    assert!(
        run.out.contains("bad.json") && run.out.contains("missing field"),
        "{}",
        run.out
    );

    let arguments = [
        "--modes", "check", "--filter", "arm_", "--limit", "1", "--format", "json",
    ];
    let run = bench(&[&[config("problems").as_str()], &arguments[..]].concat());
    assert_eq!(run.exit, 0, "{}", run.err);
    let report = run.json();
    assert_eq!(report["rows"].as_array().unwrap().len(), 1);
    assert_eq!(
        report["rows"][0]["answers"]["check"]["ratio"].as_f64(),
        Some(1.0)
    );
    assert_eq!(
        report["sets"][0]["modes"]["check"]["valid"].as_u64(),
        Some(1)
    );
}

#[test]
fn a_run_beside_an_earlier_one_says_what_is_another() {
    let folder = tempfile::tempdir().unwrap();
    let before = folder.path().join("before.json");
    let before = before.to_str().unwrap();
    let problems = config("problems");
    let asked = [
        problems.as_str(),
        "--filter",
        "arm_",
        "--repeat",
        "1",
        "--modes",
        "gradient,contact",
    ];
    assert_eq!(bench(&[&asked[..], &["--out", before]].concat()).exit, 0);
    let again = || bench(&[&asked[..], &["--against", before]].concat());
    let run = again();
    assert_eq!((run.exit, run.err.as_str()), (0, ""), "{}", run.out);
    assert_eq!(run.out.lines().count(), 1, "{}", run.out);
    assert!(run.out.contains(" 0 different"), "{}", run.out);

    let mut report: Value = serde_json::from_str(&fs::read_to_string(before).unwrap()).unwrap();
    let answers = &mut report["rows"][0]["answers"];
    answers["gradient"]["work"] = Value::from(1);
    fs::write(before, report.to_string()).unwrap();
    let run = again();
    assert!(
        run.exit == 0 && run.out.contains("other work ") && run.out.contains(" 1 with other work"),
        "{}",
        run.out
    );

    report["rows"][0]["answers"]["contact"]["path_hash"] = Value::from("0");
    fs::write(before, report.to_string()).unwrap();
    let run = again();
    assert_eq!(run.exit, 1, "{}", run.out);
    assert!(run.out.contains(" contact: path 0 -> "), "{}", run.out);

    fs::write(before, "{}").unwrap();
    let run = again();
    assert_eq!((run.exit, run.err.lines().count()), (65, 1), "{}", run.err);
}

#[test]
fn the_users_command_is_the_same_program() {
    let mut command = Command::new(taut());
    command.args(["bench", &config("problems"), "--modes", "check"]);
    command.args(["--filter", "corner", "--format", "json"]);
    let run = Run::of(command.output().unwrap());
    assert_eq!(run.exit, 0, "{}", run.err);
    assert_eq!(list(&run.json()["rows"]).len(), 1);
}

/// Trajectories of shipped problems: what is said of them agrees with itself, and a list names problems.
#[test]
fn timed_problems_are_above_their_bounds_and_within_limits() {
    let folder = config("problems");
    let list_file = tempfile::NamedTempFile::new().unwrap();
    fs::write(
        list_file.path(),
        "# two\nproblems/arm_window given\nproblems/corner\n",
    )
    .unwrap();
    let root = Path::new(&folder)
        .parent()
        .unwrap()
        .to_str()
        .unwrap()
        .to_owned();
    let run = bench(&[
        &root,
        "--time",
        "--named",
        list_file.path().to_str().unwrap(),
        "--repeat",
        "2",
        "--work",
        "5000",
        "--format",
        "json",
    ]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let report = run.json();
    let rows = list(&report["rows"]);
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert_eq!(row["error"], Value::Null, "{row}");
        let duration = number(&row["duration_s"]);
        assert!(duration >= number(&row["bound_s"]) - 1e-9, "{row}");
        assert!(
            number(&row["stops_ratio"]) >= number(&row["ratio"]),
            "{row}"
        );
        for part in ["velocity_part", "acceleration_part"] {
            let part = number(&row[part]);
            assert!(part > 0.5 && part <= 1.0 + 1e-6, "{row}");
        }
        assert_eq!(
            (&row["rests_at_ends"], &row["verified"]),
            (&Value::Bool(true), &Value::Bool(true)),
            "{row}"
        );
    }
    assert_eq!(report["summary"]["verified"], 2);
    assert!(list(&report["recorded"]["peers"]).len() > 5);
    let bad = tempfile::NamedTempFile::new().unwrap();
    fs::write(bad.path(), "problems/corner balls\n").unwrap();
    let run = bench(&[&root, "--time", "--named", bad.path().to_str().unwrap()]);
    assert_eq!(run.exit, 65, "{}", run.err);
    assert!(
        run.err.contains("line 1") && run.err.contains("given or spheres"),
        "{}",
        run.err
    );
}
