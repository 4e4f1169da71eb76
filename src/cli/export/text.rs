//! Answers as CSV, YAML and JSON. Numbers are written so that they are read back to the last bit.

use std::fmt::Write;

use serde_json::json;
use taut::files::ResultFile;
use taut::files::result::{ResultCoordinate, ResultCorridor, ResultTurns};

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

fn numbers(row: &[f64], between: &str) -> String {
    row.iter()
        .map(|value| number(*value))
        .collect::<Vec<_>>()
        .join(between)
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
    let names: Vec<String> = result
        .variables
        .iter()
        .map(|name| quoted(name))
        .collect();
    let mut text = names.join(",") + "\n";
    for row in &result.path {
        let _ = writeln!(text, "{}", numbers(row, ","));
    }
    let _ = writeln!(text, "# {}", proved(result));
    text + &comments(result)
}

/// A name as a header of a column.
fn quoted(name: &str) -> String {
    match name.contains([',', '"', '#', '\n']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    }
}

/// What was proved of the numbers of the path.
fn proved(result: &ResultFile) -> String {
    let text = match result.subject.unwrapped {
        true => "proved free on the straight lines between its points, every column a real number",
        false => "proved free where every column moves from number to number as they stand",
    };
    text.to_owned()
        + &result
            .turned
            .iter()
            .map(turns)
            .collect::<String>()
}

fn turns(turned: &ResultTurns) -> String {
    let ResultTurns { variable, turns } = turned;
    match turns {
        0 => format!("; {variable} was written anew between its ends"),
        turns => format!("; {variable} ends {turns:+} turns from the goal that was given"),
    }
}

/// ROS's JointTrajectory: positions only.
pub(super) fn yaml(result: &ResultFile) -> String {
    let names: Vec<String> = result
        .variables
        .iter()
        .map(|name| json!(name).to_string())
        .collect();
    let mut text = format!(
        "# A path, {}. It has no times: every time_from_start is 0.\n\
         # Time it, then prove what a controller makes of it: taut check --timed\n\
         {}joint_names: [{}]\npoints:\n",
        proved(result),
        comments(result),
        names.join(", ")
    );
    for row in &result.path {
        let _ = writeln!(text, "  - positions: [{}]", numbers(row, ", "));
        let _ = writeln!(text, "    time_from_start: {{sec: 0, nanosec: 0}}");
    }
    text
}

/// What the corridor says, for people.
fn comments(result: &ResultFile) -> String {
    result
        .corridor
        .as_ref()
        .map_or_else(String::new, corridor)
}

fn corridor(corridor: &ResultCorridor) -> String {
    let mut text = format!(
        "# corridor: every pair keeps {} m at any q with sum(reach |q - p|) <= slack around a p of the segment\n",
        number(corridor.floor_m)
    );
    text.extend(corridor.coordinates.iter().map(reach));
    for (segment, slack) in corridor.slack_m.iter().enumerate() {
        let _ = writeln!(text, "# slack of segment {segment}: {} m", number(*slack));
    }
    text
}

fn reach(coordinate: &ResultCoordinate) -> String {
    format!(
        "# reach {} ({}): {} m per unit\n",
        coordinate.variable,
        coordinate.kind,
        number(coordinate.reach_m)
    )
}

/// A row per segment: its slack, and how far each coordinate may stray alone.
pub(super) fn corridor_csv(corridor: &ResultCorridor) -> String {
    let mut text = format!(
        "# every pair keeps {} m\nsegment,slack_m",
        number(corridor.floor_m)
    );
    for coordinate in &corridor.coordinates {
        let _ = write!(
            text,
            ",\"{} alone\"",
            coordinate.variable.replace('"', "\"\"")
        );
    }
    text.push('\n');
    for (segment, slack) in corridor.slack_m.iter().enumerate() {
        let alone = alone(corridor, *slack);
        let _ = writeln!(text, "{segment},{},{alone}", number(*slack));
    }
    text
}

/// How far each coordinate may stray alone where there is so much slack.
fn alone(corridor: &ResultCorridor, slack: f64) -> String {
    corridor
        .coordinates
        .iter()
        .map(|coordinate| number_or_inf(slack / coordinate.reach_m))
        .collect::<Vec<_>>()
        .join(",")
}

fn number_or_inf(value: f64) -> String {
    match value.is_finite() {
        true => number(value),
        false => "inf".to_owned(),
    }
}

/// The corridor as it stands in the answer.
pub(super) fn corridor_json(corridor: &ResultCorridor) -> String {
    format!("{}\n", json!(corridor))
}
