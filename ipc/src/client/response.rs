//! A response in shared memory.

use crate::transport::Variant;
use crate::wire::section::numbers;
use crate::wire::{Code, ResponseHeader, ResponseView, Status, WireError};
use iceoryx2::response::Response as Received;

/// A response, read in place; its memory goes back when it is dropped.
#[derive(Debug)]
pub struct Response {
    received: Received<Variant, [u8], ResponseHeader>,
    header: ResponseHeader,
    code: Code,
}

impl Response {
    pub(super) fn new(
        received: Received<Variant, [u8], ResponseHeader>,
    ) -> Result<Self, WireError> {
        let header = *received.user_header();
        let code = ResponseView::parse(header, received.payload())?.code;
        Ok(Self {
            received,
            header,
            code,
        })
    }

    /// The header.
    pub fn header(&self) -> &ResponseHeader {
        &self.header
    }

    /// How it went.
    pub fn code(&self) -> Code {
        self.code
    }

    /// Its sections as they lie in shared memory.
    pub fn payload(&self) -> &[u8] {
        self.received.payload()
    }

    /// The path, row by row, in shared memory; empty if there is none.
    pub fn path(&self) -> &[f64] {
        numbers(
            self.received.payload(),
            "path",
            self.header.path,
            usize::MAX,
        )
        .unwrap_or_default()
    }

    /// Whether it is the last response of its request.
    pub fn is_final(&self) -> bool {
        self.header.status == u32::from(Status::Final)
    }

    /// All sections.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed them after sending.
    pub fn view(&self) -> Result<ResponseView<'_>, WireError> {
        ResponseView::parse(self.header, self.received.payload())
    }

    /// The line for people, empty if there is none.
    pub fn message(&self) -> &str {
        self.view().map_or("", |view| view.message)
    }
}
