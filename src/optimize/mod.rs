//! The method: from a proved path to ever shorter proved paths. Start reading in [`gradient`].

pub mod outcome;
pub mod settings;

pub use outcome::{LoweredFloor, Outcome, Refusal, Termination};
pub use settings::{Mode, Settings};
