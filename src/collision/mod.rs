//! Who can collide with whom, and how far apart two bodies are.

pub mod body;
pub mod contact;
pub mod distance;
pub mod filter;
pub mod model;
pub mod neutral;
pub mod piece;
pub mod query;
pub mod tree;

pub use body::{Body, reach_weights};
pub use contact::Contact;
pub use filter::Filter;
pub use model::{BodyPair, CollisionModel, CollisionModelError};
pub use neutral::neutral_warnings;
