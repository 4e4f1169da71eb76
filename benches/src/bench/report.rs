//! All that a benchmark found.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::Serialize;

use super::arguments::Arguments;
use super::pooled;
use super::row::Row;
use super::summary::Summary;
use crate::output;

/// Rows and what they amount to. Times are in seconds, lengths in each problem's metric.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// CPU time of the calibration kernel on this machine.
    pub calibration_s: f64,
    /// Runs of each mode on each problem.
    pub repeat: usize,
    /// Times at which lengths are compared.
    pub budgets_s: Vec<f64>,
    /// Deadline of each run.
    pub deadline_s: Option<f64>,
    /// Peer whose paths stand in the place of the planners'.
    pub from: Option<String>,
    /// Problems left out because no path of that peer is recorded.
    pub skipped: usize,
    /// Modes, in the order asked for.
    pub modes: Vec<&'static str>,
    /// One for each problem.
    pub rows: Vec<Row>,
    /// One for each folder.
    pub sets: Vec<Summary>,
    /// One for all sets that share the beginning of their names.
    pub pooled: Vec<Summary>,
}

impl Report {
    /// Sums up the rows.
    pub(super) fn new(
        arguments: &Arguments,
        calibration_s: f64,
        rows: Vec<Row>,
        skipped: usize,
    ) -> Self {
        let modes: Vec<&'static str> = arguments
            .modes()
            .iter()
            .map(|mode| mode.name())
            .collect();
        let [sets, pooled] = summaries(&rows, &modes, arguments.at.len());
        Self {
            calibration_s,
            repeat: arguments.repeat.into(),
            budgets_s: arguments
                .at
                .iter()
                .map(Duration::as_secs_f64)
                .collect(),
            deadline_s: arguments
                .rules
                .deadline
                .as_ref()
                .map(Duration::as_secs_f64),
            from: arguments.from.clone(),
            skipped,
            modes,
            rows,
            sets,
            pooled,
        }
    }

    /// Whether a problem could not be read or run, or its runs differ.
    pub(super) fn has_errors(&self) -> bool {
        self.rows.iter().any(|row| row.error.is_some())
    }

    /// All of it as JSON.
    pub(super) fn json(&self) -> String {
        output::json(self)
    }
}

/// Of each set, and of each family of sets.
fn summaries(rows: &[Row], modes: &[&'static str], budgets: usize) -> [Vec<Summary>; 2] {
    let by_set = by_set(rows);
    let families = pooled::groups(by_set.keys().copied());
    let pool = |(family, sets): (&str, Vec<&str>)| {
        let rows: Vec<&Row> = sets
            .iter()
            .flat_map(|set| &by_set[set])
            .copied()
            .collect();
        Summary::of(&format!("{family} (pooled)"), &rows, modes, budgets)
    };
    let pooled = families.into_iter().map(pool).collect();
    let each = |(set, rows): (&&str, &Vec<&Row>)| Summary::of(set, rows, modes, budgets);
    [by_set.iter().map(each).collect(), pooled]
}

fn by_set(rows: &[Row]) -> BTreeMap<&str, Vec<&Row>> {
    let mut by_set: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        by_set.entry(&row.set).or_default().push(row);
    }
    by_set
}
