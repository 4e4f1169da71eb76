//! Requests of clients to gateways, by the rules of [`crate::call`].

mod bringing;
mod control;
mod models;
mod running;
mod seen;
mod shared;

pub use running::{Running, Sink};
pub use seen::Seen;
pub use shared::{Caller, Client};
