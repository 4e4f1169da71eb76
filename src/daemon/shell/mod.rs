//! Threads, ports and the clock around the [`service`](super::service). Start reading in
//! [`crew`], whose threads take turns at the port and compute.

mod cleaning;
mod crew;
mod drive;
mod framer;
mod heal;
mod lines;
mod loader;
mod port;
mod preparer;
mod pulse;
mod rests;
pub(crate) mod start;
pub mod supervise;
mod warm_up;
mod web;
mod worker;
