//! Hours of scenes that change and clients that come and go: memory stays as it is.

use std::time::{Duration, Instant};

use taut_ipc::control::ControlRequest;
use taut_ipc::planner::Planner;

use super::row::Row;
use super::trial::Trial;
use crate::cli::error::CliError;
use crate::cli::load_test::fleet::{Fleet, Member};
use crate::cli::load_test::interrupt;
use crate::cli::load_test::process::{open_files, resident_bytes};
use crate::cli::load_test::site::{Setup, Site, number, until};
use crate::cli::load_test::tally::Tally;

const CLIENTS: usize = 3;
const MIB: f64 = (1 << 20) as f64;
/// Growth that is none (MiB): the allocator's own.
const SLACK_MIB: f64 = 8.0;
/// Open files more that are none: one that is being written just now. Hundreds of clients come and
/// go.
const SLACK_FILES: u64 = 4;
/// How long a daemon that has nothing to do may take to be as it was.
const SETTLE: Duration = Duration::from_secs(20);

/// Resident memory, shared memory and open files of the daemon.
#[derive(Clone, Copy)]
struct Size {
    resident_mib: f64,
    shared_mib: f64,
    shared_files: usize,
    open_files: u64,
}

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let site = Site::own(&Setup {
        workers: 2,
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?;
    let total = trial.pick(Duration::from_secs(20), Duration::from_secs(1800));
    let mut churn = Churn {
        changes: 0,
        clients: 0,
        random: fastrand::Rng::with_seed(trial.seed),
    };
    let mut all = Tally::default();
    let mut sizes = Vec::new();
    let quarters = 4;
    for quarter in 0..quarters {
        let end = Instant::now() + total / quarters;
        let mut windows = 0;
        while Instant::now() < end {
            interrupt::check()?;
            let length = Duration::from_secs(1).min(total / quarters / 2);
            windows += 1;
            fleet.begin(trial.window(quarter as usize * 10_000 + windows), length)?;
            churn.during(&site, length)?;
            all.merge(&Tally::of(&fleet.finish(length)?));
        }
        sizes.push(settled(&site, &sizes)?);
    }
    // The first quarter fills caches; from there on nothing may grow.
    let first = sizes[0];
    let last = sizes[sizes.len() - 1];
    let minutes = (total * 3 / 4).as_secs_f64() / 60.0;
    let grown = |from: f64, to: f64, unit: &str| format!("{from:.1} -> {to:.1}{unit}");
    let resident = last.resident_mib - first.resident_mib;
    Ok(vec![
        Row::none("daemon exits", u64::from(!site.is_alive())),
        Row::none(
            format!("of {} requests, without a proved answer", all.sent),
            all.sent - all.served,
        ),
        Row::told(
            "scene changes, clients that came and went",
            format!("{}, {}", churn.changes, churn.clients),
            churn.changes as f64,
        ),
        Row::is(
            format!("memory of the daemon over {minutes:.1} min"),
            "flat",
            grown(first.resident_mib, last.resident_mib, " MiB"),
            resident,
            resident <= SLACK_MIB + 0.1 * first.resident_mib,
        ),
        Row::is(
            "shared memory",
            "flat",
            grown(first.shared_mib, last.shared_mib, " MiB"),
            last.shared_mib,
            last.shared_mib <= first.shared_mib * 1.1 + 1.0
                && last.shared_files <= first.shared_files,
        ),
        Row::is(
            "open files",
            "flat",
            grown(first.open_files as f64, last.open_files as f64, ""),
            last.open_files as f64,
            last.open_files <= first.open_files + SLACK_FILES,
        ),
    ])
}

/// What comes and goes while the fleet sends.
struct Churn {
    changes: u64,
    clients: u64,
    random: fastrand::Rng,
}

impl Churn {
    /// Loads and replaces a scene over and over, drops it now and then; a client comes and is
    /// killed or goes.
    fn during(&mut self, site: &Site, length: Duration) -> Result<(), CliError> {
        let end = Instant::now() + length;
        let client = site.client()?;
        self.clients += 1;
        let guest = Member::start(site.instance(), &site.jobs, 5000 + self.clients as usize)?;
        while Instant::now() < end {
            let label = format!("churn{}", self.random.u8(..4));
            let at = self.random.f64() * 5.0 + 5.0;
            let objects: Vec<String> = (0..20).map(|index| sphere(index, at)).collect();
            let json = format!(r#"{{"objects": [{}]}}"#, objects.join(","));
            Planner::new(client.clone()).control(&ControlRequest::LoadScene {
                label: label.clone(),
                json,
                base_dir: None,
                replace: true,
            })?;
            self.changes += 1;
            if self.random.u8(..10) == 0 {
                Planner::new(client.clone()).control(&ControlRequest::UnloadScene { label })?;
                self.changes += 1;
            }
        }
        match self.random.bool() {
            true => guest.kill(),
            false => guest.let_go()?,
        }
        Ok(())
    }
}

fn sphere(index: usize, at: f64) -> String {
    format!(
        r#"{{"id": "s{index}", "primitives": [{{"type": "sphere", "dimensions": [0.1]}}], "primitive_poses": [{{"position": [{at}, {index}, 9]}}]}}"#
    )
}

/// Sizes once dead clients are cleaned up, or as they are after a while.
fn settled(site: &Site, earlier: &[Size]) -> Result<Size, CliError> {
    let client = site.client()?;
    until(SETTLE, || {
        Ok(number(&client, "clients")? <= (CLIENTS + 1) as f64)
    })?;
    let size = || -> Result<Size, CliError> {
        let pid = site.pid().ok_or_else(|| site.gone())?;
        let (shared_files, taken) = site.shared_memory();
        Ok(Size {
            resident_mib: resident_bytes(pid) as f64 / MIB,
            shared_mib: taken as f64 / MIB,
            shared_files,
            open_files: open_files(pid),
        })
    };
    if let Some(first) = earlier.first() {
        until(SETTLE, || {
            size().map(|now| {
                now.shared_files <= first.shared_files
                    && now.open_files <= first.open_files + SLACK_FILES
            })
        })?;
    }
    size()
}
