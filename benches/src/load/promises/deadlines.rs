//! Requests that never end by themselves, with deadlines, beside a process that sleeps to the same
//! deadlines.

use std::time::Duration;

use taut_ipc::wire::Code;

use super::row::Row;
use super::trial::{FAULTS, HANG_SEED, Trial, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::{Pace, Window};
use crate::load::site::{Setup, Site};
use crate::load::tally::{LATE_NS, Tally};
use crate::units;

const DEADLINES_MS: [u64; 4] = [1, 5, 20, 100];
/// Waypoints of the paths: more than the optimizer is done with in the longest deadline.
const WAYPOINTS: usize = 300;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup {
        workers: 2,
        waypoints: WAYPOINTS,
        lines: FAULTS.to_owned(),
        ..Setup::default()
    })?;
    let mut beside = Beside {
        asker: Fleet::start(site.instance(), &site.jobs, 0, 1)?,
        sleeper: Fleet::start(site.instance(), &site.jobs, 1, 1)?,
        length: trial.pick(Duration::from_millis(500), Duration::from_secs(4)),
    };
    let mut rows = Vec::new();
    let mut ours = Tally::default();
    let mut control = Tally::default();
    for deadline_ms in DEADLINES_MS {
        let [asked, slept] = beside.of_deadline(trial, deadline_ms)?;
        rows.push(told(deadline_ms, &asked, &slept));
        ours.merge(&asked);
        control.merge(&slept);
    }
    let excess = late(&ours) - late(&control);
    ours.merge(&beside.hung(trial)?);
    rows.push(Row::none(
        format!("of {} answers, neither proved nor TIMED_OUT", ours.sent),
        ours.sent - expected(&ours),
    ));
    rows.push(Row::part(
        "answers more than 1 ms late, less the control's part",
        0.001,
        excess,
    ));
    Ok(rows)
}

/// A client with deadlines and a process that sleeps to the same.
struct Beside {
    asker: Fleet,
    sleeper: Fleet,
    length: Duration,
}

impl Beside {
    /// What came of the requests, and of the sleeps.
    fn of_deadline(&mut self, trial: &Trial, deadline_ms: u64) -> Result<[Tally; 2], Error> {
        let mut asked = Tally::default();
        let mut slept = Tally::default();
        for number in 0..trial.windows() {
            let window = Window {
                budget: 0,
                deadline_ns: deadline_ms * 1_000_000,
                ..trial.window(number)
            };
            let sleep = Window {
                pace: Pace::Sleep,
                ..window
            };
            self.sleeper.begin(sleep, self.length)?;
            asked.merge(&run(&mut self.asker, window, self.length)?);
            slept.merge(&Tally::of(&self.sleeper.finish(self.length)?));
        }
        Ok([asked, slept])
    }

    /// At its worst place: a request that stays where it is and is asked to stop.
    fn hung(&mut self, trial: &Trial) -> Result<Tally, Error> {
        let window = Window {
            request_seed: Some(HANG_SEED),
            deadline_ns: 20_000_000,
            budget: 0,
            ..trial.window(0)
        };
        run(&mut self.asker, window, self.length)
    }
}

/// Part of the answers that came more than 1 ms after their deadline.
fn late(tally: &Tally) -> f64 {
    tally.lateness.share_above(LATE_NS)
}

fn told(deadline_ms: u64, asked: &Tally, slept: &Tally) -> Row {
    let p99 = |tally: &Tally| units::time(tally.lateness.quantile(0.99));
    let measured = format!(
        "{:.2} % / {:.2} %, p99 {} / {}",
        late(asked) * 1e2,
        late(slept) * 1e2,
        p99(asked),
        p99(slept)
    );
    Row::told(
        format!("{deadline_ms} ms: more than 1 ms late / a sleeping process"),
        measured,
        late(asked),
    )
}

/// Proved, early or late, or out of time.
fn expected(tally: &Tally) -> u64 {
    let late = tally.refused.get("LATE").copied().unwrap_or(0);
    tally.served + tally.with(Code::TimedOut) + late
}
