//! The port of the local instance, and the requests that came through it.

use super::control;
use super::error::AttachError;
use super::local::Locals;
use crate::call::Nanos;
use crate::caller::{Caller, Running, Sink};
use crate::message::Payload;
use std::sync::Arc;
use std::time::Duration;
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingControl, IncomingRequest, SendError, Server, Waker};
use taut_ipc::wire::{Code, ResponseHeader, Status, WireError};
use zenoh::bytes::ZBytes;

/// Gets the answers to a request of this machine.
struct Planner {
    /// Gone after the final answer.
    request: Option<IncomingRequest>,
    /// Whether it was seen that its client wants the best so far.
    is_hinted: bool,
}

/// What a planner wants of a request that it has sent.
#[derive(PartialEq)]
enum Wants {
    Answers,
    TheBest,
    Nothing,
}

impl Sink for Planner {
    fn deliver(&mut self, header: &ResponseHeader, payload: &Payload) -> Result<(), WireError> {
        let Some(request) = &mut self.request else {
            return Ok(());
        };
        let fill = |place: &mut [u8]| payload.copy_to(place);
        let is_final = header.status == u32::from(Status::Final);
        match request.relay(header, payload.len(), fill) {
            Ok(()) => {}
            Err(SendError::TooLarge(error)) => return Err(error),
            // One improvement less: the request goes on.
            Err(error) => {
                tracing::warn!(request = header.request_id, "{error}");
                if is_final {
                    let _ = request.refuse(Code::ResourceExhausted, &error.to_string(), 0);
                }
            }
        }
        if is_final {
            self.request = None;
        }
        Ok(())
    }
}

impl Planner {
    fn wants(&mut self) -> Wants {
        let Some(request) = &self.request else {
            return Wants::Answers;
        };
        if !request.is_connected() {
            return Wants::Nothing;
        }
        let is_new = !self.is_hinted && request.has_disconnect_hint();
        self.is_hinted |= is_new;
        match is_new {
            true => Wants::TheBest,
            false => Wants::Answers,
        }
    }
}

/// The port, and what came through it.
pub(super) struct Port {
    caller: Arc<Caller>,
    locals: Arc<Locals>,
    calls: Vec<Arc<Running<Planner>>>,
    due: Option<Nanos>,
    waker: Waker,
    /// Last: requests hold its node.
    server: Arc<Server>,
}

impl Port {
    pub(super) fn new(caller: Arc<Caller>, server: Arc<Server>) -> Self {
        let locals = Arc::new(Locals::new(caller.clone(), server.clone()));
        Self {
            caller,
            locals,
            calls: Vec::new(),
            due: None,
            waker: server.waker(),
            server,
        }
    }

    /// Sleeps until something is to be done, at most for this time.
    pub(super) fn wait(&self, patience: Duration) -> Result<(), AttachError> {
        let left = self
            .due
            .map(|due| Duration::from_nanos(due.saturating_sub(monotonic_ns())));
        let patience = left.map_or(patience, |left| left.min(patience));
        self.server.wait(patience)?;
        Ok(())
    }

    /// Takes all that came.
    pub(super) fn receive(&mut self) -> Result<(), AttachError> {
        while let Some(request) = self.server.receive()? {
            self.begin(request);
        }
        while let Some(message) = self.server.receive_control()? {
            self.control(message);
        }
        Ok(())
    }

    fn begin(&mut self, mut request: IncomingRequest) {
        // Checked and numbered here, so that nothing else goes onto the network.
        if let Err(error) = request.view() {
            let code = error.code();
            let _ = request.refuse(code, &error.to_string(), 0);
            return;
        }
        let client = match self.locals.client(request.client_id()) {
            Ok(client) => client,
            Err(error) => {
                let _ = request.refuse(Code::ResourceExhausted, &error.to_string(), 0);
                return;
            }
        };
        let header = *request.header();
        let payload = ZBytes::from(request.payload().to_vec());
        let planner = Planner {
            request: Some(request),
            is_hinted: false,
        };
        let waker = self.waker.clone();
        let wake = move || waker.wake();
        let call = self
            .caller
            .call(&client, header, payload, planner, wake);
        call.drive();
        self.calls.push(call);
    }

    fn control(&self, message: IncomingControl) {
        let client = self.locals.client(message.client_id());
        control::start(&self.caller, client, message);
    }

    /// Drives the requests that are out, and lets those go that ended.
    pub(super) fn drive(&mut self) {
        for call in &self.calls {
            match call.with_sink(Planner::wants) {
                Wants::Answers => {}
                Wants::TheBest => call.finish_early(),
                Wants::Nothing => call.cancel(),
            }
        }
        let mut due: Option<Nanos> = None;
        self.calls.retain(|call| {
            let next = call.drive();
            due = [due, next].into_iter().flatten().min();
            next.is_some()
        });
        self.due = due;
    }

    /// Looks after the instance.
    pub(super) fn care(&self) -> Result<(), AttachError> {
        self.locals.forget_gone();
        match self.server.missing_file() {
            Some(file) => Err(AttachError::Removed(file.display().to_string())),
            None => Ok(()),
        }
    }
}
