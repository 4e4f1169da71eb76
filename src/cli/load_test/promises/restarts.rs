//! The daemon is killed under load and started again, and the clients send on.

use std::time::Duration;

use taut_ipc::control::{ControlReply, ControlRequest, Listing};
use taut_ipc::planner::Planner;
use taut_ipc::{Client, monotonic_ns};

use super::row::Row;
use super::trial::Trial;
use crate::cli::error::CliError;
use crate::cli::error::unexpected;
use crate::cli::load_test::fleet::Fleet;
use crate::cli::load_test::interrupt;
use crate::cli::load_test::site::{Setup, Site};
use crate::cli::load_test::tally::{Tally, Times};

const CLIENTS: usize = 4;
/// Kills of one daemon: a supervisor gives up one that dies more often at once.
const ROUND: u64 = 3;
/// Longest time between a restart and the next kill (ms).
const PAUSE_MS: u64 = 600;
/// How long a restart may take before it counts as none.
const RESTART: Duration = Duration::from_secs(20);
/// Time after the last kill of a round for everybody to recover.
const AFTER: Duration = Duration::from_secs(3);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, CliError> {
    let mut random = fastrand::Rng::with_seed(trial.seed);
    let mut kills = Vec::new();
    let mut all = Tally::default();
    let mut other = 0;
    for round in 0..trial.pick(1, 34) {
        other += self::round(trial, round, &mut random, &mut kills, &mut all)?;
    }
    let found = Found::of(&all, &kills);
    Ok(vec![
        Row::none(
            format!(
                "of {} requests over {} kills, without an end",
                all.sent,
                kills.len()
            ),
            all.lost,
        ),
        Row::none("answers for another scene than asked for", all.other_scene),
        Row::none("unequal answers to equal requests", all.unequal),
        Row::none(
            "restarts after which a robot or scene is another, or older",
            other,
        ),
        Row::none(
            format!(
                "of {} clients cut off, without an answer afterwards",
                all.losses.len()
            ),
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
    ])
}

/// One supervised daemon, killed under load; tells after how many kills something is another, or
/// older.
fn round(
    trial: &Trial,
    round: usize,
    random: &mut fastrand::Rng,
    kills: &mut Vec<u64>,
    all: &mut Tally,
) -> Result<u64, CliError> {
    let site = Site::own(&Setup {
        workers: 2,
        supervise: true,
        ..Setup::default()
    })?;
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, CLIENTS)?;
    let length = Duration::from_millis(ROUND * (PAUSE_MS + 600)) + AFTER;
    let window = fleet.begin(trial.window(round), length)?;
    let mut other = 0;
    for kill in 0..ROUND {
        interrupt::check()?;
        // What was acknowledged last is what must be there.
        load(&site.client()?, round as u64 * ROUND + kill)?;
        std::thread::sleep(Duration::from_millis(100 + random.u64(..PAUSE_MS - 100)));
        let before = listing(&site.client()?)?;
        if monotonic_ns() + AFTER.as_nanos() as u64 > window.end_ns {
            break;
        }
        kills.push(monotonic_ns());
        site.kill_and_wait(RESTART)?;
        other += u64::from(!is_same(&before, &listing(&site.client()?)?));
    }
    all.merge(&Tally::of(&fleet.finish(length)?));
    Ok(other)
}

/// Gives a scene new content under its label.
fn load(client: &Client, number: u64) -> Result<(), CliError> {
    let object = r#""primitives": [{"type": "sphere", "dimensions": [0.1]}], "primitive_poses": [{"position": [9, 9, 9]}]"#;
    let json = format!(r#"{{"objects": [{{"id": "s{number}", {object}}}]}}"#);
    let message = ControlRequest::LoadScene {
        label: "kept".to_owned(),
        json,
        base_dir: None,
        replace: true,
    };
    Planner::new(client.clone()).control(&message)?;
    Ok(())
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
            let next = kills.get(index + 1).copied().unwrap_or(u64::MAX);
            // A request of this daemon: sent before it was killed, or while the system was at it.
            let hit = || {
                tally
                    .losses
                    .iter()
                    .filter(|loss| loss.known_ns >= kill && loss.known_ns < next)
            };
            for loss in hit() {
                found.known.add(loss.known_ns - kill);
                match loss.good_ns {
                    0 => found.never += 1,
                    good => found.good.add(good - kill),
                }
            }
            if let Some(good) = hit()
                .filter(|loss| loss.good_ns != 0)
                .map(|loss| loss.good_ns)
                .min()
            {
                found.first.add(good - kill);
            }
        }
        found
    }
}

fn listing(client: &Client) -> Result<Listing, CliError> {
    match Planner::new(client.clone()).control(&ControlRequest::List)? {
        ControlReply::Listing(listing) => Ok(listing),
        other => Err(unexpected(&other)),
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
        let is_it = |other: &&taut_ipc::control::SceneSummary| other.label == scene.label;
        now.scenes.iter().find(is_it).is_some_and(|other| {
            other.scene_hash == scene.scene_hash && other.version >= scene.version
        })
    });
    robots && scenes
}
