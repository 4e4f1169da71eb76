//! What a client sent, and the way back to it.

use super::{LetGo, Shared};
use crate::control::{ControlError, ControlReply, ControlRequest, Refusal, decode, encode};
use crate::limits::{CONTROL_MAX, CONTROL_REPLY_MAX, WIRE_VERSION};
use crate::transport::Variant;
use crate::wire::body::check_size;
use crate::wire::request::check_version;
use crate::wire::section::section_bytes;
use crate::wire::{
    Code, ControlHeader, ControlReplyHeader, RequestHeader, RequestView, ResponseBody,
    ResponseHeader, ResponseView, Section, Status, Termination, WireError,
};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::response_mut::ResponseMut;
use std::sync::Arc;

type Loan = ResponseMut<Variant, [u8], ResponseHeader>;

/// Why a response did not get into the client's buffer.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    /// Its sections do not fit a payload.
    #[error(transparent)]
    TooLarge(#[from] WireError),
    /// Too little shared memory is left.
    #[error("no room in /dev/shm for a response of {0} bytes")]
    NoMemory(usize),
    /// A control reply cannot be encoded.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// iceoryx2 refused.
    #[error("response not sent: {0}")]
    Port(String),
}

impl Shared {
    fn check_room(&self, bytes: usize) -> Result<(), SendError> {
        if self.room.take(bytes) {
            Ok(())
        } else {
            Err(SendError::NoMemory(bytes))
        }
    }
}

/// A request and the stream of its responses. Dropping it ends the stream.
#[derive(Debug)]
pub struct IncomingRequest {
    active: ActiveRequest<Variant, [u8], RequestHeader, [u8], ResponseHeader>,
    header: RequestHeader,
    seq: u32,
    // After the stream: the client has to see its end when it wakes.
    farewell: Farewell,
    _let_go: LetGo,
}

/// Wakes a client whose request ends without a final response.
#[derive(Debug)]
struct Farewell {
    shared: Arc<Shared>,
    listener_id: [u64; 2],
    finished: bool,
}

impl Drop for Farewell {
    fn drop(&mut self) {
        if !self.finished {
            self.shared.bell.ring(self.listener_id);
        }
    }
}

impl IncomingRequest {
    pub(super) fn new(
        active: ActiveRequest<Variant, [u8], RequestHeader, [u8], ResponseHeader>,
        shared: Arc<Shared>,
    ) -> Self {
        let header = *active.user_header();
        let let_go = LetGo(shared.clone());
        let farewell = Farewell {
            shared,
            listener_id: header.listener_id,
            finished: false,
        };
        Self {
            active,
            header,
            seq: 0,
            farewell,
            _let_go: let_go,
        }
    }

    /// The header, read once; nothing in it is checked yet.
    pub fn header(&self) -> &RequestHeader {
        &self.header
    }

    /// The payload, still in memory that the client can write: copy what matters once, then check
    /// the copy.
    pub fn payload(&self) -> &[u8] {
        self.active.payload()
    }

    /// The header checked and the payload cut into sections.
    ///
    /// # Errors
    /// What is wrong; [`WireError::code`] goes into the refusal.
    pub fn view(&self) -> Result<RequestView<'_>, WireError> {
        RequestView::parse(self.header, self.payload())
    }

    /// Which client sent it; two ports of one process count as two.
    pub fn client_id(&self) -> u128 {
        self.active.origin().value()
    }

    /// False once the client dropped the request; a killed client stays connected until it is
    /// cleaned up.
    pub fn is_connected(&self) -> bool {
        self.active.is_connected()
    }

    /// The client wants the best so far, now.
    pub fn has_disconnect_hint(&self) -> bool {
        self.active.has_disconnect_hint()
    }

    /// Responses sent so far.
    pub fn sent(&self) -> u32 {
        self.seq
    }

    /// Sends a response and wakes the client. Never waits: if the client does not read, its oldest
    /// response is dropped. Version, lengths, request id, sequence number, boot id and sections are
    /// filled in.
    ///
    /// # Errors
    /// [`SendError`]; the request stays usable, for example for a smaller refusal.
    pub fn send(
        &mut self,
        header: &ResponseHeader,
        body: &ResponseBody<'_>,
    ) -> Result<(), SendError> {
        let mut header = ResponseHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<ResponseHeader>() as u32,
            request_id: self.header.request_id,
            seq: self.seq,
            boot_id: self.farewell.shared.boot_id,
            ..*header
        };
        let bytes = body.lay_out(&mut header)?;
        let mut response = self.loan(bytes)?;
        *response.user_header_mut() = header;
        body.write(&header, response.payload_mut());
        self.dispatch(response)
    }

    /// Sends a response of somebody elsewhere on, with so many bytes of payload, which `fill`
    /// writes. Its header is kept but for request id and sequence number, which never falls.
    ///
    /// # Errors
    /// [`SendError`], also for bytes that are no response; the request stays usable.
    pub fn relay(
        &mut self,
        header: &ResponseHeader,
        bytes: usize,
        fill: impl FnOnce(&mut [u8]),
    ) -> Result<(), SendError> {
        let header = ResponseHeader {
            request_id: self.header.request_id,
            seq: header.seq.max(self.seq),
            ..*header
        };
        check_size(bytes)?;
        let mut response = self.loan(bytes)?;
        fill(response.payload_mut());
        ResponseView::parse(header, response.payload())?;
        *response.user_header_mut() = header;
        self.dispatch(response)
    }

    fn loan(&self, bytes: usize) -> Result<Loan, SendError> {
        self.farewell.shared.check_room(bytes)?;
        let loan = self.active.loan_slice(bytes);
        loan.map_err(|error| SendError::Port(error.to_string()))
    }

    /// Sends it and wakes the client.
    fn dispatch(&mut self, response: Loan) -> Result<(), SendError> {
        let header = *response.user_header();
        response
            .send()
            .map_err(|error| SendError::Port(error.to_string()))?;
        self.seq = header.seq.saturating_add(1);
        self.farewell.finished |= header.status == u32::from(Status::Final);
        self.farewell
            .shared
            .bell
            .ring(self.header.listener_id);
        Ok(())
    }

    /// Sends a final response that only says why not.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn refuse(
        &mut self,
        code: Code,
        message: &str,
        retry_after_ms: u32,
    ) -> Result<(), SendError> {
        let header = ResponseHeader {
            status: Status::Final.into(),
            code: code.into(),
            termination: Termination::Refused.into(),
            scene_id: self.header.scene_id,
            retry_after_ms,
            ..ResponseHeader::default()
        };
        self.send(
            &header,
            &ResponseBody {
                message,
                ..ResponseBody::default()
            },
        )
    }
}

