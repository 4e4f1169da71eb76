//! The connection.

use crate::borrow::{maybe_text, needed};
use crate::code::TAUT_SUCCESS;
use crate::error::{Error, run};
use crate::handle::{Handle, Table};
use std::ffi::c_char;
use taut_ipc::Instance;
use taut_ipc::planner::{Planner, PlannerError};

/// A connection to a daemon. One per process is enough: every call on it may come from any thread,
/// and four requests can be in flight. It survives a restart of the daemon.
pub struct Daemon {
    _opaque: [u8; 0],
}

impl Handle for Daemon {
    type Value = Planner;
    const NAME: &'static str = "taut_daemon";

    fn table() -> &'static Table<Planner> {
        static DAEMONS: Table<Planner> = Table::new();
        &DAEMONS
    }
}

/// Connects to a daemon. `instance` is NAME or NAME:ROOT; NULL = what the variable TAUT_INSTANCE
/// says, or the default. Closed by `taut_close`.
///
/// Codes: TAUT_DAEMON_LOST if there is none, TAUT_OVERLOADED if it is full.
///
/// # Safety
/// `instance` is NULL or a string; `daemon` points to a place for the handle, `error` too or is
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn taut_connect(
    instance: *const c_char,
    daemon: *mut *mut Daemon,
    error: *mut *mut Error,
) -> i32 {
    let work = || {
        let place = needed("daemon", daemon)?;
        // SAFETY: the caller promises a string or NULL.
        let instance = match unsafe { maybe_text("instance", instance) }? {
            None => Instance::from_environment().map_err(PlannerError::from)?,
            Some(text) => Instance::parse(&text).map_err(PlannerError::from)?,
        };
        let handle = Daemon::of(Planner::connect(&instance)?);
        // SAFETY: not null, and the caller's own.
        unsafe { place.write(handle) };
        Ok(TAUT_SUCCESS)
    };
    // SAFETY: the caller's promise is the same.
    unsafe { run(error, work) }
}

/// Closes a connection. Requests and answers that were made with it stay until they are freed. NULL
/// and connections that are closed are let be.
#[unsafe(no_mangle)]
pub extern "C" fn taut_close(daemon: *mut Daemon) {
    drop(Daemon::end(daemon));
}
