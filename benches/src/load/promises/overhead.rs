//! From a request to its answer, less computing, beside a bare echo of the same sizes.
//!
//! Clients of the daemon and of the echo are processes that send one request after the other in
//! closed loop and take the same stamps: before the memory of a request is loaned, and when its
//! final answer is there. What is compared is what a request takes beyond computing (as its answer
//! says; the echo computes nothing) and waiting for others, by one definition on both sides
//! ([`own_shares`]): from its sending, or from the answer before it where that came later, to its
//! own answer. A client that is alone waits for nobody, so that all of its way there and back
//! counts, with every hop inside the daemon. What the daemon says of waiting is not used. Of each
//! window the middle half is looked at ([`middle`]).
//!
//! Two processes that answer each other at once stay on one core, or find the other one awake.
//! Computing in between ends that for anybody: an echo that keeps its core busy for as long as the
//! daemon computes tells how much of the difference is the daemon's.

use std::time::Duration;

use taut::optimize::Mode;

use super::row::Row;
use super::trial::{Trial, median, ratio};
use crate::error::Error;
use crate::load::echo::Echo;
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::orders::{Exchange, Window, wire_mode};
use crate::load::rounds::{Round, middle, own_shares};
use crate::load::site::{Setup, Site};
use crate::load::tally::Tally;
use crate::load::times::Times;
use crate::units;

/// Clients at once, besides one alone.
const MANY: usize = 16;
/// What is compared: the median and the 99th percentile.
const PARTS: [(&str, f64); 2] = [("p50", 0.5), ("p99", 0.99)];

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
    let echo = Echo::start()?;
    let mut beside = Beside {
        alone: Pair::start(trial, &site, &echo, 1)?,
        crowd: Pair::start(trial, &site, &echo, MANY)?,
    };
    let exchange = beside.alone.exchange(trial)?;
    let mut seen = Seen::default();
    for number in 0..trial.pick(5, 24) {
        interrupt::check()?;
        let window = Window {
            exchange,
            ..checking(trial, number)
        };
        beside.look(number, window, &mut seen)?;
    }
    Ok(seen.rows(what, exchange))
}

/// All clients send the same mix.
fn checking(trial: &Trial, number: usize) -> Window {
    Window {
        mode: wire_mode(Mode::Check),
        in_order: true,
        ..trial.window(number)
    }
}

/// One client alone and many at once.
struct Beside {
    alone: Pair,
    crowd: Pair,
}

impl Beside {
    /// One fleet after the other, so that they do not disturb each other.
    fn look(&mut self, number: usize, window: Window, seen: &mut Seen) -> Result<(), Error> {
        seen.alone.add(self.alone.look(number, window)?);
        seen.crowd.add(self.crowd.look(number, window)?);
        Ok(())
    }
}

/// As many clients of the daemon as of the echo.
struct Pair {
    ours: Fleet,
    bare: Fleet,
    length: Duration,
}

impl Pair {
    fn start(trial: &Trial, site: &Site, echo: &Echo, clients: usize) -> Result<Self, Error> {
        Ok(Self {
            ours: Fleet::start(site.instance(), &site.jobs, 0, clients)?,
            bare: Fleet::of_echo(echo.instance(), clients)?,
            length: trial.pick(Duration::from_millis(250), Duration::from_millis(500)),
        })
    }

    /// As many bytes there and back as the daemon's requests and answers have in the mean.
    fn exchange(&mut self, trial: &Trial) -> Result<Exchange, Error> {
        let window = checking(trial, 0);
        let tally = Tally::of(&self.ours.run(window, self.length)?);
        let count = tally.latency.len().max(1);
        let [there, back] = tally
            .bytes
            .map(|bytes| (bytes / count) as usize);
        let compute_ns = (tally.compute.quantile(0.5) * 1e9) as u64;
        Ok(Exchange {
            there,
            back,
            compute_ns,
        })
    }

