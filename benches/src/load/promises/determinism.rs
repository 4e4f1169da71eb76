//! Equal requests have equal answers: alone and under load, by one worker and by two.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{Trial, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::{Window, wire_mode};
use crate::load::site::Site;
use crate::load::tally::Tally;

const CLIENTS: usize = 6;
/// How long one client may take for every job once.
const ONCE: Duration = Duration::from_secs(60);

const MODES: [Mode; 6] = [
    Mode::Check,
    Mode::Gradient,
    Mode::RandomShortcut,
    Mode::PartialShortcut,
    Mode::Contact,
    Mode::Hybrid,
];

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut all: [Tally; MODES.len()] = Default::default();
    for workers in [1, 2] {
        let site = Site::of_workers(workers)?;
        let mut crowd = Crowd {
            alone: Fleet::start(site.instance(), &site.jobs, 0, 1)?,
            others: Fleet::start(site.instance(), &site.jobs, 1, CLIENTS - 1)?,
            jobs: site.jobs.len() as u64,
            length: trial.pick(Duration::from_millis(400), Duration::from_secs(20)),
        };
        for (mode, sum) in MODES.into_iter().zip(&mut all) {
            let window = Window {
                mode: wire_mode(mode),
                budget: trial.pick(6_000, 0),
                ..trial.window(workers)
            };
            sum.merge(&crowd.answers(window)?);
        }
    }
    let rows = MODES
        .iter()
        .zip(&all)
        .flat_map(|(mode, sum)| rows(mode.name(), sum));
    Ok(rows.collect())
}

/// One client and many others.
struct Crowd {
    alone: Fleet,
    others: Fleet,
    jobs: u64,
    length: Duration,
}

impl Crowd {
    /// Every job by one client alone, then by all together.
    fn answers(&mut self, window: Window) -> Result<Tally, Error> {
        let in_order = Window {
            in_order: true,
            ..window
        };
        let once = Window {
            count: self.jobs,
            ..in_order
        };
        let mut sum = run(&mut self.alone, once, ONCE)?;
        self.others.begin(window, self.length)?;
        sum.merge(&run(&mut self.alone, in_order, self.length)?);
        sum.merge(&Tally::of(&self.others.finish(self.length)?));
        Ok(sum)
    }
}

fn rows(mode: &str, sum: &Tally) -> [Row; 2] {
    let answers = sum.latency.len();
    let jobs = sum.answers.len();
    [
        Row::none(
            format!("{mode} unequal of {answers} answers to {jobs} requests"),
            sum.unequal,
        ),
        Row::none(
            format!("{mode} requests without their proved answer"),
            sum.sent - sum.served,
        ),
    ]
}
