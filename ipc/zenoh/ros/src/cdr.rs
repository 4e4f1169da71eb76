//! Messages as bytes: four that say how they are encoded, then CDR as DDS has it.

use crate::Message;
use byteorder::{BigEndian, LittleEndian};

/// Little-endian CDR; what ROS 2 nodes of today write.
const LITTLE: [u8; 4] = [0, 1, 0, 0];
/// Of the first two bytes.
const BIG: [u8; 2] = [0, 0];

/// Bytes that are not the message.
#[derive(Debug, thiserror::Error)]
pub enum CdrError {
    /// Too short to say how they are encoded.
    #[error("{0} bytes; four say how the others are encoded")]
    Short(usize),
    /// Encoded otherwise.
    #[error("encoding {0:02x} {1:02x}; plain CDR, 00 00 or 00 01, is read")]
    Encoding(u8, u8),
    /// Not of this type.
    #[error("not a {name}: {source}")]
    Content {
        /// The message that was expected.
        name: &'static str,
        /// What is wrong.
        source: cdr_encoding::Error,
    },
}

/// A message as bytes, little-endian.
///
/// # Errors
/// [`CdrError::Content`] where a bounded sequence is too long.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, CdrError> {
    let body = cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(content::<M>)?;
    Ok([&LITTLE[..], &body].concat())
}

/// The message that bytes hold; what follows it is padding.
///
/// # Errors
/// [`CdrError`] for bytes that are none.
pub fn decode<M: Message>(bytes: &[u8]) -> Result<M, CdrError> {
    let Some((encoding, body)) = bytes.split_at_checked(LITTLE.len()) else {
        return Err(CdrError::Short(bytes.len()));
    };
    let read = match [encoding[0], encoding[1]] {
        [0, 1] => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        BIG => cdr_encoding::from_bytes::<M, BigEndian>(body),
        [first, second] => return Err(CdrError::Encoding(first, second)),
    };
    read.map(|(message, _)| message)
        .map_err(content::<M>)
}

fn content<M: Message>(source: cdr_encoding::Error) -> CdrError {
    CdrError::Content {
        name: M::NAME,
        source,
    }
}
