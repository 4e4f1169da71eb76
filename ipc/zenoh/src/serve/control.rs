//! Control messages of clients elsewhere.

use super::later::{Later, reply, start};
use super::remote::Remote;
use crate::live::locked;
use crate::message::Refused;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use taut_ipc::client::ClientError;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal, encode};
use taut_ipc::wire::Code;
use zenoh::bytes::ZBytes;
use zenoh::query::Query;

/// How long one may take: large meshes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);
/// Messages of a client that wait at most.
const WAITING: u32 = 4;
/// Replies kept, so that a message that comes twice is done once.
const KEPT: usize = 8;
/// Replies larger than this are not kept: what they tell can be asked for again.
const LARGEST_KEPT: usize = 1 << 20;

/// The control messages of one client, one at a time.
#[derive(Debug, Default)]
pub(super) struct Control {
    waiting: AtomicU32,
    done: Mutex<VecDeque<(u64, ZBytes)>>,
}

/// Whether a message may come from elsewhere.
pub(super) fn check(daemon: &str, message: &ControlRequest) -> Result<(), Refused> {
    let what = match message {
        ControlRequest::Shutdown => "a daemon is stopped",
        ControlRequest::Record { .. } | ControlRequest::EndRecording => "runs are recorded",
        ControlRequest::Bundle { .. } => "bundles are written",
        _ => return Ok(()),
    };
    Err(Refused::new(
        Code::MalformedRequest,
        format!("{what} on its own machine; use `taut` there, where {daemon} runs"),
    ))
}

impl Remote {
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
        let remote = self.clone();
        start("taut-control", move || {
            remote.control_one(request, &message, &query);
            let waiting = &remote.control.waiting;
            waiting.fetch_sub(1, Ordering::Relaxed);
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
            Ok(reply) => reply,
            Err(ClientError::DaemonLost { .. } | ClientError::GivenUp) => return None,
            Err(error) => ControlReply::Refused(Refusal::new(error.code(), error.to_string())),
        };
        encode(&reply).ok().map(ZBytes::from)
    }

    fn say_later(&self, query: Query, reply: &ControlReply) {
        if let Ok(bytes) = encode(reply) {
            self.later
                .send(Later::Reply(query, bytes.into()));
        }
    }
}