    /// The shares of the daemon, of the bare echo and of the busy one, which take turns in being
    /// first.
    fn look(&mut self, number: usize, window: Window) -> Result<[Times; 3], Error> {
        let mut all = [const { None }; 3];
        for turn in 0..3 {
            let which = (number + turn) % 3;
            all[which] = Some(self.shares_of(which, window)?);
        }
        Ok(all.map(Option::unwrap_or_default))
    }

    fn shares_of(&mut self, which: usize, mut window: Window) -> Result<Times, Error> {
        if which == 1 {
            window.exchange.compute_ns = 0;
        }
        let fleet = match which {
            0 => &mut self.ours,
            _ => &mut self.bare,
        };
        shares(fleet, window, self.length)
    }
}

/// Of all clients of a fleet, in one window.
fn shares(fleet: &mut Fleet, window: Window, length: Duration) -> Result<Times, Error> {
    let tallies = fleet.run(window, length)?;
    let rounds: Vec<Round> = tallies
        .into_iter()
        .flat_map(|tally| tally.rounds)
        .collect();
    let middle = middle(&rounds);
    Ok(own_shares(rounds, &middle))
}

/// What was seen.
#[derive(Default)]
struct Seen {
    alone: Compared,
    crowd: Compared,
}

impl Seen {
    fn rows(&self, what: &str, exchange: Exchange) -> Vec<Row> {
        let Exchange { there, back, .. } = exchange;
        let mut rows = self
            .alone
            .judged(1.5, &format!("1 client, {what}"));
        rows.push(
            self.alone
                .told(format!("  both, {there} B there and {back} B back")),
        );
        rows.push(self.alone.beside_busy());
        rows.extend(
            self.crowd
                .judged(2.0, &format!("{MANY} clients, {what}")),
        );
        rows.push(self.crowd.told("  both".to_owned()));
        rows.push(self.crowd.beside_busy());
        rows
    }
}

/// For each of [`PARTS`], a number for each window.
#[derive(Default)]
struct Compared {
    ratios: [Vec<f64>; 2],
    /// The same over an echo that computes as long.
    beside_busy: [Vec<f64>; 2],
    /// Of the daemon, of the bare echo, and of the busy one.
    medians: [[Vec<f64>; 2]; 3],
}

impl Compared {
    fn add(&mut self, all: [Times; 3]) {
        for (index, (_, part)) in PARTS.into_iter().enumerate() {
            let [ours, bare, busy] = all.each_ref().map(|times| times.quantile(part));
            self.ratios[index].push(ratio(ours, bare));
            self.beside_busy[index].push(ratio(ours, busy));
            for (medians, value) in self.medians.iter_mut().zip([ours, bare, busy]) {
                medians[index].push(value);
            }
        }
    }

    fn judged(&self, most: f64, what: &str) -> Vec<Row> {
        let rows = PARTS
            .iter()
            .zip(&self.ratios)
            .map(|((name, _), ratios)| {
                let figure = format!("{name} less computing / bare echo's, {what}");
                Row::at_most(figure, most, median(ratios))
            });
        rows.collect()
    }

    /// Beside an echo that keeps its core as busy: what both cost that the bare one has not to pay
    /// (cold caches, cores that sleep meanwhile, a client on another core) is on both sides then.
    fn beside_busy(&self) -> Row {
        let [p50, p99] = self
            .beside_busy
            .each_ref()
            .map(|ratios| median(ratios));
        Row::told(
            "  p50, p99 / those of an echo that computes as long",
            format!("{p50:.3}, {p99:.3}"),
            p50,
        )
    }

    /// The medians themselves.
    fn told(&self, figure: String) -> Row {
        let medians = self
            .medians
            .each_ref()
            .map(|parts| parts.each_ref().map(|values| median(values)));
        let texts = medians.map(|parts| parts.map(units::time).join(", "));
        Row::told(
            format!("{figure}, the echo that computes as long: p50, p99"),
            texts.join(" / "),
            medians[0][0],
        )
    }
}
