//! `taut-bench bench --time`: each problem's shortened path with times, beside the least there can be and
//! what others were seen to do.

mod executed;
mod measure;
mod report;
mod row;

use super::arguments::Arguments;
use super::problems::{self, Chosen};
use report::Report;
use row::Row;

/// Times every problem.
pub(super) fn report(arguments: &Arguments, files: &[Chosen]) -> Report {
    let rows = problems::each(arguments, files, |set, name, loaded| {
        let measured = loaded.and_then(|loaded| measure::measure(arguments, &loaded));
        let (figures, error) = match measured {
            Ok(figures) => (Some(figures), None),
            Err(error) => (None, Some(error.to_string())),
        };
        Some(Row {
            set,
            name,
            error,
            figures,
        })
    });
    Report::new(rows)
}
