//! Control messages of clients elsewhere.

use super::copies::Copies;
use super::later::{Later, reply, start};
use super::remote::Remote;
use crate::live::locked;
use crate::message::Refused;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use taut_ipc::client::ClientError;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal, Stats, encode};
use taut_ipc::wire::Code;
use zenoh::bytes::ZBytes;
use zenoh::query::Query;

/// How long one may take: large meshes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);
/// How long an introduction may take.
const MOMENT: Duration = Duration::from_millis(100);
/// Messages of a client that wait at most.
const WAITING: u32 = 4;
/// Replies kept, so that a message that comes twice is done once.
const KEPT: usize = 8;
/// Replies larger than this are not kept: what they tell can be asked for again.
const LARGEST_KEPT: usize = 1 << 20;

/// Whether a message may come from elsewhere.
pub(super) fn check(
    daemon: &str,
    copies: &Copies,
    message: &ControlRequest,
) -> Result<(), Refused> {
    check_home(copies, message)?;
    let what = match message {
        ControlRequest::Shutdown => "a daemon is stopped",
        ControlRequest::Frame { .. } => "frames of sensors are taken in",
        ControlRequest::Record { .. } | ControlRequest::EndRecording => "runs are recorded",
        ControlRequest::Bundle { .. } => "bundles are written",
        ControlRequest::LoadRobot { files: None, .. }
        | ControlRequest::LoadScene { files: None, .. }
        | ControlRequest::DiffScene { files: None, .. } => "paths of files are read",
        // The gateway says who they are.
        ControlRequest::Introduce { .. } => "clients are introduced",
        _ => return Ok(()),
    };
    Err(Refused::new(
        Code::MalformedRequest,
        format!("{what} on a daemon's own machine; use `taut` there, where {daemon} runs"),
    ))
}

/// Scenes are changed at their home alone.
fn check_home(copies: &Copies, message: &ControlRequest) -> Result<(), Refused> {
    let label = match message {
        ControlRequest::DiffScene { label, .. } | ControlRequest::UnloadScene { label } => label,
        // Without `replace` it changes nothing.
        ControlRequest::LoadScene {
            label,
            replace: true,
            ..
        } => label,
        _ => return Ok(()),
    };
    match copies.labelled(label) {
        None => Ok(()),
        Some(copy) => Err(copy.unchanged()),
    }
}

/// A place among the messages of a client that wait; free again however its thread ends.
struct Place(Arc<Remote>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0
            .control
            .waiting
            .fetch_sub(1, Ordering::Relaxed);
    }
}

impl Remote {
    /// Tells the daemon whom the port is for, if it does not know. Others wait for this one no
    /// longer than a moment.
    pub(super) fn introduce(&self) {
        let is_known = &self.control.is_introduced;
        if is_known.load(Ordering::Relaxed) {
            return;
        }
        let Ok(_alone) = self.control.done.try_lock() else {
            return;
        };
        let name = self.name.clone();
        let told = self
            .client
            .control(&ControlRequest::Introduce { name }, MOMENT);
        match told {
            Ok(_) => is_known.store(true, Ordering::Relaxed),
            Err(error) => tracing::debug!(client = %self.name, "not introduced: {error}"),
        }
    }

    /// Another start of the daemon does not know it.
    pub(super) fn is_stranger_again(&self) {
        self.control
            .is_introduced
            .store(false, Ordering::Relaxed);
    }

    /// Has a thread do it: some take minutes.
    pub(super) fn controlled(
        self: &Arc<Self>,
        request: u64,
        message: ControlRequest,
        query: Query,
    ) {
        let waiting = &self.control.waiting;
        if waiting.fetch_add(1, Ordering::Relaxed) >= WAITING {
            waiting.fetch_sub(1, Ordering::Relaxed);
            let code = Code::Overloaded.into();
            let message = format!("{WAITING} control messages of this client wait; send it later");
            let refusal = Refusal {
                code,
                message,
                retry_after_ms: 100,
            };
            return self.say_later(query, &ControlReply::Refused(refusal));
        }
        let place = Place(self.clone());
        start("taut-control", move || {
            place.0.control_one(request, &message, &query);
        });
    }

    fn control_one(&self, request: u64, message: &ControlRequest, query: &Query) {
        let mut done = locked(&self.control.done);
        let known = done
            .iter()
            .find(|(id, _)| *id == request)
            .map(|(_, bytes)| bytes.clone());
        let bytes = match known {
            Some(bytes) => bytes,
            None => {
                let Some(bytes) = self.control_now(message) else {
                    return;
                };
                if bytes.len() <= LARGEST_KEPT {
                    done.push_back((request, bytes.clone()));
                }
                bytes
            }
        };
        while done.len() > KEPT {
            done.pop_front();
        }
        drop(done);
        if let Err(error) = reply(query, bytes) {
            tracing::debug!(client = %self.name, "a control reply was not sent: {error}");
        }
    }

    /// Its reply; `None` where the daemon is gone: the client asks again.
    fn control_now(&self, message: &ControlRequest) -> Option<ZBytes> {
        let stop = || self.is_gone();
        let reply = match self
            .client
            .control_until(message, PATIENCE, &stop)
        {
            Ok(ControlReply::Stats(stats)) => ControlReply::Stats(self.counted(stats)),
            Ok(reply) => reply,
            Err(ClientError::DaemonLost { .. } | ClientError::GivenUp) => return None,
            Err(error) => ControlReply::Refused(Refusal::new(error.code(), error.to_string())),
        };
        encode(&reply).ok().map(ZBytes::from)
    }

    /// With what this gateway counted.
    fn counted(&self, mut stats: Stats) -> Stats {
        let counts = self.counts.named();
        stats
            .numbers
            .extend(counts.map(|(name, count)| (name.to_owned(), count as f64)));
        stats
    }

    fn say_later(&self, query: Query, reply: &ControlReply) {
        if let Ok(bytes) = encode(reply) {
            self.later
                .send(Later::Reply(query, bytes.into()));
        }
    }
}
