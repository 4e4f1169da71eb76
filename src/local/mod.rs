//! Answers requests in this process as the daemon does, bit for bit: for programs that have no
//! daemon.
//!
//! ```
//! use taut::local::LocalService;
//! use taut_ipc::planner::Planner;
//!
//! let planner = Planner::in_process(LocalService::default());
//! assert!(planner.list().unwrap().robots.is_empty());
//! ```

mod models;
mod service;

pub use service::LocalService;
