//! The core of **taut**: pulls a planner's path taut and proves every answer collision-free.
//!
//! Pure: no clock, no thread, no disk, no log. Time comes in as a `stop` closure, files as bytes.

#[cfg(feature = "wire")]
pub mod answer;
pub mod collision;
pub mod constraint;
pub mod files;
pub(crate) mod hash;
pub mod lanes;
#[cfg(feature = "wire")]
pub mod local;
pub mod math;
pub mod optimize;
pub mod path;
pub mod robot;
pub mod scene;
pub mod shape;
pub mod solid;
pub mod store;
#[cfg(test)]
pub(crate) mod testing;
pub mod timing;
#[cfg(feature = "wire")]
pub mod translate;
pub mod validation;
pub mod warning;

/// The README's program compiles.
#[cfg(all(doctest, feature = "daemon"))]
#[doc = include_str!("../README.md")]
pub struct Readme;
