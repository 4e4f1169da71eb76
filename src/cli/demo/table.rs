//! The table of `taut demo`.

use std::fmt::Write;

use super::row::Row;
use crate::cli::report;

const HEAD: [&str; 9] = [
    "planner",
    "robot",
    "planned",
    "before",
    "after",
    "− %",
    "proved",
    "clearance",
    "time",
];

/// The rows for people: a planner each.
pub(super) fn table(rows: &[Row]) -> String {
    let mut lines = vec![(HEAD.map(str::to_owned), "")];
    lines.extend(
        rows.iter()
            .map(|row| (cells(row), row.reason())),
    );
    let width = |column: usize| {
        let cells = lines
            .iter()
            .map(|(cells, _)| cells[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths = std::array::from_fn(width);
    let mut text = String::new();
    for (cells, reason) in &lines {
        // Why there is no answer stands behind the row.
        let line = aligned(cells, widths) + reason;
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// The cells of a line: names to the left, figures to the right.
fn aligned(cells: &[String; 9], widths: [usize; 9]) -> String {
    let mut line = String::new();
    for (column, (cell, width)) in cells.iter().zip(widths).enumerate() {
        let _ = match column < 2 {
            true => write!(line, "{cell:<width$}   "),
            false => write!(line, "{cell:>width$}   "),
        };
    }
    line
}

fn cells(row: &Row) -> [String; 9] {
    let clearance_m = row.clearance_m;
    [
        format!("{} {}", row.planner, row.problem),
        row.robot.clone(),
        or_dash(row.planned_s, report::time),
        or_dash(row.length_before, length),
        or_dash(row.length_after, length),
        or_dash(row.saved_percent(), |percent| format!("{percent:.1}")),
        if row.proved { "yes" } else { "no" }.to_owned(),
        or_dash(clearance_m, |metres| {
            format!("≥ {}", report::length(metres))
        }),
        or_dash(row.time_s, report::time),
    ]
}

fn or_dash(value: Option<f64>, text: fn(f64) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), text)
}

fn length(length: f64) -> String {
    format!("{length:.3}")
}
