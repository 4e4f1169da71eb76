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
    let mut all = Tally::default();
    let mut ours = Vec::new();
    let mut control = Vec::new();
    for number in 0..trial.windows() {
        let window = trial.window(number);
        let cancelled = run(&mut fleet, cancelling(window), length)?;
        let calm = run(&mut fleet, checking(window), length)?;
        ours.push(cancelled.cancel.quantile(0.99));
        control.push(calm.overhead.quantile(0.99) + calm.queue.quantile(0.99));
        all.merge(&cancelled);
    }
    Ok(vec![
        Row::none("daemon exits", u64::from(!site.is_alive())),
        all.endless("requests after a cancelled one"),
        Row::none("workers still busy afterwards", still_busy(&site)?),
        Row::told(
            "p99 without cancelling, the control",
            units::time(median(&control)),
            median(&control),
        ),
        Row::time(
            "from cancelling to a free worker, p99 less the control",
            0.002,
            (median(&ours) - median(&control)).max(0.0),
        ),
    ])
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
