//! The shell around the core: `taut serve`. Start reading in [`event_loop`].
//!
//! One thread owns every port and the store; it never computes and never waits for a client.
//! Workers run the core, loaders read files, a journal writes what has to last; all hand back
//! [`event::Event`]s.

mod admission;
mod clients;
pub mod config;
mod content;
mod control;
mod event;
mod event_loop;
mod frames;
mod job;
mod journal;
mod keep;
pub mod live;
mod loader;
mod mailbox;
mod metrics;
mod poison;
mod prepared;
mod preparer;
mod pulse;
pub mod recording;
mod requests;
mod restore;
mod scenes;
mod schedule;
mod scrape;
mod start;
pub mod state;
mod story;
pub mod supervise;
mod watch;
mod web;
mod worker;

pub use journal::inspect;
pub use start::{DaemonError, serve};
pub use taut::translate;
pub use worker::{HANG_SEED, PANIC_SEED};
