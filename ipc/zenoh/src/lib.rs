//! The same service across machines through Zenoh.
