//! Control messages with a body that is written in place: a sensor's frame.

use super::ClientError;
use super::link::{ControlLoan, Link, section};
use crate::control::{ControlError, ControlReply, ControlRequest, encode};
use crate::limits::{CONTROL_MAX, PAYLOAD_ALIGN};
use crate::wire::ControlHeader;
use std::sync::Arc;
use std::time::Duration;

/// A control message and its body in shared memory, not sent yet.
pub struct LoanedFrame {
    // Before the link: the memory belongs to its port.
    loan: ControlLoan,
    header: ControlHeader,
    link: Arc<Link>,
}

impl LoanedFrame {
    /// Shared memory for a message and a body of so many bytes.
    pub(super) fn new(
        link: Arc<Link>,
        message: &ControlRequest,
        body: usize,
        request_id: u64,
    ) -> Result<Self, ClientError> {
        let message = encode(message)?;
        let offset = body.next_multiple_of(PAYLOAD_ALIGN);
        let bytes = offset + message.len();
        if bytes > CONTROL_MAX {
            return Err(ControlError::BodyTooLarge(body).into());
        }
        let mut loan = link.loan_control(bytes)?;
        loan.payload_mut()[offset..].copy_from_slice(&message);
        let header = ControlHeader {
            request_id,
            message: section(offset, message.len()),
            body: section(0, body),
            ..ControlHeader::default()
        };
        Ok(Self { loan, header, link })
    }

    /// The body in shared memory; zeros at first.
    pub fn body_mut(&mut self) -> &mut [u8] {
        let bytes = self.header.body.count as usize;
        &mut self.loan.payload_mut()[..bytes]
    }

    /// Sends it and waits for the reply.
    ///
    /// # Errors
    /// As [`crate::Client::control`].
    pub fn send(self, timeout: Duration) -> Result<ControlReply, ClientError> {
        let Self { loan, header, link } = self;
        link.exchange(loan, header, timeout, &|| false)
    }
}

impl std::fmt::Debug for LoanedFrame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LoanedFrame")
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}
