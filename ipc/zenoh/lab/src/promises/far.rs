//! Gateways at 100 ms and 5 % loss.

use super::ends::{Runs, ends};
use super::trial::Trial;
use crate::error::Error;
use crate::fleet;
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs::{jobs, sized};
use crate::network::{Link, Weather, hosts};
use crate::orders::{Asking, Tally};
use crate::row::Row;
use crate::statistics::{quantile, time};

const CLIENTS: usize = 8;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, planners] = hosts(["a", "planners"])?;
    let link = Link::between(&a, &planners, trial.seed)?;
    let station = Station::start(&a, 2, &[])?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&a)], &[])?;
    let mut members = fleet::planners(&planners, attached.instance(), CLIENTS)?;
    link.set(Weather::far(100, 0.05));
    let small = Asking {
        jobs: jobs()?,
        count: trial.pick(10, 100),
        patience_ms: 60_000,
        ..Asking::default()
    };
    let large = Asking {
        jobs: vec![sized(64 << 10)],
        count: trial.pick(3, 30),
        ..small.clone()
    };
    let hurried = Asking {
        deadline_ms: 400,
        ..small.clone()
    };
    let mut rows = Vec::new();
    for (name, asking) in [
        ("of some waypoints", &small),
        ("of 64 KiB", &large),
        ("with 0.4 s", &hurried),
    ] {
        let runs = Runs::of([&station.daemon])?;
        let tally = Tally::of(fleet::all(&mut members, asking)?);
        rows.extend(ends(&tally, name));
        rows.push(runs.twice(&tally)?);
        rows.push(Row::told(
            "  time to an end, p50, p99",
            [0.5, 0.99]
                .map(|part| time(quantile(&tally.times, part)))
                .join(", "),
        ));
    }
    Ok(rows)
}
