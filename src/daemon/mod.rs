//! The shell around the core: `taut serve`. Start reading in [`event_loop`].
//!
//! One thread owns every port and the store; it never computes and never waits for a client.
//! Workers run the core, loaders read files, a journal writes what has to last; all hand back
//! [`event::Event`]s.

mod admission;
mod cleaning;
mod clients;
pub mod config;
mod control;
mod error;
mod event;
mod event_loop;
mod heal;
mod job;
mod journal;
mod keep;
mod keeping;
pub mod live;
mod loader;
mod loading;
mod mailbox;
mod metrics;
mod open_request;
mod persisted;
mod poison;
mod prepared;
mod preparer;
mod pulse;
mod record_log;
pub mod recording;
mod requests;
mod restore;
mod scenes;
mod schedule;
mod scrape;
mod start;
pub mod state;
mod status;
mod status_clock;
mod story;
pub mod supervise;
mod threads;
mod watch;
mod web;
mod worker;

pub use error::DaemonError;
pub use journal::inspect;
pub use start::serve;
pub use taut::translate;
