//! Medians, means, and who wins.

use serde::Serialize;

/// Lengths that differ by less than this part of the other's are a tie.
pub(crate) const TIE: f64 = 1e-3;

/// The middle value, or the mean of the two middle ones.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        count if count % 2 == 1 => Some(values[middle]),
        _ => Some((values[middle - 1] + values[middle]) / 2.0),
    }
}

/// The mean.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0_u32, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / f64::from(count))
}

/// Median and mean of the same values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Average {
    /// The middle one.
    pub median: f64,
    /// The mean.
    pub mean: f64,
}

impl Average {
    /// `None` of nothing.
    pub(crate) fn of(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        Some(Self {
            median: median(values.clone())?,
            mean: mean(values)?,
        })
    }
}

/// The largest of several values, and the path that it belongs to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Worst {
    /// The value.
    pub value: f64,
    /// Set and name of the problem.
    pub problem: String,
}

impl Worst {
    /// `None` of nothing.
    pub(crate) fn of(values: impl Iterator<Item = (f64, String)>) -> Option<Self> {
        let worst = values.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self {
            value: worst.0,
            problem: worst.1,
        })
    }
}

/// How often ours is shorter, as long, or longer than another's, path by path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Tally {
    /// Ours is shorter.
    pub wins: usize,
    /// Neither is shorter by more than the tie.
    pub ties: usize,
    /// Ours is longer.
    pub losses: usize,
}

impl Tally {
    /// From ours ÷ theirs of each path.
    pub(crate) fn of(quotients: impl Iterator<Item = f64>) -> Self {
        let mut tally = Self::default();
        for quotient in quotients {
            match quotient {
                shorter if shorter < 1.0 - TIE => tally.wins += 1,
                longer if longer > 1.0 + TIE => tally.losses += 1,
                _ => tally.ties += 1,
            }
        }
        tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_count_is_the_mean_of_the_middle_two() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), Some(2.0));
        assert_eq!(median([4.0, 1.0, 2.0, 3.0].into_iter()), Some(2.5));
        assert_eq!(median(std::iter::empty()), None);
        assert_eq!(
            Average::of([1.0, 2.0, 6.0].into_iter()),
            Some(Average {
                median: 2.0,
                mean: 3.0
            })
        );
    }

    #[test]
    fn a_tie_is_within_a_thousandth() {
        let tally = Tally::of([0.5, 0.9989, 0.9991, 1.0, 1.0009, 1.0011].into_iter());
        assert_eq!(
            tally,
            Tally {
                wins: 2,
                ties: 3,
                losses: 1
            }
        );
    }

    #[test]
    fn the_worst_knows_its_path() {
        let values =
            [(1.0, "a"), (1.2, "b"), (0.9, "c")].map(|(value, name)| (value, name.to_owned()));
        assert_eq!(
            Worst::of(values.into_iter()),
            Some(Worst {
                value: 1.2,
                problem: "b".to_owned()
            })
        );
    }
}
