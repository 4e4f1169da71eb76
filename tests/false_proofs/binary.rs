//! A share of the proofs as users get them: by the command line, from files to files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use super::case::Case;
use super::library::{Answer, HALF_A_TURN, Refused};
use super::read::path::{csv, ordered, yaml};
use super::verdict::Proved;

/// Runs `taut` to its end.
fn taut(case: &Case, arguments: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taut"));
    command
        .args(arguments)
        .current_dir(&case.files.folder)
        .env_remove("TAUT_LOG");
    command
        .output()
        .expect("the command line starts")
}

fn asked<'a>(case: &'a Case, verb: &'a str, path: &'a Path) -> Vec<&'a Path> {
    let mut arguments = vec![
        Path::new(verb),
        path,
        Path::new("--robot"),
        &case.files.urdf,
    ];
    if let Some(srdf) = &case.files.srdf {
        arguments.extend([Path::new("--srdf"), srdf]);
    }
    arguments.extend([
        Path::new("--scene"),
        &case.files.scene,
        Path::new("--local"),
    ]);
    arguments
}

/// Checks a path; what was proved is what the answer says.
pub fn check(case: &Case, path: &Path) -> Answer {
    let mut arguments = asked(case, "check", path);
    arguments.extend([Path::new("--format"), Path::new("json")]);
    answer(case, &taut(case, &arguments), false)
}

/// Shortens a path, and exports the answer; what was proved is what the exported file says.
pub fn export(case: &Case, path: &Path, ending: &str) -> Answer {
    let result = case.files.folder.join("result.json");
    let exported = PathBuf::from(format!("exported.{ending}"));
    let _ = fs::remove_file(&result);
    let mut arguments = asked(case, "shorten", path);
    arguments.extend([
        Path::new("-o"),
        &result,
        Path::new("--format"),
        Path::new("json"),
    ]);
    let mut found = answer(case, &taut(case, &arguments), true);
    if let Answer::Proved(proved) = &mut found {
        let output = taut(
            case,
            &[Path::new("export"), &result, Path::new("-o"), &exported],
        );
        if !output.status.success() {
            return Answer::Unread(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        let text =
            fs::read_to_string(case.files.folder.join(&exported)).expect("the export is a text");
        let table = if ending == "csv" {
            csv(&text)
        } else {
            yaml(&text)
        };
        proved.rows = ordered(&case.names, table);
    }
    found
}

fn answer(case: &Case, output: &Output, is_shortened: bool) -> Answer {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let code = output.status.code().unwrap_or(-1);
    assert!(
        (0..=3).contains(&code) || (64..=66).contains(&code),
        "exit code {code}: {said}"
    );
    if code > 3 {
        return Answer::Unread(said);
    }
    let value: Value = serde_json::from_slice(&output.stdout).expect("an answer is JSON");
    let is_proved = value["proved"]
        .as_bool()
        .expect("it says whether it is proved");
    assert_eq!(code == 0, is_proved, "the exit code says the same: {said}");
    if !is_proved {
        let reason = value["reason"]
            .as_str()
            .unwrap_or("UNCERTIFIED")
            .to_owned();
        return Answer::Refused(Refused {
            reason,
            collision: None,
        });
    }
    let text = |value: &Value| value.as_str().expect("a name").to_owned();
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let numbers = |row: &Value| {
        list(row)
            .iter()
            .map(|x| x.as_f64().expect("a number"))
            .collect()
    };
    let names: Vec<String> = list(&value["variables"])
        .iter()
        .map(text)
        .collect();
    let rows = list(&value["path"])
        .iter()
        .map(numbers)
        .collect();
    let lowered = list(&value["floors_lowered"])
        .into_iter()
        .filter(|floor| floor["kind"] == "clearance")
        .map(|floor| {
            (
                [text(&floor["names"][0]), text(&floor["names"][1])],
                floor["floor"].as_f64().expect("a floor"),
            )
        });
    Answer::Proved(Box::new(Proved {
        rows: ordered(&case.names, (names, rows)),
        clearance_m: value["clearance_m"]
            .as_f64()
            .expect("a clearance"),
        lowered: lowered.collect::<BTreeMap<_, _>>(),
        is_shortened,
        is_said: list(&value["warnings"])
            .iter()
            .any(|warning| text(warning).contains(HALF_A_TURN)),
    }))
}
