//! A planner's requests by name: robots, scenes, columns, joints and groups as people call them.
//!
//! ```no_run
//! # use std::time::Duration;
//! # use taut_ipc::{Instance, planner::{Planner, Request}};
//! # fn main() -> Result<(), taut_ipc::planner::PlannerError> {
//! let planner = Planner::connect(&Instance::from_environment()?)?;
//! let request = Request { deadline: Some(Duration::from_millis(20)), ..Request::new("panda", Some("kitchen")) };
//! let path = [[0.0, -1.0, 0.0, -2.0, 0.0, 1.0, 0.0], [0.5, -1.0, 0.0, -2.0, 0.0, 1.0, 0.0]];
//! let mut answers = planner.ask(&request, path.as_flattened())?;
//! while let Some(best) = answers.next(Duration::from_secs(1))? {
//!     println!("{} {:?}", best.header().length_after, best.path());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Nothing here knows more of a robot than its description says; what a request means the daemon
//! decides.

mod answers;
mod best;
pub mod carrier;
mod columns;
mod connection;
#[cfg(feature = "iceoryx2")]
mod daemon;
mod error;
#[cfg(feature = "iceoryx2")]
mod frames;
mod here;
mod kept;
mod link;
mod models;
pub mod options;
mod outlive;
mod prepared;
mod request;
mod service;
#[cfg(test)]
mod tests;
mod trajectory;
pub mod words;

pub use answers::Answers;
pub use best::{Best, Corridor, Warning};
pub use carrier::{Carrier, Ending};
pub use columns::{Columns, held_at_zero};
pub use connection::Planner;
pub use error::{Place, PlannerError, Refused};
pub use kept::Kept;
pub use models::EMPTY_SCENE;
pub use options::Request;
pub use service::{Service, Tell};
pub use trajectory::{Lowered, Nearest, Trajectory, Used};
