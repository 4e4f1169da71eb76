//! The daemon's ports, and the requests that came through them, by ticket.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use taut::store::Snapshot;
use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::server::{IncomingControl, IncomingRequest, SendError, Server, ServerError, Waker};
use taut_ipc::wire::{Code, ResponseBody, ResponseHeader, SceneEvent, StatusRecord};

use super::cleaning::Cleaning;
use crate::daemon::service::client::Client;
use crate::daemon::service::event::{Asked, Event, Surroundings, Ticket};
use crate::daemon::threads::locked;
use crate::daemon::translate::{self, Question, Reply};

/// Ports whose clients are remembered.
const REMEMBERED: usize = 1024;

/// Ports, and what came through them.
pub(super) struct Port {
    requests: Mutex<HashMap<Ticket, Stream>>,
    controls: Mutex<HashMap<Ticket, Control>>,
    /// By the ports that they send through.
    clients: Mutex<HashMap<u128, Client>>,
    tickets: AtomicU64,
    cleaning: Cleaning,
    waker: Waker,
    /// Last: requests and the janitor hold its node, and only the last to go can leave nothing
    /// behind.
    server: Server,
}

/// A control request that came; one thread at a time uses it.
type Control = Arc<Mutex<IncomingControl>>;

/// A request that came; one thread at a time uses it.
type Stream = Arc<Mutex<Request>>;

struct Request {
    request: IncomingRequest,
    /// Whether it was told that its client wants the best so far.
    is_hinted: bool,
}

impl Port {
    /// The ports of a server.
    pub(super) fn new(server: Server, cleaning: Cleaning) -> Self {
        Self {
            requests: Mutex::default(),
            controls: Mutex::default(),
            clients: Mutex::default(),
            tickets: AtomicU64::new(0),
            cleaning,
            waker: server.waker(),
            server,
        }
    }

    /// Sleeps until somebody calls, or for this time.
    pub(super) fn wait(&self, patience: Duration) -> Result<(), ServerError> {
        self.server.wait(patience).map(drop)
    }

    /// Ends the current or the next wait.
    pub(super) fn wake(&self) {
        self.waker.wake();
    }

    /// The next request, if there is one.
    pub(super) fn receive(&self) -> Result<Option<Event>, ServerError> {
        let received = self.server.receive()?;
        Ok(received.map(|request| self.asked(request)))
    }

    fn asked(&self, request: IncomingRequest) -> Event {
        let ticket = self.ticket();
        let checked = request
            .view()
            .map(drop)
            .map_err(|error| refusal(&error));
        let asked = Asked {
            ticket,
            client: self.client(request.client_id()),
            header: *request.header(),
            bytes: request.payload().len(),
            checked,
        };
        let request = Request {
            request,
            is_hinted: false,
        };
        locked(&self.requests).insert(ticket, Arc::new(Mutex::new(request)));
        Event::Asked(Box::new(asked))
    }

    /// The next control request, if there is one.
    pub(super) fn receive_control(&self) -> Result<Option<Event>, ServerError> {
        let received = self.server.receive_control()?;
        Ok(received.map(|control| self.controlled(control)))
    }

    fn controlled(&self, control: IncomingControl) -> Event {
        let ticket = self.ticket();
        let message = control.message().map(Box::new);
        let client = self.client(control.client_id());
        locked(&self.controls).insert(ticket, Arc::new(Mutex::new(control)));
        Event::Controlled {
            ticket,
            client,
            message,
            around: self.around(),
        }
    }

    /// Requests whose clients are gone, or newly want the best so far.
    pub(super) fn ended(&self) -> Vec<Event> {
        let mut busy = Vec::new();
        let mut ended: Vec<Event> = locked(&self.requests)
            .iter()
            .filter_map(|(ticket, stream)| match stream.try_lock() {
                Ok(mut request) => request.ended(*ticket),
                Err(_) => {
                    busy.push((*ticket, stream.clone()));
                    None
                }
            })
            .collect();
        // Who uses one for long keeps nobody from the others.
        let waited = busy.into_iter();
        ended.extend(waited.filter_map(|(ticket, stream)| locked(&stream).ended(ticket)));
        ended
    }

    /// A file that is gone, by which clients find the daemon.
    pub(super) fn missing_file(&self) -> Option<PathBuf> {
        self.server.missing_file().map(Path::to_owned)
    }

    /// What the service is not told otherwise.
    pub(super) fn around(&self) -> Surroundings {
        Surroundings {
            clients: self.server.clients() as u32,
            cleaned_nodes: self.cleaning.cleaned(),
        }
    }

    /// Copies the payload of a request out and checks it. Where its client is gone, nobody needs
    /// it.
    pub(super) fn read(
        &self,
        ticket: Ticket,
        snapshot: &Snapshot,
        clearance_m: f64,
    ) -> Option<Result<Question, Refusal>> {
        let stream = self.stream(ticket)?;
        let request = &locked(&stream).request;
        Some(question(request, snapshot, clearance_m))
    }

