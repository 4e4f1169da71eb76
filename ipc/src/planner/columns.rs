//! A caller's columns and the robot's.

use super::PlannerError;
use crate::wire::Code;

/// Which of the robot's variables a caller's columns are, in the caller's order; the others stand still.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// For each variable of the robot, where its numbers come from.
    sources: Vec<Source>,
    /// For each column of the caller, the robot's variable.
    variables: Vec<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// A column of the caller.
    Column(usize),
    /// No column: this value in every row.
    Held(f64),
}

impl Columns {
    /// `names` are the caller's columns, none for all of the robot's in its order; `held` says where those stand that
    /// are no columns.
    ///
    /// # Errors
    /// [`PlannerError::Invalid`] for a name that is none of `variables`, that is there twice, or that is missing and not
    /// held.
    pub fn new(variables: &[&str], names: &[String], held: &[(String, f64)]) -> Result<Self, PlannerError> {
        if names.is_empty() {
            let all = 0..variables.len();
            return Ok(Self { sources: all.clone().map(Source::Column).collect(), variables: all.collect() });
        }
        let code = Code::InvalidRobotState;
        let mut sources = vec![None; variables.len()];
        let mut order = Vec::with_capacity(names.len());
        for (column, name) in names.iter().enumerate() {
            let found = variables.iter().position(|variable| variable == name);
            let Some(variable) = found else {
                return Err(PlannerError::unknown("column of the robot", name, variables.iter().copied(), code));
            };
            if sources[variable].replace(Source::Column(column)).is_some() {
                return Err(PlannerError::invalid(code, format!("column {name:?} is there twice; name it once")));
            }
            order.push(variable);
        }
        for (source, name) in sources.iter_mut().zip(variables).filter(|(source, _)| source.is_none()) {
            let value = held.iter().rev().find(|(held, _)| held == name).map(|(_, value)| *value);
            let Some(value) = value else {
                let message = format!(
                    "column {name:?} is missing and not held; add it, or say where it stands (valid: {})",
                    variables.join(", ")
                );
                return Err(PlannerError::invalid(code, message));
            };
            *source = Some(Source::Held(value));
        }
        Ok(Self { sources: sources.into_iter().flatten().collect(), variables: order })
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
        self.sources.iter().map(|source| u8::from(matches!(source, Source::Column(_)))).collect()
    }

    /// Whether they are all of the robot's, in its order.
    pub fn are_the_robots(&self) -> bool {
        self.width() == self.robot_width() && self.stretch().is_some()
    }

    /// The robot's variable of the first column, where the others follow it in the robot's order too: a row of the
    /// caller is then a piece of the robot's row.
    pub fn stretch(&self) -> Option<usize> {
        let first = *self.variables.first()?;
        (first..).zip(&self.variables).all(|(expected, variable)| expected == *variable).then_some(first)
    }

    /// Rows of the caller as rows of the robot, one copy; both have as many rows.
    pub fn write(&self, rows: &[f64], robot_rows: &mut [f64]) {
        if self.are_the_robots() {
            robot_rows.copy_from_slice(rows);
            return;
        }
        let (width, robot_width) = (self.width(), self.robot_width());
        for (row, robot_row) in rows.chunks_exact(width).zip(robot_rows.chunks_exact_mut(robot_width)) {
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
        let (width, robot_width) = (self.width(), self.robot_width());
        for (row, robot_row) in rows.chunks_exact_mut(width).zip(robot_rows.chunks_exact(robot_width)) {
            for (number, variable) in row.iter_mut().zip(&self.variables) {
                *number = robot_row[*variable];
            }
        }
    }
}
