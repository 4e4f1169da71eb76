//! Requests that arrive at once, twice and ten times as often as they can be served.

use std::time::Duration;

use super::row::Row;
use super::trial::{Trial, median, ratio};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::{Pace, Window};
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::{LATE_NS, Tally};
use taut_ipc::wire::Code;

const CLIENTS: usize = 16;
const DEADLINE: Duration = Duration::from_millis(150);
const TIMES: [f64; 3] = [1.0, 2.0, 10.0];

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    // A short queue, so that it runs full before the transport's own limit is reached.
    let site = Site::own(&Setup {
        workers: 1,
        lines: "queue = 12".to_owned(),
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?;
    let length = trial.pick(Duration::from_secs(1), Duration::from_secs(2));
    let mut ratios = Vec::new();
    let mut sums: [Tally; 3] = Default::default();
    let mut rates = Vec::new();
    let deadline_ns = DEADLINE.as_nanos() as u64;
    for number in 0..trial.windows() {
        // What it can do now: the machine's other work changes.
        let full = Tally::of(&fleet.run(trial.window(number), length)?).goodput();
        rates.push(full);
        let mut goodput = [0.0; 3];
        for (index, times) in TIMES.iter().enumerate() {
            let pace = Pace::Open {
                rate_hz: times * full / CLIENTS as f64,
            };
            let window = Window {
                pace,
                deadline_ns,
                ..trial.window(number)
            };
            let tally = Tally::of(&fleet.run(window, length)?);
            goodput[index] = tally.goodput();
            sums[index].merge(&tally);
        }
        ratios.push(ratio(goodput[2], goodput[0].max(goodput[1]).max(full)));
    }
    let ten = &sums[2];
    let lost: u64 = sums.iter().map(|sum| sum.lost).sum();
    let sent: u64 = sums.iter().map(|sum| sum.sent).sum();
    let waits_long = ten.queue.share_above(deadline_ns + LATE_NS);
    let rate = median(&rates);
    Ok(vec![
        Row::told(
            "saturation, closed loop",
            format!("{rate:.0} a second"),
            rate,
        ),
        Row::none("daemon exits", u64::from(!site.is_alive())),
        Row::none(format!("of {sent} requests, without an end"), lost),
        Row::none(
            format!("of {} refused at 10x, without a hint", ten.refusal.len()),
            ten.without_hint,
        ),
        Row::is(
            "requests refused as OVERLOADED at 10x",
            "> 0",
            ten.with(Code::Overloaded).to_string(),
            ten.with(Code::Overloaded) as f64,
            ten.with(Code::Overloaded) > 0,
        ),
        Row::at_least("goodput at 10x / the most", 0.9, median(&ratios)),
        Row::time(
            "a refusal comes within, p99 at 10x",
            0.01,
            ten.refusal.quantile(0.99),
        ),
        Row::part("requests that wait past their deadline", 0.001, waits_long),
        Row::told(
            "answers later than 1 ms after the deadline at 10x",
            format!("{:.2} %", ten.lateness.share_above(LATE_NS) * 1e2),
            ten.lateness.share_above(LATE_NS),
        ),
    ])
}
