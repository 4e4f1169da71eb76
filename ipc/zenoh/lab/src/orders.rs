//! What the parent tells its client processes, a line of JSON each, and what they answer.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// A line to a client process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Order {
    /// Be a client of the bare echo at this endpoint. Answered by [`Said::Ready`].
    Bare(String),
    /// Be a planner of the instance in the environment. Answered by [`Said::Ready`].
    Planner,
    /// Be a planner without a helper process, of the gateway at this endpoint. Answered by
    /// [`Said::Ready`].
    Direct(String),
    /// Load the robot and the scene of this folder. Answered by [`Said::Ready`].
    Load(PathBuf),
    /// Ask. Answered by [`Said::Done`].
    Ask(Asking),
    /// Ask, and hold the stream of answers. Answered by [`Said::At`] once the first is there.
    Hold(Box<Job>),
    /// Drop the stream that is held. Answered by [`Said::At`].
    Cancel,
    /// Send mutated messages. Answered by [`Said::Done`].
    Mutate(Mutating),
    /// Ask the echo for so many answers. Answered by [`Said::Done`].
    Exchange(Exchange),
}

/// Messages to a gateway that are nearly right.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Mutating {
    /// Its endpoint.
    pub connect: String,
    /// Its daemon's name.
    pub daemon: String,
    /// Id of a robot of two variables.
    pub robot_id: u64,
    /// Hash of its variables.
    pub layout_hash: u64,
    /// Id of a scene.
    pub scene_id: u64,
    /// How many.
    pub count: u64,
    /// Which.
    pub seed: u64,
}

/// Round trips to the bare echo.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Exchange {
    /// Bytes of a request.
    pub there: usize,
    /// Bytes of its answer.
    pub back: usize,
    /// How many.
    pub count: u64,
}

/// One request after another, until all are sent or the time is over, whichever is first.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Asking {
    /// What is asked for, in turn.
    pub jobs: Vec<Job>,
    /// At most so many; 0 = any number.
    pub count: u64,
    /// For so long (ms); 0 = any time.
    pub length_ms: u64,
    /// Each one's deadline (ms); 0 = none.
    pub deadline_ms: u64,
    /// When a request without an end counts as lost (ms).
    pub patience_ms: u64,
}

/// A kind of request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Job {
    /// Its name.
    pub name: String,
    /// Label of the robot.
    pub robot: String,
    /// Label of the scene.
    pub scene: Option<String>,
    /// The path, row by row.
    pub path: Vec<f64>,
    /// Name of the mode; empty = the default.
    pub mode: String,
    /// Work budget; 0 = the default.
    pub budget: u64,
    /// Seed.
    pub seed: u64,
}

/// A line of a client process.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Said {
    /// It can ask.
    Ready,
    /// Done, and when it began to (ns, monotonic clock).
    At(u64),
    /// What came of an order.
    Done(Box<Tally>),
    /// It cannot go on.
    Failed(String),
}

/// What came of requests.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tally {
    /// Requests.
    pub sent: u64,
    /// How they ended: by code, and in words where there was no answer.
    pub ends: BTreeMap<String, u64>,
    /// Requests without an end.
    pub endless: u64,
    /// Answers that were not the last.
    pub improvements: u64,
    /// From sending to the end (s).
    pub times: Vec<f64>,
    /// When those that took more than a second were sent (s, from the order), and how long.
    pub slow: Vec<(f64, f64)>,
    /// The same without waiting and computing (s).
    pub shares: Vec<f64>,
    /// From sending to the first improvement (s).
    pub first: Vec<f64>,
    /// Version and hash of each scene that an answer names.
    pub scenes: BTreeSet<(u64, u64)>,
    /// Bytes of the largest answer.
    pub bytes: usize,
    /// Hashes of the answers to each job.
    pub answers: BTreeMap<String, BTreeSet<u64>>,
}

impl Tally {
    /// Those that ended so.
    pub(crate) fn ended(&self, code: &str) -> u64 {
        self.ends.get(code).copied().unwrap_or(0)
    }

    /// Those that have a proved answer.
    pub(crate) fn served(&self) -> u64 {
        self.ended("Success")
    }

    /// Adds another client's.
    pub(crate) fn merge(&mut self, other: Self) {
        self.sent += other.sent;
        self.endless += other.endless;
        self.improvements += other.improvements;
        self.bytes = self.bytes.max(other.bytes);
        for (end, count) in other.ends {
            *self.ends.entry(end).or_default() += count;
        }
        self.times.extend(other.times);
        self.slow.extend(other.slow);
        self.shares.extend(other.shares);
        self.first.extend(other.first);
        self.scenes.extend(other.scenes);
        for (job, answers) in other.answers {
            self.answers
                .entry(job)
                .or_default()
                .extend(answers);
        }
    }

    /// All clients' as one.
    pub(crate) fn of(tallies: Vec<Self>) -> Self {
        let mut all = Self::default();
        tallies
            .into_iter()
            .for_each(|tally| all.merge(tally));
        all
    }

    /// How they ended, for people.
    pub(crate) fn told(&self) -> String {
        let ends = self
            .ends
            .iter()
            .map(|(end, count)| format!("{count} {end}"));
        ends.collect::<Vec<_>>().join(", ")
    }
}
