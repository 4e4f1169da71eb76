//! The method: from a proved path to ever shorter proved paths. Start reading in [`gradient`].

pub mod active_set;
mod answer;
pub mod best;
mod candidate;
mod canonical;
pub mod contact;
#[cfg(test)]
mod contracts;
pub mod cost;
mod factor;
pub mod gradient;
mod gram;
pub mod half_space;
mod holds;
pub mod hybrid;
mod input;
pub mod limits;
pub mod mode;
mod nearest;
pub mod outcome;
pub mod progress;
#[cfg(test)]
mod properties;
pub mod quadratic_step;
mod question;
mod refused;
pub mod request;
mod request_error;
mod restorer;
pub mod rows;
#[cfg(test)]
mod scenarios;
pub mod settings;
pub mod shortcut;
mod steps;
pub mod task;
#[cfg(test)]
mod testing;
mod unroll;

pub use input::lower_bound;
pub use mode::Mode;
pub use outcome::{
    ColumnTurns, KeptConstraint, NearestHolds, Outcome, PathHold, Refusal, RefusalPlace, Stage,
    StageShare, Termination,
};
pub use request::{Workspace, run};
pub use request_error::{LIMIT_TOLERANCE, QUATERNION_TOLERANCE, RequestError};
pub use settings::Settings;
pub use task::{Improvement, Task};
