//! Equal requests have equal answers, bit for bit, wherever they are asked and answered.

use std::collections::BTreeSet;

use super::trial::Trial;
use crate::daemon::Daemon;
use crate::error::Error;
use crate::fleet::{self, Member};
use crate::gateway::{self, Attached, endpoint};
use crate::jobs::{PROBLEMS, jobs};
use crate::network::{cable, hosts};
use crate::orders::{Asking, Tally};
use crate::row::Row;

const CLIENTS: usize = 8;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, b, planners] = hosts(["a", "b", "planners"])?;
    cable(&a, &planners)?;
    cable(&b, &planners)?;
    let daemons = [Daemon::start(&a, "one", 2)?, Daemon::start(&b, "two", 2)?];
    let _gateways = [
        gateway::serve(&a, &daemons[0], &[])?,
        gateway::serve(&b, &daemons[1], &[])?,
    ];
    let connect = [endpoint(&a), endpoint(&b)];
    let forth = Attached::start(
        &planners,
        "forth",
        &connect,
        &["--daemon", "a", "--daemon", "b"],
    )?;
    let back = Attached::start(
        &planners,
        "back",
        &connect,
        &["--daemon", "b", "--daemon", "a"],
    )?;
    let asking = Asking {
        jobs: jobs()?,
        count: trial.pick(40, 400),
        patience_ms: 60_000,
        ..Asking::default()
    };
    let mut local = Member::planner(&a, daemons[0].instance())?;
    let local = local.ask(&asking)?;
    let mut members = Vec::new();
    for number in 0..CLIENTS {
        let attached = if number % 2 == 0 { &forth } else { &back };
        members.push(Member::planner(&planners, attached.instance())?);
    }
    let remote = Tally::of(fleet::all(&mut members, &asking)?);
    Ok(vec![
        Row::none(
            format!("of {} local requests, without a proved answer", local.sent),
            local.sent - local.served(),
        ),
        Row::none(
            format!(
                "of {} requests of {CLIENTS} clients to two daemons, without a proved answer",
                remote.sent
            ),
            remote.sent - remote.served(),
        ),
        Row::none(
            "problems with other answers than locally",
            differing(&local, &remote),
        ),
    ])
}

/// Problems that do not have one answer only, the same in both.
fn differing(one: &Tally, other: &Tally) -> u64 {
    let answers = |tally: &Tally, name: &str| -> BTreeSet<u64> {
        tally
            .answers
            .get(name)
            .cloned()
            .unwrap_or_default()
    };
    let differs = |name: &&&str| {
        let local = answers(one, name);
        local.len() != 1 || local != answers(other, name)
    };
    PROBLEMS.iter().filter(differs).count() as u64
}
