//! Result codes: MoveIt's numbers where MoveIt has one, ours from -1001 down.

use super::WireError;

macro_rules! codes {
    ($( $name:ident = $number:literal, $text:literal, exit $exit:literal, $retry:literal, $meaning:literal; )*) => {
        /// How a request or control message ended.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(i32)]
        pub enum Code {
            $( #[doc = $meaning] $name = $number, )*
        }

        impl Code {
            /// Every code.
            pub const ALL: &'static [Code] = &[$( Code::$name, )*];

            /// The name that people and logs see, such as `TIMED_OUT`.
            pub const fn name(self) -> &'static str {
                match self { $( Code::$name => $text, )* }
            }

            /// What it means, in one line.
            pub const fn meaning(self) -> &'static str {
                match self { $( Code::$name => $meaning, )* }
            }

            /// Exit code of the command line for it.
            pub const fn exit_code(self) -> u8 {
                match self { $( Code::$name => $exit, )* }
            }

            /// Whether the same request may succeed later; such answers carry `retry_after_ms`.
            pub const fn is_retryable(self) -> bool {
                match self { $( Code::$name => $retry, )* }
            }
        }

        impl TryFrom<i32> for Code {
            type Error = WireError;

            fn try_from(number: i32) -> Result<Self, WireError> {
                match number {
                    $( $number => Ok(Code::$name), )*
                    _ => Err(WireError::UnknownValue { field: "code", value: number.into() }),
                }
            }
        }
    };
}

codes! {
    Success = 1, "SUCCESS", exit 0, false, "proved, shorter or not";
    InvalidMotionPlan = -2, "INVALID_MOTION_PLAN", exit 1, false, "the input path collides, or is outside a path constraint, between its ends; never repaired";
    InvalidatedByEnvironmentChange = -3, "MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE", exit 1, false, "a watched path that was proved is no longer proved after a change of its scene";
    TimedOut = -6, "TIMED_OUT", exit 2, false, "the deadline passed before the input was proved";
    Preempted = -7, "PREEMPTED", exit 3, false, "cancelled by the client";
    StartStateInCollision = -10, "START_STATE_IN_COLLISION", exit 1, false, "the first waypoint collides";
    StartStateViolatesPathConstraints = -11, "START_STATE_VIOLATES_PATH_CONSTRAINTS", exit 1, false, "the first waypoint is outside a path constraint";
    GoalInCollision = -12, "GOAL_IN_COLLISION", exit 1, false, "the last waypoint collides";
    GoalViolatesPathConstraints = -13, "GOAL_VIOLATES_PATH_CONSTRAINTS", exit 1, false, "the last waypoint is outside a path constraint";
    InvalidGroupName = -15, "INVALID_GROUP_NAME", exit 65, false, "unknown group";
    InvalidRobotState = -17, "INVALID_ROBOT_STATE", exit 65, false, "NaN, wrong number of columns, not a unit quaternion, limits exceeded by more than 1e-4, or another variable layout";
    InvalidLinkName = -18, "INVALID_LINK_NAME", exit 65, false, "unknown link";
    InvalidObjectName = -19, "INVALID_OBJECT_NAME", exit 65, false, "unknown object";
    Crash = -29, "CRASH", exit 70, false, "the worker panicked on this request";
    Uncertified = -1001, "UNCERTIFIED", exit 2, false, "not provable, and nothing found colliding";
    Overloaded = -1002, "OVERLOADED", exit 4, true, "the queue is full";
    Quota = -1003, "QUOTA", exit 4, true, "this client has too many requests in flight";
    UnknownRobot = -1004, "UNKNOWN_ROBOT", exit 66, false, "no robot of that id, or its hash differs";
    UnknownScene = -1005, "UNKNOWN_SCENE", exit 66, false, "no scene of that id, or its hash differs";
    VersionConflict = -1006, "VERSION_CONFLICT", exit 66, false, "the scene has another version than the request asks for";
    ResourceExhausted = -1007, "RESOURCE_EXHAUSTED", exit 67, false, "too large, too many waypoints, or no memory or disk left";
    MalformedRequest = -1008, "MALFORMED_REQUEST", exit 65, false, "wire version, lengths, unknown mode or flag";
    DaemonLost = -1009, "DAEMON_LOST", exit 69, false, "no daemon, or it went away; resending is safe";
    Loading = -1010, "LOADING", exit 4, true, "the robot or scene is still being prepared";
    LabelTaken = -1011, "LABEL_TAKEN", exit 66, false, "the label names other content and replacing was not asked for";
    InvalidModel = -1012, "INVALID_MODEL", exit 65, false, "a robot or scene file is wrong; the message names file and line";
    InvalidConstraint = -1014, "INVALID_CONSTRAINT", exit 65, false, "a path constraint names what is not there, makes no sense or cannot be proved; the message says which and what to write";
    Untimed = -1015, "UNTIMED", exit 2, false, "the path is proved, but has no times: the request ended before a trajectory was proved, or none is; `times` and the message say which";
    InvalidTiming = -1016, "INVALID_TIMING", exit 65, false, "what is said of times makes no sense, or a joint that moves has no limit; the message says which and what to write";
    CloudTooOld = -1017, "CLOUD_TOO_OLD", exit 4, true, "what a sensor sees of the scene is older than the request allows";
    UnreadableFile = -1013, "UNREADABLE_FILE", exit 66, false, "a robot or scene file cannot be read";
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({})", self.name(), *self as i32)
    }
}

impl From<Code> for i32 {
    fn from(code: Code) -> i32 {
        code as i32
    }
}

impl WireError {
    /// The code that a refusal for this reason carries.
    pub fn code(&self) -> Code {
        match self {
            Self::PathSize { .. } | Self::PayloadSize { .. } | Self::SectionLimit { .. } => {
                Code::ResourceExhausted
            }
            _ => Code::MalformedRequest,
        }
    }
}
