//! The daemon: `taut serve`. Start reading in [`service`], which decides; the [`shell`] around it
//! has the threads, the ports and the clock.

pub mod config;
mod durability;
mod error;
mod observe;
mod service;
mod shell;
pub mod state;
mod threads;

pub use durability::journal::inspect;
pub use error::DaemonError;
pub use observe::live;
pub use observe::recording;
pub use shell::start::serve;
pub use shell::supervise;
pub use taut::translate;
