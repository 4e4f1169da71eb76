//! The files of an instance are removed under load, and the daemon heals: it starts anew by itself,
//! or ends and is started again by its supervisor. The clients send on with the connection that they
//! have, and others come.

use std::fs;
use std::io::ErrorKind;
use std::time::Duration;

use taut::optimize::Mode;
use taut_ipc::memory::shared_files;
use taut_ipc::{Client, Instance, monotonic_ns};

use super::recovery::{is_equal, load};
use super::row::Row;
use super::trial::Trial;
use crate::error::Error;
use crate::load::asking::Asker;
use crate::load::control::listing;
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::orders::{Window, wire_mode};
use crate::load::rounds::longest_pause_ns;
use crate::load::site::{Setup, Site, until};
use crate::load::tally::Tally;
use crate::load::times::Times;

const CLIENTS: usize = 4;
/// Removals under one daemon: a supervisor gives up one that ends more often at once.
const ROUND: u64 = 3;
/// Longest time between a recovery and the next removal (ms).
const PAUSE_MS: u64 = 600;
/// How long a recovery is promised to take at most.
const RECOVERY: Duration = Duration::from_secs(2);
/// How long it may take before it counts as none.
const NEVER: Duration = Duration::from_secs(20);
/// Time after the last removal of a round for everybody to recover.
const AFTER: Duration = Duration::from_secs(3);
/// The daemon's state lies beside the instance's root: what is removed with that cannot come back.
const STATE: &str = "state = \"state\"";

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for supervise in [true, false] {
        let mut rounds = Rounds {
            trial,
            supervise,
            random: fastrand::Rng::with_seed(trial.seed),
            seen: Seen::default(),
        };
        let mut left = trial.pick(2, 25);
        while left > 0 {
            let removals = left.min(ROUND);
            rounds.round(removals)?;
            left -= removals;
        }
        rows.extend(rounds.seen.rows(match supervise {
            true => "supervised",
            false => "alone",
        }));
    }
    Ok(rows)
}

/// What is removed.
#[derive(Clone, Copy)]
enum Removed {
    /// What lies in the root and in shared memory (`rm`).
    All,
    /// What lies in shared memory (RemoveIPC at logout).
    SharedMemory,
}

/// Daemons whose files are removed under load, one after the other.
struct Rounds<'a> {
    trial: &'a Trial,
    supervise: bool,
    random: fastrand::Rng,
    seen: Seen,
}

impl Rounds<'_> {
    /// One daemon, whose files are removed some times.
    fn round(&mut self, removals: u64) -> Result<(), Error> {
        let site = Site::own(&Setup {
            workers: 2,
            lines: STATE.to_owned(),
            supervise: self.supervise,
            ..Setup::default()
        })?;
        let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?;
        let each = Duration::from_millis(PAUSE_MS) + RECOVERY;
        let length = each * removals as u32 + AFTER;
        let window = self.trial.window(self.seen.removals.len());
        let window = fleet.begin(window, length)?;
        for _ in 0..removals {
            interrupt::check()?;
            // Late in the window nobody would be left to recover; then the times tell why.
            if monotonic_ns() + AFTER.as_nanos() as u64 > window.end_ns {
                break;
            }
            self.remove(&site)?;
        }
        for tally in fleet.finish(length)? {
            self.seen.add(&tally, window);
        }
        self.seen.exits += u64::from(!self.supervise && !site.is_alive());
        Ok(())
    }

    fn remove(&mut self, site: &Site) -> Result<(), Error> {
        let number = self.seen.removals.len() as u64;
        // What was acknowledged last is what must be there.
        load(&site.client()?, number)?;
        let pause_ms = 100 + self.random.u64(..PAUSE_MS - 100);
        std::thread::sleep(Duration::from_millis(pause_ms));
        let before = listing(&site.client()?)?;
        let what = [Removed::All, Removed::SharedMemory][number as usize % 2];
        self.seen.removals.push(monotonic_ns());
        what.remove(site.instance())?;
        match until(NEVER, || Ok(is_served(site)))? {
            Some(time) => self.seen.served.add(time.as_nanos() as u64),
            None => return Err(site.gone()),
        }
        let now = listing(&site.client()?)?;
        self.seen.other += u64::from(!is_equal(&before, &now));
        Ok(())
    }
}

