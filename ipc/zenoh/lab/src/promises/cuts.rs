//! A link is cut for longer than a lease, and heals.

use std::time::Duration;

use super::ends::{Runs, ends};
use super::trial::Trial;
use crate::error::Error;
use crate::fleet::{self, Member};
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs::jobs;
use crate::network::{Host, Link, Weather, cable, hosts};
use crate::orders::{Asking, Tally};
use crate::row::Row;
use crate::statistics::time;

const CLIENTS: usize = 3;
/// How long requests are asked before a cut and after it.
const BEFORE: Duration = Duration::from_secs(1);
const AFTER: Duration = Duration::from_secs(4);
/// Until a dead link is noticed and a request is answered elsewhere, and until it is given up where
/// there is no other gateway (s).
const LEASE_S: f64 = 1.5;
const ALONE_S: f64 = 2.6;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, b, planners] = hosts(["a", "b", "planners"])?;
    let link = Link::between(&a, &planners, trial.seed)?;
    cable(&b, &planners)?;
    let stations = [Station::start(&a, 1, &[])?, Station::start(&b, 1, &[])?];
    let mut site = Site {
        alone: Attached::start(&planners, "alone", &[endpoint(&a)], &[])?,
        both: Attached::start(
            &planners,
            "both",
            &[endpoint(&a), endpoint(&b)],
            &["--daemon", "a", "--daemon", "b"],
        )?,
        link,
        planners,
        stations,
        _others: [a, b],
    };
    let mut rows = Vec::new();
    for seconds in trial.pick(vec![5], vec![5, 30]) {
        rows.extend(site.cut(Duration::from_secs(seconds))?);
    }
    Ok(rows)
}

struct Site {
    // Processes before hosts: fields are dropped in order.
    alone: Attached,
    both: Attached,
    stations: [Station; 2],
    link: Link,
    planners: Host,
    _others: [Host; 2],
}

impl Site {
    fn cut(&mut self, length: Duration) -> Result<Vec<Row>, Error> {
        let mut alone = fleet::planners(&self.planners, self.alone.instance(), CLIENTS)?;
        let mut both = fleet::planners(&self.planners, self.both.instance(), CLIENTS)?;
        let asking = Asking {
            jobs: jobs()?,
            length_ms: (BEFORE + length + AFTER).as_millis() as u64,
            patience_ms: 30_000,
            ..Asking::default()
        };
        let [a, b] = &self.stations;
        let runs = Runs::of([&a.daemon, &b.daemon])?;
        fleet::begin(&mut alone, &asking)?;
        fleet::begin(&mut both, &asking)?;
        std::thread::sleep(BEFORE);
        self.link.set(Weather::CUT);
        std::thread::sleep(length);
        self.link.set(Weather::CLEAR);
        let of_alone = Tally::of(fleet::finish(&mut alone, &asking)?);
        let of_both = Tally::of(fleet::finish(&mut both, &asking)?);
        let cut = format!("{} s cut", length.as_secs());
        let mut rows = ends(&of_alone, &format!("to one gateway, {cut}"));
        rows.extend(ends(&of_both, &format!("with another gateway, {cut}")));
        let mut of_all = of_alone.clone();
        of_all.merge(of_both.clone());
        rows.push(runs.twice(&of_all)?);
        rows.push(Row::none(
            format!(
                "of {} requests with another gateway, {cut}, without a proved answer",
                of_both.sent
            ),
            of_both.sent - of_both.served(),
        ));
        rows.push(longest("one gateway", ALONE_S, &of_alone));
        rows.push(longest("another gateway", LEASE_S, &of_both));
        rows.push(healed(&mut alone)?);
        Ok(rows)
    }
}

fn longest(who: &str, most: f64, tally: &Tally) -> Row {
    let longest = tally.times.iter().copied().fold(0.0, f64::max);
    Row::time(format!("longest time to an end, {who}"), most, longest)
}

/// Who had only the gateway that was cut off has it again.
fn healed(members: &mut [Member]) -> Result<Row, Error> {
    let asking = Asking {
        jobs: jobs()?,
        count: 8,
        patience_ms: 30_000,
        ..Asking::default()
    };
    let tally = Tally::of(fleet::all(members, &asking)?);
    Ok(Row::none(
        format!(
            "of {} requests {} after healing, without a proved answer",
            tally.sent,
            time(AFTER.as_secs_f64())
        ),
        tally.sent - tally.served(),
    ))
}
