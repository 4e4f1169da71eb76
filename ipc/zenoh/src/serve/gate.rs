//! What comes from the network, checked and brought to its client's port.

use super::clients::Clients;
use super::copies::Copies;
use super::counts::{Counts, count};
use super::later::{Later, Sender};
use super::options::Options;
use super::remote::Remote;
use crate::live::locked;
use crate::message::{self, Payload, Refused, UNKNOWN};
use crate::names::{self, Wish};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;
use taut_ipc::Instance;
use taut_ipc::client::ClientError;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal, decode, encode};
use taut_ipc::wire::{Code, EnvelopeKind, RequestHeader, WireError};
use zenoh::Session;
use zenoh::query::Query;
use zenoh::sample::{Sample, SampleKind};

/// A gateway.
#[derive(Debug)]
pub(super) struct Gate {
    name: String,
    pub(super) session: Session,
    pub(super) instance: Instance,
    clients: Mutex<Clients>,
    copies: Copies,
    later: Arc<Sender>,
    counts: Arc<Counts>,
}

impl Gate {
    pub(super) fn new(session: Session, options: &Options) -> Arc<Self> {
        Arc::new(Self {
            name: options.name.clone(),
            session,
            instance: options.instance.clone(),
            clients: Mutex::default(),
            copies: Copies::default(),
            later: Arc::new(Sender::start()),
            counts: Arc::default(),
        })
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Scenes whose home is elsewhere.
    pub(super) fn copies(&self) -> &Copies {
        &self.copies
    }

    /// A request, or the question what became of one.
    pub(super) fn asked(self: &Arc<Self>, query: Query) {
        let sender = match message::Sender::read(query.attachment()) {
            Ok(sender) => sender,
            Err(error) => return self.refuse(query, 0, &error.into()),
        };
        let request = sender.envelope.request;
        match sender.kind {
            EnvelopeKind::Request => self.request(&sender, query),
            EnvelopeKind::Again => self.again(&sender, query),
            EnvelopeKind::Control => self.refuse(query, request, &misplaced().into()),
        }
    }

    fn request(&self, sender: &message::Sender, query: Query) {
        let request = sender.envelope.request;
        let (header, payload) = match self.checked(sender, &query) {
            Ok(checked) => checked,
            Err(refused) => return self.refuse(query, request, &refused),
        };
        match self.remote(sender) {
            Ok(remote) => remote.request(header, &payload, query),
            // It asks another gateway, or this one later.
            Err(ClientError::DaemonLost { .. }) => self.later.send(Later::LetGo(query)),
            Err(error) => self.refuse(query, request, &full(&error)),
        }
    }

    fn checked(
        &self,
        sender: &message::Sender,
        query: &Query,
    ) -> Result<(RequestHeader, Payload), Refused> {
        let (header, payload) = request_of(sender, query)?;
        self.check_seen(sender, &header)?;
        Ok((header, payload))
    }

    /// A copy that is older than what the client has seen would answer for a world that is gone.
    fn check_seen(&self, sender: &message::Sender, header: &RequestHeader) -> Result<(), Refused> {
        let seen = sender.envelope.seen_version;
        match self.copies.of(header.scene_id) {
            Some(copy) if header.scene_version == 0 && copy.version < seen => Err(Refused {
                code: Code::Loading,
                message: format!(
                    "version {seen} of scene {} has not come from {} yet, here is {}",
                    copy.label, copy.home, copy.version
                ),
                retry_after_ms: 50,
            }),
            _ => Ok(()),
        }
    }

    fn again(&self, sender: &message::Sender, query: Query) {
        let remote = locked(&self.clients).find(sender.envelope.client);
        match remote {
            Some(remote) => remote.again(sender.envelope.request, query),
            None => self
                .later
                .send(Later::Fail(query, UNKNOWN.into())),
        }
    }

    /// The port of a client, opened where it is new.
    fn remote(&self, sender: &message::Sender) -> Result<Arc<Remote>, ClientError> {
        let now = Instant::now();
        let unannounced = locked(&self.clients).make_room(sender.envelope.client, now);
        for remote in unannounced {
            remote.leave();
        }
        let slot = locked(&self.clients).slot(sender.envelope.client, now)?;
        // Others do not wait for this one's port.
        let mut opened = locked(&slot);
        if let Some(remote) = &*opened {
            if !remote.is_stale() {
                return Ok(remote.clone());
            }
            remote.leave();
        }
        let remote = Remote::open(
            sender.envelope.client,
            &sender.name,
            &self.instance,
            &self.later,
            &self.counts,
        )?;
        *opened = Some(remote.clone());
        Ok(remote)
    }

    fn refuse(&self, query: Query, request: u64, refused: &Refused) {
        count(&self.counts.refused);
        tracing::debug!(request, "refused: {}", refused.message);
        let (header, payload) = refused.response(request);
        let bytes = message::copied(&header, &payload);
        self.later.send(Later::Reply(query, bytes));
    }

    /// A control message.
    pub(super) fn controlled(self: &Arc<Self>, query: Query) {
        match self.control_of(&query) {
            Ok((remote, request, message)) => {
                remote.controlled(request, message, query);
            }
            // It asks another gateway, or this one later.
            Err(refused) if refused.code == Code::DaemonLost => {
                self.later.send(Later::LetGo(query));
            }
            Err(refused) => self.refuse_control(query, &refused),
        }
    }

    fn control_of(&self, query: &Query) -> Result<(Arc<Remote>, u64, ControlRequest), Refused> {
        let sender = message::Sender::read(query.attachment())?;
        if sender.kind != EnvelopeKind::Control {
            return Err(misplaced().into());
        }
        let bytes = query
            .payload()
            .map(|payload| payload.to_bytes())
            .unwrap_or_default();
        let message: ControlRequest = decode(&bytes)
            .map_err(|error| Refused::new(Code::MalformedRequest, error.to_string()))?;
        super::control::check(&self.name, &self.copies, &message)?;
        let remote = self.remote(&sender);
        let remote = remote.map_err(|error| full(&error))?;
        Ok((remote, sender.envelope.request, message))
    }

    fn refuse_control(&self, query: Query, refused: &Refused) {
        count(&self.counts.refused);
        let refusal = Refusal {
            code: refused.code.into(),
            message: refused.message.clone(),
            retry_after_ms: refused.retry_after_ms,
        };
        let later = match encode(&ControlReply::Refused(refusal)) {
            Ok(bytes) => Later::Reply(query, bytes.into()),
            Err(_) => Later::LetGo(query),
        };
        self.later.send(later);
    }

    /// What a client wishes of a request.
    pub(super) fn wished(&self, wish: Wish, key: &str) {
        let Some((client, request)) = names::client_and_request(key) else {
            return;
        };
        let remote = locked(&self.clients).find(client);
        if let Some(remote) = remote {
            remote.wish(wish, request);
        }
    }

    /// A client's token came or went.
    pub(super) fn client_changed(&self, sample: &Sample) {
        if let Some(client) = names::client_of(sample.key_expr().as_str()) {
            let is_there = sample.kind() == SampleKind::Put;
            locked(&self.clients).changed(client, is_there, Instant::now());
        }
    }

    /// What is to be done now and then.
    pub(super) fn tick(&self) {
        let now = Instant::now();
        let gone = locked(&self.clients).gone(now);
        for remote in gone {
            remote.leave();
        }
        for remote in self.remotes() {
            remote.forget(now);
        }
    }

    /// The daemon may be gone: requests that it had are lost.
    pub(super) fn daemon_changed(&self) {
        for remote in self.remotes() {
            remote.pump();
        }
    }

    fn remotes(&self) -> Vec<Arc<Remote>> {
        locked(&self.clients).all()
    }

    /// What happened, in one line.
    pub(super) fn report(&self) {
        let counts = &self.counts;
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        tracing::info!(
            requests = of(&counts.requests),
            finished = of(&counts.finished),
            known = of(&counts.known),
            refused = of(&counts.refused),
            cancelled = of(&counts.cancelled),
            "the gateway of {} ends",
            self.name
        );
    }
}

fn request_of(
    sender: &message::Sender,
    query: &Query,
) -> Result<(RequestHeader, Payload), WireError> {
    let none = zenoh::bytes::ZBytes::new();
    let bytes = query.payload().unwrap_or(&none);
    let (header, payload): (RequestHeader, Payload) = message::split(bytes)?;
    if header.request_id != sender.envelope.request {
        return Err(WireError::UnknownValue {
            field: "request_id",
            value: header.request_id as i64,
        });
    }
    Ok((header, payload))
}

fn misplaced() -> WireError {
    WireError::UnknownValue {
        field: "kind",
        value: u32::from(EnvelopeKind::Control).into(),
    }
}

/// Why a client gets no port.
fn full(error: &ClientError) -> Refused {
    let code = error.code();
    Refused {
        code,
        message: format!("the gateway has no port for this client: {error}"),
        retry_after_ms: if code.is_retryable() { 100 } else { 0 },
    }
}
