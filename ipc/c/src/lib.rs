//! taut for C and C++: `include/taut.h` is made of this crate, `include/taut.hpp` wraps it.
//!
//! Handles are numbers in a pointer's clothes, looked up in a table and never followed: a null,
//! freed or wrong one gives a code. What cannot be checked are the strings, arrays and places for
//! results that a caller points to.

pub mod answer;
pub mod answers;
mod borrow;
pub mod code;
pub mod daemon;
pub mod error;
pub mod frame;
mod handle;
pub mod options;
#[rustfmt::skip] // As it is made.
pub mod options_table;
pub mod robot;
pub mod scene;
mod trajectory;
mod values;
