//! `taut-zenoh-lab promises`: what is promised, each measured with real processes on hosts, as a table.

mod answers;
mod cancelling;
mod cuts;
mod deaths;
mod ends;
mod far;
mod felt;
mod languages;
mod later;
mod links;
mod mutated;
mod overhead;
mod required;
mod routers;
mod scenes;
mod stopped;
mod trial;

use crate::error::Error;
use crate::row::{self, Row};
use required::is_all_required;
use trial::Trial;

/// One promise: its name on the command line, and what measures it.
type Promise = (&'static str, fn(&Trial) -> Result<Vec<Row>, Error>);

/// All of them.
const PROMISES: [Promise; 14] = [
    ("links", links::measure),
    ("answers", answers::measure),
    ("languages", languages::measure),
    ("later", later::measure),
    ("overhead", overhead::measure),
    ("cancelling", cancelling::measure),
    ("deaths", deaths::measure),
    ("cuts", cuts::measure),
    ("felt", felt::measure),
    ("routers", routers::measure),
    ("far", far::measure),
    ("scenes", scenes::measure),
    ("mutated", mutated::measure),
    ("stopped", stopped::measure),
];

/// Measure what is promised between machines, and print promised beside measured
///
/// Hosts are network namespaces with links whose delay, loss and cuts are switched while they run;
/// this takes root, iproute2 and /dev/net/tun, and leaves nothing behind. Without them it says NOT
/// RUN, which is a failure where TAUT_REQUIRE_ALL=1. The short form takes some minutes and decides
/// only by counts. The long form decides by times and ratios as well; ratios are medians of windows
/// that alternate with a control.
///
/// Exit code: 0 every promise that was judged is kept, 1 one is not, 67 a program is not there.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The long form
    #[arg(long)]
    long: bool,
    /// Only these, separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = clap::builder::PossibleValuesParser::new(PROMISES.map(|(name, _)| name)))]
    only: Vec<String>,
    /// Seed of losses, choices and deaths
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Measures.
pub(crate) fn run(arguments: &Arguments) -> Result<u8, Error> {
    let trial = Trial {
        long: arguments.long,
        seed: arguments.seed,
    };
    println!("{}", row::head());
    let mut broken = false;
    for (name, measure) in PROMISES {
        if arguments.asks_for(name) {
            broken |= promise(name, measure, &trial)?;
        }
    }
    Ok(u8::from(broken))
}

impl Arguments {
    fn asks_for(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|one| one == name)
    }
}

/// Measures one; tells whether it is broken.
fn promise(
    name: &str,
    measure: fn(&Trial) -> Result<Vec<Row>, Error>,
    trial: &Trial,
) -> Result<bool, Error> {
    let rows = match measure(trial) {
        Err(error) if error.is_of_the_machine() => {
            println!("{name:<10} NOT RUN: {error}");
            return Ok(is_all_required());
        }
        rows => rows?,
    };
    for row in &rows {
        println!("{}", row.line(name, trial.long));
    }
    Ok(rows.iter().any(|row| row.is_broken(trial.long)))
}
