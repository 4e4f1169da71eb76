//! Every limit of the service in one place, and how the limits depend on each other.

use std::time::Duration;

/// Version of the layouts in [`crate::wire`]; also part of the service names.
pub const WIRE_VERSION: u32 = 1;

/// Client processes (and gateway ports) that may be connected at once.
pub const MAX_CLIENTS: usize = 128;
/// Requests that one client may have in flight, watches of paths included.
pub const ACTIVE_REQUESTS_PER_CLIENT: usize = 4;
/// Control requests that one client may have in flight.
pub const CONTROL_REQUESTS_PER_CLIENT: usize = 1;
/// Responses that wait for a client that does not read; the oldest is dropped first.
pub const RESPONSE_BUFFER: usize = 8;
/// Responses of one request that a client may hold at once.
pub const BORROWED_RESPONSES: usize = 3;
/// Listeners of one client: one for each request in flight, of either kind.
pub const LISTENERS_PER_CLIENT: usize = ACTIVE_REQUESTS_PER_CLIENT + CONTROL_REQUESTS_PER_CLIENT;
/// Nodes beside the clients': the daemon's own, its janitor's and a restarting daemon's.
pub const DAEMON_NODES: usize = 4;
/// Nodes that may open one service.
pub const MAX_NODES: usize = MAX_CLIENTS + DAEMON_NODES;

/// Most bytes of one payload of a path, in either direction.
pub const MAX_PAYLOAD: usize = 16 * 1024 * 1024;
/// Most bytes of one encoded control request.
pub const CONTROL_MAX: usize = 16 * 1024 * 1024;
/// Most bytes of one encoded control reply.
pub const CONTROL_REPLY_MAX: usize = 4 * 1024 * 1024;
/// Most bytes of a piece in which a file is given.
pub const GIVE_MAX: usize = 1024 * 1024;
/// Most bytes of a file that is given.
pub const FILE_MAX: u64 = 256 * 1024 * 1024;
/// Most files of one robot, scene or diff that are given.
pub const FILES_MAX: usize = 4096;
/// Most bytes of the name of a file that is given.
pub const FILE_NAME_MAX: usize = 900;
/// Most entries of a list of names in a control message.
pub const LIST_MAX: usize = 65_536;
/// Alignment of payloads and of every section inside them, in bytes.
pub const PAYLOAD_ALIGN: usize = 8;

/// Most waypoints of a path.
pub const MAX_WAYPOINTS: usize = 131_072;
/// Most variables of a configuration.
pub const MAX_VARIABLES: usize = 256;
/// Most numbers of one path: waypoints times variables.
pub const MAX_PATH_NUMBERS: usize = 1 << 20;
/// Most records of one response section (lowered and pinched pairs, contacts).
pub const MAX_RECORDS: usize = 4096;
/// Most stages that a response lists.
pub const MAX_STAGES: usize = 16;
/// Most warnings that a response lists.
pub const MAX_WARNINGS: usize = 256;
/// Most bytes of one text section.
pub const MAX_TEXT: usize = 64 * 1024;
/// Most claims of constraints of one response: of each segment one for each constraint.
pub const MAX_CLAIMS: usize = 1 << 19;
/// Most waypoints times constraints of a request: its answer may have more waypoints, and fits.
pub const MAX_CONSTRAINED: usize = MAX_CLAIMS / 2;
/// Most points of a trajectory.
pub const MAX_POINTS: usize = 1 << 17;
/// Most numbers of one kind of a trajectory: points times variables.
pub const MAX_TRAJECTORY_NUMBERS: usize = 1 << 18;
/// Most numbers of a path that gets times: its answer has room for them.
pub const MAX_TIMED_NUMBERS: usize = 1 << 17;
/// Most bytes that warnings have of the section `names`.
pub const MAX_WARNINGS_TEXT: usize = MAX_TEXT / 2;

/// Robots that one status message lists.
pub const STATUS_ROBOTS: usize = 16;
/// Scenes that one status message lists.
pub const STATUS_SCENES: usize = 32;
/// Scene events that wait for a subscriber that does not read.
pub const SCENE_EVENT_BUFFER: usize = 64;

