//! A machine stops (SIGSTOP) while large answers come to it; the others do not feel it.

use rustix::process::Signal;
use std::time::Duration;

use super::trial::Trial;
use crate::error::Error;
use crate::fleet::{self, Member};
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs::{jobs, sized};
use crate::network::{cable, hosts};
use crate::orders::{Asking, Tally};
use crate::row::Row;
use crate::statistics::{median, quantile, ratio, time};

const OTHERS: usize = 7;
/// Clients of the machine that stops, each with an answer of some megabytes.
const STOPPED: usize = 4;
/// From asking until answers are on their way.
const INTO_ANSWERS: Duration = Duration::from_millis(150);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, planners, stopping] = hosts(["a", "planners", "stopping"])?;
    cable(&a, &planners)?;
    cable(&a, &stopping)?;
    let mut station = Station::start(&a, 2, &[])?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&a)], &[])?;
    let stops = Attached::start(&stopping, "stops", &[endpoint(&a)], &[])?;
    let mut sides = Sides {
        others: fleet::planners(&planners, attached.instance(), OTHERS)?,
        stopped: fleet::planners(&stopping, stops.instance(), STOPPED)?,
        stops,
        length_ms: trial.pick(1_000, 2_000),
        all: [Tally::default(), Tally::default()],
    };
    let mut seen = [Vec::new(), Vec::new()];
    let mut ratios = Vec::new();
    for number in 0..trial.pick(3, 20) {
        let mut p99 = [0.0; 2];
        for turn in [number % 2, 1 - number % 2] {
            p99[turn] = sides.window(turn == 1)?;
            seen[turn].push(p99[turn]);
        }
        ratios.push(ratio(p99[1], p99[0]));
    }
    let [calm, disturbed] = &sides.all;
    let sent = calm.sent + disturbed.sent;
    Ok(vec![
        Row::none("daemon exits", u64::from(!station.daemon.is_alive())),
        Row::none("gateway exits", u64::from(!station.gateway.is_alive())),
        Row::none(
            format!("of {sent} requests of the others, without a proved answer"),
            sent - calm.served() - disturbed.served(),
        ),
        Row::at_most(
            "p99 of seven others, one stopped / it reads",
            1.1,
            median(&ratios),
        ),
        Row::told(
            "  p99 of windows, one stopped, it reads; longest",
            [
                median(&seen[1]),
                median(&seen[0]),
                quantile(&disturbed.times, 1.0),
            ]
            .map(time)
            .join(", "),
        ),
    ])
}

struct Sides {
    others: Vec<Member>,
    stopped: Vec<Member>,
    stops: Attached,
    length_ms: u64,
    /// What came of the others' requests, in calm windows and in disturbed ones.
    all: [Tally; 2],
}

impl Sides {
    /// The others' p99 (s).
    fn window(&mut self, is_stopped: bool) -> Result<f64, Error> {
        let large = Asking {
            jobs: vec![sized(2 << 20)],
            count: 1,
            patience_ms: 60_000,
            ..Asking::default()
        };
        let small = Asking {
            jobs: jobs()?,
            length_ms: self.length_ms,
            patience_ms: 60_000,
            ..Asking::default()
        };
        fleet::begin(&mut self.stopped, &large)?;
        std::thread::sleep(INTO_ANSWERS);
        if is_stopped {
            self.stops.process().signal(Signal::STOP);
        }
        let tally = Tally::of(fleet::all(&mut self.others, &small)?);
        self.stops.process().signal(Signal::CONT);
        fleet::finish(&mut self.stopped, &large)?;
        let p99 = quantile(&tally.times, 0.99);
        self.all[usize::from(is_stopped)].merge(tally);
        Ok(p99)
    }
}
