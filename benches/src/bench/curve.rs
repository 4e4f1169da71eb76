//! Remaining length over time of one run.

use serde::Serialize;

/// Lengths that differ by this part are the same but for rounding.
const ROUNDING: f64 = 1e-9;

/// The lengths of a run as steps (time in s, length): the input at 0, then each improvement when it
/// came.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub(super) struct Curve(Vec<(f64, f64)>);

impl Curve {
    /// A run that has nothing yet but its input.
    pub(super) fn new(length: f64) -> Self {
        // Room for what most runs publish, so that a run measured is not one that allocates.
        let mut steps = Vec::with_capacity(1024);
        steps.push((0.0, length));
        Self(steps)
    }

    /// Takes an improvement.
    pub(super) fn push(&mut self, time_s: f64, length: f64) {
        self.0.push((time_s, length));
    }

    /// Ends with the answer. An optimizer adds lengths up in its own order, so its last figure may
    /// differ in the last digits; an answer that was never published is one more step.
    pub(super) fn close(&mut self, before: f64, answer: f64, time_s: f64) {
        self.0[0].1 = before;
        let is_known = (self.end() - answer).abs() <= ROUNDING * before;
        match self.0.last_mut() {
            Some(last) if is_known => last.1 = answer,
            _ => self.push(time_s, answer),
        }
    }

    /// The same steps at other times.
    pub(super) fn at_times(&self, time_s: impl Fn(usize) -> f64) -> Self {
        Self(
            self.0
                .iter()
                .enumerate()
                .map(|(step, &(_, length))| (time_s(step), length))
                .collect(),
        )
    }

    /// Time of a step (s).
    pub(super) fn time_s(&self, step: usize) -> f64 {
        self.0[step].0
    }

    /// Steps after the input.
    pub(super) fn improvements(&self) -> usize {
        self.0.len() - 1
    }

    /// When the first improvement came (s).
    pub(super) fn first_s(&self) -> Option<f64> {
        self.0.get(1).map(|step| step.0)
    }

    /// Length of the input.
    fn start(&self) -> f64 {
        self.0[0].1
    }

    /// Length of the answer.
    fn end(&self) -> f64 {
        self.0[self.0.len() - 1].1
    }

    /// What remains of the input's length at a time; all of it where nothing came yet.
    pub(super) fn remaining(&self, time_s: f64) -> f64 {
        let came = self.0.partition_point(|step| step.0 <= time_s);
        ratio(self.0[came.max(1) - 1].1, self.start())
    }

    /// What remains at the end.
    pub(super) fn remaining_at_end(&self) -> f64 {
        ratio(self.end(), self.start())
    }
}

/// A length as a part of another; a path without length stays whole.
pub(super) fn ratio(length: f64, before: f64) -> f64 {
    if before > 0.0 { length / before } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Curve {
        let mut curve = Curve::new(4.0);
        curve.push(0.1, 3.0);
        curve.push(0.3, 2.0);
        curve
    }

    #[test]
    fn a_step_holds_from_its_time_until_the_next() {
        let curve = curve();
        for (time_s, remaining) in [
            (0.0, 1.0),
            (0.09, 1.0),
            (0.1, 0.75),
            (0.29, 0.75),
            (0.3, 0.5),
            (1e9, 0.5),
        ] {
            assert_eq!(curve.remaining(time_s), remaining, "at {time_s} s");
        }
        assert_eq!((curve.first_s(), curve.improvements()), (Some(0.1), 2));
        assert_eq!(Curve::new(4.0).first_s(), None);
    }

    #[test]
    fn it_ends_with_the_answer_whether_that_was_published_or_not() {
        let mut known = curve();
        known.close(4.0, 2.0 + 1e-15, 0.5);
        assert_eq!((known.improvements(), known.end()), (2, 2.0 + 1e-15));
        let mut unpublished = curve();
        unpublished.close(4.0, 1.0, 0.5);
        assert_eq!(
            (unpublished.remaining(0.4), unpublished.remaining_at_end()),
            (0.5, 0.25)
        );
    }

    #[test]
    fn a_path_without_length_stays_whole() {
        let mut curve = Curve::new(0.0);
        curve.close(0.0, 0.0, 0.1);
        assert_eq!((curve.remaining(1.0), curve.improvements()), (1.0, 0));
    }
}
