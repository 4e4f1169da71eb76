//! Why an instance is not attached.

use crate::network::NetworkError;
use taut_ipc::server::ServerError;

/// Why an instance is not attached, or not any more.
#[derive(Debug, thiserror::Error)]
pub enum AttachError {
    /// The network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The local instance.
    #[error(transparent)]
    Server(#[from] ServerError),
    /// The system has no thread left.
    #[error("no thread: {0}")]
    Thread(#[from] std::io::Error),
    /// Its files were removed.
    #[error("{0} was removed: clients do not find this instance any more; start it again")]
    Removed(String),
}
