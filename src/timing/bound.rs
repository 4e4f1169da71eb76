//! The least time that the motors need, whatever stands around: no trajectory from rest to rest within the
//! limits takes less.

use super::limits::Limits;
use super::ramp::Ends;

/// Of the column that needs most (s).
pub fn least_s(from: &[f64], to: &[f64], limits: &Limits) -> f64 {
    let columns = from.iter().zip(to).zip(limits.columns());
    columns
        .filter(|((from, to), _)| from != to)
        .map(|((from, to), limits)| {
            let ends = Ends {
                way: to - from,
                velocities: [0.0; 2],
            };
            ends.least_s(limits)
        })
        .fold(0.0, f64::max)
}
