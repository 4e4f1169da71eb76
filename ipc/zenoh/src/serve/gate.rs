//! What comes from the network, checked and brought to its client's port.

use super::clients::Clients;
use super::copies::Copies;
use super::counts::{Counts, count};
use super::later::{Later, Sender, start};
use super::options::Options;
use super::remote::Remote;
use crate::live::locked;
use crate::message::{self, Payload, Refused, UNKNOWN};
use crate::names::{self, Wish};
use crate::network::{NetworkError, declared};
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
    /// For those that have no port.
    later: Sender,
    counts: Arc<Counts>,
}

impl Gate {
    pub(super) fn new(session: Session, options: &Options) -> Result<Arc<Self>, NetworkError> {
        let later = declared("a thread that sends", Sender::start())?;
        Ok(Arc::new(Self {
            name: options.name.clone(),
            session,
            instance: options.instance.clone(),
            clients: Mutex::default(),
            copies: Copies::new(&options.follow),
            later,
            counts: Arc::default(),
        }))
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
            Ok(remote) => remote.request(&sender.envelope, header, &payload, query),
            Err(error) if is_passing(&error) => self.later.send(Later::LetGo(query)),
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
        match self.copies.of(header.scene_id) {
            Some(copy) if header.scene_version == 0 => {
                copy.check_seen(sender.envelope.seen_version)
            }
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
        let _alone = slot.alone();
        if let Some(remote) = slot.remote() {
            if remote.is_served() {
                return Ok(remote);
            }
            remote.leave();
        }
        let remote = self.open(sender)?;
        if slot.open(&remote) {
            return Ok(remote);
        }
        // Its token went meanwhile: nobody would ever close this port.
        remote.leave();
        Err(ClientError::GivenUp)
    }

    fn open(&self, sender: &message::Sender) -> Result<Arc<Remote>, ClientError> {
        Remote::open(
            sender.envelope.client,
            &sender.name,
            &self.instance,
            &self.counts,
        )
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
        let (sender, message) = match self.control_of(&query) {
            Ok(read) => read,
            Err(refused) => return self.refuse_control(query, &refused),
        };
        match self.remote(&sender) {
            Ok(remote) => remote.controlled(sender.envelope.request, message, query),
            Err(error) if is_passing(&error) => self.later.send(Later::LetGo(query)),
            Err(error) => self.refuse_control(query, &full(&error)),
        }
    }

    fn control_of(&self, query: &Query) -> Result<(message::Sender, ControlRequest), Refused> {
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
        Ok((sender, message))
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
            // Passing on what had come before may wait for a client that does not read.
            start("taut-lost", move || remote.pump());
        }
    }

    fn remotes(&self) -> Vec<Arc<Remote>> {
        locked(&self.clients).all()
    }

    /// What happened, in one line.
    pub(super) fn report(&self) {
        let counts = self.counts.named();
        let counts: Vec<String> = counts
            .iter()
            .map(|(name, count)| format!("{name} {count}"))
            .collect();
        tracing::info!("the gateway of {} ends: {}", self.name, counts.join(", "));
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

/// Whether a client that hears nothing does better than one that is refused: it asks another gateway,
/// or this one later.
fn is_passing(error: &ClientError) -> bool {
    matches!(error, ClientError::DaemonLost { .. } | ClientError::GivenUp)
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
