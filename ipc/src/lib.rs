//! The wire between planners and the taut daemon: shared-memory types, a client and a server.
//!
//! This crate knows nothing of robots, scenes or paths beyond their bytes, so that a planner links
//! little. The daemon uses [`Server`], planners use [`Client`]; both find each other by an
//! [`Instance`].

#[macro_use]
mod option_table;

pub mod client;
pub mod control;
mod in_place;
mod instance;
pub mod limits;
mod lock;
pub mod memory;
pub mod own_daemon;
pub mod planner;
pub mod server;
pub mod services;
mod time;
mod transport;
pub mod wire;
pub use client::{Client, ClientError, Pending, Response};
pub use instance::{DEFAULT_NAME, INSTANCE_VARIABLE, Instance, InstanceError};
pub use lock::{DaemonState, daemon_state};
pub use server::Server;
pub use time::{deadline_after, monotonic_ns};
