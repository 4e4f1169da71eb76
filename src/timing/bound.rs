//! The least time that the motors need, whatever stands around: no trajectory within the limits from a
//! state to rest somewhere else takes less.

use super::limits::Limits;
use super::ramp::Ends;

/// The least time, and whose motor needs it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// Of the column that needs most (s).
    pub time_s: f64,
    /// That column; the first where none needs any.
    pub column: usize,
}

impl Bound {
    /// From one place to another, with these velocities at the start and none at the end.
    pub fn between([from, to]: [&[f64]; 2], velocities: &[f64], limits: &Limits) -> Self {
        let columns = 0..from.len();
        let of_column = |column: usize| {
            let ends = Ends {
                way: to[column] - from[column],
                velocities: [velocities[column], 0.0],
            };
            let limits = &limits.columns()[column];
            let time_s = if ends.are_still() {
                0.0
            } else {
                ends.least_s(limits)
            };
            Self { time_s, column }
        };
        columns
            .map(of_column)
            .fold(Self::default(), |most, own| {
                if own.time_s > most.time_s { own } else { most }
            })
    }
}
