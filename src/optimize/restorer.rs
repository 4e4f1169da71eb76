//! From the optimizers' form of a path back to the caller's.

use super::input::Input;
use super::unroll::whole_turns_on;
use crate::path::Path;

/// Gives waypoints that must stay as they were the caller's bits back: the optimizers' form of a
/// row may differ by the norm of a quaternion. Angles keep the numbers that were proved, which may
/// be whole turns away.
pub(super) struct Restorer<'a> {
    given: &'a Path,
    input: &'a Input,
    /// The fixed waypoints of the optimizers' form, in order.
    fixed: Vec<usize>,
    circles: Vec<usize>,
}

impl<'a> Restorer<'a> {
    pub fn new(given: &'a Path, input: &'a Input) -> Self {
        let count = input.fixed.len();
        Self {
            given,
            input,
            fixed: (0..count)
                .filter(|&index| input.fixed[index])
                .collect(),
            circles: input.space.circles().collect(),
        }
    }

    /// Gives a path the caller's rows.
    pub fn restore(&self, path: &mut Path) {
        let mut fixed = self.fixed.iter().peekable();
        for index in 0..path.len() {
            let row = path.waypoint_mut(index);
            // The last row is the last fixed one even where an earlier row equals it.
            if let Some(&place) = fixed.next_if(|&&place| self.is_same_place(row, place)) {
                self.restore_row(row, place);
            }
        }
    }

    fn restore_row(&self, row: &mut [f64], place: usize) {
        let given = self.given.waypoint(self.input.origins[place]);
        for (q, number) in row.iter_mut().enumerate() {
            if !self.circles.contains(&q) {
                *number = given[q];
            }
        }
    }

    /// Whether a path's row is this fixed one, but for whole turns of the caller's angles.
    fn is_same_place(&self, at: &[f64], place: usize) -> bool {
        let row = self.input.path.waypoint(place);
        let original = self.given.waypoint(self.input.origins[place]);
        let is_same = |q: usize| match self.circles.contains(&q) {
            true => at[q] == whole_turns_on(original[q], at[q]),
            false => at[q] == row[q],
        };
        (0..at.len()).all(is_same)
    }
}
