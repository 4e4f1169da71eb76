//! Records in a file: each with its length and checksum, one after the other. Whoever writes one
//! hands it to the system in one piece, so that only the last can be half there.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// Bytes before each record: its length and its checksum.
pub(crate) const HEADER: usize = 4 + 8;
/// Most bytes of a record.
const RECORD_MAX: usize = 256 * 1024 * 1024;

/// What a file says at its start that it is: a line with a word and the version of its records.
pub(crate) struct Format {
    /// The word.
    pub what: &'static str,
    /// What people call such a file.
    pub name: &'static str,
    /// Counts changes of the records.
    pub version: u32,
}

impl Format {
    /// The first line of a file.
    pub(crate) fn start(&self) -> Vec<u8> {
        format!("taut {} {}\n", self.what, self.version).into_bytes()
    }

    /// The records of a file.
    ///
    /// # Errors
    /// A file of another kind or version, or where it is damaged, and how: what is said of the file,
    /// from "it is" on.
    pub(crate) fn parse<T: DeserializeOwned>(&self, bytes: &[u8]) -> Result<Contents<T>, String> {
        let start = self.start();
        match bytes.starts_with(&start) {
            true => parse(bytes, start.len()).map_err(|place| format!("it is damaged {place}")),
            false => Err(self.other(bytes)),
        }
    }

    /// What a file is that does not start like this one.
    fn other(&self, bytes: &[u8]) -> String {
        let name = self.name;
        let version = self.version;
        match self.version_of(bytes) {
            Some(other) => format!(
                "it is a {name} of version {other}, this release reads version {version}; the one that wrote it reads it"
            ),
            None => format!("it is no {name}"),
        }
    }

    /// The version of a file's records, if it is such a file.
    fn version_of(&self, bytes: &[u8]) -> Option<u32> {
        let line = bytes.split(|byte| *byte == b'\n').next()?;
        let line = String::from_utf8_lossy(line);
        let number = line.strip_prefix(&format!("taut {} ", self.what))?;
        number.parse().ok()
    }
}

/// What a file holds.
#[derive(Debug)]
pub(crate) struct Contents<T> {
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
fn parse<T: DeserializeOwned>(bytes: &[u8], start: usize) -> Result<Contents<T>, String> {
    let mut rest = &bytes[start..];
    let mut records = Vec::new();
    while let Some((record, after)) =
        next(rest).map_err(|how| format!("at byte {}: {how}", bytes.len() - rest.len()))?
    {
        records.push(record);
        rest = after;
    }
    Ok(Contents {
        records,
        torn: rest.len(),
    })
}

/// Bytes that belong together, and those after them.
type Parted<'a> = (&'a [u8], &'a [u8]);

/// The first record and the bytes after it; `None` where none is whole.
fn next<T: DeserializeOwned>(bytes: &[u8]) -> Result<Option<(T, &[u8])>, String> {
    match first_payload(bytes)? {
        Some((payload, rest)) => Ok(Some((decoded(payload)?, rest))),
        None => Ok(None),
    }
}

fn decoded<T: DeserializeOwned>(payload: &[u8]) -> Result<T, String> {
    let record = bincode::serde::decode_from_slice(payload, bincode::config::standard());
    let (record, read) = record.map_err(|error| error.to_string())?;
    match read == payload.len() {
        true => Ok(record),
        false => Err("a record is longer than it should be".to_owned()),
    }
}

/// The bytes of the first record, and those after it; `None` where it is not whole.
fn first_payload(bytes: &[u8]) -> Result<Option<Parted<'_>>, String> {
    let Some((header, after)) = bytes.split_first_chunk::<HEADER>() else {
        return Ok(None);
    };
    let length = u32::from_le_bytes([header[0], header[1], header[2], header[3]]) as usize;
    let Some((payload, rest)) = after.split_at_checked(length) else {
        return Ok(None);
    };
    match header[4..] == checksum(payload) {
        true => Ok(Some((payload, rest))),
        false => Err("a checksum is wrong".to_owned()),
    }
}

fn checksum(payload: &[u8]) -> [u8; 8] {
    let digest = Sha256::digest(payload);
    std::array::from_fn(|index| digest[index])
}

/// Appends a record to bytes.
///
/// # Errors
/// One that is too large, or cannot be written as bytes.
pub(crate) fn encode<T: Serialize>(record: &T, bytes: &mut Vec<u8>) -> Result<(), String> {
    let payload = bincode::serde::encode_to_vec(record, bincode::config::standard());
    let payload = payload.map_err(|error| error.to_string())?;
    check_length(payload.len())?;
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(checksum(&payload));
    bytes.extend(payload);
    Ok(())
}

fn check_length(bytes: usize) -> Result<(), String> {
    if bytes <= RECORD_MAX {
        return Ok(());
    }
    Err(format!(
        "a record of {bytes} bytes, at most {RECORD_MAX} are kept"
    ))
}
