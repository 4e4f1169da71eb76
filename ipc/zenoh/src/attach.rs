//! A local instance whose daemons are elsewhere: planners use it as they use a daemon's.

mod control;
mod error;
mod feeds;
mod local;
mod port;

use crate::caller::Caller;
use crate::network::Network;
use crate::stop::Stop;
pub use error::AttachError;
pub use local::host;
use port::Port;
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::Instance;
use taut_ipc::server::{Janitor, Server};

/// How long a start waits for the first gateway before it says that it is ready all the same.
const FIRST_GATEWAY: Duration = Duration::from_secs(3);
/// How often the instance is looked after: planners that left, files that were removed.
const CARE: Duration = Duration::from_millis(500);

/// What is attached.
#[derive(Clone, Debug)]
pub struct Options {
    /// The local instance.
    pub instance: Instance,
    /// Daemons to ask, the best first; empty = all that are there, by name.
    pub daemons: Vec<String>,
}

/// Serves the local instance until it is to stop.
///
/// # Errors
/// [`AttachError`]. Gateways that are not there are no error.
pub fn attach(network: &Network, options: &Options, stop: &Stop) -> Result<(), AttachError> {
    let server = Arc::new(Server::create(&options.instance)?);
    let caller = Caller::open(network, &options.daemons)?;
    let waker = server.waker();
    let for_janitor = waker.clone();
    let _janitor = Janitor::start(&options.instance, move |_| for_janitor.wake())?;
    let for_live = waker.clone();
    caller.live.wakes(move || for_live.wake());
    feeds::follow(&caller, &server)?;
    let mut port = Port::new(caller.clone(), server);
    wait_for_gateway(&caller, stop);
    let root = options.instance.root().display();
    println!("ready: {root} reaches {:?}", caller.live);
    let served = serve(&mut port, stop);
    let (resent, late) = caller.counts();
    tracing::info!(resent, late, "the instance {root} is left");
    served
}

fn wait_for_gateway(caller: &Caller, stop: &Stop) {
    let end = Instant::now() + FIRST_GATEWAY;
    while caller.best().is_none() && Instant::now() < end && !stop.is_asked() {
        stop.wait(Duration::from_millis(5));
    }
}

fn serve(port: &mut Port, stop: &Stop) -> Result<(), AttachError> {
    let mut cared = Instant::now();
    while !stop.is_asked() {
        port.wait(CARE)?;
        port.receive()?;
        port.drive();
        if cared.elapsed() >= CARE {
            cared = Instant::now();
            port.care()?;
        }
    }
    Ok(())
}
