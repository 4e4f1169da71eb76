//! From the optimizers' form of a path back to the caller's.

use std::f64::consts::TAU;

use super::input::Input;
use super::task::Improvement;
use crate::path::Path;
use crate::robot::configuration::turns_between;

/// Gives waypoints that must stay as they were the caller's bits back: the optimizers' form of a
/// row may differ by the norm of a quaternion. Angles keep the numbers that were proved, which may
/// be whole turns away.
pub(super) struct Restorer<'a> {
    given: &'a Path,
    input: &'a Input,
    /// The fixed waypoints of the optimizers' form, in order.
    fixed: Vec<usize>,
    circles: Vec<usize>,
    buffer: Path,
}

impl<'a> Restorer<'a> {
    pub fn new(given: &'a Path, input: &'a Input) -> Self {
        let count = input.fixed.len();
        Self {
            given,
            input,
            fixed: (0..count).filter(|&index| input.fixed[index]).collect(),
            circles: input.space.circles().collect(),
            buffer: input.path.clone(),
        }
    }

    /// The path with the caller's rows.
    pub fn into_restored(mut self, path: &Path) -> Path {
        self.restore(path);
        self.buffer
    }

    fn restore(&mut self, path: &Path) {
        self.buffer.clone_from(path);
        let mut fixed = self.fixed.iter();
        let mut next = fixed.next();
        for index in 0..path.len() {
            // The last row is the last fixed one even where an earlier row equals it.
            if let Some(&place) = next
                && self.is_same_place(path.waypoint(index), place)
            {
                let original = self.given.waypoint(self.input.origins[place]);
                let restored = self.buffer.waypoint_mut(index);
                restored.copy_from_slice(original);
                for &q in &self.circles {
                    restored[q] = path.waypoint(index)[q];
                }
                next = fixed.next();
            }
        }
    }

    /// Whether a path's row is this fixed one, but for whole turns of the caller's angles.
    fn is_same_place(&self, at: &[f64], place: usize) -> bool {
        let row = self.input.path.waypoint(place);
        let original = self.given.waypoint(self.input.origins[place]);
        let is_same = |q: usize| match self.circles.contains(&q) {
            true => at[q] == original[q] + turns_between(original[q], at[q]) as f64 * TAU,
            false => at[q] == row[q],
        };
        (0..at.len()).all(is_same)
    }

    pub fn publish(&mut self, improvement: &Improvement, publish: &mut dyn FnMut(Improvement)) {
        self.restore(improvement.path);
        publish(Improvement {
            path: &self.buffer,
            ..*improvement
        });
    }
}
