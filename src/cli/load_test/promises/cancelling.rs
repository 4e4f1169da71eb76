//! Requests cancelled at random times; the next request says when the only worker is free.

use std::time::Duration;

use taut::optimize::Mode;
use taut_ipc::wire::RequestFlags;

use super::row::Row;
use super::trial::{Trial, median, run};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::{Pace, Window};
use crate::cli::load_test::site::{Setup, Site, number, until};
use crate::cli::load_test::tally::Tally;
use crate::cli::load_test::wire_mode;

/// Longest time until a request is cancelled.
const WITHIN: Duration = Duration::from_millis(8);
const WAYPOINTS: usize = 300;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 1,
        waypoints: WAYPOINTS,
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, 1)?;
    let length = trial.pick(Duration::from_millis(700), Duration::from_secs(4));
    let mut all = Tally::default();
    let mut p99 = [Vec::new(), Vec::new()];
    for index in 0..trial.windows() {
        let pace = Pace::Cancel {
            within_ns: WITHIN.as_nanos() as u64,
        };
        let window = Window {
            pace,
            budget: 0,
            ..trial.window(index)
        };
        let cancelled = run(&mut fleet, window, length)?;
        let check = Window {
            mode: wire_mode(Mode::Check),
            flags: RequestFlags::WITHOUT_CONTACTS,
            ..trial.window(index)
        };
        let undisturbed = run(&mut fleet, check, length)?;
        p99[0].push(cancelled.cancel.quantile(0.99));
        p99[1].push(undisturbed.overhead.quantile(0.99) + undisturbed.queue.quantile(0.99));
        all.merge(&cancelled);
    }
    let client = site.client()?;
    let idle = until(Duration::from_secs(5), || {
        Ok(number(&client, "requests_running")? == 0.0)
    })?;
    let [ours, control] = p99.map(|values| median(&values));
    Ok(vec![
        Row::none("daemon exits", u64::from(!site.is_alive())),
        Row::none(
            format!(
                "of {} requests after a cancelled one, without an end",
                all.sent
            ),
            all.lost,
        ),
        Row::none("workers still busy afterwards", u64::from(idle.is_none())),
        Row::told(
            "p99 without cancelling, the control",
            crate::cli::report::time(control),
            control,
        ),
        Row::time(
            "from cancelling to a free worker, p99 less the control",
            0.002,
            (ours - control).max(0.0),
        ),
    ])
}
