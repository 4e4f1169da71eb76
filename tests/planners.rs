//! Planners that nobody here wrote, as clients of a real daemon: the scripts of examples/planners
//! and the guide's code.

mod common;

use common::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Python with OMPL, HPP, pinocchio, coal and taut; `None` where there is none.
fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Option<PathBuf>> = OnceLock::new();
    let install = || {
        let lists = ["ompl", "hpp"].map(|name| {
            fs::read_to_string(source(&format!(
                "examples/planners/requirements-{name}.txt"
            )))
            .unwrap()
        });
        common::python::python(
            &lists
                .iter()
                .flat_map(|list| list.lines())
                .collect::<Vec<_>>(),
        )
    };
    PYTHON.get_or_init(install).as_deref()
}

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Runs a script of examples/planners in an instance; `None` where Python or its packages are out
/// of reach.
fn script(place: &Place, arguments: &[&str]) -> Option<Run> {
    let python = python()?;
    let mut command = Command::new(python);
    command
        .arg(source("examples/planners").join(arguments[0]))
        .args(&arguments[1..]);
    command
        .current_dir(source(""))
        .env("TAUT_INSTANCE", place.name());
    Some(Run::of(command.output().unwrap()))
}

fn a_script_shortens_a_shipped_problem(name: &str, problem: &str, says: &str) {
    let place = Place::new();
    let _daemon = place.serve("");
    let Some(run) = script(
        &place,
        &[
            name,
            &config(&format!("problems/{problem}.json")),
            "--deadline",
            "60",
        ],
    ) else {
        return;
    };
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    assert!(
        run.out.contains(says) && run.out.contains("proved, clearance"),
        "{}",
        run.out
    );
}

#[test]
fn ompl_plans_and_taut_shortens() {
    a_script_shortens_a_shipped_problem("ompl_planner.py", "arm_window", "own simplifyMax");
}

#[test]
fn ompl_plans_for_a_base_that_turns() {
    a_script_shortens_a_shipped_problem("ompl_planner.py", "exchange_arms", "own simplifyMax");
}

#[test]
fn hpp_plans_and_taut_shortens() {
    a_script_shortens_a_shipped_problem("hpp_planner.py", "arm_window", "own RandomShortcut");
}

#[test]
fn hpp_plans_for_a_body_that_flies() {
    a_script_shortens_a_shipped_problem("hpp_planner.py", "ell_window", "own RandomShortcut");
}

#[test]
fn moveits_trajectory_comes_back_shorter() {
    let place = Place::new();
    let _daemon = place.serve("");
    let urdf = config("robots/panda_like.urdf");
    let srdf = config("robots/panda_like.srdf");
    let file = source("examples/planners/moveit_request.json");
    let arguments = [
        "moveit_adapter.py",
        file.to_str().unwrap(),
        "--urdf",
        &urdf,
        "--srdf",
        &srdf,
    ];
    let Some(run) = script(&place, &arguments) else {
        return;
    };
    assert_eq!(run.exit, 0, "{}", run.err);
    let sent: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let sent = &sent["trajectory"]["joint_trajectory"];
    let back = &run.json()["joint_trajectory"];
    let ends = |trajectory: &serde_json::Value| {
        let points = trajectory["points"].as_array().unwrap();
        (
            points[0]["positions"].clone(),
            points[points.len() - 1]["positions"].clone(),
        )
    };
    assert_eq!(
        (ends(back), &back["joint_names"]),
        (ends(sent), &sent["joint_names"])
    );
    assert!(
        run.err.contains("proved") && back["points"][1]["time_from_start"]["sec"] == 0,
        "{}",
        run.err
    );
}

#[test]
fn a_table_compares_planners() {
    let place = Place::new();
    let _daemon = place.serve("");
    let table = place.folder.path().join("table.json");
    let problem = config("problems/corner.json");
    let output = table.to_str().unwrap().to_owned();
    let Some(run) = script(
        &place,
        &[
            "compare.py",
            &problem,
            "--queries",
            "2",
            "--deadline",
            "60",
            "-o",
            &output,
        ],
    ) else {
        return;
    };
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    let rows: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(table).unwrap()).unwrap();
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 4, "two queries, two planners: {}", run.out);
    for row in rows.iter().filter(|row| row["refused"] == "") {
        assert!(row["proved"] == true && row["taut_hits"] == "", "{row}");
        assert!(
            row["taut"].as_f64().unwrap() <= row["before"].as_f64().unwrap(),
            "{row}"
        );
    }
    assert!(rows.iter().any(|row| row["refused"] == ""), "{}", run.out);
}

/// OMPL's constrained path comes back shorter, and kinematics of nobody's here see the cup upright.
#[test]
fn a_constrained_planners_path_stays_upright() {
    let place = Place::new();
    let recorded = place.folder.path().join("recorded");
    let recorded = recorded.to_str().unwrap();
    let problem = config("problems/arm_window.json");
    let plan = ["constrained_planner.py", &problem, "-o", recorded];
    let hand = ["--link", "hand", "--touch", "left_finger", "right_finger"];
    let Some(run) = script(&place, &[&plan[..], &hand].concat()) else {
        return;
    };
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    assert!(run.out.contains("1 recorded"), "{} {}", run.out, run.err);
    let taut = env!("CARGO_BIN_EXE_taut");
    let judge = ["constrained_judge.py", recorded, "--taut", taut];
    let looks = [
        "--collisions",
        "0.02",
        "--option=--budget",
        "--option=200000",
    ];
    let run = script(&place, &[&judge[..], &looks].concat()).unwrap();
    assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    let kept = "1 paths, 1 proved, 0 violated";
    assert!(run.out.contains(kept), "{} {}", run.out, run.err);
}

/// Code of the guide, by the word behind its language.
#[test]
fn the_guides_code_runs() {
    for name in ["ompl", "hpp", "moveit"] {
        let place = Place::new();
        let _daemon = place.serve("");
        let Some(run) = script(&place, &["guide_check.py", name]) else {
            return;
        };
        assert_eq!(run.exit, 0, "{name}: {} {}", run.out, run.err);
    }
}

/// VAMP is built from sources of GitHub's, so it is no requirement; where it is installed it has to
/// work.
#[test]
fn vamp_plans_and_taut_shortens() {
    let Some(problem) = std::env::var_os("TAUT_VAMP_PROBLEM") else {
        eprintln!("skipped: TAUT_VAMP_PROBLEM names no problem of a robot that VAMP knows");
        return;
    };
    let problem = problem.to_str().unwrap().to_owned();
    for arguments in [
        ["vamp_planner.py", &problem, "--deadline", "60"].as_slice(),
        &["guide_check.py", "vamp", &problem],
    ] {
        let place = Place::new();
        let _daemon = place.serve("");
        let Some(run) = script(&place, arguments) else {
            return;
        };
        assert_eq!(run.exit, 0, "{} {}", run.out, run.err);
    }
}
