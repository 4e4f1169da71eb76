//! `taut promises`: what the service promises, each measured with real processes, as a table.

mod cancelling;
mod cost;
mod deadlines;
mod deaths;
mod determinism;
mod fairness;
mod memory;
mod overhead;
mod overload;
mod planners;
mod poison;
mod restarts;
mod row;
mod stopped;
mod trial;

use std::io::Write;

use serde::Serialize;

use super::interrupt;
use crate::cli::error::{CliError, stdout};
use crate::cli::{Format, progress_bar};
use row::Row;
use trial::Trial;

/// One promise: its name on the command line, what is promised, and what measures it.
type Promise = (
    &'static str,
    &'static str,
    fn(&Trial) -> Result<Vec<Row>, CliError>,
);

/// All of them, quick ones first.
const PROMISES: [Promise; 13] = [
    (
        "determinism",
        "equal requests have equal answers",
        determinism::measure,
    ),
    (
        "poison",
        "a poisonous request hurts only itself",
        poison::measure,
    ),
    ("deaths", "a dying client harms nobody", deaths::measure),
    ("restarts", "the daemon may die", restarts::measure),
    (
        "stopped",
        "stopped readers hold nobody up",
        stopped::measure,
    ),
    (
        "overload",
        "overload is refused at once and costs no goodput",
        overload::measure,
    ),
    (
        "fairness",
        "a greedy client does not starve others",
        fairness::measure,
    ),
    (
        "deadlines",
        "answers come by their deadline",
        deadlines::measure,
    ),
    (
        "cancelling",
        "a cancelled request frees its worker",
        cancelling::measure,
    ),
    (
        "overhead",
        "the daemon's own share is near the transport's",
        overhead::measure,
    ),
    (
        "cost",
        "a request costs what the optimizer costs",
        cost::measure,
    ),
    ("planners", "planners stay small", planners::measure),
    ("memory", "memory is bounded", memory::measure),
];

/// Measure what the service promises, with real processes, and print promised beside measured
///
/// Starts daemons and planners of its own, kills and stops some of them, and leaves nothing behind.
/// The short form takes some minutes and decides only by what no noise can change; its times are
/// printed and marked as not judged. The long form takes about 80 minutes and decides by all of it.
/// Times are judged against a control in the same run, in alternating windows, as the median ratio.
///
/// Exit code: 0 every promise that was judged is kept, 1 one is not, 69 a daemon that cannot be
/// started, 130 interrupted.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// The long form
    #[arg(long)]
    long: bool,
    /// Only these, separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = clap::builder::PossibleValuesParser::new(PROMISES.map(|(name, ..)| name)))]
    only: Vec<String>,
    /// Seed of arrivals, choices and deaths
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Serialize)]
struct Report<'a> {
    seed: u64,
    long: bool,
    kept: bool,
    rows: &'a [Row],
}

/// Measures.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    interrupt::listen()?;
    let chosen =
        |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|only| only == name);
    let promises = || PROMISES.iter().filter(|(name, ..)| chosen(name));
    let bar = progress_bar(promises().count() as u64);
    let trial = Trial {
        long: arguments.long,
        seed: arguments.seed,
    };
    let mut rows = Vec::new();
    if arguments.format == Format::Table {
        print(&format!(
            "seed {}   {} form\n{}",
            arguments.seed,
            trial.pick("short", "long"),
            row::head()
        ))?;
    }
    for (name, promise, measure) in promises() {
        bar.set_message((*promise).to_owned());
        for row in measure(&trial)? {
            let row = Row {
                promise: name,
                judged: row.certain || arguments.long,
                ..row
            };
            if arguments.format == Format::Table {
                bar.suspend(|| print(&row.line()))?;
            }
            rows.push(row);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let kept = rows.iter().all(|row| row.kept || !row.judged);
    if arguments.format == Format::Json {
        let report = Report {
            seed: arguments.seed,
            long: arguments.long,
            kept,
            rows: &rows,
        };
        print(
            &(serde_json::to_string(&report).expect("a report holds only strings and numbers")
                + "\n"),
        )?;
    }
    Ok(u8::from(!kept))
}

fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(stdout)
}
