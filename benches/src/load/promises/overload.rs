//! Requests that arrive at once, twice and ten times as often as they can be served.

use std::time::Duration;

use taut_ipc::wire::Code;

use super::row::Row;
use super::trial::{Trial, median, ratio, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::{Pace, Window};
use crate::load::site::{Setup, Site};
use crate::load::tally::{LATE_NS, Tally};

const CLIENTS: usize = 16;
const DEADLINE: Duration = Duration::from_millis(150);
const TIMES: [f64; 3] = [1.0, 2.0, 10.0];

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    // A short queue, so that it runs full before the transport's own limit is reached.
    let site = Site::own(&Setup {
        workers: 1,
        lines: "queue = 12".to_owned(),
        ..Setup::default()
    })?;
    let mut flood = Flood {
        fleet: Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?,
        length: trial.pick(Duration::from_secs(1), Duration::from_secs(2)),
        sums: Default::default(),
        rates: Vec::new(),
        goodput: Default::default(),
    };
    for number in 0..trial.windows() {
        flood.rise(trial.window(number))?;
    }
    let exits = u64::from(!site.is_alive());
    let mut rows = flood.counts(exits);
    rows.extend(flood.figures());
    Ok(rows)
}

/// Clients whose requests arrive ever more often.
struct Flood {
    fleet: Fleet,
    length: Duration,
    /// What came of the requests, for each of [`TIMES`].
    sums: [Tally; 3],
    /// Saturation of each window (requests a second).
    rates: Vec<f64>,
    /// Goodput of each window, for each of [`TIMES`].
    goodput: [Vec<f64>; 3],
}

impl Flood {
    fn rise(&mut self, window: Window) -> Result<(), Error> {
        // What it can do now: the machine's other work changes.
        let full = run(&mut self.fleet, window, self.length)?.goodput();
        self.rates.push(full);
        for (index, times) in TIMES.iter().enumerate() {
            let rate_hz = times * full / CLIENTS as f64;
            let flood = Window {
                pace: Pace::Open { rate_hz },
                deadline_ns: DEADLINE.as_nanos() as u64,
                ..window
            };
            let tally = run(&mut self.fleet, flood, self.length)?;
            self.goodput[index].push(tally.goodput());
            self.sums[index].merge(&tally);
        }
        Ok(())
    }

    /// Goodput at the most arrivals over the most goodput. The best of some windows would be the one
    /// that the machine favoured: each is the median of its windows before they are compared.
    fn kept(&self) -> f64 {
        let [once, twice, ten] = self
            .goodput
            .each_ref()
            .map(|windows| median(windows));
        ratio(ten, once.max(twice).max(median(&self.rates)))
    }

    fn counts(&self, exits: u64) -> Vec<Row> {
        let [.., ten] = &self.sums;
        let all = Tally::of(&self.sums);
        let rate = median(&self.rates);
        let overloaded = ten.with(Code::Overloaded);
        vec![
            Row::told(
                "saturation, closed loop",
                format!("{rate:.0} a second"),
                rate,
            ),
            Row::none("daemon exits", exits),
            all.endless("requests"),
            Row::none(
                format!("of {} refused at 10x, without a hint", ten.refusal.len()),
                ten.without_hint,
            ),
            Row::is(
                "requests refused as OVERLOADED at 10x",
                "> 0",
                overloaded.to_string(),
                overloaded as f64,
                overloaded > 0,
            ),
        ]
    }

    fn figures(&self) -> [Row; 4] {
        let [.., ten] = &self.sums;
        let waits_long = ten
            .queue
            .share_above(DEADLINE.as_nanos() as u64 + LATE_NS);
        let late = ten.lateness.share_above(LATE_NS);
        [
            Row::at_least("goodput at 10x / the most", 0.9, self.kept()),
            Row::time(
                "a refusal comes within, p99 at 10x",
                0.01,
                ten.refusal.quantile(0.99),
            ),
            Row::part("requests that wait past their deadline", 0.001, waits_long),
            Row::told(
                "answers later than 1 ms after the deadline at 10x",
                format!("{:.2} %", late * 1e2),
                late,
            ),
        ]
    }
}
