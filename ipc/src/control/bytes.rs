//! Control messages as bytes.

use crate::limits::CONTROL_MAX;
use serde::{Deserialize, Serialize};

/// Why a control message could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ControlError {
    /// It does not fit.
    #[error(
        "a control message of more than {CONTROL_MAX} bytes; send the scene in parts or as files"
    )]
    TooLarge,
    /// Its body does not fit.
    #[error(
        "a body of {0} bytes, and at most {CONTROL_MAX} fit with their message; send fewer points or smaller ones"
    )]
    BodyTooLarge(usize),
    /// The bytes are no message of this version.
    #[error("not a control message of this version: {0}")]
    Malformed(String),
}

fn configuration() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<CONTROL_MAX>()
}

/// A message as bytes.
///
/// # Errors
/// [`ControlError::TooLarge`] over [`CONTROL_MAX`].
pub fn encode<M: Serialize>(message: &M) -> Result<Vec<u8>, ControlError> {
    match bincode::serde::encode_to_vec(message, configuration()) {
        Ok(bytes) if bytes.len() <= CONTROL_MAX => Ok(bytes),
        Ok(_) => Err(ControlError::TooLarge),
        Err(error) => Err(ControlError::Malformed(error.to_string())),
    }
}

/// A message from bytes; all of them have to belong to it.
///
/// # Errors
/// [`ControlError`]; never panics, and never allocates more than a few times what came, whatever the
/// bytes.
pub fn decode<M: for<'de> Deserialize<'de>>(bytes: &[u8]) -> Result<M, ControlError> {
    if bytes.len() > CONTROL_MAX {
        return Err(ControlError::TooLarge);
    }
    match bincode::serde::decode_from_slice(bytes, configuration()) {
        Ok((message, read)) if read == bytes.len() => Ok(message),
        Ok((_, read)) => Err(ControlError::Malformed(format!(
            "{} bytes follow its end",
            bytes.len() - read
        ))),
        Err(error) => Err(ControlError::Malformed(error.to_string())),
    }
}
