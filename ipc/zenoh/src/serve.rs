//! A gateway beside a daemon: each client elsewhere is a client of the daemon, with a port of its
//! own.

mod clients;
mod control;
mod controls;
mod copies;
mod counts;
mod daemon;
mod follow;
mod gate;
mod later;
mod options;
mod remote;
mod runs;
mod slot;

use crate::names::{self, Wish};
use crate::network::{Network, NetworkError, declared};
use crate::stop::Stop;
pub use options::Options;

use gate::Gate;
use std::sync::Arc;
use std::time::Duration;
use zenoh::{Session, Wait};

/// How often the gateway looks at its daemon and its clients.
const TICK: Duration = Duration::from_millis(50);

/// Serves until it is to stop.
///
/// # Errors
/// [`NetworkError`]: a session that cannot be opened. A daemon that is not there is waited for.
pub fn serve(network: &Network, options: &Options, stop: &Stop) -> Result<(), NetworkError> {
    let session = network.open()?;
    let gate = Gate::new(session.clone(), options)?;
    declare(&session, &gate)?;
    for home in &options.follow {
        follow::start(&gate, home, stop)?;
    }
    println!(
        "ready: serves {} as {}",
        options.instance.root().display(),
        options.name
    );
    let mut daemon = daemon::Daemon::new(gate.clone());
    while !stop.is_asked() {
        daemon.look();
        gate.tick();
        stop.wait(TICK);
    }
    gate.report();
    Ok(())
}

fn declare(session: &Session, gate: &Arc<Gate>) -> Result<(), NetworkError> {
    let name = gate.name();
    queryable(session, gate, names::optimize(name), Gate::asked)?;
    queryable(session, gate, names::control(name), Gate::controlled)?;
    for wish in [Wish::Cancel, Wish::Finish] {
        let for_callback = gate.clone();
        let subscriber = session
            .declare_subscriber(wish.all(name))
            .callback(move |sample| for_callback.wished(wish, sample.key_expr().as_str()))
            .background()
            .wait();
        declared("a subscriber of wishes", subscriber)?;
    }
    let for_callback = gate.clone();
    let tokens = session
        .liveliness()
        .declare_subscriber(names::client_tokens())
        .history(true)
        .callback(move |sample| for_callback.client_changed(&sample))
        .background()
        .wait();
    declared("a subscriber of tokens", tokens)
}

fn queryable(
    session: &Session,
    gate: &Arc<Gate>,
    key: String,
    take: fn(&Arc<Gate>, zenoh::query::Query),
) -> Result<(), NetworkError> {
    let gate = gate.clone();
    let queryable = session
        .declare_queryable(key)
        .complete(true)
        .callback(move |query| take(&gate, query))
        .background()
        .wait();
    declared("a queryable", queryable)
}
