//! Memory of planner processes: what a connection adds, and sixteen planners with a daemon beside
//! sixteen without.

use super::row::Row;
use super::trial::{Trial, run};
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::orders::Window;
use crate::cli::load_test::process::{private_bytes, resident_bytes};
use crate::cli::load_test::site::{Setup, Site};
use std::time::Duration;

const PLANNERS: usize = 16;
const MIB: f64 = (1 << 20) as f64;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 1,
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, PLANNERS)?;
    run(
        &mut fleet,
        Window {
            in_order: true,
            ..trial.window(0)
        },
        Duration::from_secs(2),
    )?;
    let added: Vec<u64> = fleet
        .0
        .iter()
        .map(|one| one.memory.after.saturating_sub(one.memory.before))
        .collect();
    let most = added.iter().max().copied().unwrap_or(0) as f64 / MIB;
    let planners: u64 = fleet.0.iter().map(|one| private_bytes(one.pid())).sum();
    let daemon = resident_bytes(site.pid().ok_or_else(|| site.gone())?);
    let alone = Fleet::computing(site.instance(), &site.files, PLANNERS)?;
    let without: u64 = alone.0.iter().map(|one| private_bytes(one.pid())).sum();
    let with = (planners + daemon) as f64 / MIB;
    let without = without as f64 / MIB;
    Ok(vec![
        Row::is(
            "private memory that a connection adds to a planner",
            "<= 2 MiB",
            format!("{most:.2} MiB"),
            most,
            most <= 2.0,
        ),
        Row::told(
            "16 planners and their daemon",
            format!("{with:.1} MiB"),
            with,
        ),
        Row::told(
            "16 planners that optimize in process",
            format!("{without:.1} MiB"),
            without,
        ),
    ])
}
