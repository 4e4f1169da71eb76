//! What is kept in files: the forms of robots, scenes, meshes and requests in the journal and in
//! recorded runs. They are apart from the model's types: a field that a model gains is not in a file
//! before someone puts it here, which changes the bytes and so raises [`JOURNAL`] or [`RUN`]. The
//! bytes are pinned by a test. Meshes and clouds stand apart, by hash.

// A new kind of shape, core or joint is an error here, not another one's arm.
#![deny(clippy::wildcard_enum_match_arm)]

mod apart;
mod cloud;
mod mesh;
mod moves;
mod plain;
mod request;
mod robot;
mod scene;
mod shape;
#[cfg(test)]
mod tests;
mod timing;

pub(crate) use apart::{Apart, Find};
pub(crate) use cloud::CloudRecord;
pub(crate) use mesh::MeshRecord;
pub(crate) use moves::{Moves, moves_between};
pub(crate) use plain::PoseRecord;
pub(crate) use request::{RUN, SettingsRecord, WayRecord};
pub(crate) use robot::RobotRecord;
pub(crate) use scene::SceneRecord;
pub(crate) use timing::TimingRecord;

use crate::daemon::durability::record_log::Format;

/// The journal's file. Since version 3 robots have motors.
pub(crate) const JOURNAL: Format = Format {
    what: "journal",
    name: "journal",
    version: 3,
};
