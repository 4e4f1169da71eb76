//! ROS 2 nodes before a real daemon: what they ask, what they are refused, and whose scene it is.
#![allow(missing_docs)]

mod cell;
mod node;
mod plans;
mod scenes;
mod sdk;
mod venv;
#[path = "../world/mod.rs"]
mod world;