/// A control message and the way back.
#[derive(Debug)]
pub struct IncomingControl {
    active: ActiveRequest<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>,
    header: ControlHeader,
    shared: Arc<Shared>,
    // After the message.
    _let_go: LetGo,
}

impl IncomingControl {
    pub(super) fn new(
        active: ActiveRequest<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>,
        shared: Arc<Shared>,
    ) -> Self {
        let header = *active.user_header();
        let let_go = LetGo(shared.clone());
        Self {
            active,
            header,
            shared,
            _let_go: let_go,
        }
    }

    /// The message, decoded from a copy of the bytes.
    ///
    /// # Errors
    /// A [`Refusal`] that can be sent back as it is.
    pub fn message(&self) -> Result<ControlRequest, Refusal> {
        let header = &self.header;
        let expected = size_of::<ControlHeader>();
        check_version(header.wire_version, header.header_len, expected).map_err(malformed)?;
        if self.active.payload().len() > CONTROL_MAX {
            return Err(Refusal::new(
                Code::ResourceExhausted,
                ControlError::TooLarge.to_string(),
            ));
        }
        let copy = self
            .section("message", header.message)?
            .to_vec();
        decode(&copy).map_err(malformed)
    }

    /// The body, in place: the client can still write it, so read each byte once and check what was
    /// read.
    ///
    /// # Errors
    /// A [`Refusal`] that can be sent back as it is.
    pub fn body(&self) -> Result<&[u8], Refusal> {
        self.section("body", self.header.body)
    }

    fn section(&self, name: &'static str, section: Section) -> Result<&[u8], Refusal> {
        section_bytes(self.active.payload(), name, section, 1, CONTROL_MAX).map_err(malformed)
    }

    /// Which client sent it.
    pub fn client_id(&self) -> u128 {
        self.active.origin().value()
    }

    /// Answers and wakes the client. A reply that is too large becomes a refusal.
    ///
    /// # Errors
    /// [`SendError`] if shared memory is full.
    pub fn reply(&self, reply: &ControlReply) -> Result<(), SendError> {
        let mut bytes = encode(reply)?;
        if bytes.len() > CONTROL_REPLY_MAX {
            let text = format!(
                "the reply has {} bytes, and at most {CONTROL_REPLY_MAX} fit",
                bytes.len()
            );
            bytes = encode(&ControlReply::Refused(Refusal::new(
                Code::ResourceExhausted,
                text,
            )))?;
        }
        self.shared.check_room(bytes.len())?;
        let loan = self.active.loan_slice_uninit(bytes.len());
        let mut response = loan.map_err(|error| SendError::Port(error.to_string()))?;
        *response.user_header_mut() = ControlReplyHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<ControlReplyHeader>() as u32,
            request_id: self.header.request_id,
            boot_id: self.shared.boot_id,
        };
        let response = response.write_from_slice(&bytes);
        response
            .send()
            .map_err(|error| SendError::Port(error.to_string()))?;
        self.shared.bell.ring(self.header.listener_id);
        Ok(())
    }
}

fn malformed(error: impl std::fmt::Display) -> Refusal {
    Refusal::new(Code::MalformedRequest, error.to_string())
}
