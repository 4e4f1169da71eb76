//! What people and tools see of the daemon.

pub mod live;
pub(crate) mod metrics;
pub mod recording;
pub(crate) mod scrape;
pub(crate) mod story;
