//! How requests ended, as rows.

use crate::daemon::{Daemon, number};
use crate::error::Error;
use crate::orders::Tally;
use crate::row::Row;
use crate::statistics::time;
use taut_ipc::Client;

/// Every request ends, with an answer or a code.
pub(super) fn ends(tally: &Tally, when: &str) -> Vec<Row> {
    let longest = tally.times.iter().copied().fold(0.0, f64::max);
    vec![
        Row::none(
            format!("of {} requests {when}, without an end", tally.sent),
            tally.endless,
        ),
        Row::told("  how they ended", tally.told()),
        Row::told("  longest time to an end", time(longest)),
        Row::told("  those over 1 s: sent at, took", slow(tally)),
    ]
}

/// A few of the slow ones.
fn slow(tally: &Tally) -> String {
    let some = tally.slow.iter().take(6);
    let told: Vec<String> = some
        .map(|(sent, took)| format!("{sent:.1} {took:.2}"))
        .collect();
    format!("{}: {}", tally.slow.len(), told.join(", "))
}

/// What daemons have finished.
pub(super) struct Runs {
    daemons: Vec<Client>,
    before: f64,
}

impl Runs {
    /// Counts from here.
    pub(super) fn of<const N: usize>(daemons: [&Daemon; N]) -> Result<Self, Error> {
        let clients = daemons.into_iter().map(Daemon::client);
        let daemons = clients.collect::<Result<Vec<_>, Error>>()?;
        let before = finished(&daemons)?;
        Ok(Self { daemons, before })
    }

    /// Those that nobody got the answer of: requests that were run twice.
    pub(super) fn twice(&self, tally: &Tally) -> Result<Row, Error> {
        let runs = finished(&self.daemons)? - self.before;
        let twice = runs - tally.served() as f64;
        Ok(Row::told(
            format!("  of {runs} runs that were finished, second ones"),
            twice.to_string(),
        ))
    }
}

fn finished(daemons: &[Client]) -> Result<f64, Error> {
    daemons
        .iter()
        .map(|daemon| number(daemon, "requests_answered"))
        .sum()
}
