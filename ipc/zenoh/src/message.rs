//! Messages as they travel: a header, then sections; beside them an envelope and a name.

use bytemuck::{AnyBitPattern, NoUninit, bytes_of, bytes_of_mut};
use std::io::{Read, Seek, SeekFrom};
use taut_ipc::limits::{MAX_PAYLOAD, WIRE_VERSION};
use taut_ipc::wire::{
    Code, Envelope, EnvelopeKind, ResponseBody, ResponseHeader, Section, Status, Termination,
    Times, WireError,
};
use zenoh::bytes::ZBytes;

/// Longest name of a client, in bytes.
pub const CLIENT_NAME_MAX: usize = 96;
/// Payload of the error reply that says that a request is not known.
pub const UNKNOWN: &[u8] = b"unknown";
/// Who sent something, and what.
#[derive(Clone, Debug)]
pub struct Sender {
    /// Ids and versions.
    pub envelope: Envelope,
    /// What it is.
    pub kind: EnvelopeKind,
    /// What people call the client.
    pub name: String,
}

impl Sender {
    /// As an attachment.
    pub fn write(envelope: &Envelope, kind: EnvelopeKind, name: &str) -> ZBytes {
        let envelope = Envelope {
            wire_version: WIRE_VERSION,
            kind: kind.into(),
            ..*envelope
        };
        let mut bytes = bytes_of(&envelope).to_vec();
        bytes.extend_from_slice(shortened(name).as_bytes());
        bytes.into()
    }

    /// Of an attachment; nothing in it is trusted.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(attachment: Option<&ZBytes>) -> Result<Self, WireError> {
        let none = ZBytes::new();
        let bytes = attachment.unwrap_or(&none);
        let (envelope, name): (Envelope, Payload) = split(bytes)?;
        envelope.check()?;
        let kind = EnvelopeKind::try_from(envelope.kind)?;
        if name.len() > CLIENT_NAME_MAX {
            return Err(WireError::SectionLimit {
                section: "client name",
                found: name.len(),
                limit: CLIENT_NAME_MAX,
            });
        }
        Ok(Self {
            envelope,
            kind,
            name: printable(&name)?,
        })
    }
}

fn shortened(name: &str) -> &str {
    &name[..name.floor_char_boundary(CLIENT_NAME_MAX)]
}

/// The name goes into logs and onto terminals.
fn printable(name: &Payload) -> Result<String, WireError> {
    let text = String::from_utf8(name.to_vec()).map_err(|_| WireError::Text("client name"))?;
    match text.chars().any(char::is_control) {
        true => Err(WireError::Text("client name")),
        false => Ok(text),
    }
}

/// The bytes behind a header.
#[derive(Clone, Debug, Default)]
pub struct Payload {
    bytes: ZBytes,
    start: usize,
}

impl Payload {
    /// How many.
    pub fn len(&self) -> usize {
        self.bytes.len() - self.start
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copies all of them to a place of their size.
    pub fn copy_to(&self, place: &mut [u8]) {
        let mut reader = self.bytes.reader();
        // Both are within what is there.
        let _ = reader.seek(SeekFrom::Start(self.start as u64));
        let _ = reader.read_exact(place);
    }

    /// A copy.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut copy = vec![0; self.len()];
        self.copy_to(&mut copy);
        copy
    }

    /// A copy that is aligned as the wire asks for, and its length in bytes.
    pub fn to_words(&self) -> Vec<u64> {
        let mut words = vec![0_u64; self.len().div_ceil(8)];
        let place: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
        self.copy_to(&mut place[..self.len()]);
        words
    }
}

impl From<Vec<u8>> for Payload {
    fn from(bytes: Vec<u8>) -> Self {
        let bytes = bytes.into();
        Self { bytes, start: 0 }
    }
}

/// A header and what follows it.
///
/// # Errors
/// Where there is less than a header, or more than a payload behind it.
pub fn split<H: AnyBitPattern + NoUninit>(bytes: &ZBytes) -> Result<(H, Payload), WireError> {
    let mut header = H::zeroed();
    let start = size_of::<H>();
    let place = bytes_of_mut(&mut header);
    if bytes.reader().read_exact(place).is_err() {
        return Err(WireError::HeaderLength {
            found: bytes.len() as u32,
            expected: start as u32,
        });
    }
    let found = bytes.len() - start;
    if found > MAX_PAYLOAD {
        let limit = MAX_PAYLOAD;
        return Err(WireError::PayloadSize { found, limit });
    }
    let bytes = bytes.clone();
    Ok((header, Payload { bytes, start }))
}

/// A header before what it tells of; copies the header alone.
pub fn join<H: NoUninit>(header: &H, payload: &ZBytes) -> ZBytes {
    let mut writer = ZBytes::writer();
    writer.append(bytes_of(header).to_vec().into());
    writer.append(payload.clone());
    writer.finish()
}

/// The same of bytes that somebody else owns: one copy.
pub fn copied<H: NoUninit>(header: &H, payload: &[u8]) -> ZBytes {
    let mut bytes = Vec::with_capacity(size_of::<H>() + payload.len());
    bytes.extend_from_slice(bytes_of(header));
    bytes.extend_from_slice(payload);
    bytes.into()
}

