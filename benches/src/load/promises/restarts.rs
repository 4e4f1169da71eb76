//! The daemon is killed under load and started again, and the clients send on.

use std::time::Duration;

use taut_ipc::monotonic_ns;

use super::recovery::{Found, is_same, load};
use super::row::Row;
use super::trial::Trial;
use crate::error::Error;
use crate::load::control::listing;
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::site::{Setup, Site};
use crate::load::tally::Tally;

const CLIENTS: usize = 4;
/// Kills of one daemon: a supervisor gives up one that dies more often at once.
const ROUND: u64 = 3;
/// Longest time between a restart and the next kill (ms).
const PAUSE_MS: u64 = 600;
/// How long a restart may take before it counts as none.
const RESTART: Duration = Duration::from_secs(20);
/// Time after the last kill of a round for everybody to recover.
const AFTER: Duration = Duration::from_secs(3);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rounds = Rounds {
        trial,
        random: fastrand::Rng::with_seed(trial.seed),
        kills: Vec::new(),
        tally: Tally::default(),
        other: 0,
    };
    for number in 0..trial.pick(1, 34) {
        rounds.round(number)?;
    }
    let mut rows = rounds.counts();
    rows.extend(rounds.times());
    Ok(rows)
}

/// Supervised daemons, killed under load one after the other.
struct Rounds<'a> {
    trial: &'a Trial,
    random: fastrand::Rng,
    /// When each kill was (ns).
    kills: Vec<u64>,
    tally: Tally,
    /// Kills after which something is another, or older.
    other: u64,
}

impl Rounds<'_> {
    /// One daemon, killed some times.
    fn round(&mut self, number: usize) -> Result<(), Error> {
        let site = Site::own(&Setup {
            workers: 2,
            supervise: true,
            ..Setup::default()
        })?;
        let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?;
        let length = Duration::from_millis(ROUND * (PAUSE_MS + 600)) + AFTER;
        let window = fleet.begin(self.trial.window(number), length)?;
        let last_ns = window.end_ns - AFTER.as_nanos() as u64;
        for kill in 0..ROUND {
            interrupt::check()?;
            if !self.kill(&site, number as u64 * ROUND + kill, last_ns)? {
                break;
            }
        }
        self.tally
            .merge(&Tally::of(&fleet.finish(length)?));
        Ok(())
    }

    /// False where that would be too late in the window.
    fn kill(&mut self, site: &Site, number: u64, last_ns: u64) -> Result<bool, Error> {
        // What was acknowledged last is what must be there.
        load(&site.client()?, number)?;
        let pause_ms = 100 + self.random.u64(..PAUSE_MS - 100);
        std::thread::sleep(Duration::from_millis(pause_ms));
        let before = listing(&site.client()?)?;
        if monotonic_ns() > last_ns {
            return Ok(false);
        }
        self.kills.push(monotonic_ns());
        site.kill_and_wait(RESTART)?;
        let now = listing(&site.client()?)?;
        self.other += u64::from(!is_same(&before, &now));
        Ok(true)
    }

    fn counts(&self) -> Vec<Row> {
        let kills = self.kills.len();
        let without_end = format!(
            "of {} requests over {kills} kills, without an end",
            self.tally.sent
        );
        vec![
            Row::none(without_end, self.tally.lost),
            Row::none(
                "answers for another scene than asked for",
                self.tally.other_scene,
            ),
            Row::none("unequal answers to equal requests", self.tally.unequal),
            Row::none(
                "restarts after which a robot or scene is another, or older",
                self.other,
            ),
        ]
    }

    fn times(&self) -> [Row; 5] {
        let found = Found::of(&self.tally, &self.kills);
        let cut_off = self.tally.losses.len();
        [
            Row::none(
                format!("of {cut_off} clients cut off, without an answer afterwards"),
                found.never,
            ),
            Row::time(
                "an open request ends with a code, p99 after the kill",
                0.5,
                found.known.quantile(0.99),
            ),
            Row::time("  the slowest", 0.5, found.known.max()),
            Row::time(
                "first good answer of anybody, p99 after the kill",
                1.0,
                found.first.quantile(0.99),
            ),
            Row::time(
                "good answer of every client cut off, p99",
                1.0,
                found.good.quantile(0.99),
            ),
        ]
    }
}
