//! What planning requests, trajectories and problems say besides a path: what it must keep, and what
//! nobody would keep, which is not left out unseen.

use std::path::Path;

use super::{FileError, read_text, yaml};
use crate::constraint::ConstraintsFile;
use crate::scene::Filled;
use crate::scene::scene_file::refuse_constraints;

/// Reads constraints from a file: MoveIt's `Constraints`, or whatever has them as its
/// `path_constraints`, as JSON or YAML; or few words.
///
/// # Errors
/// A file that cannot be read or has none.
pub fn constraints_of(file: &Path) -> Result<ConstraintsFile, FileError> {
    let text = read_text(file)?;
    in_text(&text, yaml::is_yaml(file)).map_err(|text| FileError::content(file, text))
}

fn in_text(text: &str, is_yaml: bool) -> Result<ConstraintsFile, String> {
    let parsed = match is_yaml {
        true => Some(yaml::documents::<serde_json::Value>(text)?.swap_remove(0)),
        false => serde_json::from_str::<serde_json::Value>(text).ok(),
    };
    match parsed {
        Some(mut value) => match value.get_mut("path_constraints") {
            Some(constraints) => path_constraints(Some(constraints.take())),
            None => ConstraintsFile::parse(&value.to_string()).map_err(|error| error.to_string()),
        },
        None => ConstraintsFile::parse(text).map_err(|error| error.to_string()),
    }
}

/// What a file's field `path_constraints` asks for; nothing where it is not there or null.
///
/// # Errors
/// What is wrong.
pub(super) fn path_constraints(
    value: Option<serde_json::Value>,
) -> Result<ConstraintsFile, String> {
    match value {
        None | Some(serde_json::Value::Null) => Ok(ConstraintsFile::default()),
        Some(value) => {
            serde_json::from_value(value).map_err(|error| format!("path_constraints: {error}"))
        }
    }
}

/// Refuses what nobody would keep, by the names of the fields.
///
/// # Errors
/// There is such a thing.
pub(super) fn check_constraints<const N: usize>(fields: [(&str, Filled); N]) -> Result<(), String> {
    let check = |(field, constraints)| {
        refuse_constraints(field, constraints).map_err(|error| error.to_string())
    };
    fields.into_iter().try_for_each(check)
}

/// Refuses a goal that says more than where joints are.
///
/// # Errors
/// It has one of these constraints.
pub(super) fn check_goal<const N: usize>(fields: [(&str, Filled); N]) -> Result<(), String> {
    match fields
        .iter()
        .find(|(_, constraints)| !constraints.is_empty())
    {
        None => Ok(()),
        Some((field, _)) => Err(format!(
            "its goal_constraints have {field}; only goals in joint space are read"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::super::PathTable;
    use super::*;

    fn read(name: &str, text: &str) -> Result<PathTable, FileError> {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join(name);
        std::fs::write(&file, text).unwrap();
        PathTable::read(&file)
    }

    #[test]
    fn what_a_path_must_keep_comes_with_it() {
        let kept = r#""path_constraints": { "name": "upright", "orientation_constraints": [{ "link_name": "hand",
            "header": { "frame_id": "world" }, "meaning": "for people", "axis": [1, 0, 0], "reference": [0, 0, 1],
            "tolerance_rad": 0.1 }] }"#;
        let expected = ConstraintsFile::parse("upright hand:x=0.1").unwrap();
        let said = |file: &str, text: String| {
            let table = read(file, &text).unwrap_or_else(|error| panic!("{text}: {error}"));
            let text = table.constraints.text();
            // A header that names the world is none.
            ConstraintsFile::parse(&text.replace(r#""header":{"frame_id":"world"},"#, "")).unwrap()
        };
        let points = r#""joint_names": ["a"], "points": [{ "positions": [1] }]"#;
        for (file, text) in [
            (
                "p.json",
                format!(r#"{{ "variables": ["a"], "path": [[1]], {kept} }}"#),
            ),
            ("p.yaml", format!("{{ {points}, {kept} }}")),
            (
                "p.json",
                format!(r#"{{ "trajectory": {{ "joint_trajectory": {{ {points} }}, {kept} }} }}"#),
            ),
            (
                "p.yaml",
                format!(
                    r#"{{ "start_state": {{ "joint_state": {{ "name": ["a"], "position": [0] }} }},
                    "goal_constraints": [{{ "joint_constraints": [{{ "joint_name": "a", "position": 1 }}] }}], {kept} }}"#
                ),
            ),
        ] {
            assert_eq!(said(file, text), expected);
        }
        let nothing = r#"{ "variables": ["a"], "path": [[1]], "path_constraints": null }"#;
        assert!(
            read("p.json", nothing)
                .unwrap()
                .constraints
                .is_empty()
        );
    }

    #[test]
    fn constraints_are_read_from_files_that_are_or_have_them() {
        let dir = tempfile::tempdir().unwrap();
        let expected = ConstraintsFile::parse("upright hand:x=0.1").unwrap();
        let text = expected.text();
        for (name, text) in [
            ("c.json", text.clone()),
            ("c.yaml", text.clone()),
            (
                "has.json",
                format!(r#"{{ "path_constraints": {text}, "group_name": "arm" }}"#),
            ),
            ("words.txt", "upright hand:x=0.1\n".to_owned()),
        ] {
            let file = dir.path().join(name);
            std::fs::write(&file, text).unwrap();
            assert_eq!(constraints_of(&file).unwrap(), expected, "{name}");
        }
        let file = dir.path().join("none.yaml");
        std::fs::write(&file, "group_name: arm\n").unwrap();
        let error = constraints_of(&file).unwrap_err().to_string();
        assert!(
            error.contains("none.yaml") && error.contains("group_name"),
            "{error}"
        );
    }
}
