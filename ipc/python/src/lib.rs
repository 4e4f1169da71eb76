//! The Rust half of the Python package `taut`; what people import is `python/taut/__init__.py`.
//!
//! Everything here waits, copies and computes without the interpreter's lock, and looks for signals
//! while it waits.

mod about;
mod answers;
mod best;
mod connection;
mod errors;
mod feed;
mod frames;
mod guard;
mod ndarray;
mod options;
mod problem;
mod result;
mod trajectory;

use pyo3::prelude::*;

/// The Rust half of taut.
#[pymodule]
mod _taut {
    #[pymodule_export]
    use super::answers::Answers;
    #[pymodule_export]
    use super::best::Improvement;
    #[pymodule_export]
    use super::connection::{Connection, connect, local};
    #[pymodule_export]
    use super::feed::SceneFeed;
}
