//! Ctrl-C and other signals that ask a load test to end: it then stops what it started.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::error::Error;

static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Begins to listen for them.
pub(super) fn listen() -> Result<(), Error> {
    let stop = STOP.get_or_init(Arc::default);
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        let registered = signal_hook::flag::register(signal, Arc::clone(stop));
        registered.map_err(|source| Error::System {
            what: "signal handler",
            source,
        })?;
    }
    Ok(())
}

/// An error if one came.
pub(super) fn check() -> Result<(), Error> {
    match STOP
        .get()
        .is_some_and(|stop| stop.load(Ordering::Relaxed))
    {
        true => Err(Error::Interrupted),
        false => Ok(()),
    }
}
