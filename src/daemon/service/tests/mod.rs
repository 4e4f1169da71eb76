//! The service by itself, in a time that the tests make: no thread, no port, no clock.

mod changes;
mod crowd;
mod ending;
mod frames;
mod given;
mod requests;
mod warmth;
mod watches;
mod world;
