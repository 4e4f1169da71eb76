//! Machines that are cut off are felt by nobody else.

use std::time::Duration;

use super::trial::Trial;
use crate::error::Error;
use crate::fleet::{self, Member};
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs::jobs;
use crate::network::{Host, Link, Weather, cable, hosts};
use crate::orders::{Asking, Tally};
use crate::row::Row;
use crate::statistics::{quantile, time};

/// More than the gateway's session has threads that read.
const CUT: usize = 3;
const BEFORE: Duration = Duration::from_secs(1);
const DURING: Duration = Duration::from_secs(5);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, near, one, two, three] = hosts(["a", "near", "one", "two", "three"])?;
    cable(&a, &near)?;
    let _station = Station::start(&a, 1, &[])?;
    let attached = Attached::start(&near, "near", &[endpoint(&a)], &[])?;
    let mut near = fleet::planners(&near, attached.instance(), 2)?;
    let far: Vec<Far> = [&one, &two, &three]
        .iter()
        .take(CUT)
        .map(|host| Far::start(&a, host, trial.seed))
        .collect::<Result<_, Error>>()?;
    let (links, mut members): (Vec<_>, Vec<_>) = far
        .into_iter()
        .map(|far| ((far.link, far.attached), far.member))
        .unzip();
    let asking = Asking {
        jobs: jobs()?,
        length_ms: (BEFORE + DURING).as_millis() as u64,
        patience_ms: 30_000,
        ..Asking::default()
    };
    fleet::begin(&mut near, &asking)?;
    fleet::begin(&mut members, &asking)?;
    std::thread::sleep(BEFORE);
    links
        .iter()
        .for_each(|(link, _)| link.set(Weather::CUT));
    let tally = Tally::of(fleet::finish(&mut near, &asking)?);
    let longest = quantile(&tally.times, 1.0);
    links
        .iter()
        .for_each(|(link, _)| link.set(Weather::CLEAR));
    fleet::finish(&mut members, &asking)?;
    Ok(vec![
        Row::none(
            format!(
                "of {} requests of others while {CUT} machines are cut off, without a proved answer",
                tally.sent
            ),
            tally.sent - tally.served(),
        ),
        Row::time("  the longest of them", 0.3, longest),
        Row::told(
            "  p50, p99",
            [0.5, 0.99]
                .map(|part| time(quantile(&tally.times, part)))
                .join(", "),
        ),
    ])
}

/// A machine that is cut off while answers come to it.
struct Far {
    // Processes before links: fields are dropped in order.
    member: Member,
    attached: Attached,
    link: Link,
}

impl Far {
    fn start(a: &Host, host: &Host, seed: u64) -> Result<Self, Error> {
        let link = Link::between(a, host, seed)?;
        let attached = Attached::start(host, "far", &[endpoint(a)], &[])?;
        Ok(Self {
            member: Member::planner(host, attached.instance())?,
            attached,
            link,
        })
    }
}
