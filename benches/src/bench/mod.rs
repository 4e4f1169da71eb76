//! `taut-bench bench`: every problem below a folder, beside the recorded answers of others, or beside
//! those of another build.

mod against;
mod arguments;
mod calibration;
mod chart;
mod check;
mod curve;
mod from;
mod grid;
mod idle;
mod loaded;
mod measure;
mod meshes;
mod mode_summary;
mod moment;
mod peer_summary;
mod pooled;
mod problems;
mod refusal;
mod repeats;
mod report;
mod row;
mod rules;
mod run;
mod sections;
mod source;
mod summary;
mod table;
#[cfg(test)]
mod tests;
mod time;

use std::path::Path;

use taut::optimize::Workspace;

pub(crate) use arguments::Arguments;

use crate::error::{BAD_DATA, Error};
use crate::output::{Format, print, write};
use against::Before;
use from::From;
use loaded::Loaded;
use problems::Chosen;
use report::Report;
use row::Row;

/// Runs every problem.
pub(crate) fn run(arguments: &Arguments) -> Result<u8, Error> {
    let files = problems::find(arguments)?;
    if arguments.check {
        return check(arguments, &files);
    }
    if arguments.time {
        return time(arguments, &files);
    }
    match &arguments.against {
        None => measure(arguments, &files),
        Some(before) => compare(arguments, &files, before),
    }
}

/// Shows what the answers amount to.
fn measure(arguments: &Arguments, files: &[Chosen]) -> Result<u8, Error> {
    let report = report(arguments, files)?;
    show(arguments, &report.json(), || report.table())?;
    if let Some(file) = &arguments.svg {
        write(file, &chart::draw(&report))?;
    }
    Ok(exit_code(report.has_errors()))
}

/// Shows which answers are not as they were.
fn compare(arguments: &Arguments, files: &[Chosen], before: &Path) -> Result<u8, Error> {
    // Read first, so that one that is none is known before the long run.
    let before = Before::read(before)?;
    let report = report(arguments, files)?;
    let compared = before.compare(&report.rows);
    if let Some(file) = &arguments.out {
        write(file, &report.json())?;
    }
    print(&compared.text())?;
    Ok(u8::from(compared.is_different()))
}

/// Measures the check on every problem.
fn check(arguments: &Arguments, files: &[Chosen]) -> Result<u8, Error> {
    let mut scratch = taut::validation::Scratch::default();
    let rows = problems::each(arguments, files, |set, name, loaded| {
        let measured = loaded
            .and_then(|loaded| check::measure(&loaded, arguments.rules.clearance, &mut scratch));
        Some(check::Row::new(set, name, measured))
    });
    let report = check::Report::new(rows);
    show(arguments, &report.json(), || report.table())?;
    Ok(exit_code(report.has_errors()))
}

/// Gives every problem times.
fn time(arguments: &Arguments, files: &[Chosen]) -> Result<u8, Error> {
    let report = time::report(arguments, files);
    show(arguments, &report.json(), || report.table())?;
    Ok(exit_code(report.has_errors()))
}

fn exit_code(has_errors: bool) -> u8 {
    if has_errors { BAD_DATA } else { 0 }
}

/// Runs the optimizers on every problem.
fn report(arguments: &Arguments, files: &[Chosen]) -> Result<Report, Error> {
    let calibration_s = calibration::seconds();
    let mut from = arguments.from.as_deref().map(From::new);
    let rows = rows(arguments, files, from.as_mut());
    let skipped = match from {
        Some(from) if rows.is_empty() => return Err(from.unknown()),
        from => from.map_or(0, |from| from.skipped),
    };
    Ok(Report::new(arguments, calibration_s, rows, skipped))
}

/// A row for each problem, but for those without the path asked for.
fn rows(arguments: &Arguments, files: &[Chosen], mut from: Option<&mut From>) -> Vec<Row> {
    let mut workspace = Workspace::default();
    problems::each(arguments, files, |set, name, loaded| {
        let mut row = Row {
            set,
            name,
            ..Row::default()
        };
        match loaded.and_then(|loaded| chosen(from.as_deref_mut(), loaded)) {
            Ok(Some(loaded)) => measure::fill(&mut row, arguments, &loaded, &mut workspace),
            Ok(None) => return None,
            Err(error) => row.error = Some(error.to_string()),
        }
        Some(row)
    })
}

/// The problem with the path asked for; `None` where it has none.
fn chosen(from: Option<&mut From>, mut loaded: Loaded) -> Result<Option<Loaded>, Error> {
    let has_it = from.map_or(Ok(true), |from| from.take(&mut loaded))?;
    Ok(has_it.then_some(loaded))
}

/// Writes a report where the arguments want it.
fn show(arguments: &Arguments, json: &str, table: impl FnOnce() -> String) -> Result<(), Error> {
    if let Some(file) = &arguments.out {
        write(file, json)?;
    }
    match arguments.format {
        Format::Json => print(json),
        Format::Table => print(&table()),
    }
}
