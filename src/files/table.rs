//! Bare paths: named columns and rows, as JSON, CSV or a trajectory.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::columns::{self, Names};
use super::constraints::path_constraints;
use super::trajectory::Start;
use super::{FileError, read_text, trajectory, vamp, yaml};
use crate::constraint::ConstraintsFile;
use crate::path;
use crate::robot::{RobotDescription, Variable};
use crate::warning::Warning;

/// A path as a file has it: columns in the file's order.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTable {
    file: PathBuf,
    variables: Vec<String>,
    rows: Vec<Vec<f64>>,
    warnings: Vec<Warning>,
    start: Start,
    /// What the file asks the path to keep besides clearance.
    pub(super) constraints: ConstraintsFile,
}

/// How far a held joint may be from where a message has it (m or rad): what printing leaves of a
/// number.
const HELD_TOLERANCE: f64 = 1e-6;

#[derive(Deserialize)]
struct JsonTable {
    variables: Vec<String>,
    path: Vec<Vec<f64>>,
    path_constraints: Option<serde_json::Value>,
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
        if is_csv(file) {
            return Self::of(file, parse_csv(&text));
        }
        if yaml::is_yaml(file) || is_trajectory(&text) {
            return Self::of_trajectory(file, &text);
        }
        let parsed = parse_json(&text).map_err(|text| FileError::content(file, text))?;
        let (columns, constraints) = parsed;
        Ok(Self {
            constraints,
            ..Self::of(file, Ok(columns))?
        })
    }

    fn of(file: &Path, parsed: Parsed) -> Result<Self, FileError> {
        let parsed = parsed.and_then(|(variables, rows)| checked(variables, rows));
        let (variables, rows) = parsed.map_err(|text| FileError::content(file, text))?;
        Ok(Self {
            file: file.to_owned(),
            variables,
            rows,
            warnings: Vec::new(),
            start: Vec::new(),
            constraints: ConstraintsFile::default(),
        })
    }

    fn of_trajectory(file: &Path, text: &str) -> Result<Self, FileError> {
        let parsed = trajectory::parse(text, yaml::is_yaml(file));
        let said = parsed.map_err(|text| FileError::content(file, text))?;
        let (variables, points) = said.path;
        let rows = points
            .into_iter()
            .map(|point| point.positions)
            .collect();
        let table = Self::of(file, Ok((variables, rows)))?;
        Ok(Self {
            start: said.start,
            constraints: said.constraints,
            ..table
        })
    }

    /// The straight line from start to goal of one of VAMP's problems, `selected` as `SET:INDEX`.
    ///
    /// # Errors
    /// A file that cannot be read, does not have that problem, or does not name its joints.
    pub fn of_vamp(file: &Path, selected: Option<&str>) -> Result<Self, FileError> {
        let text = read_text(file)?;
        let problem = vamp::Problem::select(&text, selected);
        Self::of(file, problem.and_then(|problem| problem.path()))
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
        let elsewhere = held.filter_map(|(name, value)| self.elsewhere(name, value));
        let elsewhere: Vec<String> = elsewhere.collect();
        if elsewhere.is_empty() {
            return Ok(());
        }
        let text = format!(
            "its start state has joints that the path does not move elsewhere than where they are held; hold them there: --hold {}",
            elsewhere.join(" --hold ")
        );
        Err(self.refuse(text))
    }

    /// Where its message has a joint, if that is elsewhere than where it is held.
    fn elsewhere(&self, name: &str, value: f64) -> Option<String> {
        let start = self.start_of(name)?;
        ((start - value).abs() > HELD_TOLERANCE).then(|| format!("{name}={start}"))
    }

    /// Where a variable stands at the start, as last named.
    fn start_of(&self, name: &str) -> Option<f64> {
        let mut named = self.start.iter().rev();
        named
            .find(|(known, _)| known == name)
            .map(|(_, start)| *start)
    }

    fn refuse(&self, text: String) -> FileError {
        FileError::content(&self.file, text)
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
        let columns = names.columns(&self.variables);
        let (found, warning) = columns.map_err(|text| self.refuse(text))?;
        for row in &mut self.rows {
            *row = found
                .iter()
                .map(|(place, _)| row[*place])
                .collect();
        }
        self.variables = found
            .into_iter()
            .map(|(_, name)| name)
            .collect();
        self.check_finite()?;
        self.warnings
            .extend(warning.map(|text| Warning::cosmetic("columns", text)));
        Ok(self)
    }

    /// A time may be no number, until the robot has a joint of that name.
    fn check_finite(&self) -> Result<(), FileError> {
        for (index, row) in self.rows.iter().enumerate() {
            if let Some(bad) = row.iter().position(|value| !value.is_finite()) {
                let name = &self.variables[bad];
                let text = format!("row {index}, column {name:?} is not a finite number");
                return Err(self.refuse(text));
            }
        }
        Ok(())
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

    /// The path with its columns in the robot's order, and what its file asks it to keep besides
    /// clearance: who answers about the one without the other answers about something else.
    ///
    /// # Errors
    /// A column that the robot does not have, or one that is missing, with the names that it has.
    pub fn into_path(
        self,
        variables: &[Variable],
    ) -> Result<(path::Path, ConstraintsFile), FileError> {
        let table = self.for_variables(variables, &[])?;
        let order = columns::order(&table.variables, variables);
        let order = order.map_err(|text| table.refuse(text))?;
        let rows = table.rows.iter();
        let numbers = rows.flat_map(|row| order.iter().map(|&column| row[column]));
        match path::Path::from_rows(variables.len(), numbers.collect()) {
            Some(path) => Ok((path, table.constraints)),
            None => Err(table.refuse("the robot has no variables".to_owned())),
        }
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

/// Names of columns, and rows of them.
type Columns = (Vec<String>, Vec<Vec<f64>>);
type Parsed = Result<Columns, String>;

fn parse_json(text: &str) -> Result<(Columns, ConstraintsFile), String> {
    let expected = r#"not a path: a path is {"variables": [names], "path": [[numbers], …]}, or a .csv or .yaml file"#;
    let table: JsonTable =
        serde_json::from_str(text).map_err(|error| format!("{expected}: {error}"))?;
    let constraints = path_constraints(table.path_constraints)?;
    check_lengths(&table.path, table.variables.len())?;
    Ok(((table.variables, table.path), constraints))
}

fn check_lengths(rows: &[Vec<f64>], columns: usize) -> Result<(), String> {
    match rows.iter().position(|row| row.len() != columns) {
        None => Ok(()),
        Some(index) => Err(format!(
            "path row {index} has {} numbers, \"variables\" names {columns} columns",
            rows[index].len()
        )),
    }
}

/// Columns are parted by commas, or where the header has none by semicolons or tabs; numbers then
/// may have a comma.
fn parse_csv(text: &str) -> Parsed {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let delimiter = delimiter(text);
    let mut records = records(text, delimiter)?.into_iter().peekable();
    let header = records.peek().cloned().unwrap_or_default();
    let mut variables = names_above(text, delimiter, &header).unwrap_or_else(|| {
        records.next();
        header.iter().map(str::to_owned).collect()
    });
    // A comma at the end of every line parts nothing.
    let has_end = variables.len() > 1 && variables.last().is_some_and(String::is_empty);
    if has_end {
        variables.pop();
    }
    let rows = records.map(|record| csv_row(&record, &variables, has_end, delimiter != ','));
    let rows = rows.collect::<Result<_, _>>()?;
    Ok((variables, rows))
}

fn filled_lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .filter(|line| !line.trim().is_empty())
}

/// What parts the columns of the first line that is no comment.
fn delimiter(text: &str) -> char {
    let first = filled_lines(text).find(|line| !line.starts_with('#'));
    let first = first.unwrap_or_default();
    let mut marks = [',', ';', '\t'].into_iter();
    marks
        .find(|mark| first.contains(*mark))
        .unwrap_or(',')
}

fn records(text: &str, delimiter: char) -> Result<Vec<csv::StringRecord>, String> {
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader
        .comment(Some(b'#'))
        .delimiter(delimiter as u8)
        .trim(csv::Trim::All)
        .flexible(true);
    let mut reader = reader
        .has_headers(false)
        .from_reader(text.as_bytes());
    let records = reader.records();
    records
        .map(|record| record.map_err(|error| error.to_string()))
        .collect()
}

/// The names in the last comment above the numbers: NumPy writes them so.
fn names_above(text: &str, delimiter: char, first: &csv::StringRecord) -> Option<Vec<String>> {
    let comments = filled_lines(text).take_while(|line| line.starts_with('#'));
    names_in_comment(comments.last()?, delimiter, first)
}

/// The names in a comment above rows of numbers, one for each.
fn names_in_comment(line: &str, delimiter: char, first: &csv::StringRecord) -> Option<Vec<String>> {
    let names: Vec<String> = line
        .trim_start_matches('#')
        .split(delimiter)
        .map(|name| name.trim().to_owned())
        .collect();
    let are_numbers = first
        .iter()
        .all(|field| field.parse::<f64>().is_ok());
    let are_names = names
        .iter()
        .all(|name| !name.is_empty() && !name.contains(char::is_whitespace));
    let is_one_word = names.len() == 1
        && line
            .trim_start_matches('#')
            .trim()
            .parse::<f64>()
            .is_err();
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
    let is_longer = record.len() > variables.len();
    let ends_empty = has_end && is_longer && record.iter().next_back() == Some("");
    let numbers = record.len() - usize::from(ends_empty);
    if numbers != variables.len() {
        let names = variables.len();
        return Err(format!(
            "line {line} has {numbers} numbers, the header names {names}"
        ));
    }
    let fields = record.iter().zip(variables);
    fields
        .map(|(word, name)| {
            csv_number(word, name, has_decimal_commas).ok_or_else(|| bad_number(line, name, word))
        })
        .collect()
}

/// A number, or none for a time: whether it is a joint after all, the robot decides.
fn csv_number(word: &str, name: &str, has_decimal_commas: bool) -> Option<f64> {
    let word = match has_decimal_commas {
        true => &word.replace(',', "."),
        false => word,
    };
    let number = word
        .parse()
        .ok()
        .filter(|value: &f64| value.is_finite());
    number.or_else(|| columns::is_time(name).then_some(f64::NAN))
}

fn bad_number(line: u64, name: &str, word: &str) -> String {
    format!("line {line}, column {name:?}: {word:?} is not a finite number")
}

fn checked(variables: Vec<String>, rows: Vec<Vec<f64>>) -> Parsed {
    columns::check_unique(&variables)?;
    if rows.is_empty() {
        return Err("the path is empty; it needs a waypoint".to_owned());
    }
    Ok((variables, rows))
}
