//! What the parent tells its client processes, a line of JSON each, and what they answer.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use taut::optimize;
use taut_ipc::wire::{Mode, NO_GROUP, RequestHeader};

use super::tally::Tally;

/// One kind of request: a path, and the robot and scene it is for.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Job {
    /// Problem that it comes from.
    pub name: String,
    /// Ids and hashes of the request's header.
    pub robot_id: u64,
    /// Content of the robot.
    pub robot_hash: u64,
    /// Its layout.
    pub layout_hash: u64,
    /// Id of the scene's label.
    pub scene_id: u64,
    /// Content of the scene; the daemon may answer for no other.
    pub scene_hash: u64,
    /// Columns of the path.
    pub variables: u32,
    /// The path, row by row.
    pub path: Vec<f64>,
    /// Weights of the metric; empty = the daemon's.
    pub weights: Vec<f64>,
}

impl Job {
    /// Waypoints of its path.
    pub(super) fn waypoints(&self) -> u32 {
        (self.path.len() / self.variables.max(1) as usize) as u32
    }

    /// The header of a request for it, without options.
    pub(super) fn header(&self) -> RequestHeader {
        RequestHeader {
            robot_id: self.robot_id,
            robot_hash: self.robot_hash,
            layout_hash: self.layout_hash,
            scene_id: self.scene_id,
            scene_hash: self.scene_hash,
            waypoints: self.waypoints(),
            variables: self.variables,
            group: NO_GROUP,
            ..RequestHeader::default()
        }
    }
}

/// When a client sends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Pace {
    /// The next request once the last is answered; hints when to try again are followed.
    Closed,
    /// As many in flight as the transport allows, hints ignored.
    Greedy,
    /// Poisson arrivals, whatever becomes of the earlier ones; latency counts from the arrival.
    Open {
        /// Arrivals per second of this client.
        rate_hz: f64,
    },
    /// Cancels each request after a random time below this, then has a small one answered.
    Cancel {
        /// Longest time until it cancels (ns).
        within_ns: u64,
    },
    /// No requests: sleeps to the same deadlines, as a control.
    Sleep,
}

/// What is sent in one stretch of time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Window {
    /// Seed of arrivals and choices; each client adds its number.
    pub seed: u64,
    /// When to begin, on the monotonic clock (ns).
    pub start_ns: u64,
    /// When to send nothing more (ns).
    pub end_ns: u64,
    /// Requests at most; 0 = any number.
    pub count: u64,
    /// When to send.
    pub pace: Pace,
    /// Wire number of the mode.
    pub mode: u32,
    /// Work budget; 0 = the default.
    pub budget: u64,
    /// Time until the deadline (ns); 0 = none.
    pub deadline_ns: u64,
    /// Flags of the request.
    pub flags: u32,
    /// Seed of every request; `None` = the number of its job, so that equal requests have equal
    /// answers.
    pub request_seed: Option<u64>,
    /// Go round all jobs in order instead of choosing at random.
    pub in_order: bool,
    /// What a client of the echo sends.
    pub exchange: Exchange,
}

/// A round trip to the echo.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Exchange {
    /// Bytes of the request.
    pub there: usize,
    /// Bytes of the answer.
    pub back: usize,
    /// How long the echo computes (ns): nothing, if it is bare.
    pub compute_ns: u64,
}

impl Window {
    /// A client that sends one request after another for no time at all: every other window is this
    /// with changes.
    pub(super) fn closed() -> Self {
        Self {
            seed: 0,
            start_ns: 0,
            end_ns: 0,
            count: 0,
            pace: Pace::Closed,
            mode: Mode::Hybrid.into(),
            budget: 0,
            deadline_ns: 0,
            flags: 0,
            request_seed: None,
            in_order: false,
            exchange: Exchange::default(),
        }
    }
}

/// Number of a mode on the wire.
pub(super) fn wire_mode(mode: optimize::Mode) -> u32 {
    mode as u32
}

/// Where a client waits to be killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Point {
    /// It has memory for a request and has not sent it.
    Loaned,
    /// It has sent and not looked for an answer.
    Sent,
    /// It holds an improvement while the request runs.
    Streaming,
    /// Anywhere in a loop of requests.
    Anywhere,
}

/// A line to a client process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Order {
    /// Connect, with these jobs and this number. Answered by [`Said::Ready`].
    Connect(Vec<Job>, u64),
    /// Connect to the echo of this instance instead of a daemon. Answered by [`Said::Ready`].
    Echo,
    /// Read these problem files and compute each once in this process. Answered by [`Said::Ready`].
    Compute(Vec<PathBuf>),
    /// Send. Answered by [`Said::Done`].
    Run(Window),
    /// Go to this point of a request for the first job, in this window's terms, and stay. Answered
    /// by [`Said::At`].
    StayAt(Point, Window),
}

/// Private memory of a process (bytes).
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Memory {
    /// With the jobs read and no connection.
    pub before: u64,
    /// After a connection and a few answers.
    pub after: u64,
}

impl Memory {
    /// What the connection added (bytes).
    pub(super) fn added(&self) -> u64 {
        self.after.saturating_sub(self.before)
    }
}

/// A line of a client process.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Said {
    /// Connected.
    Ready(Memory),
    /// What came of a window.
    Done(Box<Tally>),
    /// Stays there.
    At(Point),
    /// It cannot go on.
    Failed(String),
}
