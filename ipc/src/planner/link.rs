//! Who answers a planner: a daemon, or a service of its process.

use super::prepared::Prepared;
use super::{Best, Columns, PlannerError};
use crate::client_error::ClientError;
use crate::control::{ControlReply, ControlRequest};
use crate::wire::ResponseHeader;
use std::fmt::Debug;
use std::sync::Arc;
use std::time::Duration;

/// How long a control message goes on after its daemon died, or had no room for it.
pub(super) const RECOVERY: Duration = Duration::from_secs(5);
/// How often a wait for an answer looks up.
const LOOK_UP: Duration = Duration::from_secs(1);

/// The way to who answers.
pub(super) trait Link: Debug + Send + Sync {
    /// Sends a control message, to the next daemon if the first dies, until `stop` says so.
    fn control(
        &self,
        message: &ControlRequest,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError>;

    /// Sends a control message to who is there now.
    fn control_once(&self, message: &ControlRequest) -> Result<ControlReply, ClientError>;

    /// Which start of it is there; `None` = nobody.
    fn boot_id(&self) -> Option<u64>;

    /// Sends a request with its path, row by row in the caller's columns.
    fn send(&self, prepared: &Prepared, path: &[f64]) -> Result<Box<dyn Stream>, PlannerError>;

    /// Sends it and waits for the final answer, for `patience` also where the one asked dies.
    fn answer(
        &self,
        prepared: &Prepared,
        path: &[f64],
        _patience: Duration,
        improved: &mut dyn FnMut(&ResponseHeader),
    ) -> Result<Best, PlannerError> {
        let mut stream = self.send(prepared, path)?;
        loop {
            match stream.next(LOOK_UP, &prepared.columns) {
                Ok(Some(best)) if best.is_final() => return Ok(best),
                Ok(Some(best)) => improved(best.header()),
                Err(ClientError::Timeout(_)) => {}
                Ok(None) => return Err(ClientError::NoAnswer.into()),
                Err(error) => return Err(error.into()),
            }
        }
    }
}

/// The answers to one request. Dropping it cancels the request.
pub(super) trait Stream: Debug + Send {
    /// The id under which the request is told of.
    fn request_id(&self) -> u64;

    /// The next answer; `None` after the final one.
    fn next(
        &mut self,
        timeout: Duration,
        columns: &Arc<Columns>,
    ) -> Result<Option<Best>, ClientError>;

    /// Asks for the best so far, now.
    fn finish_early(&self);

    /// The path that was sent, in the caller's columns, where the request may be sent again.
    fn sent(&self, columns: &Columns) -> Option<Vec<f64>>;
}
