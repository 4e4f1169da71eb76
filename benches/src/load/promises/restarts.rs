//! The daemon is killed under load and started again, and the clients send on.

use std::time::Duration;

use taut_ipc::control::{ControlRequest, Listing, SceneSummary};
use taut_ipc::{Client, monotonic_ns};

use super::row::Row;
use super::trial::Trial;
use crate::error::Error;
use crate::load::control::{control, listing};
use crate::load::fleet::Fleet;
use crate::load::interrupt;
use crate::load::site::{Setup, Site};
use crate::load::tally::{Loss, Tally, Times};

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
    rows.extend(Found::of(&rounds.tally, &rounds.kills).rows(&rounds.tally));
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
}

/// Gives a scene new content under its label.
fn load(client: &Client, number: u64) -> Result<(), Error> {
    let object = r#""primitives": [{"type": "sphere", "dimensions": [0.1]}], "primitive_poses": [{"position": [9, 9, 9]}]"#;
    let json = format!(r#"{{"objects": [{{"id": "s{number}", {object}}}]}}"#);
    let message = ControlRequest::LoadScene {
        label: "kept".to_owned(),
        json,
        base_dir: None,
        replace: true,
    };
    control(client, &message).map(|_| ())
}

/// Times from a kill to what the clients see of it.
#[derive(Default)]
struct Found {
    known: Times,
    good: Times,
    first: Times,
    never: u64,
}

impl Found {
    fn of(tally: &Tally, kills: &[u64]) -> Self {
        let mut found = Self::default();
        for (index, &kill) in kills.iter().enumerate() {
            let next = kills
                .get(index + 1)
                .copied()
                .unwrap_or(u64::MAX);
            // A request of this daemon: sent before it was killed, or while the system was at it.
            let hit = |loss: &&Loss| (kill..next).contains(&loss.known_ns);
            let losses: Vec<&Loss> = tally.losses.iter().filter(hit).collect();
            found.add(kill, &losses);
        }
        found
    }

    /// Those that one kill cut off.
    fn add(&mut self, kill: u64, losses: &[&Loss]) {
        for loss in losses {
            self.known.add(loss.known_ns - kill);
        }
        let good = losses.iter().map(|loss| loss.good_ns);
        let good: Vec<u64> = good.filter(|good_ns| *good_ns != 0).collect();
        self.never += (losses.len() - good.len()) as u64;
        for good_ns in &good {
            self.good.add(good_ns - kill);
        }
        if let Some(first_ns) = good.iter().min() {
            self.first.add(first_ns - kill);
        }
    }

    fn rows(&self, tally: &Tally) -> [Row; 5] {
        let cut_off = tally.losses.len();
        [
            Row::none(
                format!("of {cut_off} clients cut off, without an answer afterwards"),
                self.never,
            ),
            Row::time(
                "an open request ends with a code, p99 after the kill",
                0.5,
                self.known.quantile(0.99),
            ),
            Row::time("  the slowest", 0.5, self.known.max()),
            Row::time(
                "first good answer of anybody, p99 after the kill",
                1.0,
                self.first.quantile(0.99),
            ),
            Row::time(
                "good answer of every client cut off, p99",
                1.0,
                self.good.quantile(0.99),
            ),
        ]
    }
}

/// Every robot and scene of before is there, by content, and no scene is older.
fn is_same(before: &Listing, now: &Listing) -> bool {
    let robots = before.robots.iter().all(|robot| {
        now.robots
            .iter()
            .any(|other| other.label == robot.label && other.robot_hash == robot.robot_hash)
    });
    let scenes = before.scenes.iter().all(|scene| {
        let is_it = |other: &&SceneSummary| other.label == scene.label;
        now.scenes
            .iter()
            .find(is_it)
            .is_some_and(|other| {
                other.scene_hash == scene.scene_hash && other.version >= scene.version
            })
    });
    robots && scenes
}
