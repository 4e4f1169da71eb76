//! Loan, write in place, send.

use super::connection::Connection;
use super::link::{Link, OptimizeLoan};
use super::{ClientError, Pending};
use crate::limits::WIRE_VERSION;
use crate::wire::body::check_size;
use crate::wire::request::path_numbers;
use crate::wire::{NO_GROUP, RequestBody, RequestHeader};
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
    /// [`crate::wire::WireError::PathSize`] over the limits, [`ClientError::NoMemory`],
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

/// A request in shared memory, not sent yet.
pub struct LoanedRequest {
    // Before the link: the memory belongs to its port.
    loan: OptimizeLoan,
    numbers: usize,
    header: RequestHeader,
    link: Arc<Link>,
}

impl LoanedRequest {
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
    pub fn send(self) -> Result<Pending, ClientError> {
        let listener = self.link.take_listener()?;
        let header = RequestHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<RequestHeader>() as u32,
            listener_id: listener.id(),
            ..self.header
        };
        let (stream, boot_id) = self.link.dispatch(self.loan, header)?;
        let listener = Some(listener.keep());
        let request_id = header.request_id;
        Ok(Pending::new(
            self.link, stream, listener, request_id, boot_id,
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
