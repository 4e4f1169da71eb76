//! Control messages: what changes the daemon's store, or asks about it.
//!
//! They travel as bincode 2.0.1 in its standard configuration, at most
//! [`crate::limits::CONTROL_MAX`] bytes.

mod at_once;
mod bytes;
mod few;
mod frame;

pub use bytes::{ControlError, decode, encode};
pub use frame::{CloudFrame, FrameSummary, PointField, PointLayout};

use crate::wire::Code;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What a client asks for. Labels are free text; their ids are [`crate::wire::label_id`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ControlRequest {
    /// Load a robot under a label.
    LoadRobot {
        /// The label.
        label: String,
        /// Where its files are and how to read them.
        source: RobotSource,
        /// Take the label away from other content.
        replace: bool,
        /// Its files, where they are given; else they are on the daemon's machine.
        files: Option<Files>,
    },
    /// Load a scene under a label.
    LoadScene {
        /// The label.
        label: String,
        /// The scene file's text (JSON).
        json: String,
        /// Folder that relative mesh paths of the scene start from; absolute.
        base_dir: Option<PathBuf>,
        /// Take the label away from other content.
        replace: bool,
        /// Its mesh files, where they are given; else they are on the daemon's machine.
        files: Option<Files>,
        /// The version that it is to have, of a scene whose versions are counted elsewhere: above
        /// the newest, or that one with equal content. `None` = the next.
        version: Option<u64>,
    },
    /// Change a scene: its next version. A diff against another version than `base_version` is
    /// refused.
    DiffScene {
        /// The label.
        label: String,
        /// The diff's text (JSON, `is_diff` set).
        json: String,
        /// Folder that relative mesh paths of the diff start from; absolute.
        base_dir: Option<PathBuf>,
        /// Version the diff is made against; 0 = the newest.
        base_version: u64,
        /// The diff's mesh files, where they are given; else they are on the daemon's machine.
        files: Option<Files>,
        /// As of a scene that is loaded.
        version: Option<u64>,
    },
    /// A piece of a file, for a robot or scene that names it: appended where there is everything
    /// before it. The reply is [`ControlReply::Given`].
    Give {
        /// The file.
        file: FileId,
        /// Where the piece begins.
        offset: u64,
        /// The piece, at most [`crate::limits::GIVE_MAX`] bytes.
        #[serde(with = "at_once")]
        bytes: Vec<u8>,
    },
    /// Forget a robot; running requests keep it until they end.
    UnloadRobot {
        /// The label.
        label: String,
    },
    /// Forget a scene with all its versions; running requests keep theirs until they end. Refused
    /// while a version is pinned.
    UnloadScene {
        /// The label.
        label: String,
    },
    /// Keep a scene version from being dropped and its scene from being unloaded, or let it go.
    PinScene {
        /// The label.
        label: String,
        /// The version.
        version: u64,
        /// Pin or unpin.
        pinned: bool,
    },
    /// Variable names, groups and hashes of a robot.
    Describe {
        /// The robot's label.
        label: String,
    },
    /// Names and versions of what is loaded.
    List,
    /// Counters and times.
    Stats,
    /// What each client has and got.
    Clients,
    /// What happened to requests.
    Stories {
        /// Id of a request in hexadecimal digits, or how it starts or ends; empty = the newest
        /// requests.
        id: String,
    },
    /// Stop the daemon after the running requests.
    Shutdown,
    /// The text of a scene version that is kept, or the diff that leads to it.
    ShowScene {
        /// The label.
        label: String,
        /// The version; 0 = the newest.
        version: u64,
        /// Version that a diff starts from; 0 = the whole scene.
        base_version: u64,
    },
    /// Record the requests that come, with their robots, scenes and answers, to a file of the
    /// daemon's machine; or, where it does so already, tell how that goes. A recording that nobody
    /// asks about for 5 s ends.
    Record {
        /// The file; absolute.
        file: PathBuf,
    },
    /// End the recording.
    EndRecording,
    /// Write what is remembered of a request to a file of the daemon's machine, to be computed
    /// again elsewhere.
    Bundle {
        /// Id of the request in hexadecimal digits, or how it starts or ends.
        id: String,
        /// The file; absolute.
        file: PathBuf,
    },
    /// How the requests of this connection are called where people read of them: for one that speaks
    /// for somebody else. A daemon that was started again has to be told again.
    Introduce {
        /// 1 to 128 bytes without control characters, such as `host/program[pid]`.
        name: String,
    },
    /// Load the robot of a label again, with these variables only and under a label of its own,
    /// which the reply names; its other joints are held.
    SelectVariables {
        /// The robot's label.
        label: String,
        /// Variables of a configuration, in order.
        #[serde(deserialize_with = "few::list")]
        variables: Vec<String>,
    },
    /// A frame of a sensor, whose points are the message's body: the shape of a sensed object from
    /// now on, in the scene's next version. The reply is [`ControlReply::Framed`]; a frame that is
    /// older than another that came meanwhile is refused with PREEMPTED.
    Frame {
        /// The scene's label.
        label: String,
        /// The object, which is sensed.
        object: String,
        /// What it is besides its points.
        frame: Box<CloudFrame>,
    },
}

/// The `robot` part of a problem file; paths are absolute.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotSource {
    /// The URDF file.
    pub urdf: PathBuf,
    /// The SRDF file.
    pub srdf: Option<PathBuf>,
    /// Folder of each package named in `package://` addresses.
    #[serde(deserialize_with = "few::map")]
    pub packages: BTreeMap<String, PathBuf>,
    /// Joint between the world and the robot's root; `None` = the SRDF's, or fixed where it has
    /// none.
    pub virtual_joint: Option<VirtualJoint>,
    /// Variables of a configuration, in order; empty = every movable joint that is not a mimic.
    #[serde(deserialize_with = "few::list")]
    pub variables: Vec<String>,
    /// Pairs of links that may touch.
    #[serde(deserialize_with = "few::list")]
    pub allowed_collisions: Vec<(String, String)>,
    /// URDF whose collision geometry is spheres, for a faster check.
    pub spherized_urdf: Option<PathBuf>,
    /// Pairs of links that may touch with the spheres.
    #[serde(deserialize_with = "few::list")]
    pub spherized_allowed_collisions: Vec<(String, String)>,
}

