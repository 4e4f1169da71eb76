//! A request in flight.

use super::link::{Link, Stream, wait_until};
use super::{ClientError, Response};
use crate::transport::Variant;
use crate::wire::section::numbers;
use iceoryx2::port::listener::Listener;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The stream of responses to one request. Dropping it cancels the request.
#[derive(Debug)]
pub struct Pending {
    // Taken only by drop, in this order before the link.
    stream: Option<Stream>,
    listener: Option<Listener<Variant>>,
    link: Arc<Link>,
    request_id: u64,
    boot_id: u64,
    finished: bool,
    /// Whether something came back.
    heard: bool,
    /// When the daemon was last known to live; calls with short timeouts have to look in between
    /// too.
    looked: Instant,
}

impl Pending {
    pub(super) fn new(
        link: Arc<Link>,
        stream: Stream,
        listener: Option<Listener<Variant>>,
        request_id: u64,
        boot_id: u64,
    ) -> Self {
        Self {
            stream: Some(stream),
            listener,
            link,
            request_id,
            boot_id,
            finished: false,
            heard: false,
            looked: Instant::now(),
        }
    }

    /// The id in the request's header.
    pub fn request_id(&self) -> u64 {
        self.request_id
    }

    /// The next response, in place; `None` after the final one.
    ///
    /// If more come than the buffer of 8 holds, the oldest are gone: `seq` shows the gap. At most
    /// three responses of a request can be held at once.
    ///
    /// # Errors
    /// [`ClientError::Timeout`] if nothing came (call again), [`ClientError::DaemonLost`] within
    /// 100 ms of the daemon's death, [`ClientError::NoAnswer`] if the daemon dropped the request.
    pub fn next(&mut self, timeout: Duration) -> Result<Option<Response>, ClientError> {
        let end = Instant::now() + timeout;
        loop {
            if self.finished {
                return Ok(None);
            }
            if let Some(response) = self.try_next()? {
                return Ok(Some(response));
            }
            self.sleep(end, timeout)?;
        }
    }

    /// The next response if it is there already.
    ///
    /// # Errors
    /// As [`Self::next`], without a timeout.
    pub fn try_next(&mut self) -> Result<Option<Response>, ClientError> {
        let Some(stream) = self.stream.as_ref().filter(|_| !self.finished) else {
            return Ok(None);
        };
        // Asked before receiving: what was sent before the end is then still received.
        let connected = stream.is_connected();
        let received = stream
            .receive()
            .map_err(|error| ClientError::transport("responses", error))?;
        match received {
            Some(response) => {
                self.heard = true;
                let response = Response::new(response)?;
                self.finished = response.is_final();
                Ok(Some(response))
            }
            None if connected => Ok(None),
            None => {
                self.finished = true;
                self.link.check_alive(self.boot_id)?;
                Err(ClientError::NoAnswer)
            }
        }
    }

    /// The final response; improvements before it are skipped.
    ///
    /// # Errors
    /// As [`Self::next`]; the timeout is for all of it.
    pub fn wait(mut self, timeout: Duration) -> Result<Response, ClientError> {
        let end = Instant::now() + timeout;
        loop {
            match self.next(end.saturating_duration_since(Instant::now())) {
                Ok(Some(response)) if response.is_final() => return Ok(response),
                Ok(Some(_)) => (),
                Ok(None) => return Err(ClientError::NoAnswer),
                Err(ClientError::Timeout(_)) => return Err(ClientError::Timeout(timeout)),
                Err(error) => return Err(error),
            }
        }
    }

    /// Asks for the best so far, now: the daemon sends its final response and ends.
    pub fn finish_early(&self) {
        if let Some(stream) = &self.stream {
            stream.set_disconnect_hint();
            self.link.call_daemon();
        }
    }

    /// Shows the path that was sent, as it lies in shared memory.
    pub(crate) fn sent_path(&self, look: impl FnOnce(&[f64])) {
        let Some(stream) = &self.stream else { return };
        let section = stream.user_header().path;
        if let Ok(path) = numbers(stream.payload(), "path", section, usize::MAX) {
            look(path);
        }
    }

    fn sleep(&mut self, end: Instant, asked: Duration) -> Result<(), ClientError> {
        if self.looked.elapsed() >= crate::limits::PROBE_INTERVAL {
            self.link.check_alive(self.boot_id)?;
            self.looked = Instant::now();
        }
        match &self.listener {
            Some(listener) => wait_until(listener, end, asked),
            None => Ok(()),
        }
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        let cancelled = !self.finished;
        drop(self.stream.take());
        if let Some(listener) = self.listener.take() {
            self.link.put_listener(listener);
        }
        if cancelled {
            self.link.call_daemon();
        }
        if !self.heard {
            self.link.was_unheard();
        }
    }
}
