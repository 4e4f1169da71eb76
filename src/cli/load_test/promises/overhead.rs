//! What the daemon takes of a round trip beyond waiting and computing, beside a bare echo of the
//! same sizes.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{Trial, median, ratio, run};
use crate::cli::error::CliError;
use crate::cli::load_test::bare::Echo;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::Window;
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::Times;
use crate::cli::load_test::{interrupt, wire_mode};
use crate::cli::report;

/// Clients at once, besides one alone.
const MANY: usize = 16;
/// What is compared: the median and the 99th percentile.
const PARTS: [f64; 2] = [0.5, 0.99];

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for (waypoints, what) in [(0, "short paths"), (500, "500 waypoints")] {
        rows.extend(sized(trial, waypoints, what)?);
    }
    Ok(rows)
}

fn sized(trial: &Trial, waypoints: usize, what: &str) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 1,
        waypoints,
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, 1)?;
    let mut many = Fleet::start(site.instance(), &site.jobs, 1, MANY)?;
    let echo = Echo::start()?;
    let length = trial.pick(Duration::from_millis(250), Duration::from_millis(500));
    let mut ratios = [Vec::new(), Vec::new()];
    let mut ours = Vec::new();
    let mut bare = Vec::new();
    let mut crowded = [Vec::new(), Vec::new()];
    let mut sizes = [0, 0];
    for number in 0..trial.pick(5, 24) {
        let window = Window {
            mode: wire_mode(Mode::Check),
            ..trial.window(number)
        };
        let tally = run(&mut fleet, window, length)?;
        let count = tally.latency.len().max(1);
        sizes = tally.bytes.map(|bytes| (bytes / count) as usize);
        let mut times = Times::default();
        let request = vec![1; sizes[0]];
        let end = std::time::Instant::now() + length;
        while std::time::Instant::now() < end {
            times.add(echo.round(&request, sizes[1])?.as_nanos() as u64);
        }
        interrupt::check()?;
        ours.push(tally.overhead.quantile(0.5));
        bare.push(times.quantile(0.5));
        let beside = run(&mut many, window, length)?;
        for (index, part) in PARTS.into_iter().enumerate() {
            ratios[index].push(ratio(tally.overhead.quantile(part), times.quantile(part)));
            crowded[index].push(beside.overhead.quantile(part));
        }
    }
    let told = format!(
        "{} / {}",
        report::time(median(&ours)),
        report::time(median(&bare))
    );
    let with_many = crowded
        .each_ref()
        .map(|all| report::time(median(all)))
        .join(", ");
    let [request, response] = sizes;
    Ok(vec![
        Row::at_most(
            format!("overhead p50 / bare echo p50, {what}"),
            2.0,
            median(&ratios[0]),
        ),
        Row::at_most(
            format!("overhead p99 / bare echo p99, {what}"),
            2.0,
            median(&ratios[1]),
        ),
        Row::told(
            format!("overhead p50, p99 with {MANY} clients, {what}"),
            with_many,
            median(&crowded[0]),
        ),
        Row::told(
            format!("p50 of the two, {request} B there and {response} B back"),
            told,
            median(&ours),
        ),
    ])
}