/// A joint between the world and the robot's root link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VirtualJoint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub kind: VirtualJointKind,
    /// The frame it hangs from.
    pub parent_frame: String,
    /// Lowest and highest position of each translation, in metres; empty = unbounded.
    pub position_bounds: Vec<(f64, f64)>,
}

/// How a virtual joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum VirtualJointKind {
    /// x, y and an angle.
    Planar,
    /// Position and unit quaternion.
    Floating,
    /// Not at all; without a name it is no joint, whatever the SRDF says.
    Fixed,
}

/// What the daemon answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ControlReply {
    /// Done; nothing to report.
    Done,
    /// A robot is loaded.
    Robot(Box<RobotDescription>),
    /// A scene is loaded or changed.
    Scene(SceneSummary),
    /// What is loaded.
    Listing(Listing),
    /// Counters and times.
    Stats(Stats),
    /// Clients, those first that had most computing time.
    Clients(Vec<ClientSummary>),
    /// Requests, the newest first.
    Stories(Vec<Story>),
    /// Nothing was changed, unless the message says that the change was made and could not be kept
    /// (a full disk).
    Refused(Refusal),
    /// The text of a scene or diff.
    SceneText(SceneText),
    /// How a recording goes, or what a bundle holds.
    Recording(RecordingState),
    /// Nothing was changed: these names are not among the files of the message, or the daemon does
    /// not have their content.
    Wanted(Vec<String>),
    /// A frame is taken in.
    Framed(Box<FrameSummary>),
    /// How much of a file is there.
    Given {
        /// Bytes from its beginning; the next piece begins there.
        bytes: u64,
    },
}

/// Files by the names that a robot or scene has for them; a robot's URDF and SRDF by the paths in
/// its [`RobotSource`].
pub type Files = BTreeMap<String, FileId>;

/// A file by its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FileId {
    /// SHA-256 of its bytes.
    pub sha256: [u8; 32],
    /// How many these are.
    pub bytes: u64,
}

impl std::fmt::Display for FileId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for byte in &self.sha256[..8] {
            write!(f, "{byte:02x}")?;
        }
        write!(f, "… of {} bytes", self.bytes)
    }
}

/// A recorded run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordingState {
    /// The file.
    pub file: PathBuf,
    /// Requests so far.
    pub requests: u64,
    /// Answers so far.
    pub answers: u64,
    /// Requests and answers that were left out because the disk was too slow.
    pub missed: u64,
    /// Bytes of the file.
    pub bytes: u64,
}

