//! Bare paths: named columns and rows, as JSON, CSV or a trajectory.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::columns::{self, Names};
use super::constraints::check_constraints;
use super::trajectory::Start;
use super::{FileError, read_text, trajectory, vamp, yaml};
use crate::path;
use crate::robot::{RobotDescription, Variable};
use crate::scene::Filled;
use crate::warning::Warning;

/// A path as a file has it: columns in the file's order.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTable {
    file: PathBuf,
    variables: Vec<String>,
    rows: Vec<Vec<f64>>,
    warnings: Vec<Warning>,
    start: Start,
}

/// How far a held joint may be from where a message has it (m or rad): what printing leaves of a
/// number.
const HELD_TOLERANCE: f64 = 1e-6;

#[derive(Deserialize)]
struct JsonTable {
    variables: Vec<String>,
    path: Vec<Vec<f64>>,
    #[serde(default)]
    path_constraints: Filled,
}

impl PathTable {
    /// Reads `{"variables": [names], "path": [[numbers]]}`, which problem and result files are too,
    /// CSV with a header row (`.csv`; lines that start with `#` are comments), or the positions of
    /// a trajectory (`.yaml`, or JSON with its fields).
    ///
    /// # Errors
    /// A file that cannot be read, is neither, or has a row that is too short, too long or no
    /// number.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = read_text(file)?;
        let parsed = if is_csv(file) {
            parse_csv(&text)
        } else if yaml::is_yaml(file) || is_trajectory(&text) {
            return Self::of_trajectory(file, &text);
        } else {
            parse_json(&text)
        };
        let (variables, rows) = parsed.map_err(|text| FileError::Content {
            file: file.to_owned(),
            text,
        })?;
        Ok(Self {
            file: file.to_owned(),
            variables,
            rows,
            warnings: Vec::new(),
            start: Vec::new(),
        })
    }

    fn of_trajectory(file: &Path, text: &str) -> Result<Self, FileError> {
        let refuse = |text: String| FileError::Content {
            file: file.to_owned(),
            text,
        };
        let (variables, points, start) =
            trajectory::parse(text, yaml::is_yaml(file)).map_err(refuse)?;
        let rows = points.into_iter().map(|point| point.positions).collect();
        let (variables, rows) = checked(variables, rows).map_err(refuse)?;
        Ok(Self {
            file: file.to_owned(),
            variables,
            rows,
            warnings: Vec::new(),
            start,
        })
    }

    /// The straight line from start to goal of one of VAMP's problems, `selected` as `SET:INDEX`.
    ///
    /// # Errors
    /// A file that cannot be read, does not have that problem, or does not name its joints.
    pub fn of_vamp(file: &Path, selected: Option<&str>) -> Result<Self, FileError> {
        let text = read_text(file)?;
        let parsed = vamp::Problem::select(&text, selected).and_then(|problem| problem.path());
        let checked = parsed.and_then(|(variables, rows)| checked(variables, rows));
        let (variables, rows) = checked.map_err(|text| FileError::Content {
            file: file.to_owned(),
            text,
        })?;
        Ok(Self {
            file: file.to_owned(),
            variables,
            rows,
            warnings: Vec::new(),
            start: Vec::new(),
        })
    }

    /// Column names in the file's order.
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// Refuses a path whose own message has joints elsewhere than where they are held: it would be
    /// proved for another robot.
    ///
    /// # Errors
    /// Those joints, and how to hold them there.
    pub fn check_held<'a>(
        &self,
        held: impl Iterator<Item = (&'a str, f64)>,
    ) -> Result<(), FileError> {
        let differs = |(name, value): (&'a str, f64)| {
            let (_, start) = self.start.iter().rev().find(|(known, _)| known == name)?;
            ((start - value).abs() > HELD_TOLERANCE).then(|| format!("{name}={start}"))
        };
        let elsewhere: Vec<String> = held.filter_map(differs).collect();
        if elsewhere.is_empty() {
            return Ok(());
        }
        let text = format!(
            "its start state has joints that the path does not move elsewhere than where they are held; hold them there: --hold {}",
            elsewhere.join(" --hold ")
        );
        Err(FileError::Content {
            file: self.file.clone(),
            text,
        })
    }

    /// What of the file is not read, a line each.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// The columns that are variables of the robot, whichever of its variables paths have; times
    /// and columns of fixed joints are left out.
    ///
    /// # Errors
    /// A column that is no variable of the robot, with the names that it has.
    pub fn for_robot(self, robot: &RobotDescription) -> Result<Self, FileError> {
        self.of_names(&Names::of_description(robot))
    }

    fn of_names(mut self, names: &Names) -> Result<Self, FileError> {
        let refuse = |text: String| FileError::Content {
            file: self.file.clone(),
            text,
        };
        let (found, warning) = names.columns(&self.variables).map_err(refuse)?;
        for (index, row) in self.rows.iter_mut().enumerate() {
            *row = found.iter().map(|(place, _)| row[*place]).collect();
            // A time may be no number, until the robot has a joint of that name.
            if let Some(bad) = row.iter().position(|value| !value.is_finite()) {
                return Err(refuse(format!(
                    "row {index}, column {:?} is not a finite number",
                    found[bad].1
                )));
            }
        }
        self.variables = found.into_iter().map(|(_, name)| name).collect();
        self.warnings
            .extend(warning.map(|text| Warning::cosmetic("columns", text)));
        Ok(self)
    }

    /// The same for a robot of which these variables and fixed joints are known.
    ///
    /// # Errors
    /// As [`Self::for_robot`].
    pub fn for_variables(
        self,
        variables: &[Variable],
        fixed: &[String],
    ) -> Result<Self, FileError> {
        self.of_names(&Names::of_variables(variables, fixed))
    }

    /// The path with its columns in the robot's order.
    ///
    /// # Errors
    /// A column that the robot does not have, or one that is missing, with the names that it has.
    pub fn into_path(self, variables: &[Variable]) -> Result<path::Path, FileError> {
        let table = self.for_variables(variables, &[])?;
        let refuse = |text: String| FileError::Content {
            file: table.file.clone(),
            text,
        };
        let order = columns::order(&table.variables, variables).map_err(refuse)?;
        let numbers = table
            .rows
            .iter()
            .flat_map(|row| order.iter().map(|&column| row[column]))
            .collect();
        path::Path::from_rows(variables.len(), numbers)
            .ok_or_else(|| refuse("the robot has no variables".to_owned()))
    }
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
    file.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

