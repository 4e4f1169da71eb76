//! What is nearest along the answer, in the caller's words: names instead of numbers, segments of
//! the caller's path.

use super::outcome::{KeptConstraint, NearestHolds, PathHold};
use super::question::Question;
use crate::validation::{Kept, Near, Nearest};

/// The caller's segment of each segment of the form that optimizers work on, given for each of the
/// caller's waypoints the one that stands for it: segments between equal waypoints are left out
/// there.
pub(super) fn segments_of(standing_for: &[usize]) -> Vec<usize> {
    (1..standing_for.len())
        .filter(|&next| standing_for[next] > standing_for[next - 1])
        .map(|next| next - 1)
        .collect()
}

/// Puts names to what was found. Segments that `segments` does not list are the caller's own.
pub(super) fn named(question: &Question, nearest: &Nearest, segments: &[usize]) -> NearestHolds {
    let placed = |near: &Near| placed(question, near, segments);
    NearestHolds {
        searched_m: nearest.searched_m,
        smallest: nearest.smallest.as_ref().map(placed),
        holds: nearest.holds.iter().map(placed).collect(),
    }
}

fn placed(question: &Question, near: &Near, segments: &[usize]) -> PathHold {
    PathHold {
        segment: segments
            .get(near.segment)
            .copied()
            .unwrap_or(near.segment),
        t: near.t,
        requirement: near
            .requirement
            .named(question.model, &question.input.constraints),
        amount: near.measure.amount,
        points: near.measure.points,
        normal: near.measure.normal,
    }
}

/// The same of what is left of constraints.
pub(super) fn keeps(question: &Question, kept: &Kept, segments: &[usize]) -> Vec<KeptConstraint> {
    let constraints = question.input.constraints.iter().enumerate();
    constraints
        .zip(&kept.tightest)
        .map(|((index, constraint), near)| KeptConstraint {
            tightest: placed(question, near, segments),
            left: least_of(kept, index),
            asked: constraint
                .held
                .reading(0.0)
                .map(|(_, asked)| asked),
        })
        .collect()
}

/// What is proved to be left of a constraint wherever the path is.
fn least_of(kept: &Kept, index: usize) -> f64 {
    let left = kept.left.iter().map(|left| left[index]);
    left.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_between_equal_waypoints_are_stepped_over() {
        // Waypoints 0 and 1 are equal, and so are 3, 4 and 5.
        assert_eq!(segments_of(&[0, 0, 1, 2, 2, 2, 3]), [1, 2, 5]);
        assert!(segments_of(&[0]).is_empty());
    }
}
