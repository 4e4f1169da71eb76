//! What belongs to one process, and waiting: until when, and what signals end.

use pyo3::prelude::*;
use std::mem;
use std::time::{Duration, Instant};

use super::errors;

/// A value of the process that made it. After a fork the child has a copy of its memory but not of
/// what is behind it (ports, threads): there it is neither used nor dropped, for that would take it
/// from the parent.
#[derive(Debug)]
pub struct Own<T> {
    pid: u32,
    value: Option<T>,
}

impl<T> Own<T> {
    pub fn new(value: T) -> Self {
        Self {
            pid: std::process::id(),
            value: Some(value),
        }
    }

    /// The value.
    ///
    /// # Errors
    /// `taut.DaemonLost` in another process than the one that made it.
    pub fn get(&self) -> PyResult<&T> {
        self.check()?;
        Ok(self.value.as_ref().expect("taken only by drop"))
    }

    pub fn get_mut(&mut self) -> PyResult<&mut T> {
        self.check()?;
        Ok(self.value.as_mut().expect("taken only by drop"))
    }

    fn check(&self) -> PyResult<()> {
        if self.pid == std::process::id() {
            return Ok(());
        }
        let text = "this connection belongs to the process that forked; connect anew in the child";
        Err(errors::raise(taut_ipc::wire::Code::DaemonLost, text))
    }
}

impl<T> Drop for Own<T> {
    fn drop(&mut self) {
        if self.pid != std::process::id() {
            mem::forget(self.value.take());
        }
    }
}

/// Whether a signal wants the interpreter; the exception is kept for [`Interrupt::take`].
#[derive(Default)]
pub struct Interrupt(std::sync::Mutex<Option<PyErr>>);

impl Interrupt {
    /// Lets the interpreter look at its signals; for code that runs without its lock.
    pub fn came(&self) -> bool {
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => false,
            Err(error) => {
                *self.lock() = Some(error);
                true
            }
        }
    }

    /// The exception that a signal's handler raised.
    pub fn take(&self) -> Option<PyErr> {
        self.lock().take()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<PyErr>> {
        self.0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// When a wait of so many seconds from now ends; `None` = never.
pub fn end_of(timeout: Option<f64>) -> PyResult<Option<Instant>> {
    let Some(seconds) = timeout else {
        return Ok(None);
    };
    let wait = Duration::try_from_secs_f64(seconds);
    let wait =
        wait.map_err(|_| errors::invalid(format!("a timeout of {seconds} s; valid: 0 or more")))?;
    Ok(Instant::now().checked_add(wait))
}
