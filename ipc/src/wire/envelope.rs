//! What accompanies a message on a network.

use super::WireError;
use crate::limits::WIRE_VERSION;
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

wire_type! {
    /// Attachment of a message on a network, before the UTF-8 name of the client.
    Envelope, size 48 {
        0 wire_version: u32, "1";
        4 kind: u32, "see envelope kinds";
        8 client: u64, "the client, a random number";
        16 request: u64, "the request among the client's; resending the same is safe";
        24 attempt: u32, "how often it was sent before";
        28 reserved: u32, "0";
        32 seen_version: u64, "newest version of the request's scene that the client has seen, 0 = none";
        40 seen_hash: u64, "content of that version";
    }
}

impl Envelope {
    /// Checks the version.
    ///
    /// # Errors
    /// [`WireError::Version`].
    pub fn check(&self) -> Result<(), WireError> {
        match self.wire_version {
            WIRE_VERSION => Ok(()),
            other => Err(WireError::Version(other)),
        }
    }
}
