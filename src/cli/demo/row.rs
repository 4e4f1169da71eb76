//! What is known of one planner, and the messages that it comes from.

use serde::{Deserialize, Serialize};

/// A line that a planner process writes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub(super) enum Message {
    /// It has a path.
    Planned {
        /// Time of the search [s].
        time_s: f64,
        /// Waypoints.
        waypoints: usize,
        /// Rows end to end.
        rows: Vec<f64>,
    },
    /// The daemon sent a shorter path.
    Improved {
        /// Its length.
        length: f64,
    },
    /// The daemon is done.
    Answered {
        /// Name of the answer's code.
        code: String,
        /// What the daemon has to say.
        message: String,
        /// Whether the path is proved.
        proved: bool,
        /// Length of the planner's path.
        length_before: f64,
        /// Length of the answer.
        length_after: f64,
        /// Distance that is kept [m].
        clearance_m: Option<f64>,
        /// Time from the request to the answer [s].
        time_s: f64,
        /// Rows end to end.
        rows: Vec<f64>,
    },
    /// It gave up.
    Failed {
        /// Why.
        error: String,
    },
}

/// One planner.
#[derive(Debug, Default, Serialize)]
pub(super) struct Row {
    /// Its number, from 1.
    pub(super) planner: usize,
    /// What it plans for.
    pub(super) problem: String,
    /// Label of its robot.
    pub(super) robot: String,
    /// Its seed.
    pub(super) seed: u64,
    /// Waypoints of its path.
    pub(super) waypoints: Option<usize>,
    /// Time of its search [s].
    pub(super) planned_s: Option<f64>,
    /// Length of its path.
    pub(super) length_before: Option<f64>,
    /// Length of the daemon's.
    pub(super) length_after: Option<f64>,
    /// Whether that is proved.
    pub(super) proved: bool,
    /// Name of the answer's code.
    pub(super) code: String,
    /// What the daemon had to say.
    pub(super) message: String,
    /// Distance that is kept [m].
    pub(super) clearance_m: Option<f64>,
    /// Shorter paths that came before the last.
    pub(super) improvements: usize,
    /// Time from the request to the answer [s].
    pub(super) time_s: Option<f64>,
    /// Why there is no answer.
    pub(super) error: Option<String>,
    /// Rows of the planner's path.
    #[serde(skip)]
    pub(super) before: Vec<f64>,
    /// Rows of the daemon's path.
    #[serde(skip)]
    pub(super) after: Vec<f64>,
}

impl Row {
    /// Takes over what a message says.
    pub(super) fn take(&mut self, message: Message) {
        match message {
            Message::Planned {
                time_s,
                waypoints,
                rows,
            } => {
                self.planned_s = Some(time_s);
                self.waypoints = Some(waypoints);
                self.before = rows;
            }
            Message::Improved { .. } => self.improvements += 1,
            Message::Answered {
                code,
                message,
                proved,
                length_before,
                length_after,
                clearance_m,
                time_s,
                rows,
            } => {
                self.code = code;
                self.message = message;
                self.proved = proved;
                self.length_before = Some(length_before);
                self.length_after = Some(length_after);
                self.clearance_m = clearance_m;
                self.time_s = Some(time_s);
                self.after = rows;
            }
            Message::Failed { error } => self.error = Some(error),
        }
    }

    /// Nothing more will come.
    pub(super) fn end(&mut self) {
        if self.time_s.is_none() && self.error.is_none() {
            self.error = Some("the planner ended without an answer".to_owned());
        }
    }

    /// Why there is no answer, or what the daemon had to say.
    pub(super) fn reason(&self) -> &str {
        self.error.as_deref().unwrap_or(&self.message)
    }

    /// What is saved [%].
    pub(super) fn saved_percent(&self) -> Option<f64> {
        let before = self.length_before?;
        let after = self.length_after?;
        (before > 0.0).then(|| 100.0 * (1.0 - after / before))
    }
}
