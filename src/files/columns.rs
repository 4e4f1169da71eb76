//! What the columns of a file are for a robot: people record more than joints, and write units
//! beside their names.

use std::collections::BTreeSet;

use crate::robot::{JointKind, RobotDescription, RobotModel, Variable};

/// Names of a column that says when a row was recorded, in small letters, without unit.
const TIMES: [&str; 12] = [
    "time",
    "t",
    "%time",
    "__time",
    "timestamp",
    "stamp",
    "time_from_start",
    "time_s",
    "sec",
    "secs",
    "seconds",
    "rosbagtimestamp",
];
/// Units that numbers here are in.
const UNITS: [&str; 9] = [
    "rad", "radian", "radians", "m", "metre", "metres", "meter", "meters", "-",
];
/// Units that people write and numbers here are not in.
const OTHER_UNITS: [&str; 9] = [
    "deg",
    "degree",
    "degrees",
    "°",
    "mm",
    "millimetres",
    "millimeters",
    "cm",
    "turns",
];

/// Place and name of each column that is a variable, and a warning where others are not read.
pub(super) type Found = (Vec<(usize, String)>, Option<String>);

/// The names that a robot gives meaning to.
pub(super) struct Names {
    movable: Vec<String>,
    fixed: BTreeSet<String>,
}

impl Names {
    /// Any of the variables of a robot may be a column.
    pub fn of_description(robot: &RobotDescription) -> Self {
        let joints = robot
            .joints
            .iter()
            .map(|joint| (joint.name.as_str(), joint.kind));
        let all = robot
            .virtual_joint
            .iter()
            .map(|joint| (joint.name.as_str(), joint.kind))
            .chain(joints);
        Self::new(
            all.clone()
                .flat_map(|(name, kind)| kind.variable_names(name))
                .collect(),
            all,
        )
    }

    /// Only the variables of a path may.
    pub fn of_model(robot: &RobotModel) -> Self {
        let joints = robot
            .joints()
            .iter()
            .map(|joint| (joint.name.as_str(), joint.kind));
        Self::new(names_of(robot.variables()), joints)
    }

    /// Only these may, of a robot that has these joints besides, which never move.
    pub fn of_variables(variables: &[Variable], fixed: &[String]) -> Self {
        let fixed = fixed
            .iter()
            .map(|name| (name.as_str(), JointKind::Fixed));
        Self::new(names_of(variables), fixed)
    }

    fn new<'a>(movable: Vec<String>, joints: impl Iterator<Item = (&'a str, JointKind)>) -> Self {
        let fixed = joints.filter(|(_, kind)| *kind == JointKind::Fixed);
        Self {
            movable,
            fixed: fixed.map(|(name, _)| name.to_owned()).collect(),
        }
    }

    /// The columns that are variables.
    ///
    /// # Errors
    /// A column that is none and has no meaning here, with the valid names; one in a unit that is
    /// not read.
    pub fn columns(&self, columns: &[String]) -> Result<Found, String> {
        let mut found = Vec::new();
        let mut others = Vec::new();
        for (place, column) in columns.iter().enumerate() {
            match self.meaning(column)? {
                Some(name) => found.push((place, name)),
                None => others.push(column.as_str()),
            }
        }
        let names: Vec<&String> = found.iter().map(|(_, name)| name).collect();
        check_unique(&names)?;
        Ok((found, not_read(&others)))
    }

    /// The variable that a column is; `None` for a time or a fixed joint.
    fn meaning(&self, column: &str) -> Result<Option<String>, String> {
        let (bare, unit) = split_unit(column);
        for name in [column, bare] {
            if self.movable.iter().any(|known| known == name) {
                check_unit(column, unit.filter(|_| name != column))?;
                return Ok(Some(name.to_owned()));
            }
            if self.fixed.contains(name) || is_time(name) {
                return Ok(None);
            }
        }
        Err(self.unknown(column))
    }

    fn unknown(&self, column: &str) -> String {
        let valid = self.movable.join(", ");
        if column.parse::<f64>().is_ok() {
            return format!(
                "line 1 must name the columns, it has the number {column}; add a header row of: {valid}"
            );
        }
        format!("column {column:?} is no variable of the robot; valid: {valid}")
    }
}

/// Whether a column says when its row was recorded.
pub(super) fn is_time(name: &str) -> bool {
    let (bare, _) = split_unit(name);
    TIMES.contains(&bare.to_lowercase().as_str())
}