/// Whether a client that comes now has a proved answer.
fn is_served(site: &Site) -> bool {
    let Ok(client) = Client::connect(site.instance()) else {
        return false;
    };
    let window = Window {
        mode: wire_mode(Mode::Check),
        ..Window::closed()
    };
    let mut asker = Asker::new(&client, &site.jobs, &window, 0);
    asker.ask(0, monotonic_ns());
    asker.tally.served == 1
}

impl Removed {
    fn remove(self, instance: &Instance) -> Result<(), Error> {
        if matches!(self, Self::All) {
            empty(instance)?;
        }
        for file in shared_files(instance) {
            removed(fs::remove_file(file.path))?;
        }
        Ok(())
    }
}

/// Removes what lies in the root.
fn empty(instance: &Instance) -> Result<(), Error> {
    let entries = fs::read_dir(instance.root()).map_err(|source| Error::System {
        what: "the instance's root",
        source,
    })?;
    for entry in entries.flatten() {
        let path = entry.path();
        removed(match path.is_dir() {
            true => fs::remove_dir_all(path),
            false => fs::remove_file(path),
        })?;
    }
    Ok(())
}

/// What is gone already, or used again at once, is no error.
fn removed(result: std::io::Result<()>) -> Result<(), Error> {
    match result {
        Err(error)
            if ![ErrorKind::NotFound, ErrorKind::DirectoryNotEmpty].contains(&error.kind()) =>
        {
            Err(Error::System {
                what: "file of the instance",
                source: error,
            })
        }
        _ => Ok(()),
    }
}

/// What was seen of all removals.
#[derive(Default)]
struct Seen {
    /// When each was (ns).
    removals: Vec<u64>,
    /// What came of the clients' requests.
    tally: Tally,
    /// From each removal to the first proved answer of a client that comes after it.
    served: Times,
    /// The longest time that a client went without an answer (ns).
    pause_ns: u64,
    /// Removals after which something is another, or of another version.
    other: u64,
    /// Daemons without a supervisor that ended.
    exits: u64,
}

impl Seen {
    /// Of one client.
    fn add(&mut self, tally: &Tally, window: Window) {
        let pause_ns = longest_pause_ns(&tally.rounds, window.start_ns, window.end_ns);
        self.pause_ns = self.pause_ns.max(pause_ns);
        self.tally.merge(tally);
    }

    fn rows(&self, whose: &str) -> Vec<Row> {
        let mut rows = self.counts(whose);
        rows.extend(self.times(whose));
        rows
    }

    fn counts(&self, whose: &str) -> Vec<Row> {
        let removals = self.removals.len();
        let requests = format!("requests over {removals} removals, {whose}");
        vec![
            self.tally.endless(&requests),
            Row::none(
                format!("answers for another scene than asked for, {whose}"),
                self.tally.other_scene,
            ),
            Row::none(
                format!("unequal answers to equal requests, {whose}"),
                self.tally.unequal,
            ),
            Row::none(
                format!("removals after which a robot, scene or version differs, {whose}"),
                self.other,
            ),
            Row::none(format!("daemons that ended for good, {whose}"), self.exits),
            self.refused(),
        ]
    }

    /// How requests ended that have no proved answer.
    fn refused(&self) -> Row {
        let by_code: Vec<String> = self
            .tally
            .refused
            .iter()
            .map(|(code, count)| format!("{code} {count}"))
            .collect();
        let count = self.tally.sent - self.tally.served;
        Row::told(
            "  sent again by its client, by code",
            by_code.join(", "),
            count as f64,
        )
    }

    fn times(&self, whose: &str) -> [Row; 2] {
        let most = RECOVERY.as_secs_f64();
        [
            Row::time(
                format!("first proved answer of a new client, the slowest, {whose}"),
                most,
                self.served.max(),
            ),
            Row::time(
                format!("longest time of a client without an answer, {whose}"),
                most,
                self.pause_ns as f64 * 1e-9,
            ),
        ]
    }
}
