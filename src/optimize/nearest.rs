//! What is nearest along the answer, in the caller's words: names instead of numbers, segments of
//! the caller's path.

use super::outcome::{NearestHolds, PathHold};
use super::question::Question;
use crate::validation::{Near, Nearest};

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
    let placed = |near: &Near| PathHold {
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
    };
    NearestHolds {
        searched_m: nearest.searched_m,
        smallest: nearest.smallest.as_ref().map(placed),
        holds: nearest.holds.iter().map(placed).collect(),
    }
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