/// A header without its quotes, and the unit in brackets behind it.
fn split_unit(column: &str) -> (&str, Option<&str>) {
    let column = unquoted(column).trim();
    for brackets in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = in_brackets(column, brackets) {
            return (name, Some(unit));
        }
    }
    (column, None)
}

fn unquoted(column: &str) -> &str {
    let within = |quote: char| column.strip_prefix(quote)?.strip_suffix(quote);
    within('\'')
        .or_else(|| within('"'))
        .unwrap_or(column)
}

/// A name and the unit behind it in brackets.
fn in_brackets(column: &str, (open, close): (char, char)) -> Option<(&str, &str)> {
    let (name, unit) = column.strip_suffix(close)?.rsplit_once(open)?;
    let name = name.trim();
    let unit = unit.trim();
    (is_unit(unit) && !name.is_empty()).then_some((name, unit))
}

fn is_unit(word: &str) -> bool {
    let units = UNITS
        .iter()
        .chain(&OTHER_UNITS)
        .chain(&["s", "ms", "ns"]);
    units
        .into_iter()
        .any(|unit| word.eq_ignore_ascii_case(unit))
}

/// For each of the robot's variables, the place of its column.
///
/// # Errors
/// One that is missing, with the names that the robot has.
pub(super) fn order(columns: &[String], variables: &[Variable]) -> Result<Vec<usize>, String> {
    let position = |variable: &Variable| {
        let found = columns
            .iter()
            .position(|name| *name == variable.name);
        found.ok_or_else(|| missing(variable, variables))
    };
    variables.iter().map(position).collect()
}

fn missing(variable: &Variable, variables: &[Variable]) -> String {
    let known: Vec<&str> = variables
        .iter()
        .map(|v| v.name.as_str())
        .collect();
    format!(
        "column {:?} is missing; the robot needs {}",
        variable.name,
        known.join(", ")
    )
}

/// Refuses names that stand twice.
pub(super) fn check_unique<N: AsRef<str>>(names: &[N]) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    for name in names {
        let name = name.as_ref();
        if !seen.insert(name) {
            return Err(format!(
                "column {name:?} is there twice; names must be unique"
            ));
        }
    }
    Ok(())
}

/// Refuses a column in a unit that numbers here are not in.
fn check_unit(column: &str, unit: Option<&str>) -> Result<(), String> {
    match unit {
        Some(unit) if OTHER_UNITS.contains(&unit.to_lowercase().as_str()) => Err(format!(
            "column {column:?} is in {unit}; numbers are read in rad and m: convert them"
        )),
        _ => Ok(()),
    }
}

fn not_read(others: &[&str]) -> Option<String> {
    let names = others.join(", ");
    (!others.is_empty()).then(|| format!("columns that no joint moves by are not read: {names}"))
}

fn names_of(variables: &[Variable]) -> Vec<String> {
    let names = variables.iter().map(|variable| &variable.name);
    names.cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Names {
        let joints = [
            ("j1", JointKind::Revolute),
            ("8", JointKind::Prismatic),
            ("mount", JointKind::Fixed),
        ];
        Names::new(
            vec!["j1".to_owned(), "8".to_owned(), "joint (left)".to_owned()],
            joints.into_iter(),
        )
    }

    fn columns(header: &str) -> Result<Vec<(usize, String)>, String> {
        let header: Vec<String> = header.split(',').map(str::to_owned).collect();
        names().columns(&header).map(|(found, _)| found)
    }

    #[test]
    fn recorded_columns_are_told_from_joints() {
        let found = columns("time [s],j1 [rad],mount,'8',joint (left),Timestamp").unwrap();
        let expected = [(1, "j1"), (3, "8"), (4, "joint (left)")];
        assert_eq!(
            found,
            expected.map(|(place, name)| (place, name.to_owned()))
        );
        let (_, warning) = names()
            .columns(&["t".to_owned(), "j1".to_owned(), "mount".to_owned()])
            .unwrap();
        assert!(warning.unwrap().ends_with("t, mount"));
        assert_eq!(names().columns(&["j1".to_owned()]).unwrap().1, None);
    }

    #[test]
    fn what_no_column_can_be_is_refused_with_the_valid_ones() {
        for (header, part) in [
            ("j1,elbow", "\"elbow\""),
            ("j1 (deg)", "in deg"),
            ("0.5,8", "the number 0.5"),
            ("j1,j1 [rad]", "twice"),
        ] {
            let error = columns(header).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
        assert!(
            columns("elbow")
                .unwrap_err()
                .contains("valid: j1, 8, joint (left)")
        );
    }
}
