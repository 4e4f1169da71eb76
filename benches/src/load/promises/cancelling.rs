//! Requests cancelled at random times; the next request says when the only worker is free.

use std::time::Duration;

use taut::optimize::Mode;
use taut_ipc::wire::RequestFlags;

use super::row::Row;
use super::trial::{Trial, median, run};
use crate::error::Error;
use crate::load::control::number;
use crate::load::fleet::Fleet;
use crate::load::orders::wire_mode;
use crate::load::orders::{Pace, Window};
use crate::load::site::{Setup, Site, until};
use crate::load::tally::Tally;
use crate::units;

/// Longest time until a request is cancelled.
const WITHIN: Duration = Duration::from_millis(8);
const WAYPOINTS: usize = 300;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup {
        workers: 1,
        waypoints: WAYPOINTS,
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, 1)?;
    let length = trial.pick(Duration::from_millis(700), Duration::from_secs(4));
    let mut seen = Seen::default();
    for number in 0..trial.windows() {
        let window = trial.window(number);
        let cancelled = run(&mut fleet, cancelling(window), length)?;
        let calm = run(&mut fleet, checking(window), length)?;
        seen.add(&cancelled, &calm);
    }
    let mut rows = seen.counts(&site)?;
    rows.extend(seen.times());
    Ok(rows)
}

/// What came of the cancelled requests, and the p99 of each window beside its control (s).
#[derive(Default)]
struct Seen {
    all: Tally,
    ours: Vec<f64>,
    control: Vec<f64>,
}

impl Seen {
    fn add(&mut self, cancelled: &Tally, calm: &Tally) {
        let control = calm.overhead.quantile(0.99) + calm.queue.quantile(0.99);
        self.ours.push(cancelled.cancel.quantile(0.99));
        self.control.push(control);
        self.all.merge(cancelled);
    }

    fn counts(&self, site: &Site) -> Result<Vec<Row>, Error> {
        Ok(vec![
            Row::none("daemon exits", u64::from(!site.is_alive())),
            self.all
                .endless("requests after a cancelled one"),
            Row::none("workers still busy afterwards", still_busy(site)?),
        ])
    }

    fn times(&self) -> [Row; 2] {
        let control = median(&self.control);
        let excess = median(&self.ours) - control;
        [
            Row::told(
                "p99 without cancelling, the control",
                units::time(control),
                control,
            ),
            Row::time(
                "from cancelling to a free worker, p99 less the control",
                0.002,
                excess.max(0.0),
            ),
        ]
    }
}

fn cancelling(window: Window) -> Window {
    let within_ns = WITHIN.as_nanos() as u64;
    Window {
        pace: Pace::Cancel { within_ns },
        budget: 0,
        ..window
    }
}

/// What is asked after a cancelled request, without one.
fn checking(window: Window) -> Window {
    Window {
        mode: wire_mode(Mode::Check),
        flags: RequestFlags::WITHOUT_CONTACTS,
        ..window
    }
}

/// 1 where a request still runs.
fn still_busy(site: &Site) -> Result<u64, Error> {
    let client = site.client()?;
    let idle = until(Duration::from_secs(5), || {
        Ok(number(&client, "requests_running")? == 0.0)
    })?;
    Ok(u64::from(idle.is_none()))
}
