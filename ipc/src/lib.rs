//! The wire between planners and the taut daemon: shared-memory types, a client and a server.
//!
//! This crate knows nothing of robots, scenes or paths beyond their bytes, so that a planner links
//! little. The daemon uses [`Server`], planners use [`Client`]; both find each other by an
//! [`Instance`].
//!
//! Without the feature `iceoryx2` it has the wire, its limits, and a planner over a [`planner::Service`]
//! or [`planner::Carrier`] of the program's own: what other transports need.

#[macro_use]
mod option_table;

#[cfg(feature = "iceoryx2")]
pub mod client;
mod client_error;
pub mod content;
pub mod control;
#[cfg(feature = "iceoryx2")]
mod in_place;
mod instance;
pub mod limits;
#[cfg(feature = "iceoryx2")]
mod lock;
#[cfg(feature = "iceoryx2")]
pub mod memory;
#[cfg(feature = "iceoryx2")]
pub mod own_daemon;
pub mod planner;
#[cfg(feature = "iceoryx2")]
pub mod server;
pub mod services;
mod time;
#[cfg(feature = "iceoryx2")]
mod transport;
pub mod wire;
#[cfg(feature = "iceoryx2")]
pub use client::{Client, Pending, Response};
pub use client_error::{ClientError, Loss};
pub use instance::{DEFAULT_NAME, INSTANCE_VARIABLE, Instance, InstanceError};
#[cfg(feature = "iceoryx2")]
pub use lock::{DaemonState, daemon_state};
#[cfg(feature = "iceoryx2")]
pub use server::Server;
pub use time::{deadline_after, monotonic_ns};
