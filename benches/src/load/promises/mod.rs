//! `taut-bench promises`: what the service promises, each measured with real processes, as a table.

mod cancelling;
mod cost;
mod deadlines;
mod deaths;
mod determinism;
mod fairness;
mod frames;
mod idle;
mod memory;
mod overhead;
mod overload;
mod planners;
mod poison;
mod recovery;
mod removed;
mod restarts;
mod row;
mod stopped;
mod trial;

use serde::Serialize;

use super::interrupt;
use crate::error::Error;
use crate::output::{Format, json, print, progress_bar};
use row::Row;
use trial::Trial;

/// One promise: its name on the command line, what is promised, and what measures it.
type Promise = (
    &'static str,
    &'static str,
    fn(&Trial) -> Result<Vec<Row>, Error>,
);

/// All of them, quick ones first.
const PROMISES: [Promise; 16] = [
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
        "removed",
        "an instance whose files are removed heals",
        removed::measure,
    ),
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
        "frames",
        "a camera's frames are seen at its rate",
        frames::measure,
    ),
    ("idle", "an idle daemon takes no processor", idle::measure),
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
/// printed and marked as not judged. The long form takes about 90 minutes and decides by all of it.
/// Times are judged against a control in the same run, in alternating windows, as the median ratio.
///
/// Exit code: 0 every promise that was judged is kept, 1 one is not, 69 a daemon that cannot be
/// started, 130 interrupted.
#[derive(clap::Args)]
pub(crate) struct Arguments {
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
pub(crate) fn run(arguments: &Arguments) -> Result<u8, Error> {
    interrupt::listen()?;
    let is_table = arguments.format == Format::Table;
    if is_table {
        print(&arguments.head())?;
    }
    let rows = arguments.rows(|row| match is_table {
        true => print(&row.line()),
        false => Ok(()),
    })?;
    let kept = rows.iter().all(|row| row.kept || !row.judged);
    if !is_table {
        print(&json(&arguments.report(kept, &rows)))?;
    }
    Ok(u8::from(!kept))
}

impl Arguments {
    fn trial(&self) -> Trial {
        Trial {
            long: self.long,
            seed: self.seed,
        }
    }

    fn head(&self) -> String {
        let form = self.trial().pick("short", "long");
        format!("seed {}   {form} form\n{}", self.seed, row::head())
    }

    fn report<'a>(&self, kept: bool, rows: &'a [Row]) -> Report<'a> {
        Report {
            seed: self.seed,
            long: self.long,
            kept,
            rows,
        }
    }

    /// The promises asked for.
    fn promises(&self) -> Vec<Promise> {
        let asked = |name: &str| self.only.is_empty() || self.only.iter().any(|one| one == name);
        let mut promises = PROMISES.to_vec();
        promises.retain(|(name, ..)| asked(name));
        promises
    }

    /// Measures one promise after another; `show` gets each row as soon as it is there.
    fn rows(&self, show: impl Fn(&Row) -> Result<(), Error>) -> Result<Vec<Row>, Error> {
        let promises = self.promises();
        let bar = progress_bar(promises.len() as u64);
        let mut rows = Vec::new();
        for (name, promise, measure) in promises {
            bar.set_message(promise);
            for row in measure(&self.trial())? {
                let row = Row {
                    promise: name,
                    judged: row.certain || self.long,
                    ..row
                };
                bar.suspend(|| show(&row))?;
                rows.push(row);
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(rows)
    }
}
