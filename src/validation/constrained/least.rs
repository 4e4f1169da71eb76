//! Where on a segment least is left of each constraint, as far as looks at places of it tell.

use super::Constrained;

/// Looks for each tolerance that what is watched may go on a segment, ...
const LOOKS_A_TOLERANCE: f64 = 8.0;
/// ... but no fewer than this besides the first, ...
const FEWEST_LOOKS: f64 = 2.0;
/// ... and no more.
const MOST_LOOKS: f64 = 16.0;
/// A place is narrowed down to this part of a segment.
const FINEST: f64 = 1.0 / 16_384.0;

/// The least that was found to be left of a constraint's tolerance, as it is asked, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Least {
    pub(super) left: f64,
    /// Ratio on the segment.
    pub(super) t: f64,
    /// How far from there the next looks were; 0 once the place is narrowed down.
    beside: f64,
}

impl Least {
    /// Takes a look in, where less is left there.
    fn take(&mut self, t: f64, left: f64) {
        if left < self.left {
            self.left = left;
            self.t = t;
        }
    }
}

impl Constrained<'_> {
    /// The least of every constraint that looks along a segment show, both ends among them.
    pub(super) fn seen_along(&mut self, ends: [&[f64]; 2]) -> Vec<Least> {
        self.set_out(ends);
        let looks = self.looks_along();
        let none = Least {
            left: f64::INFINITY,
            t: 0.0,
            beside: 1.0 / looks,
        };
        let mut least = vec![none; self.constraints.len()];
        for look in 0..=looks as u32 {
            let t = f64::from(look) / looks;
            self.standing.stand(ends[0], t);
            for (index, least) in least.iter_mut().enumerate() {
                least.take(t, self.left_here(index));
            }
        }
        least
    }

    /// How many looks there are along the segment that was set out on: what goes far may turn back.
    fn looks_along(&self) -> f64 {
        let constraints = self.constraints.iter().zip(&self.bounds);
        let wanted = constraints
            .map(|(constraint, bounds)| bounds.speed(0) / constraint.held.tolerance())
            .fold(0.0, f64::max);
        (LOOKS_A_TOLERANCE * wanted)
            .ceil()
            .clamp(FEWEST_LOOKS, MOST_LOOKS)
    }

    /// What is left of a constraint where the robot stands.
    fn left_here(&self, index: usize) -> f64 {
        let held = &self.constraints[index].held;
        held.left(held.watched.at(&self.standing.seen()))
    }

    /// The same place, narrowed down between the looks beside it.
    pub(super) fn narrowed_down(
        &mut self,
        index: usize,
        ends: [&[f64]; 2],
        mut least: Least,
    ) -> Least {
        self.standing.set_out(ends);
        let mut beside = std::mem::take(&mut least.beside);
        while beside > FINEST {
            beside *= 0.5;
            for t in [least.t - beside, least.t + beside] {
                if (0.0..=1.0).contains(&t) {
                    self.standing.stand(ends[0], t);
                    least.take(t, self.left_here(index));
                }
            }
        }
        least
    }
}
