//! `taut bench`: every problem below a folder, beside the recorded answers of others.

mod calibration;
mod chart;
mod check;
mod curve;
mod from;
mod grid;
mod idle;
mod measure;
mod meshes;
mod mode_summary;
mod moment;
mod peer_summary;
mod pooled;
mod problems;
mod repeats;
mod report;
mod row;
pub(in crate::cli) mod rules;
pub(in crate::cli) mod run;
mod sections;
mod statistics;
mod summary;
mod table;
#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use taut::optimize::{Mode, Workspace};

use super::error::{CliError, stdout};
use super::source::Source;
use super::{Format, load, progress_bar, quantity};
use from::From;
use problems::{set_name, stem};
use report::Report;
use row::Row;
use rules::Rules;

/// Shorten every problem of a folder and compare with the recorded answers of others
///
/// Each mode runs on each problem several times, one run after the other in one thread; loading is
/// left out. The runs must agree in every bit; their times are medians. With --deadline they may
/// differ, and the run of median length counts. Runs longer than 2 s are not repeated.
///
/// An answer that is not proved is the path given: it counts with the length 1. Two lengths within
/// 0.1 % tie. The calibration kernel is a fixed piece of arithmetic on a small table; its CPU time
/// relates machines.
///
/// Problems that cannot be read become rows with the reason. Exit code: 0 where all could be read
/// and run, whether their paths are proved or not; 65 otherwise.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Folder with problem files, at any depth
    folder: PathBuf,
    /// Optimizers to run, separated by commas; default: all but check
    #[arg(long, value_delimiter = ',', value_parser = rules::mode())]
    modes: Vec<Mode>,
    /// Runs of each optimizer on each problem
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// Times at which the lengths are compared, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.15ms,1ms,10ms", value_name = "TIMES",
        value_parser = quantity::duration)]
    at: Vec<Duration>,
    /// Shorten the recorded path of this peer instead of the planner's; problems without one are
    /// left out
    #[arg(long, value_name = "NAME")]
    from: Option<String>,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    rules: Rules,
    /// Measure the check instead: time to prove each path, to refuse the straight way, and to
    /// sample the path
    #[arg(long, conflicts_with_all = ["modes", "repeat", "at", "from", "svg", "deadline", "seed", "strict", "weights"])]
    check: bool,
    /// Only problems whose folder or file name contains this text
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// At most this many problems of each folder
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Draw remaining length over time into this file, a panel for each folder
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write the whole report as JSON to this file too
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Arguments {
    /// The optimizers to run, each once.
    fn modes(&self) -> Vec<Mode> {
        let all: Vec<Mode> = Mode::ALL
            .into_iter()
            .filter(|mode| *mode != Mode::Check)
            .collect();
        let mut modes: Vec<Mode> = Vec::new();
        for mode in if self.modes.is_empty() {
            &all
        } else {
            &self.modes
        } {
            if !modes.contains(mode) {
                modes.push(*mode);
            }
        }
        modes
    }
}

/// Runs every problem.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let files = problems::find(arguments)?;
    if arguments.check {
        return check(arguments, &files);
    }
    let calibration_s = calibration::seconds();
    let mut from = arguments.from.as_deref().map(From::new);
    let rows = measure(arguments, &files, from.as_mut())?;
    let report = Report::new(
        arguments,
        calibration_s,
        rows,
        from.map_or(0, |from| from.skipped),
    );
    show(arguments, &report.json(), || report.table())?;
    if let Some(file) = &arguments.svg {
        write(file, &chart::draw(&report))?;
    }
    Ok(if report.has_errors() { 65 } else { 0 })
}

/// A row for each problem, but for those without the path asked for.
fn measure(
    arguments: &Arguments,
    files: &[PathBuf],
    mut from: Option<&mut From>,
) -> Result<Vec<Row>, CliError> {
    let mut reader = load::reader(&arguments.source);
    let mut workspace = Workspace::default();
    let bar = progress_bar(files.len() as u64);
    let mut rows = Vec::with_capacity(files.len());
    for file in files {
        let mut row = Row {
            set: set_name(&arguments.folder, file),
            name: stem(file),
            ..Row::default()
        };
        bar.set_message(row.label());
        let loaded = load::load(&mut reader, file, &arguments.source, true);
        let taken = loaded.and_then(|mut loaded| {
            let taken = from
                .as_mut()
                .map_or(Ok(true), |from| from.take(&mut loaded))?;
            Ok(taken.then_some(loaded))
        });
        match taken {
            Ok(Some(loaded)) => measure::fill(&mut row, arguments, &loaded, &mut workspace),
            Ok(None) => {
                bar.inc(1);
                continue;
            }
            Err(error) => row.error = Some(error.to_string()),
        }
        rows.push(row);
        bar.inc(1);
    }
    bar.finish_and_clear();
    match from {
        Some(from) if rows.is_empty() => Err(from.unknown()),
        _ => Ok(rows),
    }
}

/// Measures the check on every problem.
fn check(arguments: &Arguments, files: &[PathBuf]) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let mut scratch = taut::validation::Scratch::default();
    let bar = progress_bar(files.len() as u64);
    let mut rows = Vec::with_capacity(files.len());
    for file in files {
        let set = set_name(&arguments.folder, file);
        let name = stem(file);
        bar.set_message(format!("{set}/{name}"));
        let measured = load::load(&mut reader, file, &arguments.source, true)
            .and_then(|loaded| check::measure(&loaded, arguments.rules.clearance, &mut scratch));
        rows.push(check::Row::new(set, name, measured));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let report = check::Report::new(rows);
    show(arguments, &report.json(), || report.table())?;
    Ok(if report.has_errors() { 65 } else { 0 })
}

/// Writes a report where the arguments want it.
fn show(arguments: &Arguments, json: &str, table: impl FnOnce() -> String) -> Result<(), CliError> {
    let json = format!("{json}\n");
    if let Some(file) = &arguments.out {
        write(file, &json)?;
    }
    let text = match arguments.format {
        Format::Json => json,
        Format::Table => table(),
    };
    std::io::stdout()
        .lock()
        .write_all(text.as_bytes())
        .map_err(stdout)
}

fn write(file: &Path, text: &str) -> Result<(), CliError> {
    std::fs::write(file, text).map_err(|source| CliError::Output {
        file: file.display().to_string(),
        source,
    })
}
