//! A caller's columns and the robot's.

use super::PlannerError;
use crate::control::VariableDescription;
use crate::wire::Code;

/// Last parts of the names of variables whose joint has several.
const PARTS: [&str; 10] = [
    "x", "y", "theta", "trans_x", "trans_y", "trans_z", "rot_x", "rot_y", "rot_z", "rot_w",
];

/// Which of the robot's variables a caller's columns are, in the caller's order; the others stand
/// still.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// For each variable of the robot, where its numbers come from.
    sources: Vec<Source>,
    /// For each column of the caller, the robot's variable.
    variables: Vec<usize>,
    /// Variables of which nobody said where they stand.
    at_zero: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// A column of the caller.
    Column(usize),
    /// No column: this value in every row.
    Held(f64),
}

impl Columns {
    /// `names` are the caller's columns, none for all of the robot's in its order; `held` says
    /// where those stand that are no columns. Where it does not, a joint stands at 0, and the
    /// answer tells so ([`Self::note`]): the rule of paths in files.
    ///
    /// # Errors
    /// [`PlannerError::Invalid`] for a name that is none of `variables`, that is there twice, or
    /// that is missing where 0 is outside of its limits or its joint has other columns.
    pub fn new(
        variables: &[VariableDescription],
        names: &[String],
        held: &[(String, f64)],
    ) -> Result<Self, PlannerError> {
        if names.is_empty() {
            let all = 0..variables.len();
            let sources = all.clone().map(Source::Column).collect();
            return Ok(Self {
                sources,
                variables: all.collect(),
                at_zero: Vec::new(),
            });
        }
        let code = Code::InvalidRobotState;
        let mut sources = vec![None; variables.len()];
        let mut order = Vec::with_capacity(names.len());
        for (column, name) in names.iter().enumerate() {
            let found = variables
                .iter()
                .position(|variable| variable.name == *name);
            let Some(variable) = found else {
                let valid = variables
                    .iter()
                    .map(|variable| variable.name.as_str());
                return Err(PlannerError::unknown(
                    "column of the robot",
                    name,
                    valid,
                    code,
                ));
            };
            if sources[variable]
                .replace(Source::Column(column))
                .is_some()
            {
                return Err(PlannerError::invalid(
                    code,
                    format!("column {name:?} is there twice; name it once"),
                ));
            }
            order.push(variable);
        }
        let mut at_zero = Vec::new();
        for (source, variable) in sources
            .iter_mut()
            .zip(variables)
            .filter(|(source, _)| source.is_none())
        {
            whole_joint(variable, names)?;
            let value = held
                .iter()
                .rev()
                .find(|(held, _)| *held == variable.name)
                .map(|(_, value)| *value);
            if value.is_none() {
                at_zero.push(variable.name.clone());
            }
            *source = Some(Source::Held(value.map_or_else(|| rest(variable), Ok)?));
        }
        Ok(Self {
            sources: sources.into_iter().flatten().collect(),
            variables: order,
            at_zero,
        })
    }

    /// What an answer tells of columns that are missing and of which nobody said where they stand.
    pub fn note(&self) -> Option<String> {
        let names: Vec<&str> = self
            .at_zero
            .iter()
            .map(String::as_str)
            .collect();
        held_at_zero(&names)
    }

    /// Columns of the caller.
    pub fn width(&self) -> usize {
        self.variables.len()
    }

    /// Variables of the robot.
    pub fn robot_width(&self) -> usize {
        self.sources.len()
    }

    /// A byte per variable of the robot, 1 where it is a column.
    pub fn given(&self) -> Vec<u8> {
        self.sources
            .iter()
            .map(|source| u8::from(matches!(source, Source::Column(_))))
            .collect()
    }

    /// Whether they are all of the robot's, in its order.
    pub fn are_the_robots(&self) -> bool {
        self.width() == self.robot_width() && self.stretch().is_some()
    }

    /// The robot's variable of the first column, where the others follow it in the robot's order
    /// too: a row of the caller is then a piece of the robot's row.
    pub fn stretch(&self) -> Option<usize> {
        let first = *self.variables.first()?;
        (first..)
            .zip(&self.variables)
            .all(|(expected, variable)| expected == *variable)
            .then_some(first)
    }

    /// Rows of the caller as rows of the robot, one copy; both have as many rows.
    pub fn write(&self, rows: &[f64], robot_rows: &mut [f64]) {
        if self.are_the_robots() {
            robot_rows.copy_from_slice(rows);
            return;
        }
        let width = self.width();
        let robot_width = self.robot_width();
        for (row, robot_row) in rows
            .chunks_exact(width)
            .zip(robot_rows.chunks_exact_mut(robot_width))
        {
            for (number, source) in robot_row.iter_mut().zip(&self.sources) {
                *number = match *source {
                    Source::Column(column) => row[column],
                    Source::Held(value) => value,
                };
            }
        }
    }

    /// Rows of the robot as rows of the caller, one copy; both have as many rows.
    pub fn read(&self, robot_rows: &[f64], rows: &mut [f64]) {
        if self.are_the_robots() {
            rows.copy_from_slice(robot_rows);
            return;
        }
        let width = self.width();
        let robot_width = self.robot_width();
        for (row, robot_row) in rows
            .chunks_exact_mut(width)
            .zip(robot_rows.chunks_exact(robot_width))
        {
            for (number, variable) in row.iter_mut().zip(&self.variables) {
                *number = robot_row[*variable];
            }
        }
    }

    /// The caller's column of a variable of the robot.
    pub(super) fn column_of(&self, variable: usize) -> Option<usize> {
        let mut variables = self.variables.iter();
        variables.position(|own| *own == variable)
    }

    /// Of what there is for each of the robot's variables that of the caller's columns.
    pub(super) fn pick<T: Copy>(&self, of_robot: &[T]) -> Vec<T> {
        let variables = self.variables.iter();
        variables
            .filter_map(|variable| of_robot.get(*variable).copied())
            .collect()
    }
}

/// What an answer tells of joints that have no column, and of which nobody said where they stand.
pub fn held_at_zero(names: &[&str]) -> Option<String> {
    (!names.is_empty()).then(|| {
        format!(
            "the path has no column for {}: held still at 0",
            names.join(", ")
        )
    })
}

/// The joint that a variable belongs to.
fn joint(name: &str) -> &str {
    name.rsplit_once('/')
        .filter(|(_, part)| PARTS.contains(part))
        .map_or(name, |(joint, _)| joint)
}

/// Refuses a joint of which some variables are columns and this one is not.
fn whole_joint(missing: &VariableDescription, names: &[String]) -> Result<(), PlannerError> {
    let of = joint(&missing.name);
    let Some(there) = names
        .iter()
        .find(|name| of != missing.name && joint(name) == of)
    else {
        return Ok(());
    };
    let text = format!(
        "column {:?} is missing, {there:?} of the same joint is there; give all columns of joint {of:?}, or none",
        missing.name
    );
    Err(PlannerError::invalid(Code::InvalidRobotState, text))
}

/// Where a variable stands of which nobody says where: at 0, or without a turn.
fn rest(variable: &VariableDescription) -> Result<f64, PlannerError> {
    let VariableDescription {
        name, lower, upper, ..
    } = variable;
    let value = if variable.coordinates == 3 && name.ends_with("/rot_w") {
        1.0
    } else {
        0.0
    };
    if *lower > value || *upper < value {
        let text = format!(
            "column {name:?} is missing, and the joint cannot be held at {value}, outside [{lower}, {upper}]; add it, or say where it stands"
        );
        return Err(PlannerError::invalid(Code::InvalidRobotState, text));
    }
    Ok(value)
}
