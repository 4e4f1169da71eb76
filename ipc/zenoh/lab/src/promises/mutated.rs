//! Messages that are nearly right hurt nobody.

use std::fs;
use std::time::Duration;

use taut_ipc::planner::Planner;

use super::trial::Trial;
use crate::error::Error;
use crate::fleet::{self, Member};
use crate::gateway::{Attached, Station, endpoint};
use crate::jobs::jobs;
use crate::network::{cable, hosts};
use crate::orders::{Asking, Mutating, Tally};
use crate::row::Row;
use crate::statistics::ratio;

/// How often its memory is looked at.
const LOOK: Duration = Duration::from_secs(1);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, planners] = hosts(["a", "planners"])?;
    cable(&a, &planners)?;
    let mut station = Station::start(&a, 2, &[])?;
    let attached = Attached::start(&planners, "attached", &[endpoint(&a)], &[])?;
    let mut honest = fleet::planners(&planners, attached.instance(), 2)?;
    let mutating = Mutating {
        connect: endpoint(&a),
        daemon: a.name().to_owned(),
        count: trial.pick(20_000, 1_000_000),
        seed: trial.seed,
        ..target(&Planner::connect(station.daemon.instance())?)?
    };
    // They are known before the others come.
    let before = Tally::of(fleet::all(&mut honest, &asking()?)?);
    let mut sender = Member::mutate(&planners, &mutating)?;
    let mut memory = Vec::new();
    let tally = loop {
        memory.push(resident(station.gateway.pid()));
        if let Some(tally) = sender.mutated(LOOK)? {
            break tally;
        }
    };
    memory.push(resident(station.gateway.pid()));
    let mut after = before;
    after.merge(Tally::of(fleet::all(&mut honest, &asking()?)?));
    let early = memory[memory.len() / 5];
    let late = memory[memory.len() - 1];
    Ok(vec![
        Row::none("gateway exits", u64::from(!station.gateway.is_alive())),
        Row::none("daemon exits", u64::from(!station.daemon.is_alive())),
        Row::none(
            format!("of {} mutated queries, without a reply", tally.sent),
            tally.endless,
        ),
        Row::told("  how they ended", tally.told()),
        Row::at_most(
            format!(
                "gateway's memory at the end / after a fifth ({} KiB)",
                early
            ),
            1.2,
            ratio(late as f64, early as f64),
        ),
        Row::none(
            format!(
                "of {} honest requests before and after, without a proved answer",
                after.sent
            ),
            after.sent - after.served(),
        ),
        Row::told("  how they ended", after.told()),
    ])
}

fn target(planner: &Planner) -> Result<Mutating, Error> {
    let robot = planner.robot("rooms")?;
    let listing = planner.list()?;
    let scene = listing
        .scenes
        .iter()
        .find(|scene| scene.label == "rooms");
    Ok(Mutating {
        robot_id: robot.robot_id,
        layout_hash: robot.layout_hash,
        scene_id: scene.map_or(0, |scene| scene.scene_id),
        ..Mutating::default()
    })
}

fn asking() -> Result<Asking, Error> {
    Ok(Asking {
        jobs: jobs()?,
        count: 20,
        patience_ms: 30_000,
        ..Asking::default()
    })
}

/// Memory of a process's own (KiB).
fn resident(pid: u32) -> u64 {
    let text = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("RssAnon:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok())
        .unwrap_or(0)
}
