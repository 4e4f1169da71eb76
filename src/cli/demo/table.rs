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
    let lines: Vec<[String; 9]> = rows.iter().map(cells).collect();
    let head = HEAD.map(str::to_owned);
    let width = |column: usize| {
        let cells = lines
            .iter()
            .chain([&head])
            .map(|cells| cells[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: [usize; 9] = std::array::from_fn(width);
    let mut text = String::new();
    for (cells, row) in
        std::iter::once((&head, None)).chain(lines.iter().zip(rows.iter().map(Some)))
    {
        let mut line = String::new();
        for (column, (cell, width)) in cells.iter().zip(widths).enumerate() {
            // Names to the left, figures to the right.
            let _ = if column < 2 {
                write!(line, "{cell:<width$}   ")
            } else {
                write!(line, "{cell:>width$}   ")
            };
        }
        // Why there is no answer stands behind the row.
        let reason = row.and_then(|row| {
            row.error
                .as_deref()
                .or((!row.message.is_empty()).then_some(&row.message))
        });
        line.push_str(reason.unwrap_or(""));
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

fn cells(row: &Row) -> [String; 9] {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    let length = |length: Option<f64>| or_dash(length.map(|length| format!("{length:.3}")));
    let clearance = match row.clearance_m {
        Some(metres) => format!("≥ {}", report::length(metres)),
        None => "-".to_owned(),
    };
    [
        format!("{} {}", row.planner, row.problem),
        row.robot.clone(),
        or_dash(row.planned_s.map(report::time)),
        length(row.length_before),
        length(row.length_after),
        or_dash(row.saved_percent().map(|percent| format!("{percent:.1}"))),
        if row.proved { "yes" } else { "no" }.to_owned(),
        clearance,
        or_dash(row.time_s.map(report::time)),
    ]
}
