//! Loan, write in place, send.

use super::connection::Connection;
use super::link::{Link, OptimizeLoan, listener_id};
use super::{ClientError, Pending, refused};
use crate::limits::{MAX_PAYLOAD, WIRE_VERSION};
use crate::wire::request::path_numbers;
use crate::wire::{NO_GROUP, RequestBody, RequestHeader, WireError};
use std::sync::Arc;

/// A request being put together; holds no shared memory yet.
#[derive(Debug)]
pub struct RequestBuilder<'a> {
    pub(super) connection: Arc<Connection>,
    /// What is asked for. Version, lengths, sections, path size and listener are filled in when it
    /// is sent; a request id of 0 gets a new one.
    pub header: RequestHeader,
    /// Optional sections.
    pub body: RequestBody<'a>,
}

impl<'a> RequestBuilder<'a> {
    pub(super) fn new(connection: Arc<Connection>, waypoints: u32, variables: u32) -> Self {
        let header = RequestHeader {
            waypoints,
            variables,
            group: NO_GROUP,
            ..RequestHeader::default()
        };
        Self {
            connection,
            header,
            body: RequestBody::default(),
        }
    }

    /// The same request with these optional sections.
    pub fn with_body<'b>(self, body: RequestBody<'b>) -> RequestBuilder<'b> {
        RequestBuilder {
            connection: self.connection,
            header: self.header,
            body,
        }
    }

    /// Takes shared memory for it.
    ///
    /// # Errors
    /// [`WireError::PathSize`] over the limits, [`ClientError::NoMemory`],
    /// [`ClientError::DaemonLost`] where its files were removed,
    /// [`ClientError::TooManyRequests`] if as many as a client may have are in flight.
    pub fn loan(mut self) -> Result<LoanedRequest, ClientError> {
        let numbers = path_numbers(self.header.waypoints, self.header.variables)?;
        let bytes = self.body.lay_out(&mut self.header, numbers);
        check_size(bytes)?;
        if self.header.request_id == 0 {
            self.header.request_id = self.connection.next_id();
        }
        let link = self.connection.link()?;
        let mut loan = link.loan(bytes)?;
        self.body
            .write(&self.header, loan.payload_mut());
        Ok(LoanedRequest {
            loan,
            numbers,
            header: self.header,
            link,
        })
    }
}

fn check_size(found: usize) -> Result<(), WireError> {
    let limit = MAX_PAYLOAD;
    match found <= limit {
        true => Ok(()),
        false => Err(WireError::PayloadSize { found, limit }),
    }
}

/// A request in shared memory, not sent yet.
pub struct LoanedRequest {
    // Before the link: the memory belongs to its port.
    loan: OptimizeLoan,
    numbers: usize,
    header: RequestHeader,
    link: Arc<Link>,
}

impl LoanedRequest {
    /// One that came from elsewhere.
    pub(super) fn copied(
        connection: &Connection,
        header: &RequestHeader,
        payload: &[u8],
    ) -> Result<Self, ClientError> {
        let numbers = path_numbers(header.waypoints, header.variables)?;
        check_size(payload.len())?;
        let link = connection.link()?;
        let mut loan = link.loan(payload.len())?;
        loan.payload_mut().copy_from_slice(payload);
        Ok(Self {
            loan,
            numbers,
            header: *header,
            link,
        })
    }

    /// The path in shared memory, row by row; zeros at first.
    pub fn path_mut(&mut self) -> &mut [f64] {
        // The path is the first section, and payloads are 8-aligned.
        bytemuck::cast_slice_mut(&mut self.loan.payload_mut()[..self.numbers * 8])
    }

    /// Sends it and wakes the daemon.
    ///
    /// # Errors
    /// [`ClientError::DaemonLost`], or [`ClientError::Overloaded`] if the daemon has not taken this
    /// client's earlier requests yet.
    pub fn send(mut self) -> Result<Pending, ClientError> {
        let boot_id = self.link.running()?;
        let listener = self.link.take_listener()?.keep();
        let request_id = self.header.request_id;
        *self.loan.user_header_mut() = RequestHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<RequestHeader>() as u32,
            listener_id: listener_id(&listener),
            ..self.header
        };
        let pending = match self.loan.send() {
            Ok(pending) => pending,
            Err(error) => {
                self.link.put_listener(listener);
                return Err(refused::from_send(error));
            }
        };
        if pending.number_of_server_connections() == 0 {
            self.link.put_listener(listener);
            self.link.check_alive(boot_id)?;
            return Err(ClientError::Overloaded);
        }
        self.link.call_daemon();
        Ok(Pending::new(
            self.link, pending, listener, request_id, boot_id,
        ))
    }
}

impl std::fmt::Debug for LoanedRequest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LoanedRequest")
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}
