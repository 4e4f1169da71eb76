//! What a request asked for, and how its answer came about.

use serde::{Deserialize, Serialize};
use taut::constraint::ConstraintsFile;
use taut::optimize::{Mode, Settings};
use taut::validation::Layers;

use crate::daemon::durability::record_log::Format;
use crate::daemon::service::event::Way;
use crate::daemon::service::job::{StopCause, Stopped, Stops};

/// A recorded run's file. In version 2 a run that was told to end says after how many questions
/// whether to; since version 3 the core asks at other places. Since version 4 answers speak of
/// requirements, since version 5 requests of constraints, since version 6 answers of what they keep of
/// them, since version 7 both of times, since version 8 answers of the age of the world.
pub(crate) const RUN: Format = Format {
    what: "run",
    name: "recorded run",
    version: 8,
};

/// The settings of a request.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SettingsRecord {
    mode: ModeRecord,
    seed: u64,
    clearance_m: f64,
    strict: bool,
    unwrapped: bool,
    keep_goal: bool,
    weights: Option<Vec<f64>>,
    work_budget: u64,
    fixed_waypoints: Option<Vec<bool>>,
    moving: Option<Vec<bool>>,
    held: Option<Vec<f64>>,
    contacts: bool,
    corridor: bool,
    layers: LayersRecord,
    constraints: ConstraintsRecord,
}

/// Constraints as their text; empty where there are none.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
struct ConstraintsRecord(ConstraintsFile);

/// A mode by the number that it has on the wire, which is its place in the table of modes.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
struct ModeRecord(Mode);

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct LayersRecord {
    filter: bool,
    along_normal: bool,
    reuse: bool,
    portable_lanes: bool,
}

impl From<&Settings> for SettingsRecord {
    fn from(settings: &Settings) -> Self {
        // Named one by one, so that nothing that settings gain is forgotten.
        let Settings {
            mode,
            seed,
            clearance_m,
            strict,
            unwrapped,
            keep_goal,
            weights,
            work_budget,
            fixed_waypoints,
            moving,
            held,
            contacts,
            corridor,
            constraints,
            layers,
        } = settings.clone();
        Self {
            mode: ModeRecord(mode),
            seed,
            clearance_m,
            strict,
            unwrapped,
            keep_goal,
            weights,
            work_budget,
            fixed_waypoints,
            moving,
            held,
            contacts,
            corridor,
            layers: layers.into(),
            constraints: ConstraintsRecord(constraints),
        }
    }
}

impl From<SettingsRecord> for Settings {
    fn from(record: SettingsRecord) -> Self {
        Self {
            mode: record.mode.0,
            seed: record.seed,
            clearance_m: record.clearance_m,
            strict: record.strict,
            unwrapped: record.unwrapped,
            keep_goal: record.keep_goal,
            weights: record.weights,
            work_budget: record.work_budget,
            fixed_waypoints: record.fixed_waypoints,
            moving: record.moving,
            held: record.held,
            contacts: record.contacts,
            corridor: record.corridor,
            layers: record.layers.into(),
            constraints: record.constraints.0,
        }
    }
}

impl From<ConstraintsRecord> for String {
    fn from(ConstraintsRecord(constraints): ConstraintsRecord) -> Self {
        match constraints.is_empty() {
            true => Self::new(),
            false => serde_json::to_string(&constraints).expect("numbers and names are written"),
        }
    }
}

impl TryFrom<String> for ConstraintsRecord {
    type Error = serde_json::Error;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        match text.is_empty() {
            true => Ok(Self(ConstraintsFile::default())),
            false => serde_json::from_str(&text).map(Self),
        }
    }
}

impl From<ModeRecord> for u32 {
    fn from(record: ModeRecord) -> Self {
        record.0 as Self
    }
}

impl TryFrom<u32> for ModeRecord {
    type Error = String;

