//! Answers as CSV, YAML and JSON. Numbers are written so that they are read back to the last bit.

use std::fmt::Write;

use serde_json::json;
use taut::files::ResultFile;
use taut::files::result::{ResultCorridor, ResultTurns};

/// A number as every reader takes it for one that may have a fraction: never with an exponent,
/// always with a point.
fn number(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') {
        text
    } else {
        text + ".0"
    }
}

fn numbers(row: &[f64]) -> String {
    row.iter()
        .map(|value| number(*value))
        .collect::<Vec<_>>()
        .join(", ")
}

/// The path with its columns, and nothing else.
pub(super) fn json(result: &ResultFile) -> String {
    format!(
        "{}\n",
        json!({ "variables": result.variables, "path": result.path })
    )
}

/// A header and a row per waypoint; the corridor stands in comments below.
pub(super) fn csv(result: &ResultFile) -> String {
    let name = |name: &String| match name.contains([',', '"', '#', '\n']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.clone(),
    };
    let mut text = result
        .variables
        .iter()
        .map(name)
        .collect::<Vec<_>>()
        .join(",")
        + "\n";
    for row in &result.path {
        let _ = writeln!(
            text,
            "{}",
            row.iter()
                .map(|value| number(*value))
                .collect::<Vec<_>>()
                .join(",")
        );
    }
    let _ = writeln!(text, "# {}", proved(result));
    text + &comments(result)
}

/// What was proved of the numbers of the path.
fn proved(result: &ResultFile) -> String {
    let mut text = match result.subject.unwrapped {
        true => "proved free on the straight lines between its points, every column a real number"
            .to_owned(),
        false => {
            "proved free where every column moves from number to number as they stand".to_owned()
        }
    };
    for ResultTurns { variable, turns } in &result.turned {
        let _ = match turns {
            0 => write!(text, "; {variable} was written anew between its ends"),
            turns => write!(
                text,
                "; {variable} ends {turns:+} turns from the goal that was given"
            ),
        };
    }
    text
}

/// ROS's JointTrajectory: positions only.
pub(super) fn yaml(result: &ResultFile) -> String {
    let mut text = format!(
        "# A path, {}. It has no times: every time_from_start is 0.\n\
         # Time it, then prove what a controller makes of it: taut check --timed\n",
        proved(result)
    );
    text += &comments(result);
    let names = result.variables.iter().map(|name| json!(name).to_string());
    let _ = writeln!(
        text,
        "joint_names: [{}]\npoints:",
        names.collect::<Vec<_>>().join(", ")
    );
    for row in &result.path {
        let _ = writeln!(text, "  - positions: [{}]", numbers(row));
        let _ = writeln!(text, "    time_from_start: {{sec: 0, nanosec: 0}}");
    }
    text
}

/// What the corridor says, for people.
fn comments(result: &ResultFile) -> String {
    let Some(corridor) = &result.corridor else {
        return String::new();
    };
    let mut text = format!(
        "# corridor: every pair keeps {} m at any q with sum(reach |q - p|) <= slack around a p of the segment\n",
        number(corridor.floor_m)
    );
    for coordinate in &corridor.coordinates {
        let variable = &coordinate.variable;
        let kind = &coordinate.kind;
        let reach = number(coordinate.reach_m);
        let _ = writeln!(text, "# reach {variable} ({kind}): {reach} m per unit");
    }
    for (segment, slack) in corridor.slack_m.iter().enumerate() {
        let _ = writeln!(text, "# slack of segment {segment}: {} m", number(*slack));
    }
    text
}

/// A row per segment: its slack, and how far each coordinate may stray alone.
pub(super) fn corridor_csv(corridor: &ResultCorridor) -> String {
    let names = corridor
        .coordinates
        .iter()
        .map(|coordinate| format!("{} alone", coordinate.variable));
    let mut text = format!(
        "# every pair keeps {} m\nsegment,slack_m",
        number(corridor.floor_m)
    );
    names.for_each(|name| text += &format!(",\"{}\"", name.replace('"', "\"\"")));
    text.push('\n');
    for (segment, slack) in corridor.slack_m.iter().enumerate() {
        let alone = corridor
            .coordinates
            .iter()
            .map(|coordinate| slack / coordinate.reach_m);
        let alone: Vec<String> = alone
            .map(|stray| {
                if stray.is_finite() {
                    number(stray)
                } else {
                    "inf".into()
                }
            })
            .collect();
        let _ = writeln!(text, "{segment},{},{}", number(*slack), alone.join(","));
    }
    text
}

/// The corridor as it stands in the answer.
pub(super) fn corridor_json(corridor: &ResultCorridor) -> String {
    format!("{}\n", json!(corridor))
}