/// A final answer that is made on the way.
#[derive(Clone, Debug)]
pub struct Refused {
    /// Why.
    pub code: Code,
    /// One line for people.
    pub message: String,
    /// When to try again, in milliseconds; 0 = never.
    pub retry_after_ms: u32,
}

impl Refused {
    /// One that is not worth trying again.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            retry_after_ms: 0,
        }
    }

    /// The response of this request that says so.
    pub fn response(&self, request_id: u64) -> (ResponseHeader, Vec<u8>) {
        let mut header = ResponseHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<ResponseHeader>() as u32,
            request_id,
            status: Status::Final.into(),
            code: self.code.into(),
            retry_after_ms: self.retry_after_ms,
            termination: Termination::Refused.into(),
            ..ResponseHeader::default()
        };
        let body = ResponseBody {
            message: &self.message,
            ..ResponseBody::default()
        };
        // A line fits.
        let bytes = body.lay_out(&mut header).unwrap_or(0);
        let mut payload = vec![0; bytes];
        body.write(&header, &mut payload);
        (header, payload)
    }
}

impl From<WireError> for Refused {
    fn from(error: WireError) -> Self {
        Self::new(error.code(), error.to_string())
    }
}

/// An improvement as the final answer, with another line for people.
pub fn as_final(best: &ResponseHeader, payload: &Payload, line: &str) -> (ResponseHeader, Payload) {
    let mut bytes = payload.to_vec();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    let message = Section {
        offset: bytes.len() as u32,
        count: line.len() as u32,
    };
    bytes.extend_from_slice(line.as_bytes());
    let header = ResponseHeader {
        status: Status::Final.into(),
        termination: Termination::Deadline.into(),
        code: match best.times == u32::from(Times::NotReached) {
            true => Code::Untimed.into(),
            false => best.code,
        },
        message,
        ..*best
    };
    (header, bytes.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use taut_ipc::wire::ResponseView;

    #[test]
    fn what_is_joined_is_split_again() {
        let header = Envelope {
            client: 7,
            ..Envelope::default()
        };
        let payload = ZBytes::from(vec![1_u8, 2, 3]);
        let (again, rest): (Envelope, Payload) = split(&join(&header, &payload)).unwrap();
        assert_eq!(again, header);
        assert_eq!(rest.to_vec(), [1, 2, 3]);
        assert_eq!(copied(&header, &[1, 2, 3]), join(&header, &payload));
    }

    #[test]
    fn an_attachment_without_envelope_or_with_odd_names_is_refused() {
        assert!(Sender::read(None).is_err());
        assert!(Sender::read(Some(&vec![0_u8; 47].into())).is_err());
        let envelope = Envelope::default();
        let good = Sender::write(&envelope, EnvelopeKind::Again, "host/plan[7]");
        assert_eq!(Sender::read(Some(&good)).unwrap().name, "host/plan[7]");
        for name in [&b"\x1b[2J"[..], b"\xff", &[b'a'; 97]] {
            let mut bytes = good.to_bytes()[..size_of::<Envelope>()].to_vec();
            bytes.extend_from_slice(name);
            assert!(Sender::read(Some(&bytes.into())).is_err(), "{name:?}");
        }
        let long = Sender::write(&envelope, EnvelopeKind::Again, &"ä".repeat(90));
        assert_eq!(Sender::read(Some(&long)).unwrap().name.len(), 96);
    }

    #[test]
    fn another_version_is_named() {
        let mut bytes = Sender::write(&Envelope::default(), EnvelopeKind::Request, "")
            .to_bytes()
            .to_vec();
        bytes[0] = 9;
        let refused = Refused::from(Sender::read(Some(&bytes.into())).unwrap_err());
        assert_eq!(refused.code, Code::MalformedRequest);
        assert!(refused.message.contains("version 9"), "{}", refused.message);
    }

    #[test]
    fn an_improvement_that_becomes_final_keeps_its_path_and_gets_a_line() {
        let path = [1.0, 2.0, 3.0];
        let body = ResponseBody {
            path: &path,
            names: "odd",
            ..ResponseBody::default()
        };
        let mut header = Refused::new(Code::Success, "").response(5).0;
        header.waypoints = 1;
        header.variables = 3;
        header.status = Status::Progress.into();
        header.times = Times::NotReached.into();
        let mut bytes = vec![0; body.lay_out(&mut header).unwrap()];
        body.write(&header, &mut bytes);
        let (header, payload) = as_final(&header, &bytes.into(), "the link was lost");
        let words = payload.to_words();
        let view = ResponseView::parse(header, &bytemuck::cast_slice(&words)[..payload.len()]);
        let view = view.unwrap();
        assert_eq!(view.status, Status::Final);
        assert_eq!(
            view.code,
            Code::Untimed,
            "times that were asked for are missing"
        );
        assert_eq!(view.path, path);
        assert_eq!(view.names, "odd");
        assert_eq!(view.message, "the link was lost");
    }
}
