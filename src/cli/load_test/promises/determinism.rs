//! Equal requests have equal answers: alone and under load, by one worker and by two.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::Trial;
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::Window;
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::Tally;
use crate::cli::load_test::wire_mode;

const CLIENTS: usize = 6;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    let modes = [
        Mode::Check,
        Mode::Gradient,
        Mode::RandomShortcut,
        Mode::PartialShortcut,
        Mode::Contact,
        Mode::Hybrid,
    ];
    let length = trial.pick(Duration::from_millis(400), Duration::from_secs(20));
    let mut all: Vec<Tally> = modes.iter().map(|_| Tally::default()).collect();
    for workers in [1, 2] {
        let site = Site::own(&Setup {
            workers,
            ..Setup::default()
        })?;
        let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?;
        let mut alone = Fleet(vec![fleet.0.remove(0)]);
        for (mode, sum) in modes.into_iter().zip(&mut all) {
            let window = Window {
                mode: wire_mode(mode),
                budget: trial.pick(6_000, 0),
                ..trial.window(workers)
            };
            let once = Window {
                in_order: true,
                count: site.jobs.len() as u64,
                ..window
            };
            sum.merge(&Tally::of(&alone.run(once, Duration::from_secs(60))?));
            fleet.begin(window, length)?;
            sum.merge(&Tally::of(&alone.run(
                Window {
                    in_order: true,
                    ..window
                },
                length,
            )?));
            sum.merge(&Tally::of(&fleet.finish(length)?));
        }
    }
    for (mode, sum) in modes.into_iter().zip(&all) {
        let answers = sum.latency.len();
        let jobs = sum.answers.len();
        rows.push(Row::none(
            format!(
                "{} unequal of {answers} answers to {jobs} requests",
                mode.name()
            ),
            sum.unequal,
        ));
        rows.push(Row::none(
            format!("{} requests without their proved answer", mode.name()),
            sum.sent - sum.served,
        ));
    }
    Ok(rows)
}
