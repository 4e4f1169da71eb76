//! Nobody computes for a caller that is gone.

use taut_ipc::{Client, monotonic_ns};

use super::trial::Trial;
use crate::daemon::number;
use crate::error::Error;
use crate::fleet::Member;
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs;
use crate::network::{Host, Link, Weather, hosts};
use crate::process::until;
use crate::row::Row;
use crate::statistics::{median, time};
use rustix::process::Signal;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(20);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, planners] = hosts(["a", "planners"])?;
    let link = Link::between(&a, &planners, trial.seed)?;
    let station = Station::start(&a, 2, &[])?;
    let mut ends = Ends {
        daemon: station.daemon.client()?,
        attached: attach(&planners, &a, 0)?,
        started: 0,
        link,
        planners,
        times: trial.pick(3, 20),
        station,
        a,
    };
    let mut rows = ends.asked("loopback", 0, 0.02)?;
    rows.extend(ends.asked("100 ms away", 100, 0.15)?);
    rows.extend(ends.row("caller killed", 0.5, |ends, member| {
        member.process().signal(Signal::KILL);
        Ok(ends)
    })?);
    rows.extend(ends.row("its machine's process killed", 0.5, |ends, _| {
        ends.attached.process().signal(Signal::KILL);
        Ok(ends)
    })?);
    rows.extend(ends.row("its machine's process stopped", 1.3, |ends, _| {
        ends.attached.process().signal(Signal::STOP);
        Ok(ends)
    })?);
    rows.extend(ends.row("cut off", 1.3, |ends, _| {
        ends.link.set(Weather::CUT);
        Ok(ends)
    })?);
    Ok(rows)
}

/// Each has a name of its own: the one before may still be there.
fn attach(planners: &Host, a: &Host, number: u32) -> Result<Attached, Error> {
    Attached::start(planners, &format!("at-{number}"), &[endpoint(a)], &[])
}

/// Both ends of a request.
struct Ends {
    // Processes before hosts: fields are dropped in order.
    daemon: Client,
    attached: Attached,
    /// How many were started after the first.
    started: u32,
    link: Link,
    planners: Host,
    times: u64,
    station: Station,
    a: Host,
}

impl Ends {
    /// A request that runs.
    fn running(&self) -> Result<Member, Error> {
        let mut member = Member::planner(&self.planners, self.attached.instance())?;
        member.hold(&jobs::endless()?)?;
        Ok(member)
    }

    /// How long the daemon goes on (s); `None` where it does not stop.
    fn stops_after(&self, begun_ns: u64) -> Option<f64> {
        until(PATIENCE, || {
            number(&self.daemon, "requests_running").is_ok_and(|running| running == 0.0)
        })?;
        Some((monotonic_ns() - begun_ns) as f64 * 1e-9)
    }

    /// The caller drops its stream.
    fn asked(&mut self, where_: &str, round_trip_ms: u64, most: f64) -> Result<Vec<Row>, Error> {
        let mut seen = Vec::new();
        for _ in 0..self.times {
            let mut member = self.running()?;
            self.link.set(Weather::far(round_trip_ms, 0.0));
            let begun = member.cancel()?;
            seen.push(self.stops_after(begun));
            self.link.set(Weather::CLEAR);
        }
        Ok(rows(&format!("cancelled, {where_}"), most, &seen))
    }

    /// Something happens to the caller; afterwards all is as before.
    fn row(
        &mut self,
        what: &str,
        most: f64,
        mut happen: impl for<'a> FnMut(&'a mut Self, &Member) -> Result<&'a mut Self, Error>,
    ) -> Result<Vec<Row>, Error> {
        let mut seen = Vec::new();
        for _ in 0..self.times {
            let member = self.running()?;
            let begun = monotonic_ns();
            happen(self, &member)?;
            seen.push(self.stops_after(begun));
            self.link.set(Weather::CLEAR);
            drop(member);
            self.attached.process().end();
            self.started += 1;
            self.attached = attach(&self.planners, &self.a, self.started)?;
        }
        let mut rows = rows(what, most, &seen);
        rows.push(Row::none(
            "  daemon exits",
            u64::from(!self.station.daemon.is_alive()),
        ));
        Ok(rows)
    }
}

fn rows(what: &str, most: f64, seen: &[Option<f64>]) -> Vec<Row> {
    let times: Vec<f64> = seen.iter().copied().flatten().collect();
    let longest = times.iter().copied().fold(0.0, f64::max);
    vec![
        Row::none(
            format!("{what}: of {} requests, still computed", seen.len()),
            (seen.len() - times.len()) as u64,
        ),
        Row::time(
            format!(
                "  until the daemon stops, longest (median {})",
                time(median(&times))
            ),
            most,
            longest,
        ),
    ]
}
