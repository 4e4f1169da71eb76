//! Answers from this process instead of a daemon.

use super::carrier::{Answered, Asked, Carrier, Ending, Inbox};
use crate::client_error::ClientError;
use crate::control::{ControlReply, ControlRequest};
use crate::wire::{RequestView, ResponseBody, ResponseHeader};
use std::sync::Arc;

/// Takes an answer.
pub type Tell<'a> = dyn Fn(&ResponseHeader, &ResponseBody<'_>) + 'a;

/// Something in this process that answers as a daemon does.
pub trait Service: Send + Sync + std::fmt::Debug {
    /// Answers a control message.
    fn control(&self, message: ControlRequest) -> ControlReply;

    /// Answers a request on a thread of its own: improvements, and a final answer last. It ends
    /// soon once it is asked to.
    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>);
}

impl<S: Service> Service for Arc<S> {
    fn control(&self, message: ControlRequest) -> ControlReply {
        (**self).control(message)
    }

    fn answer(&self, request: &RequestView<'_>, ending: &Ending, tell: &Tell<'_>) {
        (**self).answer(request, ending, tell);
    }
}

/// A service that gets a thread for each request.
#[derive(Debug)]
pub(super) struct Threads<S>(Arc<S>);

impl<S> Threads<S> {
    pub(super) fn new(service: S) -> Self {
        Self(Arc::new(service))
    }
}

impl<S: Service + 'static> Carrier for Threads<S> {
    fn control(&self, message: ControlRequest) -> ControlReply {
        self.0.control(message)
    }

    fn send(&self, asked: Asked, inbox: Inbox) -> Result<(), ClientError> {
        let service = self.0.clone();
        std::thread::Builder::new()
            .name("taut-local".into())
            .spawn(move || work(&*service, &asked, &inbox))
            .map_err(|error| ClientError::transport("a thread for the request", error))?;
        Ok(())
    }
}

fn work(service: &dyn Service, asked: &Asked, inbox: &Inbox) {
    let tell = |header: &ResponseHeader, body: &ResponseBody<'_>| {
        if inbox.ending().asked() == Some(false) {
            return;
        }
        let told = Answered::made(header, body).and_then(|answered| inbox.put(answered));
        if let Err(error) = told {
            inbox.broke(error);
        }
    };
    match asked.view() {
        Ok(view) => service.answer(&view, inbox.ending(), &tell),
        Err(error) => inbox.broke(error),
    }
}
