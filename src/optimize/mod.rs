//! The method: from a proved path to ever shorter proved paths. Start reading in [`gradient`].

mod candidate;
pub mod cost;
pub mod gradient;
mod input;
pub mod limits;
pub mod outcome;
#[cfg(test)]
mod properties;
pub mod quadratic_step;
pub mod request;
pub mod rows;
pub mod settings;
pub mod shortcut;
pub mod task;
#[cfg(test)]
mod testing;

pub use input::{LIMIT_TOLERANCE, QUATERNION_TOLERANCE, RequestError};
pub use outcome::{LoweredFloor, Outcome, Refusal, RefusalPlace, Termination};
pub use request::{Workspace, run};
pub use settings::{Mode, Settings};
pub use task::{Improvement, Task};
