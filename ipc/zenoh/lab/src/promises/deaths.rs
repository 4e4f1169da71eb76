//! The gateway that answers is killed, again and again, under load.

use std::time::Duration;

use super::ends::{Runs, ends};
use super::trial::Trial;
use crate::error::Error;
use crate::fleet;
use crate::gateway::{Attached, Station, endpoint, serve};
use crate::jobs::jobs;
use crate::network::{Host, cable, hosts};
use crate::orders::{Asking, Tally};
use crate::random::Random;
use crate::row::Row;

/// Clients of each of two attached instances, that ask different gateways first.
const CLIENTS: usize = 4;
/// The longest that a gateway answers, and that it is away.
const LIVES_MS: usize = 600;
const AWAY_MS: usize = 200;

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, b, planners] = hosts(["a", "b", "planners"])?;
    cable(&a, &planners)?;
    cable(&b, &planners)?;
    let mut stations = [Station::start(&a, 1, &[])?, Station::start(&b, 1, &[])?];
    let connect = [endpoint(&a), endpoint(&b)];
    let attached = [
        Attached::start(
            &planners,
            "forth",
            &connect,
            &["--daemon", "a", "--daemon", "b"],
        )?,
        Attached::start(
            &planners,
            "back",
            &connect,
            &["--daemon", "b", "--daemon", "a"],
        )?,
    ];
    let mut members = Vec::new();
    for attached in &attached {
        members.extend(fleet::planners(&planners, attached.instance(), CLIENTS)?);
    }
    let kills = trial.pick(10, 100);
    let asking = Asking {
        jobs: jobs()?,
        length_ms: kills as u64 * (LIVES_MS + AWAY_MS) as u64 / 2,
        patience_ms: 30_000,
        ..Asking::default()
    };
    let runs = Runs::of([&stations[0].daemon, &stations[1].daemon])?;
    fleet::begin(&mut members, &asking)?;
    kill(&[&a, &b], &mut stations, kills, trial.seed)?;
    let tally = Tally::of(fleet::finish(&mut members, &asking)?);
    let mut rows = ends(&tally, &format!("under {kills} kills -9 of the gateway"));
    rows.push(runs.twice(&tally)?);
    rows.push(alive(stations));
    Ok(rows)
}

/// One after the other, each back before the other dies.
fn kill(
    hosts: &[&Host; 2],
    stations: &mut [Station; 2],
    kills: usize,
    seed: u64,
) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let mut pause = |most| std::thread::sleep(Duration::from_millis(random.below(most) as u64));
    for number in 0..kills {
        let dying = number % 2;
        pause(LIVES_MS);
        stations[dying].gateway.end();
        pause(AWAY_MS);
        stations[dying].gateway = serve(hosts[dying], &stations[dying].daemon, &[])?;
    }
    Ok(())
}

fn alive(stations: [Station; 2]) -> Row {
    let dead = stations
        .into_iter()
        .map(|mut station| u64::from(!station.daemon.is_alive()))
        .sum();
    Row::none("daemon exits", dead)
}
