//! taut for C and C++: `include/taut.h` is made of this crate, `include/taut.hpp` wraps it.
//!
//! Handles are numbers in a pointer's clothes, looked up in a table and never followed: a null, freed or wrong one gives
//! a code. What cannot be checked are the strings, arrays and places for results that a caller points to.

mod answer;
mod answers;
mod borrow;
mod code;
mod daemon;
mod error;
mod handle;
mod options;
mod robot;
mod scene;