    fn try_from(number: u32) -> Result<Self, String> {
        let known = Mode::ALL.get(number as usize);
        let last = Mode::ALL.len() - 1;
        known
            .map(|mode| Self(*mode))
            .ok_or_else(|| format!("mode {number}; modes are 0 to {last}"))
    }
}

impl From<Layers> for LayersRecord {
    fn from(layers: Layers) -> Self {
        let Layers {
            filter,
            along_normal,
            reuse,
            portable_lanes,
        } = layers;
        Self {
            filter,
            along_normal,
            reuse,
            portable_lanes,
        }
    }
}

impl From<LayersRecord> for Layers {
    fn from(record: LayersRecord) -> Self {
        Self {
            filter: record.filter,
            along_normal: record.along_normal,
            reuse: record.reuse,
            portable_lanes: record.portable_lanes,
        }
    }
}

/// How an answer came about.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) enum WayRecord {
    /// The core computed it, and was perhaps told to end: its path, and its times.
    Computed([Option<StoppedRecord>; 2]),
    /// It was never begun.
    Untouched,
}

/// How often the core had asked whether to end, and why it was to.
type StoppedRecord = (u64, CauseRecord);

/// Why the work on a request ended.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) enum CauseRecord {
    Deadline,
    Cancelled,
    FinishedEarly,
    Shutdown,
}

impl From<Way> for WayRecord {
    fn from(way: Way) -> Self {
        match way {
            Way::Computed(Stops { path, times }) => {
                let record = |Stopped { asked, cause }| (asked, cause.into());
                Self::Computed([path, times].map(|stopped| stopped.map(record)))
            }
            Way::Untouched => Self::Untouched,
        }
    }
}

impl From<WayRecord> for Way {
    fn from(record: WayRecord) -> Self {
        match record {
            WayRecord::Computed(records) => {
                let stopped = |(asked, cause): StoppedRecord| Stopped {
                    asked,
                    cause: cause.into(),
                };
                let [path, times] = records.map(|record| record.map(stopped));
                Self::Computed(Stops { path, times })
            }
            WayRecord::Untouched => Self::Untouched,
        }
    }
}

impl From<StopCause> for CauseRecord {
    fn from(cause: StopCause) -> Self {
        match cause {
            StopCause::Deadline => Self::Deadline,
            StopCause::Cancelled => Self::Cancelled,
            StopCause::FinishedEarly => Self::FinishedEarly,
            StopCause::Shutdown => Self::Shutdown,
        }
    }
}

impl From<CauseRecord> for StopCause {
    fn from(record: CauseRecord) -> Self {
        match record {
            CauseRecord::Deadline => Self::Deadline,
            CauseRecord::Cancelled => Self::Cancelled,
            CauseRecord::FinishedEarly => Self::FinishedEarly,
            CauseRecord::Shutdown => Self::Shutdown,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{hex, read};
    use super::*;

    /// Settings that name weights and fixed waypoints.
    const SETTINGS: &str =
        "0500fca9f1d24d62503f0000000101000000000000f03f00010101000001000101010000";
    /// An answer whose client went away when the core had asked three times.
    const WAY: &str = "0001030100";

    #[test]
    fn bytes_are_those_of_the_version() {
        let settings = Settings {
            weights: Some(vec![1.0]),
            fixed_waypoints: Some(vec![true]),
            ..Settings::default()
        };
        let way = Way::Computed(Stops {
            path: Some(Stopped {
                asked: 3,
                cause: StopCause::Cancelled,
            }),
            times: None,
        });
        let advice = "readers of this version's files would not understand these: raise it";
        assert_eq!(hex(&SettingsRecord::from(&settings)), SETTINGS, "{advice}");
        assert_eq!(hex(&WayRecord::from(way)), WAY, "{advice}");
        assert_eq!(Settings::from(read::<SettingsRecord>(SETTINGS)), settings);
        assert_eq!(Way::from(read::<WayRecord>(WAY)), way);
    }
}