/// Bytes a socket's path may have (`sun_path` without the closing zero).
pub const SOCKET_PATH_MAX: usize = 107;
/// Shared memory that must stay free, in bytes; of a small one at most an eighth.
pub const SHM_RESERVE: u64 = 64 * 1024 * 1024;
/// Bytes a process may send before it looks again how much shared memory is free.
pub const SHM_ALLOWANCE: u64 = 16 * 1024 * 1024;

/// How often a waiting client looks whether the daemon still lives.
pub const PROBE_INTERVAL: Duration = Duration::from_millis(100);
/// How long a client that leaves waits for a daemon that has not received yet what it sent.
pub const LEAVE: Duration = Duration::from_millis(300);
/// How often the janitor looks whether clients came, and for the death of those it cannot watch.
pub const JANITOR_INTERVAL: Duration = Duration::from_millis(250);
/// How soon the janitor tries again what failed, at first.
pub const JANITOR_RETRY: Duration = Duration::from_millis(10);
/// How often the janitor looks at every node, whatever it saw.
pub const JANITOR_FULL_PASS: Duration = Duration::from_secs(120);
/// Age from which an unfinished file counts as left over by a dead process.
pub const UNFINISHED_FILE_AGE: Duration = Duration::from_secs(2);
/// How long a starting daemon tries to get the instance's lock: clients probe it for microseconds.
pub const LOCK_PATIENCE: Duration = Duration::from_millis(100);

/// Bytes of every response section besides the path, at its limit.
const RESPONSE_EXTRAS: usize = MAX_WAYPOINTS * 16
    + MAX_RECORDS * 312
    + MAX_CLAIMS * 8
    + MAX_STAGES * 32
    + MAX_WARNINGS * 16
    + 3 * MAX_TEXT
    + 1024;

const _: () = assert!(
    MAX_PATH_NUMBERS * 8 < MAX_PAYLOAD,
    "a full path fits a payload"
);
const _: () = assert!(
    MAX_PATH_NUMBERS * 8
        + 3 * MAX_VARIABLES * 8
        + MAX_WAYPOINTS
        + MAX_VARIABLES
        + 2 * MAX_TEXT
        + 64
        <= MAX_PAYLOAD,
    "a full path with all optional sections fits a request"
);
const _: () = assert!(
    MAX_PATH_NUMBERS * 8 + RESPONSE_EXTRAS <= MAX_PAYLOAD,
    "a full path with all its records fits a response"
);
/// Bytes of a trajectory, at its limit.
const TRAJECTORY: usize = MAX_POINTS * 8
    + 3 * MAX_TRAJECTORY_NUMBERS * 8
    + 8 * MAX_VARIABLES * 8
    + MAX_RECORDS * 32
    + 256;
const _: () = assert!(
    MAX_TIMED_NUMBERS * 8 + RESPONSE_EXTRAS + TRAJECTORY <= MAX_PAYLOAD,
    "a path that gets times fits a response with them"
);
const _: () = assert!(MAX_WAYPOINTS * MAX_VARIABLES >= MAX_PATH_NUMBERS);
const _: () = assert!(
    MAX_PAYLOAD <= u32::MAX as usize,
    "section offsets are 32 bits wide"
);
const _: () = assert!(CONTROL_REPLY_MAX <= CONTROL_MAX);
const _: () = assert!(GIVE_MAX + 1024 <= CONTROL_MAX, "a piece fits a message");
const _: () = assert!(
    FILES_MAX * (FILE_NAME_MAX + 16) <= CONTROL_REPLY_MAX,
    "the names of all files that are wanted fit a reply"
);
const _: () = assert!(
    BORROWED_RESPONSES >= 3,
    "an iterating client holds one response while it takes the next, and may copy that one out"
);
const _: () = assert!(SHM_RESERVE >= 4 * SHM_ALLOWANCE && SHM_ALLOWANCE >= MAX_PAYLOAD as u64);

/// Widest corridor that an answer tells of, in metres.
pub const WIDEST_CORRIDOR_M: f64 = 0.1;
/// Part of a segment's clearance that pays for rounding and is no part of its corridor, in metres.
pub const CORRIDOR_ROUNDING_M: f64 = 1e-9;
