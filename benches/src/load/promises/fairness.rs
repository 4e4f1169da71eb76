//! One greedy client beside seven normal ones.

use std::time::Duration;

use super::row::Row;
use super::trial::{Trial, disturbed_over_calm, median, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::{Pace, Window};
use crate::load::report::Fairness;
use crate::load::site::Site;
use crate::load::tally::Tally;

const NORMAL: usize = 7;
/// Part of the saturation that the normal clients ask for together.
const LOAD: f64 = 0.35;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (what, budget) in [
        ("equal requests", super::trial::BUDGET),
        ("requests of any length", 0),
    ] {
        rows.extend(against(trial, what, budget)?);
    }
    Ok(rows)
}

fn against(trial: &Trial, what: &str, budget: u64) -> Result<Vec<Row>, Error> {
    let site = Site::of_workers(2)?;
    let mut clients = Clients {
        normal: Fleet::start(site.instance(), &site.jobs, 0, NORMAL)?,
        greedy: Fleet::start(site.instance(), &site.jobs, NORMAL, 1)?,
        budget,
        length: trial.pick(Duration::from_secs(1), Duration::from_secs(3)),
        all: Tally::default(),
        taken: 0,
        jain: Vec::new(),
    };
    let mut ratios = Vec::new();
    for number in 0..trial.windows() {
        let window = clients.at_ease(trial.window(number))?;
        ratios.push(disturbed_over_calm(number, |is_greedy| {
            clients.p99(window, is_greedy)
        })?);
    }
    Ok(clients.rows(what, median(&ratios)))
}

/// Seven that ask for their part, and one that asks for all it can.
struct Clients {
    normal: Fleet,
    greedy: Fleet,
    /// Work of each greedy request; 0 = any.
    budget: u64,
    length: Duration,
    /// What came of the normal requests.
    all: Tally,
    /// Answers that the greedy client got.
    taken: u64,
    /// Jain's index of the normal clients' served parts beside it.
    jain: Vec<f64>,
}

impl Clients {
    /// A window in which the normal clients ask for a part of what can be served now.
    fn at_ease(&mut self, window: Window) -> Result<Window, Error> {
        let full = run(&mut self.normal, window, self.length / 2)?.goodput();
        let rate_hz = full * LOAD / NORMAL as f64;
        Ok(Window {
            pace: Pace::Open { rate_hz },
            ..window
        })
    }

    /// The normal clients' p99 in a window (s).
    fn p99(&mut self, window: Window, is_greedy: bool) -> Result<f64, Error> {
        if is_greedy {
            let all_it_can = Window {
                pace: Pace::Greedy,
                budget: self.budget,
                ..window
            };
            self.greedy.begin(all_it_can, self.length)?;
        }
        let each = self.normal.run(window, self.length)?;
        if is_greedy {
            self.taken += Tally::of(&self.greedy.finish(self.length)?).served;
            self.jain
                .push(Fairness::of(&served_parts(&each)).jain);
        }
        let tally = Tally::of(&each);
        self.all.merge(&tally);
        Ok(tally.latency.quantile(0.99))
    }

    fn rows(&self, what: &str, ratio: f64) -> Vec<Row> {
        let jain = median(&self.jain);
        vec![
            Row::at_most(
                format!("normal p99 beside a greedy client, {what} / alone"),
                2.0,
                ratio,
            ),
            Row::told(
                "  Jain's index of the normal clients' served parts",
                format!("{jain:.4}"),
                jain,
            ),
            Row::told(
                "  answers that the greedy client got",
                self.taken.to_string(),
                self.taken as f64,
            ),
            self.all.endless("normal requests"),
        ]
    }
}

/// Thousandths of each client's requests that were served.
fn served_parts(each: &[Tally]) -> Vec<u64> {
    each.iter()
        .map(|one| one.served * 1000 / one.sent.max(1))
        .collect()
}
