//! Calls that outlive the daemon: what failed because it died, or was refused for now, is sent
//! again.

use super::{ClientError, RequestBuilder, Response};
use crate::wire::WireError;
use std::time::{Duration, Instant};

/// Pause before something is sent again where the daemon names none: a restart takes some 50 ms.
const PAUSE: Duration = Duration::from_millis(20);
/// How often a wait for an answer looks at the time.
const LOOK_UP: Duration = Duration::from_secs(1);
/// Daemons that may be lost over one request. It may be what kills them, and a supervisor gives up
/// after a few more.
const MOST_LOSSES: u32 = 3;

impl ClientError {
    /// Whether the same call may succeed soon: the daemon went away or is still starting, or has no
    /// room for it now.
    pub fn is_passing(&self) -> bool {
        matches!(
            self,
            Self::DaemonLost { .. } | Self::Overloaded | Self::NoAnswer
        )
    }
}

/// Makes a call again while its failure [is passing](ClientError::is_passing), until `patience` has
/// passed since the first; gives the last error then.
///
/// Only for calls that may be made twice. All of this crate's may: loading what is loaded already
/// changes nothing.
///
/// # Errors
/// What `call` gives.
pub fn retry<T>(
    patience: Duration,
    mut call: impl FnMut() -> Result<T, ClientError>,
) -> Result<T, ClientError> {
    let mut end = None;
    loop {
        match call() {
            Err(error) if error.is_passing() => {
                let now = Instant::now();
                if now + PAUSE >= *end.get_or_insert(now + patience) {
                    return Err(error);
                }
                std::thread::sleep(PAUSE);
            }
            result => return result,
        }
    }
}

impl RequestBuilder<'_> {
    /// Sends the request with this path and waits for its final response, whatever happens to the
    /// daemon meanwhile.
    ///
    /// If the daemon dies, the request is sent to the next one under the same id; if it is refused
    /// for now (OVERLOADED, QUOTA, LOADING, CLOUD_TOO_OLD), again when the refusal says. This goes on until
    /// `patience` has passed since the first of these, or three daemons died over it; then the last
    /// refusal is the response, the last loss the error. `watch` gets every improvement; after a
    /// loss they begin anew. A deadline in the header holds for all of it.
    ///
    /// # Errors
    /// As [`Self::loan`] and [`super::Pending::next`], except that a request without an answer is
    /// waited for.
    pub fn answer(
        mut self,
        path: &[f64],
        patience: Duration,
        watch: &mut dyn FnMut(&Response),
    ) -> Result<Response, ClientError> {
        if self.header.request_id == 0 {
            self.header.request_id = self.connection.next_id();
        }
        let mut end = None;
        let mut losses = 0;
        loop {
            let (result, pause) = match self.once(path, watch, &mut losses) {
                Ok(response) if response.code().is_retryable() => {
                    let hint = Duration::from_millis(response.header().retry_after_ms.into());
                    (Ok(response), hint.max(PAUSE))
                }
                Err(error) if error.is_passing() && losses < MOST_LOSSES => (Err(error), PAUSE),
                result => return result,
            };
            let now = Instant::now();
            if now + pause >= *end.get_or_insert(now + patience) {
                return result;
            }
            // A refusal's memory goes back before the wait.
            drop(result);
            std::thread::sleep(pause);
        }
    }

    fn once(
        &self,
        path: &[f64],
        watch: &mut dyn FnMut(&Response),
        losses: &mut u32,
    ) -> Result<Response, ClientError> {
        let again = Self {
            connection: self.connection.clone(),
            header: self.header,
            body: self.body,
        };
        let mut loan = again.loan()?;
        let slots = loan.path_mut();
        if slots.len() != path.len() {
            let found = path.len();
            let expected = slots.len();
            return Err(WireError::SectionCount {
                section: "path",
                found,
                expected,
            }
            .into());
        }
        slots.copy_from_slice(path);
        let mut pending = loan.send()?;
        loop {
            match pending.next(LOOK_UP) {
                Ok(Some(response)) if response.is_final() => return Ok(response),
                Ok(Some(response)) => watch(&response),
                Err(ClientError::Timeout(_)) => {}
                result => {
                    *losses += 1;
                    return Err(result.err().unwrap_or(ClientError::NoAnswer));
                }
            }
        }
    }
}
