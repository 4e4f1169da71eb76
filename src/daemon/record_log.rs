//! Records in a file: each with its length and checksum, one after the other. Whoever writes one
//! hands it to the system in one piece, so that only the last can be half there.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// Bytes before each record: its length and its checksum.
pub(super) const HEADER: usize = 4 + 8;
/// Most bytes of a record.
const RECORD_MAX: usize = 256 * 1024 * 1024;

/// What a file holds.
#[derive(Debug)]
pub(super) struct Contents<T> {
    /// Its records in order.
    pub records: Vec<T>,
    /// Bytes at its end of a record that was not finished.
    pub torn: usize,
}

impl<T> Default for Contents<T> {
    fn default() -> Self {
        Self {
            records: Vec::new(),
            torn: 0,
        }
    }
}

/// The records of a file that stand from byte `start` on.
///
/// # Errors
/// Where it is damaged, and how.
pub(super) fn parse<T: DeserializeOwned>(
    bytes: &[u8],
    start: usize,
) -> Result<Contents<T>, String> {
    let mut rest = &bytes[start..];
    let mut records = Vec::new();
    while let Some((header, after)) = rest.split_first_chunk::<HEADER>() {
        let place = bytes.len() - rest.len();
        let length = u32::from_le_bytes([header[0], header[1], header[2], header[3]]) as usize;
        let Some(payload) = after.get(..length) else {
            break;
        };
        let damaged = |how: &str| format!("at byte {place}: {how}");
        if header[4..] != checksum(payload) {
            return Err(damaged("a checksum is wrong"));
        }
        let record = bincode::serde::decode_from_slice(payload, bincode::config::standard());
        match record {
            Ok((record, read)) if read == length => records.push(record),
            Ok(_) => return Err(damaged("a record is longer than it should be")),
            Err(error) => return Err(damaged(&error.to_string())),
        }
        rest = &after[length..];
    }
    Ok(Contents {
        records,
        torn: rest.len(),
    })
}

fn checksum(payload: &[u8]) -> [u8; 8] {
    let digest = Sha256::digest(payload);
    std::array::from_fn(|index| digest[index])
}

/// Appends a record to bytes.
///
/// # Errors
/// One that is too large, or cannot be written as bytes.
pub(super) fn encode<T: Serialize>(record: &T, bytes: &mut Vec<u8>) -> Result<(), String> {
    let payload = bincode::serde::encode_to_vec(record, bincode::config::standard());
    let payload = payload.map_err(|error| error.to_string())?;
    if payload.len() > RECORD_MAX {
        return Err(format!(
            "a record of {} bytes, at most {RECORD_MAX} are kept",
            payload.len()
        ));
    }
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(checksum(&payload));
    bytes.extend(payload);
    Ok(())
}
