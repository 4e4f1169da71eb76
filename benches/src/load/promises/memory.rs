//! Hours of scenes that change and clients that come and go: memory stays as it is.

use std::time::{Duration, Instant};

use taut_ipc::Client;
use taut_ipc::control::ControlRequest;

use super::row::Row;
use super::trial::Trial;
use crate::error::Error;
use crate::load::control::{control, number};
use crate::load::fleet::{Fleet, Member};
use crate::load::interrupt;
use crate::load::process::{open_files, resident_bytes};
use crate::load::site::{Site, until};
use crate::load::tally::Tally;

const CLIENTS: usize = 3;
/// Parts of the time; after each is looked.
const QUARTERS: u32 = 4;
const MIB: f64 = (1 << 20) as f64;
/// Growth that is none (MiB): the allocator's own.
const SLACK_MIB: f64 = 8.0;
/// Open files more that are none: one that is being written just now. Hundreds of clients come and
/// go.
const SLACK_FILES: u64 = 4;
/// How long a daemon that has nothing to do may take to be as it was.
const SETTLE: Duration = Duration::from_secs(20);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let site = Site::of_workers(2)?;
    let quarter = trial.pick(Duration::from_secs(20), Duration::from_secs(1800)) / QUARTERS;
    let mut hours = Hours {
        trial,
        fleet: Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?,
        churn: Churn {
            changes: 0,
            clients: 0,
            random: fastrand::Rng::with_seed(trial.seed),
        },
        all: Tally::default(),
    };
    let mut sizes = Vec::new();
    for number in 0..QUARTERS {
        hours.pass(&site, number as usize, quarter)?;
        sizes.push(settled(&site, sizes.first())?);
    }
    let mut rows = hours.counts(&site);
    // The first quarter fills caches; from there on nothing may grow.
    let growth = Growth {
        minutes: (quarter * (QUARTERS - 1)).as_secs_f64() / 60.0,
        first: sizes[0],
        last: sizes[sizes.len() - 1],
    };
    rows.extend(growth.rows());
    Ok(rows)
}

/// Clients that send while others, and scenes, come and go.
struct Hours<'a> {
    trial: &'a Trial,
    fleet: Fleet,
    churn: Churn,
    all: Tally,
}

impl Hours<'_> {
    /// Sends for so long, window after window.
    fn pass(&mut self, site: &Site, quarter: usize, time: Duration) -> Result<(), Error> {
        let end = Instant::now() + time;
        let length = Duration::from_secs(1).min(time / 2);
        for number in 1.. {
            if Instant::now() >= end {
                break;
            }
            interrupt::check()?;
            let window = self.trial.window(quarter * 10_000 + number);
            self.fleet.begin(window, length)?;
            self.churn.during(site, length)?;
            self.all
                .merge(&Tally::of(&self.fleet.finish(length)?));
        }
        Ok(())
    }

    fn counts(&self, site: &Site) -> Vec<Row> {
        let Churn {
            changes, clients, ..
        } = self.churn;
        vec![
            Row::none("daemon exits", u64::from(!site.is_alive())),
            self.all.unserved("requests"),
            Row::told(
                "scene changes, clients that came and went",
                format!("{changes}, {clients}"),
                changes as f64,
            ),
        ]
    }
}

/// Resident memory, shared memory and open files of the daemon.
#[derive(Clone, Copy)]
struct Size {
    resident_mib: f64,
    shared_mib: f64,
    shared_files: usize,
    open_files: u64,
}

impl Size {
    fn of(site: &Site) -> Result<Self, Error> {
        let pid = site.serving()?;
        let (shared_files, taken) = site.shared_memory();
        Ok(Self {
            resident_mib: resident_bytes(pid) as f64 / MIB,
            shared_mib: taken as f64 / MIB,
            shared_files,
            open_files: open_files(pid),
        })
    }

    /// Whether it has no more files than at first.
    fn is_back_at(&self, first: &Self) -> bool {
        self.shared_files <= first.shared_files && self.open_files <= first.open_files + SLACK_FILES
    }
}

/// From the end of the first quarter to that of the last.
struct Growth {
    minutes: f64,
    first: Size,
    last: Size,
}

impl Growth {
    fn rows(&self) -> [Row; 3] {
        [self.resident(), self.shared(), self.files()]
    }

    fn resident(&self) -> Row {
        let first = self.first.resident_mib;
        let last = self.last.resident_mib;
        let grown = last - first;
        Row::is(
            format!("memory of the daemon over {:.1} min", self.minutes),
            "flat",
            format!("{first:.1} -> {last:.1} MiB"),
            grown,
            grown <= SLACK_MIB + 0.1 * first,
        )
    }

    fn shared(&self) -> Row {
        let first = self.first.shared_mib;
        let last = self.last.shared_mib;
        let is_flat = last <= first * 1.1 + 1.0;
        Row::is(
            "shared memory",
            "flat",
            format!("{first:.1} -> {last:.1} MiB"),
            last,
            is_flat && self.last.shared_files <= self.first.shared_files,
        )
    }

    fn files(&self) -> Row {
        let first = self.first.open_files;
        let last = self.last.open_files;
        Row::is(
            "open files",
            "flat",
            format!("{first} -> {last}"),
            last as f64,
            last <= first + SLACK_FILES,
        )
    }
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
    fn during(&mut self, site: &Site, length: Duration) -> Result<(), Error> {
        let end = Instant::now() + length;
        let client = site.client()?;
        self.clients += 1;
        let number = 5000 + self.clients as usize;
        let guest = Member::start(site.instance(), &site.jobs, number)?;
        while Instant::now() < end {
            self.change(&client)?;
        }
        match self.random.bool() {
            true => guest.kill(),
            false => guest.let_go()?,
        }
        Ok(())
    }

    fn change(&mut self, client: &Client) -> Result<(), Error> {
        let label = format!("churn{}", self.random.u8(..4));
        let at = self.random.f64() * 5.0 + 5.0;
        self.send(client, &load(label.clone(), at))?;
        if self.random.u8(..10) == 0 {
            self.send(client, &ControlRequest::UnloadScene { label })?;
        }
        Ok(())
    }

    fn send(&mut self, client: &Client, message: &ControlRequest) -> Result<(), Error> {
        control(client, message)?;
        self.changes += 1;
        Ok(())
    }
}

/// A scene of a row of balls.
fn load(label: String, at: f64) -> ControlRequest {
    let objects: Vec<String> = (0..20).map(|index| sphere(index, at)).collect();
    ControlRequest::LoadScene {
        label,
        json: format!(r#"{{"objects": [{}]}}"#, objects.join(",")),
        base_dir: None,
        replace: true,
        files: None,
        version: None,
    }
}

fn sphere(index: usize, at: f64) -> String {
    format!(
        r#"{{"id": "s{index}", "primitives": [{{"type": "sphere", "dimensions": [0.1]}}], "primitive_poses": [{{"position": [{at}, {index}, 9]}}]}}"#
    )
}

/// The size once dead clients are cleaned up, or as it is after a while.
fn settled(site: &Site, first: Option<&Size>) -> Result<Size, Error> {
    let client = site.client()?;
    until(SETTLE, || {
        Ok(number(&client, "clients")? <= (CLIENTS + 1) as f64)
    })?;
    if let Some(first) = first {
        until(SETTLE, || Ok(Size::of(site)?.is_back_at(first)))?;
    }
    Size::of(site)
}
