//! What a gateway is told at its start.

use taut_ipc::Instance;

/// What a gateway serves.
#[derive(Clone, Debug)]
pub struct Options {
    /// The daemon's name on the network.
    pub name: String,
    /// The daemon.
    pub instance: Instance,
    /// Daemons whose scenes are copied.
    pub follow: Vec<String>,
}
