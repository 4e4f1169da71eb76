//! What a record of the journal holds.

use serde::{Deserialize, Serialize};

use crate::daemon::durability::persisted::{Moves, RobotRecord, SceneRecord};

/// One record of the journal. Later records of a label replace earlier ones.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Record {
    /// What a robot's label names.
    Robot {
        label: String,
        hash: u64,
        weights: Vec<f64>,
        configured: bool,
        robot: RobotRecord,
    },
    /// What a scene's label names.
    Scene {
        label: String,
        version: u64,
        hash: u64,
        configured: bool,
        scene: SceneRecord,
    },
    /// What a scene's label names, as what moved since its record before.
    Moved {
        label: String,
        version: u64,
        hash: u64,
        moves: Moves,
    },
    /// A robot's label names nothing any more.
    RobotGone { label: String },
    /// A scene's label names nothing any more.
    SceneGone { label: String },
    /// The daemon ended in order.
    Ended,
}
