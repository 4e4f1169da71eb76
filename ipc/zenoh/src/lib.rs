//! The same service across machines through Zenoh.
//!
//! A gateway beside each daemon, a local instance on each planner's machine, and a transport for
//! programs that want neither. Everything of the network is Zenoh's; the rules that make one answer
//! of what it may lose, double or delay are in [`call`].

pub mod call;
pub mod caller;
pub mod doctor;
pub mod live;
pub mod message;
pub mod names;
pub mod network;
pub mod transport;

#[cfg(feature = "local")]
pub mod attach;
#[cfg(feature = "local")]
pub mod ros;
#[cfg(feature = "local")]
pub mod serve;
#[cfg(feature = "local")]
pub mod stop;

pub use network::Network;
pub use transport::Zenoh;
