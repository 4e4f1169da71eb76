//! Networks that need routers: one that restarts, and two linked ones with peers, where Zenoh itself
//! delivers a query twice.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use super::ends::{Runs, ends};
use super::trial::Trial;
use crate::error::Error;
use crate::fleet;
use crate::gateway::{Attached, Station, ready};
use crate::jobs::jobs;
use crate::network::{Host, cable, hosts};
use crate::orders::{Asking, Tally};
use crate::process::Process;
use crate::programs::own;
use crate::row::Row;

const CLIENTS: usize = 4;
const UP: Duration = Duration::from_millis(3_000);
const AWAY: Duration = Duration::from_millis(300);

pub(super) fn measure(trial: &Trial) -> Result<Vec<Row>, Error> {
    let mut rows = restarts(trial)?;
    rows.extend(linked(trial, "peer")?);
    rows.extend(linked(trial, "client")?);
    Ok(rows)
}

/// Both sides are clients of one router, which is killed and started again.
fn restarts(trial: &Trial) -> Result<Vec<Row>, Error> {
    let [a, middle, planners] = hosts(["a", "middle", "planners"])?;
    cable(&a, &middle)?;
    cable(&planners, &middle)?;
    let mut running = router(&middle, &[])?;
    let config = configured(&a, "client", &[&middle])?;
    let station = Station::start(&a, 1, &["--config", &config])?;
    let config = configured(&planners, "client", &[&middle])?;
    let attached = Attached::start(&planners, "attached", &[], &["--config", &config])?;
    let mut members = fleet::planners(&planners, attached.instance(), CLIENTS)?;
    let times = trial.pick(2, 20);
    let runs = Runs::of([&station.daemon])?;
    let asking = asking(times as u64 * (UP + AWAY).as_millis() as u64 + 1_000)?;
    fleet::begin(&mut members, &asking)?;
    for _ in 0..times {
        std::thread::sleep(UP);
        running.end();
        std::thread::sleep(AWAY);
        running = router(&middle, &[])?;
    }
    let tally = Tally::of(fleet::finish(&mut members, &asking)?);
    let mut rows = ends(&tally, &format!("over {times} restarts of their router"));
    rows.push(runs.twice(&tally)?);
    Ok(rows)
}

/// The gateway is a peer of two routers that are linked; planners are in this mode.
fn linked(trial: &Trial, mode: &str) -> Result<Vec<Row>, Error> {
    let [a, one, other, planners] = hosts(["a", "one", "other", "planners"])?;
    for (first, second) in [
        (&one, &other),
        (&a, &one),
        (&a, &other),
        (&planners, &one),
        (&planners, &other),
        // Peers that know each other by their routers link directly.
        (&a, &planners),
    ] {
        cable(first, second)?;
    }
    let _routers = [router(&one, &[])?, router(&other, &[&one])?];
    let config = configured(&a, "peer", &[&one, &other])?;
    let station = Station::start(&a, 1, &["--config", &config])?;
    let config = configured(&planners, mode, &[&one, &other])?;
    let attached = Attached::start(&planners, "attached", &[], &["--config", &config])?;
    let mut members = fleet::planners(&planners, attached.instance(), CLIENTS)?;
    let runs = Runs::of([&station.daemon])?;
    let tally = Tally::of(fleet::all(
        &mut members,
        &asking(trial.pick(2_000, 20_000))?,
    )?);
    let mut rows = ends(
        &tally,
        &format!("of a {mode} to a peer of two linked routers"),
    );
    // Zenoh may leave a peer without any reply here (zenoh#2477): such requests end with a code.
    if mode == "client" {
        rows.push(Row::none(
            format!("of {} requests, without a proved answer", tally.sent),
            tally.sent - tally.served(),
        ));
    }
    rows.push(runs.twice(&tally)?);
    Ok(rows)
}

fn asking(length_ms: u64) -> Result<Asking, Error> {
    Ok(Asking {
        jobs: jobs()?,
        length_ms,
        patience_ms: 30_000,
        ..Asking::default()
    })
}

fn endpoint(host: &Host) -> String {
    format!("tcp/{}:7450", host.address())
}

/// Any session is a router that is told so.
fn router(host: &Host, linked: &[&Host]) -> Result<Process, Error> {
    let mut command = host.command(&own()?, &host.instance("none")?);
    command.args(["echo", "--mode", "router", "--listen", &endpoint(host)]);
    for other in linked {
        command.args(["--connect", &endpoint(other)]);
    }
    ready(host, "router", command)
}

/// A configuration of Zenoh's own; tells its file.
fn configured(host: &Host, mode: &str, routers: &[&Host]) -> Result<String, Error> {
    let file: PathBuf = host.folder().join("zenoh.json5");
    let endpoints: Vec<String> = routers
        .iter()
        .map(|router| endpoint(router))
        .collect();
    let is_peer = mode == "peer";
    // Peers that listen to nobody are not found.
    let listen: Vec<String> = is_peer
        .then(|| format!("tcp/{}:7449", host.address()))
        .into_iter()
        .collect();
    let text = format!(
        "{{ mode: {mode:?}, connect: {{ endpoints: {endpoints:?} }}, listen: {{ endpoints: {listen:?} }}, \
         scouting: {{ multicast: {{ enabled: false }}, gossip: {{ enabled: {is_peer} }} }} }}"
    );
    fs::write(&file, text).map_err(|source| Error::System {
        what: "a configuration",
        source,
    })?;
    Ok(file.display().to_string())
}
