//! What ROS 2 nodes say to each other over rmw_zenoh, without ROS: messages ([`messages`]), their bytes
//! ([`cdr`]), the hashes of their types ([`message_hash`], [`service_hash`]), and the keys, tokens and
//! attachments under which they travel.
//!
//! A message is a struct whose fields in their order are the interface; bytes, hash and `.msg` text come
//! from that one table.

pub mod cdr;
mod field;
mod hash;
pub mod keys;
mod message;
pub mod messages;

pub use field::{Bounded, Byte, Field, FieldType};
pub use hash::{message_hash, service_hash};
pub use message::{Message, Service, definition, definitions};

#[cfg(test)]
mod random;
#[cfg(test)]
mod tests;
