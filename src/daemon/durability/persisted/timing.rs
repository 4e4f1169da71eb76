//! What a request asked of times.

use serde::{Deserialize, Serialize};
use taut::timing::{ColumnLimits, Controller, Fixed, Limits, Range, Settings};
use taut::translate::Timing;

/// What a request asked of times.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct TimingRecord {
    /// Of each column the least and greatest velocity, the least and greatest acceleration.
    limits: Vec<[f64; 4]>,
    strict: bool,
    seed: u64,
    most_work: u64,
    start_velocity: Option<Vec<f64>>,
    controller: ControllerRecord,
    clearance_m: f64,
    ignores_scaling: bool,
}

/// New ones stand last: files name one by its number.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum ControllerRecord {
    Cubic,
    Quintic,
    Linear(f64),
}

impl From<&Timing> for TimingRecord {
    fn from(timing: &Timing) -> Self {
        // Named one by one, so that nothing that settings gain is forgotten.
        let Timing {
            settings,
            clearance_m,
            ignores_scaling,
        } = timing.clone();
        let Settings {
            limits,
            strict,
            seed,
            most_work,
            start_velocity,
            // Made of the path that it follows.
            fixed_waypoints: _,
            controller,
        } = settings;
        Self {
            limits: limits.columns().iter().map(of_column).collect(),
            strict,
            seed,
            most_work,
            start_velocity,
            controller: controller.into(),
            clearance_m,
            ignores_scaling,
        }
    }
}

impl From<TimingRecord> for Timing {
    fn from(record: TimingRecord) -> Self {
        let limits = record.limits.iter().map(column).collect();
        Self {
            settings: Settings {
                limits: Limits::new(limits),
                strict: record.strict,
                seed: record.seed,
                most_work: record.most_work,
                start_velocity: record.start_velocity,
                fixed_waypoints: Fixed::Ends,
                controller: record.controller.into(),
            },
            clearance_m: record.clearance_m,
            ignores_scaling: record.ignores_scaling,
        }
    }
}

fn of_column(own: &ColumnLimits) -> [f64; 4] {
    let ColumnLimits {
        velocity,
        acceleration,
    } = own;
    [
        velocity.least,
        velocity.most,
        acceleration.least,
        acceleration.most,
    ]
}

fn column(record: &[f64; 4]) -> ColumnLimits {
    let [least_velocity, velocity, least_acceleration, acceleration] = *record;
    ColumnLimits {
        velocity: Range {
            least: least_velocity,
            most: velocity,
        },
        acceleration: Range {
            least: least_acceleration,
            most: acceleration,
        },
    }
}

impl From<Controller> for ControllerRecord {
    fn from(controller: Controller) -> Self {
        match controller {
            Controller::Cubic => Self::Cubic,
            Controller::Quintic => Self::Quintic,
            Controller::Linear { rate_hz } => Self::Linear(rate_hz),
        }
    }
}

impl From<ControllerRecord> for Controller {
    fn from(record: ControllerRecord) -> Self {
        match record {
            ControllerRecord::Cubic => Self::Cubic,
            ControllerRecord::Quintic => Self::Quintic,
            ControllerRecord::Linear(rate_hz) => Self::Linear { rate_hz },
        }
    }
}
