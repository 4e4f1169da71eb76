//! The same service across machines through Zenoh.

pub mod call;
