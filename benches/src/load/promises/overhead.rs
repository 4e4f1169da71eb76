//! What the daemon takes of a round trip beyond waiting and computing, beside a bare echo of the
//! same sizes.

use std::time::{Duration, Instant};

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{Trial, median, ratio, run};
use crate::error::Error;
use crate::load::bare::Echo;
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::orders::{Window, wire_mode};
use crate::load::site::{Setup, Site};
use crate::load::tally::Times;
use crate::units;

/// Clients at once, besides one alone.
const MANY: usize = 16;
/// What is compared: the median and the 99th percentile.
const PARTS: [f64; 2] = [0.5, 0.99];

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (waypoints, what) in [(0, "short paths"), (500, "500 waypoints")] {
        rows.extend(sized(trial, waypoints, what)?);
    }
    Ok(rows)
}

fn sized(trial: &Trial, waypoints: usize, what: &str) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup {
        workers: 1,
        waypoints,
        ..Setup::default()
    })?;
    let mut beside = Beside {
        one: Fleet::start(site.instance(), &site.jobs, 0, 1)?,
        many: Fleet::start(site.instance(), &site.jobs, 1, MANY)?,
        echo: Echo::start()?,
        length: trial.pick(Duration::from_millis(250), Duration::from_millis(500)),
    };
    let mut seen = Seen::default();
    for number in 0..trial.pick(5, 24) {
        let window = Window {
            mode: wire_mode(Mode::Check),
            ..trial.window(number)
        };
        beside.look(window, &mut seen)?;
    }
    Ok(seen.rows(what))
}

/// The daemon's clients and the echo.
struct Beside {
    one: Fleet,
    many: Fleet,
    echo: Echo,
    length: Duration,
}

impl Beside {
    /// One after the other, so that they do not disturb each other.
    fn look(&mut self, window: Window, seen: &mut Seen) -> Result<(), Error> {
        let one = run(&mut self.one, window, self.length)?;
        let count = one.latency.len().max(1);
        seen.sizes = one.bytes.map(|bytes| (bytes / count) as usize);
        let bare = self.bare(seen.sizes)?;
        interrupt::check()?;
        let many = run(&mut self.many, window, self.length)?;
        seen.add(&one.overhead, &bare, &many.overhead);
        Ok(())
    }

    /// Round trips of as many bytes there and back.
    fn bare(&self, [there, back]: [usize; 2]) -> Result<Times, Error> {
        let request = vec![1; there];
        let end = Instant::now() + self.length;
        let mut times = Times::default();
        while Instant::now() < end {
            let round = self.echo.round(&request, back)?;
            times.add(round.as_nanos() as u64);
        }
        Ok(times)
    }
}

/// What was seen, a number for each window.
#[derive(Default)]
struct Seen {
    /// For each of [`PARTS`].
    ratios: [Vec<f64>; 2],
    crowded: [Vec<f64>; 2],
    ours: Vec<f64>,
    bare: Vec<f64>,
    /// Bytes there and back.
    sizes: [usize; 2],
}

impl Seen {
    fn add(&mut self, one: &Times, bare: &Times, many: &Times) {
        self.ours.push(one.quantile(0.5));
        self.bare.push(bare.quantile(0.5));
        for (index, part) in PARTS.into_iter().enumerate() {
            let over_bare = ratio(one.quantile(part), bare.quantile(part));
            self.ratios[index].push(over_bare);
            self.crowded[index].push(many.quantile(part));
        }
    }

    fn rows(&self, what: &str) -> Vec<Row> {
        let [p50, p99] = self
            .ratios
            .each_ref()
            .map(|ratios| median(ratios));
        vec![
            Row::at_most(format!("overhead p50 / bare echo p50, {what}"), 2.0, p50),
            Row::at_most(format!("overhead p99 / bare echo p99, {what}"), 2.0, p99),
            self.crowded(what),
            self.of_the_two(),
        ]
    }

    fn crowded(&self, what: &str) -> Row {
        let medians = self.crowded.each_ref().map(|all| median(all));
        Row::told(
            format!("overhead p50, p99 with {MANY} clients, {what}"),
            medians.map(units::time).join(", "),
            medians[0],
        )
    }

    fn of_the_two(&self) -> Row {
        let [request, response] = self.sizes;
        let [ours, bare] = [&self.ours, &self.bare].map(|all| median(all));
        Row::told(
            format!("p50 of the two, {request} B there and {response} B back"),
            format!("{} / {}", units::time(ours), units::time(bare)),
            ours,
        )
    }
}