/// Why a control request was refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// Number of a [`Code`].
    pub code: i32,
    /// One line: the bad value, the valid ones, the next step.
    pub message: String,
    /// When to try again, in milliseconds; 0 = never.
    pub retry_after_ms: u32,
}

impl Refusal {
    /// A refusal that is not worth retrying.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code: code.into(),
            message: message.into(),
            retry_after_ms: 0,
        }
    }
}

/// What a client has to know of a robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotDescription {
    /// The label.
    pub label: String,
    /// Its id.
    pub robot_id: u64,
    /// Hash of its content.
    pub robot_hash: u64,
    /// Hash of the variable layout; requests carry it.
    pub layout_hash: u64,
    /// Variables of a configuration, in order.
    pub variables: Vec<VariableDescription>,
    /// Variables of the held joints, in order.
    pub held_variables: Vec<String>,
    /// Where they are where a request does not say (m or rad).
    pub held_values: Vec<f64>,
    /// Joints that never move: files of paths have columns for them.
    pub fixed_joints: Vec<String>,
    /// Groups, in order; requests carry the index.
    pub groups: Vec<GroupDescription>,
    /// Variables of a configuration.
    pub nq: u32,
    /// Velocity coordinates.
    pub nv: u32,
    /// Default weights, one per velocity coordinate: metres moved per unit of joint motion.
    pub weights: Vec<f64>,
    /// What the loader wants people to know, one line each.
    pub warnings: Vec<String>,
}

/// One variable of a configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VariableDescription {
    /// Its name: a joint's, or `joint/x`, `joint/qw`, ... for joints of several variables.
    pub name: String,
    /// Lowest value within limits and soft limits, in radians or metres; negative infinity =
    /// unbounded.
    pub lower: f64,
    /// Highest value, in radians or metres; infinity = unbounded.
    pub upper: f64,
    /// An angle on the circle.
    pub continuous: bool,
    /// Its velocity coordinate; for a variable of a quaternion, the first of the three that it has
    /// altogether.
    pub coordinate: u32,
    /// Velocity coordinates: 1, or 3 for a variable of a quaternion.
    pub coordinates: u32,
}

/// One group of joints.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroupDescription {
    /// Its name.
    pub name: String,
    /// Indices of its variables.
    pub variables: Vec<u32>,
}

/// One scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneSummary {
    /// The label.
    pub label: String,
    /// Its id.
    pub scene_id: u64,
    /// Hash of its content.
    pub scene_hash: u64,
    /// Its newest version.
    pub version: u64,
    /// Objects in it.
    pub objects: u32,
    /// What the loader wants people to know, one line each.
    pub warnings: Vec<String>,
    /// Oldest version from which on all are kept.
    pub kept_from: u64,
    /// Pinned versions, in order.
    pub pinned: Vec<u64>,
    /// Its objects that sensors see.
    pub sensed: Vec<SensedSummary>,
}

/// An object that a sensor sees.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensedSummary {
    /// Its id.
    pub object: String,
    /// Its last frame; `None` before there is any: nothing is known of what is there.
    pub last: Option<LastFrame>,
}

/// The last frame of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LastFrame {
    /// How long ago it was taken (ns).
    pub age_ns: u64,
    /// How long after the one before (ns); 0 of the first.
    pub period_ns: u64,
    /// Points that came.
    pub came: u32,
    /// Points left out as the robot's or of what it carries.
    pub on_robot: u32,
    /// Of these, points that only the padding holds: the world may be there.
    pub in_padding: u32,
    /// Points of the shape.
    pub points: u32,
}

/// A scene version as text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneText {
    /// The label.
    pub label: String,
    /// The version.
    pub version: u64,
    /// Hash of its content.
    pub scene_hash: u64,
    /// Version that the text is a diff against; 0 = it is the whole scene.
    pub base_version: u64,
    /// The text (JSON), as loading a scene and changing one take it.
    pub json: String,
}

/// One robot in a listing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotSummary {
    /// The label.
    pub label: String,
    /// Its id.
    pub robot_id: u64,
    /// Hash of its content.
    pub robot_hash: u64,
    /// Variables of a configuration.
    pub nq: u32,
}

/// What is loaded.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Listing {
    /// The robots.
    pub robots: Vec<RobotSummary>,
    /// The scenes.
    pub scenes: Vec<SceneSummary>,
    /// How far each of them is made, and those whose files are still being read.
    pub models: Vec<ModelState>,
}

