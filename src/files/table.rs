//! Bare paths: named columns and rows, as JSON, CSV or a trajectory.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{FileError, read_text, trajectory, vamp, yaml};
use crate::path;
use crate::robot::Variable;

/// A path as a file has it: columns in the file's order.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTable {
    file: PathBuf,
    variables: Vec<String>,
    rows: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct JsonTable {
    variables: Vec<String>,
    path: Vec<Vec<f64>>,
}

impl PathTable {
    /// Reads `{"variables": [names], "path": [[numbers]]}`, which problem and result files are too, CSV with a header
    /// row (`.csv`; lines that start with `#` are comments), or the positions of a trajectory (`.yaml`, or JSON with
    /// its fields).
    ///
    /// # Errors
    /// A file that cannot be read, is neither, or has a row that is too short, too long or no number.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = read_text(file)?;
        let parsed = if is_csv(file) {
            parse_csv(&text)
        } else if yaml::is_yaml(file) || is_trajectory(&text) {
            parse_trajectory(&text, yaml::is_yaml(file))
        } else {
            parse_json(&text)
        };
        let (variables, rows) = parsed.map_err(|text| FileError::Content { file: file.to_owned(), text })?;
        Ok(Self { file: file.to_owned(), variables, rows })
    }

    /// The straight line from start to goal of one of VAMP's problems, `selected` as `SET:INDEX`.
    ///
    /// # Errors
    /// A file that cannot be read, does not have that problem, or does not name its joints.
    pub fn of_vamp(file: &Path, selected: Option<&str>) -> Result<Self, FileError> {
        let text = read_text(file)?;
        let parsed = vamp::Problem::select(&text, selected).and_then(|problem| problem.path());
        let checked = parsed.and_then(|(variables, rows)| checked(variables, rows));
        let (variables, rows) = checked.map_err(|text| FileError::Content { file: file.to_owned(), text })?;
        Ok(Self { file: file.to_owned(), variables, rows })
    }

    /// Column names in the file's order.
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// The path with its columns in the robot's order.
    ///
    /// # Errors
    /// A column that the robot does not have, or one that is missing, with the names that it has.
    pub fn into_path(self, variables: &[Variable]) -> Result<path::Path, FileError> {
        let refuse = |text: String| FileError::Content { file: self.file.clone(), text };
        let order = order(&self.variables, variables).map_err(refuse)?;
        let numbers = self.rows.iter().flat_map(|row| order.iter().map(|&column| row[column])).collect();
        path::Path::from_rows(variables.len(), numbers).ok_or_else(|| refuse("the robot has no variables".to_owned()))
    }
}

/// For each of the robot's variables, the place of its column.
///
/// # Errors
/// A column that the robot does not have, or one that is missing, with the names that it has.
pub(super) fn order(columns: &[String], variables: &[Variable]) -> Result<Vec<usize>, String> {
    let known = || variables.iter().map(|v| v.name.as_str()).collect::<Vec<_>>().join(", ");
    if let Some(unknown) = columns.iter().find(|name| !variables.iter().any(|v| v.name == **name)) {
        return Err(format!("column {unknown:?} is no variable of the robot; valid: {}", known()));
    }
    let position = |variable: &Variable| {
        let found = columns.iter().position(|name| *name == variable.name);
        found.ok_or_else(|| format!("column {:?} is missing; the robot needs {}", variable.name, known()))
    };
    variables.iter().map(position).collect()
}

/// Whether a JSON text has a trajectory's fields and not a path's.
fn is_trajectory(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Probe {
        path: Option<serde::de::IgnoredAny>,
        points: Option<serde::de::IgnoredAny>,
        joint_trajectory: Option<serde::de::IgnoredAny>,
        trajectory: Option<serde::de::IgnoredAny>,
    }
    let has_one = |probe: Probe| {
        let fields = [probe.points, probe.joint_trajectory, probe.trajectory];
        probe.path.is_none() && fields.iter().any(Option::is_some)
    };
    serde_json::from_str::<Probe>(text).is_ok_and(has_one)
}

/// Whether a path file is CSV, by its name.
pub(super) fn is_csv(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

type Parsed = Result<(Vec<String>, Vec<Vec<f64>>), String>;

fn parse_json(text: &str) -> Parsed {
    let expected = r#"not a path: a path is {"variables": [names], "path": [[numbers], …]}, or a .csv or .yaml file"#;
    let table: JsonTable = serde_json::from_str(text).map_err(|error| format!("{expected}: {error}"))?;
    let columns = table.variables.len();
    if let Some((index, row)) = table.path.iter().enumerate().find(|(_, row)| row.len() != columns) {
        return Err(format!("path row {index} has {} numbers, \"variables\" names {columns} columns", row.len()));
    }
    checked(table.variables, table.path)
}

fn parse_trajectory(text: &str, is_yaml: bool) -> Parsed {
    let (variables, points) = trajectory::parse(text, is_yaml)?;
    checked(variables, points.into_iter().map(|point| point.positions).collect())
}

fn parse_csv(text: &str) -> Parsed {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?;
    let variables: Vec<String> = header.iter().map(str::to_owned).collect();
    if let Some(number) = variables.iter().find(|name| name.parse::<f64>().is_ok()) {
        return Err(format!("line 1 must name the columns, it has the number {number}; add a header row"));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != variables.len() {
            return Err(format!("line {line} has {} numbers, the header names {}", record.len(), variables.len()));
        }
        let number = |(word, name): (&str, &String)| {
            let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| format!("line {line}, column {name:?}: {word:?} is not a finite number"))
        };
        rows.push(record.iter().zip(&variables).map(number).collect::<Result<Vec<_>, _>>()?);
    }
    checked(variables, rows)
}

fn checked(variables: Vec<String>, rows: Vec<Vec<f64>>) -> Parsed {
    if let Some(index) = (1..variables.len()).find(|&i| variables[..i].contains(&variables[i])) {
        return Err(format!("column {:?} is there twice; names must be unique", variables[index]));
    }
    if rows.is_empty() {
        return Err("the path is empty; it needs a waypoint".to_owned());
    }
    Ok((variables, rows))
}
