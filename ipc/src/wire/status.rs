//! What the daemon publishes for people and tools.

use crate::limits::{STATUS_ROBOTS, STATUS_SCENES};
use bytemuck::{Pod, Zeroable};
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

/// A loaded robot.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "iceoryx2", derive(ZeroCopySend))]
pub struct RobotEntry {
    /// Id of its label.
    pub id: u64,
    /// Hash of its content.
    pub hash: u64,
}

/// A loaded scene.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "iceoryx2", derive(ZeroCopySend))]
pub struct SceneEntry {
    /// Id of its label.
    pub id: u64,
    /// Hash of its content.
    pub hash: u64,
    /// Its newest version.
    pub version: u64,
}

wire_type! {
    /// State of the daemon, published twice a second on `taut/v1/status`.
    StatusRecord, size 1184 {
        0 wire_version: u32, "1";
        4 header_len: u32, "size of this record";
        8 boot_id: u64, "changes with every start of the daemon";
        16 heartbeat: u64, "counts the status messages since the start";
        24 uptime_ns: u64, "time since the start";
        32 workers: u32, "worker threads";
        36 running: u32, "requests being worked on";
        40 queued: u32, "requests that wait";
        44 clients: u32, "connected clients";
        48 robots: u32, "robots loaded; the first 16 are listed";
        52 scenes: u32, "scenes loaded; the first 32 are listed";
        56 received: u64, "requests received";
        64 answered: u64, "requests answered with SUCCESS";
        72 refused: u64, "requests answered with another code";
        80 overloaded: u64, "of those, OVERLOADED or QUOTA";
        88 cancelled: u64, "requests whose client cancelled or vanished";
        96 timed_out: u64, "requests answered with TIMED_OUT";
        104 panics: u64, "worker panics";
        112 cleaned_nodes: u64, "dead clients cleaned up";
        120 queue_p50_ns: u64, "median time in the queue, last window";
        128 queue_p99_ns: u64, "99th percentile of it";
        136 compute_p50_ns: u64, "median computing time, last window";
        144 compute_p99_ns: u64, "99th percentile of it";
        152 reserved: u64, "0";
        160 robot: [RobotEntry; STATUS_ROBOTS], "id and hash of each robot listed";
        416 scene: [SceneEntry; STATUS_SCENES], "id, hash and version of each scene listed";
    }
}

wire_type! {
    /// A change of a scene, published on `taut/v1/scene-events`.
    SceneEvent, size 64 {
        0 wire_version: u32, "1";
        4 kind: u32, "see scene event kinds";
        8 boot_id: u64, "of the daemon";
        16 scene_id: u64, "id of the scene's label";
        24 scene_hash: u64, "hash of its new content";
        32 scene_version: u64, "its new version";
        40 subscription: u64, "request id of the watch whose path became unsafe, else 0";
        48 segment: u32, "first segment of that path that is no longer proved";
        52 reserved: u32, "0";
        56 parent_hash: u64, "hash of the content that was changed, 0 = there was none, or nothing changed";
    }
}
