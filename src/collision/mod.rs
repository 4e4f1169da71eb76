//! Who can collide with whom, and how far apart two bodies are.

// A new kind of shape, core or joint is an error here, not another one's arm.
#![deny(clippy::wildcard_enum_match_arm)]

pub mod body;
mod carry;
pub mod chain;
mod count;
mod coverage;
mod error;
pub mod filter;
mod frames;
pub mod model;
pub mod neutral;
mod own;
pub mod pairs;
mod solids;
#[cfg(test)]
mod tests;

pub use body::{Body, BodyKind, reach_weights};
pub use count::Count;
pub use error::CollisionModelError;
pub use filter::Filter;
pub use frames::{check_frames, shared_names};
pub use model::CollisionModel;
pub use neutral::neutral_warnings;
pub use own::OwnBodies;
pub use pairs::BodyPair;
pub use solids::Solids;