type Parsed = Result<(Vec<String>, Vec<Vec<f64>>), String>;

fn parse_json(text: &str) -> Parsed {
    let expected = r#"not a path: a path is {"variables": [names], "path": [[numbers], …]}, or a .csv or .yaml file"#;
    let table: JsonTable =
        serde_json::from_str(text).map_err(|error| format!("{expected}: {error}"))?;
    check_constraints([("path_constraints", table.path_constraints)])?;
    let columns = table.variables.len();
    if let Some((index, row)) = table
        .path
        .iter()
        .enumerate()
        .find(|(_, row)| row.len() != columns)
    {
        return Err(format!(
            "path row {index} has {} numbers, \"variables\" names {columns} columns",
            row.len()
        ));
    }
    checked(table.variables, table.path)
}

/// Columns are parted by commas, or where the header has none by semicolons or tabs; numbers then
/// may have a comma.
fn parse_csv(text: &str) -> Parsed {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = || text.lines().filter(|line| !line.trim().is_empty());
    let first = lines()
        .find(|line| !line.starts_with('#'))
        .unwrap_or_default();
    let delimiter = [',', ';', '\t']
        .into_iter()
        .find(|mark| first.contains(*mark))
        .unwrap_or(',');
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader
        .comment(Some(b'#'))
        .delimiter(delimiter as u8)
        .trim(csv::Trim::All)
        .flexible(true);
    let mut reader = reader.has_headers(false).from_reader(text.as_bytes());
    let mut records = reader
        .records()
        .map(|record| record.map_err(|error| error.to_string()))
        .peekable();

    let header = records
        .peek()
        .cloned()
        .unwrap_or_else(|| Ok(csv::StringRecord::new()))?;
    // NumPy writes the names as a comment above the numbers.
    let above = lines().take_while(|line| line.starts_with('#')).last();
    let above = above.and_then(|line| names_in_comment(line, delimiter, &header));
    let mut variables = above.unwrap_or_else(|| {
        records.next();
        header.iter().map(str::to_owned).collect()
    });
    // A comma at the end of every line parts nothing.
    let has_end = variables.len() > 1 && variables.last().is_some_and(String::is_empty);
    if has_end {
        variables.pop();
    }
    let mut rows = Vec::new();
    for record in records {
        rows.push(csv_row(&record?, &variables, has_end, delimiter != ',')?);
    }
    checked(variables, rows)
}

/// The names in a comment above rows of numbers, one for each.
fn names_in_comment(line: &str, delimiter: char, first: &csv::StringRecord) -> Option<Vec<String>> {
    let names: Vec<String> = line
        .trim_start_matches('#')
        .split(delimiter)
        .map(|name| name.trim().to_owned())
        .collect();
    let are_numbers = first.iter().all(|field| field.parse::<f64>().is_ok());
    let are_names = names
        .iter()
        .all(|name| !name.is_empty() && !name.contains(char::is_whitespace));
    let is_one_word =
        names.len() == 1 && line.trim_start_matches('#').trim().parse::<f64>().is_err();
    (are_numbers && are_names && names.len() == first.len() && (names.len() > 1 || is_one_word))
        .then_some(names)
}

fn csv_row(
    record: &csv::StringRecord,
    variables: &[String],
    has_end: bool,
    has_decimal_commas: bool,
) -> Result<Vec<f64>, String> {
    let line = record.position().map_or(0, csv::Position::line);
    let end = usize::from(
        has_end && record.len() > variables.len() && record.iter().next_back() == Some(""),
    );
    if record.len() - end != variables.len() {
        return Err(format!(
            "line {line} has {} numbers, the header names {}",
            record.len() - end,
            variables.len()
        ));
    }
    let number = |(word, name): (&str, &String)| {
        let word_in_points = if has_decimal_commas {
            word.replace(',', ".")
        } else {
            word.to_owned()
        };
        match word_in_points
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
        {
            Some(value) => Ok(value),
            // Whether it is a joint after all, the robot decides.
            None if columns::is_time(name) => Ok(f64::NAN),
            None => Err(format!(
                "line {line}, column {name:?}: {word:?} is not a finite number"
            )),
        }
    };
    record.iter().zip(variables).map(number).collect()
}

fn checked(variables: Vec<String>, rows: Vec<Vec<f64>>) -> Parsed {
    if let Some(index) = (1..variables.len()).find(|&i| variables[..i].contains(&variables[i])) {
        return Err(format!(
            "column {:?} is there twice; names must be unique",
            variables[index]
        ));
    }
    if rows.is_empty() {
        return Err("the path is empty; it needs a waypoint".to_owned());
    }
    Ok((variables, rows))
}
