//! A daemon that nobody asks anything: it waits, and so do its clients.

use std::time::{Duration, Instant};

use super::row::Row;
use super::trial::Trial;
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::process::cpu_ns_of;
use crate::load::site::{Setup, Site};

/// Clients that are connected.
const MANY: usize = 64;
/// Time for a daemon that was asked something to come to rest.
const SETTLE: Duration = Duration::from_secs(2);
/// How often a signal is looked for.
const TICK: Duration = Duration::from_millis(100);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::own(&Setup::default())?;
    let nobody = idle(trial, &site, 0)?;
    let fleet = Fleet::start(site.instance(), &site.jobs, 0, MANY)?;
    let many = idle(trial, &site, fleet.0.len())?;
    Ok(vec![
        nobody,
        many,
        Row::none("daemon exits", u64::from(!site.is_alive())),
    ])
}

/// CPU of the daemon as part of a core.
fn idle(trial: &Trial, site: &Site, clients: usize) -> Result<Row, Error> {
    let pid = site.serving()?;
    sleep(SETTLE)?;
    let start = Instant::now();
    let before_ns = cpu_ns_of(pid);
    sleep(trial.pick(Duration::from_secs(2), Duration::from_secs(60)))?;
    let spent_ns = cpu_ns_of(pid) - before_ns;
    let part = spent_ns as f64 / start.elapsed().as_nanos() as f64;
    let figure = format!("of a core that an idle daemon takes, {clients} clients");
    Ok(Row::part(figure, 0.001, part))
}

fn sleep(time: Duration) -> Result<(), Error> {
    let end = Instant::now() + time;
    loop {
        interrupt::check()?;
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(());
        }
        std::thread::sleep(left.min(TICK));
    }
}
