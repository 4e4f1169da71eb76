//! The least time that the motors need, whatever stands around: no trajectory within the limits from a
//! state to rest somewhere else takes less.

use super::limits::Limits;
use super::ramp::Ends;
use super::trajectory::State;

/// The least time, and whose motor needs it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// Of the column that needs most (s).
    pub time_s: f64,
    /// That column; the first where none needs any.
    pub column: usize,
}

impl Bound {
    /// From a state to rest at a goal.
    pub fn between(start: &State, goal: &[f64], limits: &Limits) -> Self {
        let columns = limits.columns().iter().enumerate();
        let bounds = columns.map(|(column, limits)| {
            let ends = Ends {
                way: goal[column] - start.positions[column],
                velocities: [start.velocities[column], 0.0],
            };
            Self {
                time_s: if ends.are_still() {
                    0.0
                } else {
                    ends.least_s(limits)
                },
                column,
            }
        });
        bounds.fold(Self::default(), Self::most)
    }

    fn most(self, other: Self) -> Self {
        if other.time_s > self.time_s {
            other
        } else {
            self
        }
    }
}
