//! Who can collide with whom, and how far apart two bodies are.

pub mod body;
mod carry;
pub mod contact;
mod coverage;
pub mod distance;
pub mod filter;
mod frames;
mod inside;
pub mod model;
pub mod neutral;
pub mod pairs;
pub mod penetration;
pub mod piece;
pub mod query;
pub mod shell;
pub mod solid;
pub mod solids;
#[cfg(test)]
mod tests;
pub mod tree;

pub use body::{Body, BodyKind, reach_weights};
pub use contact::Contact;
pub use filter::Filter;
pub use frames::{check_frames, shared_names};
pub use model::{CollisionModel, CollisionModelError};
pub use neutral::neutral_warnings;
pub use pairs::BodyPair;
pub use solid::Solid;