    /// Sends a response that is not the last; whether it was sent.
    pub(super) fn tell(
        &self,
        ticket: Ticket,
        header: &ResponseHeader,
        body: &ResponseBody<'_>,
    ) -> bool {
        let Some(stream) = self.stream(ticket) else {
            return true;
        };
        let request = &mut locked(&stream).request;
        let sent = request.send(header, body);
        if let Err(error) = &sent {
            let request = request.header().request_id;
            tracing::warn!(request, "a response was not sent: {error}");
        }
        sent.is_ok()
    }

    /// Sends an answer and ends the stream; where it has no room, a refusal.
    pub(super) fn answer(&self, ticket: Ticket, reply: &Reply) {
        if let Some(stream) = self.remove(ticket) {
            deliver(&mut locked(&stream).request, reply);
        }
    }

    /// Sends a final response that only says why not, and ends the stream.
    pub(super) fn refuse(&self, ticket: Ticket, refusal: &Refusal) {
        let Some(stream) = self.remove(ticket) else {
            return;
        };
        let code = Code::try_from(refusal.code).unwrap_or(Code::MalformedRequest);
        let request = &mut locked(&stream).request;
        let refused = request.refuse(code, &refusal.message, refusal.retry_after_ms);
        if let Err(error) = refused {
            tracing::warn!("a refusal was not sent: {error}");
        }
    }

    /// Ends a stream without a word.
    pub(super) fn drop(&self, ticket: Ticket) {
        self.remove(ticket);
    }

    /// Has a look at the body of a control request that is not answered yet, in place.
    pub(super) fn with_body<T>(
        &self,
        ticket: Ticket,
        look: impl FnOnce(&[u8]) -> Result<T, Refusal>,
    ) -> Option<Result<T, Refusal>> {
        let control = locked(&self.controls).get(&ticket).cloned()?;
        let control = locked(&control);
        Some(control.body().and_then(look))
    }

    /// Answers a control request; a reply that is too large, or has no room, becomes a refusal.
    pub(super) fn reply(&self, ticket: Ticket, reply: &ControlReply) {
        let control = locked(&self.controls).remove(&ticket);
        if let Some(Err(error)) = control.map(|control| locked(&control).reply(reply)) {
            tracing::warn!("a control reply was not sent: {error}");
        }
    }

    /// Tells everybody who listens of a change.
    pub(super) fn publish(&self, event: &SceneEvent) -> Result<(), ServerError> {
        self.server.publish_scene_event(event)
    }

    /// Tells everybody how things stand, and in the log whether clean-ups hang.
    pub(super) fn publish_status(&self, status: &StatusRecord) -> Result<(), ServerError> {
        self.cleaning.warn_if_slow();
        self.server.publish_status(status)
    }

    fn ticket(&self) -> Ticket {
        1 + self.tickets.fetch_add(1, Ordering::Relaxed)
    }

    fn client(&self, id: u128) -> Client {
        let mut clients = locked(&self.clients);
        if !clients.contains_key(&id) {
            if clients.len() == REMEMBERED {
                clients.clear();
            }
            self.cleaning.look();
            clients.insert(id, self.connected(id));
        }
        clients[&id]
    }

    /// Who sends through a port; one that is gone already stands for itself.
    fn connected(&self, id: u128) -> Client {
        let peer = self.server.peer(id);
        peer.map_or(Client { id, pid: 0 }, |peer| Client {
            id: peer.connection,
            pid: peer.pid,
        })
    }

    fn stream(&self, ticket: Ticket) -> Option<Stream> {
        locked(&self.requests).get(&ticket).cloned()
    }

    fn remove(&self, ticket: Ticket) -> Option<Stream> {
        locked(&self.requests).remove(&ticket)
    }
}

impl Request {
    /// What its client has done meanwhile.
    fn ended(&mut self, ticket: Ticket) -> Option<Event> {
        if !self.request.is_connected() {
            return Some(Event::Gone(ticket));
        }
        let is_newly_hinted = !self.is_hinted && self.request.has_disconnect_hint();
        self.is_hinted |= is_newly_hinted;
        is_newly_hinted.then_some(Event::Hinted(ticket))
    }
}

fn question(
    request: &IncomingRequest,
    snapshot: &Snapshot,
    clearance_m: f64,
) -> Result<Question, Refusal> {
    let view = request
        .view()
        .map_err(|error| refusal(&error))?;
    translate::question(&view, snapshot, clearance_m)
}

fn refusal(error: &taut_ipc::wire::WireError) -> Refusal {
    Refusal::new(error.code(), error.to_string())
}

/// Sends an answer; where it has no room, a refusal.
fn deliver(request: &mut IncomingRequest, reply: &Reply) {
    let Err(error) = request.send(&reply.header, &reply.body()) else {
        return;
    };
    let id = request.header().request_id;
    tracing::warn!(request = id, "the answer was not sent: {error}");
    if !matches!(error, SendError::TooLarge(_) | SendError::NoMemory(_)) {
        return;
    }
    if let Err(error) = request.refuse(Code::ResourceExhausted, &error.to_string(), 0) {
        tracing::warn!(request = id, "its refusal neither: {error}");
    }
}
