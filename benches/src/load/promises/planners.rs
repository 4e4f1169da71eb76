//! Memory of planner processes: what a connection adds, and sixteen planners with a daemon beside
//! sixteen without.

use std::time::Duration;

use super::row::Row;
use super::trial::{Trial, run};
use crate::error::Error;
use crate::load::fleet::Fleet;
use crate::load::orders::Window;
use crate::load::process::{private_bytes, resident_bytes};
use crate::load::site::Site;

const PLANNERS: usize = 16;
const MIB: f64 = (1 << 20) as f64;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::of_workers(1)?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, PLANNERS)?;
    let window = Window {
        in_order: true,
        ..trial.window(0)
    };
    run(&mut fleet, window, Duration::from_secs(2))?;
    let with = private(&fleet) + resident_bytes(site.serving()?);
    let alone = Fleet::computing(site.instance(), &site.files, PLANNERS)?;
    Ok(vec![
        added(&fleet),
        told("16 planners and their daemon", with),
        told("16 planners that optimize in process", private(&alone)),
    ])
}

fn added(fleet: &Fleet) -> Row {
    let added = fleet.0.iter().map(|one| one.memory.added());
    let most = added.max().unwrap_or(0) as f64 / MIB;
    Row::is(
        "private memory that a connection adds to a planner",
        "<= 2 MiB",
        format!("{most:.2} MiB"),
        most,
        most <= 2.0,
    )
}

fn told(figure: &str, bytes: u64) -> Row {
    let mib = bytes as f64 / MIB;
    Row::told(figure, format!("{mib:.1} MiB"), mib)
}

/// Private memory of all of them (bytes).
fn private(fleet: &Fleet) -> u64 {
    fleet
        .0
        .iter()
        .map(|one| private_bytes(one.pid()))
        .sum()
}
