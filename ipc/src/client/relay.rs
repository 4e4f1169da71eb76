//! Requests of somebody elsewhere, sent on as they are: what a gateway needs.

use super::link::{Link, listener_id, wait_until};
use super::{Client, ClientError, Pending, Response};
use crate::transport::Variant;
use crate::wire::body::check_size;
use crate::wire::{RequestHeader, RequestView};
use iceoryx2::port::listener::Listener;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Sends requests on whose bytes came from elsewhere, and is woken for all of them at once.
#[derive(Debug)]
pub struct Relay {
    // Before the link: it belongs to its node.
    listener: Listener<Variant>,
    link: Arc<Link>,
}

impl Client {
    /// A way for requests that are sent on as they are.
    ///
    /// # Errors
    /// [`ClientError::DaemonLost`], [`ClientError::Setup`] if its listener cannot be made.
    pub fn relay(&self) -> Result<Relay, ClientError> {
        let link = self.connection.link()?;
        let listener = link.take_listener()?.keep();
        Ok(Relay { listener, link })
    }
}

impl Relay {
    /// Whether no daemon will ever serve these ports again: have the client make another.
    pub fn is_stale(&self) -> bool {
        self.link.is_stale()
    }

    /// Sends a request of so many bytes of payload, which `fill` writes; its header is kept but for
    /// the listener. The deadline in it has to be of this machine's clock.
    ///
    /// # Errors
    /// [`ClientError::Wire`] for bytes that are no request, and what cannot be sent.
    pub fn send(
        &self,
        header: RequestHeader,
        bytes: usize,
        fill: impl FnOnce(&mut [u8]),
    ) -> Result<Relayed, ClientError> {
        check_size(bytes)?;
        let mut loan = self.link.loan(bytes)?;
        fill(loan.payload_mut());
        RequestView::parse(header, loan.payload())?;
        let header = RequestHeader {
            listener_id: listener_id(&self.listener),
            ..header
        };
        let (stream, boot_id) = self.link.dispatch(loan, header)?;
        let link = self.link.clone();
        let pending = Pending::new(link, stream, None, header.request_id, boot_id);
        Ok(Relayed(pending))
    }

    /// Sleeps until a response came to one of the requests, or for this time.
    ///
    /// # Errors
    /// [`ClientError::Transport`] if the listener is broken.
    pub fn wait(&self, patience: Duration) -> Result<(), ClientError> {
        match wait_until(&self.listener, Instant::now() + patience, patience) {
            Err(ClientError::Timeout(_)) => Ok(()),
            result => result,
        }
    }
}

/// A request that was sent on. Dropping it cancels the request.
#[derive(Debug)]
pub struct Relayed(Pending);

impl Relayed {
    /// The next response if it is there already; `None` after the final one too.
    ///
    /// # Errors
    /// As [`Pending::try_next`].
    pub fn try_next(&mut self) -> Result<Option<Response>, ClientError> {
        self.0.try_next()
    }

    /// Asks for the best so far, now.
    pub fn finish_early(&self) {
        self.0.finish_early();
    }
}
