//! Results of calls. MoveIt's numbers where MoveIt has one.

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::sync::OnceLock;
use taut_ipc::wire::Code;

/// `taut_next`: there are no more answers.
pub const TAUT_END: i32 = 0;
/// Done, or proved.
pub const TAUT_SUCCESS: i32 = 1;
/// `taut_next`: nothing came within the time; the request goes on.
pub const TAUT_PENDING: i32 = 2;
/// The path collides, or is outside a path constraint, between its ends.
pub const TAUT_INVALID_MOTION_PLAN: i32 = -2;
/// A watched path that was proved is no longer, after a change of its scene.
pub const TAUT_MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE: i32 = -3;
/// The deadline passed before the path was proved.
pub const TAUT_TIMED_OUT: i32 = -6;
/// Cancelled.
pub const TAUT_PREEMPTED: i32 = -7;
/// The first waypoint collides.
pub const TAUT_START_STATE_IN_COLLISION: i32 = -10;
/// The first waypoint is outside a path constraint.
pub const TAUT_START_STATE_VIOLATES_PATH_CONSTRAINTS: i32 = -11;
/// The last waypoint collides.
pub const TAUT_GOAL_IN_COLLISION: i32 = -12;
/// The last waypoint is outside a path constraint.
pub const TAUT_GOAL_VIOLATES_PATH_CONSTRAINTS: i32 = -13;
/// Unknown group.
pub const TAUT_INVALID_GROUP_NAME: i32 = -15;
/// NaN, wrong or missing columns, not a unit quaternion, outside the limits.
pub const TAUT_INVALID_ROBOT_STATE: i32 = -17;
/// Unknown link.
pub const TAUT_INVALID_LINK_NAME: i32 = -18;
/// Unknown object.
pub const TAUT_INVALID_OBJECT_NAME: i32 = -19;
/// Something panicked; the message says what.
pub const TAUT_CRASH: i32 = -29;
/// Not provable, and nothing found colliding.
pub const TAUT_UNCERTIFIED: i32 = -1001;
/// The daemon has too much to do; `taut_error_retry_after_ms` says when to try again.
pub const TAUT_OVERLOADED: i32 = -1002;
/// This client has too many requests in flight.
pub const TAUT_QUOTA: i32 = -1003;
/// No robot of that label.
pub const TAUT_UNKNOWN_ROBOT: i32 = -1004;
/// No scene of that label.
pub const TAUT_UNKNOWN_SCENE: i32 = -1005;
/// The scene has another version.
pub const TAUT_VERSION_CONFLICT: i32 = -1006;
/// Too large, or no memory or disk left.
pub const TAUT_RESOURCE_EXHAUSTED: i32 = -1007;
/// A call that is wrong in itself: a null or freed handle, a bad option.
pub const TAUT_MALFORMED_REQUEST: i32 = -1008;
/// No daemon, or it went away; sending again is safe.
pub const TAUT_DAEMON_LOST: i32 = -1009;
/// The robot or scene is still being prepared.
pub const TAUT_LOADING: i32 = -1010;
/// The label names other content and replacing was not asked for.
pub const TAUT_LABEL_TAKEN: i32 = -1011;
/// A robot or scene file is wrong; the message names file and line.
pub const TAUT_INVALID_MODEL: i32 = -1012;
/// A robot or scene file cannot be read.
pub const TAUT_UNREADABLE_FILE: i32 = -1013;
/// A path constraint names what is not there, makes no sense or cannot be proved.
pub const TAUT_INVALID_CONSTRAINT: i32 = -1014;
/// The path is proved, but has no times; the message says why.
pub const TAUT_UNTIMED: i32 = -1015;
/// What is said of times makes no sense, or a joint that moves has no limit.
pub const TAUT_INVALID_TIMING: i32 = -1016;
/// What a sensor sees of the scene is older than the request allows.
pub const TAUT_CLOUD_TOO_OLD: i32 = -1017;

/// The name of a code, such as "TIMED_OUT"; "UNKNOWN" for a number that is none. Valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn taut_code_name(code: i32) -> *const c_char {
    static NAMES: OnceLock<BTreeMap<i32, CString>> = OnceLock::new();
    let names = NAMES.get_or_init(|| {
        let own = [(TAUT_END, "END"), (TAUT_PENDING, "PENDING")];
        let all = Code::ALL
            .iter()
            .map(|code| (i32::from(*code), code.name()))
            .chain(own);
        all.map(|(code, name)| (code, CString::new(name).unwrap_or_default()))
            .collect()
    });
    const UNKNOWN: &CStr = c"UNKNOWN";
    names
        .get(&code)
        .map_or(UNKNOWN, CString::as_c_str)
        .as_ptr()
}
