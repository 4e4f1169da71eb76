//! The stream of answers.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, TryLockError, Weak};
use std::time::{Duration, Instant};
use taut_ipc::ClientError;
use taut_ipc::planner::{self, Best, PlannerError};
use taut_ipc::wire::Code;

use super::about::About;
use super::best::{Improvement, Shared};
use super::errors;
use super::guard::{self, Own};

/// How often a wait looks at what other threads want of it.
const LOOK: Duration = Duration::from_millis(10);
/// How often it looks for signals.
const SIGNALS: Duration = Duration::from_millis(50);
/// Improvements of a request that may lie in shared memory besides the one that comes.
const MOST_SHARED: usize = 2;

/// Answers to one request as they come.
#[pyclass(frozen, module = "taut._taut")]
pub struct Answers {
    stream: Mutex<Own<Option<planner::Answers>>>,
    about: Arc<About>,
    /// What was handed out and may still lie in shared memory.
    shared: Mutex<Vec<Weak<Mutex<Own<Best>>>>>,
    finish: AtomicBool,
    cancel: AtomicBool,
    request_id: u64,
}

impl Answers {
    pub fn new(stream: planner::Answers, about: About) -> Self {
        let request_id = stream.request_id();
        Self {
            stream: Mutex::new(Own::new(Some(stream))),
            about: Arc::new(about),
            shared: Mutex::default(),
            finish: AtomicBool::new(false),
            cancel: AtomicBool::new(false),
            request_id,
        }
    }

    /// Improvements that users still hold in shared memory.
    fn held(&self) -> usize {
        let mut shared = self
            .shared
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        shared.retain(|best| best.strong_count() > 0);
        shared.len()
    }

    fn handed_out(&self, best: Best) -> Shared {
        // Users may keep what they get for as long as they like: where they hold as many as may lie
        // in shared memory, they get a copy.
        let best = if best.is_shared() && self.held() >= MOST_SHARED {
            best.into_own()
        } else {
            best
        };
        let is_shared = best.is_shared();
        let best = Arc::new(Mutex::new(Own::new(best)));
        if is_shared {
            let mut shared = self
                .shared
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            shared.push(Arc::downgrade(&best));
        }
        best
    }

    /// Waits for a while, until `end` at the latest; `None` where nothing came.
    fn wait(
        &self,
        stream: &mut Option<planner::Answers>,
        end: Option<Instant>,
    ) -> Result<Option<Option<Best>>, PlannerError> {
        let slice = Instant::now() + SIGNALS;
        let until = end.map_or(slice, |end| end.min(slice));
        loop {
            if self.cancel.load(Ordering::Relaxed) {
                *stream = None;
            }
            let Some(answers) = stream else {
                return Ok(Some(None));
            };
            if self.finish.swap(false, Ordering::Relaxed) {
                answers.finish_early();
            }
            let left = until.saturating_duration_since(Instant::now());
            match answers.next(left.min(LOOK)) {
                Ok(Some(best)) => {
                    if best.is_final() {
                        *stream = None;
                    }
                    return Ok(Some(Some(best)));
                }
                Ok(None) => {
                    *stream = None;
                    return Ok(Some(None));
                }
                Err(PlannerError::Client(ClientError::Timeout(_))) if left.is_zero() => {
                    return Ok(None);
                }
                Err(PlannerError::Client(ClientError::Timeout(_))) => {}
                Err(error) => {
                    *stream = None;
                    return Err(error);
                }
            }
        }
    }
}

#[pymethods]
impl Answers {
    /// The next answer, or None after the final one, after `close`, or after `timeout` seconds.
    #[pyo3(signature = (timeout=None))]
    fn next(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<Option<Improvement>> {
        let end = guard::end_of(timeout)?;
        let mut stream = match self.stream.try_lock() {
            Ok(stream) => stream,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                return Err(errors::invalid(
                    "another thread waits for these answers; iterate in one thread",
                ));
            }
        };
        let stream = stream.get_mut()?;
        let was_open = stream.is_some();
        loop {
            let waited = py.detach(|| self.wait(stream, end));
            py.check_signals()?;
            match waited.map_err(|error| errors::of(&error))? {
                Some(Some(best)) => {
                    let best = py.detach(|| self.handed_out(best));
                    return Ok(Some(Improvement::new(best, self.about.clone())?));
                }
                Some(None) if was_open && self.cancel.load(Ordering::Relaxed) => {
                    return Err(errors::raise(
                        Code::Preempted,
                        "the request was cancelled while this waited",
                    ));
                }
                Some(None) => return Ok(None),
                None if end.is_some_and(|end| Instant::now() >= end) => return Ok(None),
                None => {}
            }
        }
    }

    /// Asks for the best so far, now.
    fn finish_early(&self) -> PyResult<()> {
        match self.stream.try_lock() {
            Ok(stream) => {
                if let Some(answers) = stream.get()? {
                    answers.finish_early();
                }
            }
            // Another thread waits, and looks at this.
            Err(_) => self.finish.store(true, Ordering::Relaxed),
        }
        Ok(())
    }

    /// Cancels the request, if it still runs.
    fn close(&self, py: Python<'_>) {
        self.cancel.store(true, Ordering::Relaxed);
        if let Ok(mut stream) = self.stream.try_lock()
            && let Ok(stream) = stream.get_mut()
        {
            py.detach(|| *stream = None);
        }
    }

    /// The id under which the daemon tells of the request.
    #[getter]
    fn request_id(&self) -> String {
        format!("{:016x}", self.request_id)
    }
}