/// How far a robot or scene is made.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelState {
    /// The label.
    pub label: String,
    /// A robot's; else a scene's.
    pub is_robot: bool,
    /// What is still being made; empty = it is warm: no request waits for it.
    pub missing: String,
    /// Triangles of its meshes.
    pub triangles: u64,
    /// Memory in bytes of its meshes, of solids made of them, and, of a robot, of what was put
    /// together of it and scenes. What several share (equal meshes in two robots) counts in each.
    pub bytes: u64,
}

/// Counters and times by name, and the daemon's own data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stats {
    /// Changes with every start of the daemon.
    pub boot_id: u64,
    /// Process id of the daemon.
    pub pid: u32,
    /// Version of the daemon's program.
    pub daemon_version: String,
    /// Time since the start, in nanoseconds.
    pub uptime_ns: u64,
    /// Numbers by name, the unit last in the name.
    pub numbers: BTreeMap<String, f64>,
}

/// One client: a connection, of which a process may have several.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClientSummary {
    /// Its id, in hexadecimal digits.
    pub client_id: String,
    /// Its process; 0 = not known.
    pub pid: u32,
    /// How it calls itself; empty = it does not.
    pub name: String,
    /// Its requests in flight.
    pub in_flight: u32,
    /// As many as it may have.
    pub in_flight_quota: u32,
    /// Bytes of the paths of its requests in flight.
    pub bytes: u64,
    /// Its requests so far.
    pub received: u64,
    /// Of these, those answered with SUCCESS.
    pub served: u64,
    /// Those answered with another code, quotas included.
    pub refused: u64,
    /// Those refused because a quota was used up.
    pub over_quota: u64,
    /// Those that it cancelled, or left behind when it went.
    pub cancelled: u64,
    /// Answers in the last whole second.
    pub answered_per_second: u64,
    /// Time that was computed for it, in nanoseconds.
    pub computed_ns: u64,
    /// Median time from request to answer, of its last ones.
    pub latency_p50_ns: u64,
    /// 99th percentile of it.
    pub latency_p99_ns: u64,
}

/// What happened to one request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Story {
    /// The client's id of it.
    pub request_id: u64,
    /// The client's process; 0 = not known.
    pub pid: u32,
    /// How the client calls itself; empty = it does not.
    pub client: String,
    /// When it came, on the monotonic clock.
    pub received_ns: u64,
    /// Label of the robot, or its id where the label is not known.
    pub robot: String,
    /// Label of the scene, or its id where the label is not known.
    pub scene: String,
    /// Version of the scene it is computed with; 0 = it did not come to that.
    pub scene_version: u64,
    /// What was asked for.
    pub mode: String,
    /// Rows of its path.
    pub waypoints: u32,
    /// Columns of its path.
    pub variables: u32,
    /// Its priority.
    pub priority: u32,
    /// Time from its coming to its deadline, in nanoseconds; 0 = none.
    pub deadline_ns: u64,
    /// What happened, in order.
    pub events: Vec<StoryEvent>,
    /// Events that are not kept.
    pub left_out: u32,
    /// Number of the final response's code; 0 = it runs.
    pub code: i32,
}

/// Something that happened to a request.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoryEvent {
    /// How long after the request came, in nanoseconds.
    pub after_ns: u64,
    /// What.
    pub what: String,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::LIST_MAX;

    fn selected(names: usize) -> Vec<u8> {
        let message = ControlRequest::SelectVariables {
            label: "arm".to_owned(),
            variables: vec![String::new(); names],
        };
        encode(&message).unwrap()
    }

    #[test]
    fn a_list_of_ever_more_of_nothing_is_refused_before_it_is_made() {
        let most = decode::<ControlRequest>(&selected(LIST_MAX));
        assert!(most.is_ok());
        let error = decode::<ControlRequest>(&selected(LIST_MAX + 1)).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("a list of more than"),
            "{error}"
        );
    }

    #[test]
    fn a_robot_is_what_it_was() {
        let pair = ("a".to_owned(), "b".to_owned());
        let source = RobotSource {
            packages: [("arms".to_owned(), PathBuf::from("/opt/arms"))].into(),
            variables: vec!["x".to_owned(), "y".to_owned()],
            allowed_collisions: vec![pair.clone()],
            spherized_allowed_collisions: vec![pair],
            ..RobotSource::default()
        };
        let again: RobotSource = decode(&encode(&source).unwrap()).unwrap();
        assert_eq!(again, source);
    }
}
