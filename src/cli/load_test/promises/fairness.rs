//! One greedy client beside seven normal ones.

use std::time::Duration;

use super::row::Row;
use super::trial::{Trial, median, ratio};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::{Pace, Window};
use crate::cli::load_test::report::Fairness;
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::Tally;

const NORMAL: usize = 7;
/// Part of the saturation that the normal clients ask for together.
const LOAD: f64 = 0.35;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for (what, budget) in [
        ("equal requests", super::trial::BUDGET),
        ("requests of any length", 0),
    ] {
        rows.extend(against(trial, what, budget)?);
    }
    Ok(rows)
}

fn against(trial: &Trial, what: &str, budget: u64) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 2,
        ..Setup::default()
    })?;
    let mut normal = Fleet::start(site.instance(), &site.jobs, 0, NORMAL)?;
    let mut greedy = Fleet::start(site.instance(), &site.jobs, NORMAL, 1)?;
    let length = trial.pick(Duration::from_secs(1), Duration::from_secs(3));
    let mut ratios = Vec::new();
    let mut all = Tally::default();
    let mut taken = 0;
    let mut jain = Vec::new();
    for number in 0..trial.windows() {
        let full = Tally::of(&normal.run(trial.window(number), length / 2)?).goodput();
        let pace = Pace::Open {
            rate_hz: full * LOAD / NORMAL as f64,
        };
        let window = Window {
            pace,
            ..trial.window(number)
        };
        let mut p99 = [0.0; 2];
        for turn in [number % 2, 1 - number % 2] {
            if turn == 1 {
                greedy.begin(
                    Window {
                        pace: Pace::Greedy,
                        budget,
                        ..window
                    },
                    length,
                )?;
            }
            let each = normal.run(window, length)?;
            let tally = Tally::of(&each);
            p99[turn] = tally.latency.quantile(0.99);
            all.merge(&tally);
            if turn == 1 {
                taken += Tally::of(&greedy.finish(length)?).served;
                let parts: Vec<u64> = each
                    .iter()
                    .map(|one| one.served * 1000 / one.sent.max(1))
                    .collect();
                jain.push(Fairness::of(&parts).jain);
            }
        }
        ratios.push(ratio(p99[1], p99[0]));
    }
    let jain = median(&jain);
    Ok(vec![
        Row::at_most(
            format!("normal p99 beside a greedy client, {what} / alone"),
            2.0,
            median(&ratios),
        ),
        Row::told(
            "  Jain's index of the normal clients' served parts",
            format!("{jain:.4}"),
            jain,
        ),
        Row::told(
            "  answers that the greedy client got",
            taken.to_string(),
            taken as f64,
        ),
        Row::none(
            format!("of {} normal requests, without an end", all.sent),
            all.lost,
        ),
    ])
}
