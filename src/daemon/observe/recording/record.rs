//! What a recorded run holds.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::daemon::durability::persisted::{
    CloudRecord, MeshRecord, PoseRecord, RobotRecord, SceneRecord, SettingsRecord, TimingRecord,
    WayRecord,
};

/// One record of a run, in the order in which things happened. What a record names stands before
/// it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum RunRecord {
    /// Who wrote it: facts by name.
    Written(BTreeMap<String, String>),
    /// A mesh, which shapes name by its hash.
    Mesh { hash: u64, mesh: MeshRecord },
    /// A robot, which requests name by its hash.
    Robot { hash: u64, robot: RobotRecord },
    /// A scene, which requests name by its hash.
    Scene { hash: u64, scene: SceneRecord },
    /// A scene that is another one but for where these objects are.
    Moved {
        hash: u64,
        base: u64,
        moved: Vec<(String, PoseRecord)>,
    },
    /// A request that was let in.
    Request(Box<RequestRecord>),
    /// Its answer.
    Answer(Box<AnswerRecord>),
    /// It was dropped by its client before it had one.
    Abandoned { number: u64 },
    /// What the daemon tells of it.
    Story(String),
    /// The recording ended in order; so many requests had to be left out.
    Ended { missed: u64 },
    /// A cloud, which shapes name by its hash.
    Cloud { hash: u64, cloud: CloudRecord },
}

/// A request as a worker gets it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct RequestRecord {
    /// Its number in the daemon.
    pub number: u64,
    /// Its client's id of it.
    pub request_id: u64,
    /// Its client.
    pub client: u128,
    /// When it came, and its deadline (0 = none), on the daemon's clock.
    pub received_ns: u64,
    pub deadline_ns: u64,
    pub priority: u32,
    pub robot_hash: u64,
    pub scene_hash: u64,
    pub scene_id: u64,
    pub scene_version: u64,
    pub settings: SettingsRecord,
    pub timing: Option<TimingRecord>,
    pub columns: usize,
    pub path: Vec<f64>,
}

/// An answer as its client got it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct AnswerRecord {
    pub number: u64,
    pub way: WayRecord,
    /// Header and sections, as on the wire.
    pub header: Vec<u8>,
    pub payload: Vec<u8>,
}
