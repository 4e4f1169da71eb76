//! How much of its tolerance each constraint provably leaves on a segment.

use super::Constrained;
use super::search::Search;
use crate::constraint::Held;

/// Places of a segment that are looked at before anything is claimed.
const LOOKS: u32 = 16;
/// Part of what is seen that is claimed, at first.
const CLAIMED: f64 = 0.95;
/// Claims that are tried.
const CLAIMS: u32 = 6;

impl Constrained<'_> {
    /// What is left of each tolerance, as it is asked for, everywhere on a proved segment: negative
    /// where it is raised and that is needed.
    pub(in crate::validation) fn claims(&mut self, ends: [&[f64]; 2]) -> Vec<f64> {
        (0..self.allowed.len())
            .map(|index| self.claim(index, ends))
            .collect()
    }

    fn claim(&mut self, index: usize, ends: [&[f64]; 2]) -> f64 {
        let held = self.constraints[index].held.clone();
        let tolerance = held.tolerance().min(f64::MAX);
        let seen = self.least_seen(&held, ends);
        let proved = -self.raises[index];
        let mut claim = seen - (1.0 - CLAIMED) * seen.abs().max(1e-3 * tolerance.min(1.0));
        for _ in 0..CLAIMS {
            if claim <= proved {
                break;
            }
            let narrowed = held.widened(-claim);
            if narrowed.is_convex() && self.keeps(index, narrowed, ends) {
                return claim;
            }
            claim -= 0.05 * tolerance.min(1.0);
        }
        proved
    }

    /// Least that is seen to be left at some places of a segment.
    fn least_seen(&mut self, held: &Held, ends: [&[f64]; 2]) -> f64 {
        self.standing.set_out(ends);
        let mut least = f64::INFINITY;
        for look in 0..=LOOKS {
            let t = f64::from(look) / f64::from(LOOKS);
            self.standing.stand(ends[0], t);
            let at = held.watched.at(&self.standing.seen());
            least = least.min(held.left(at));
        }
        least
    }

    /// Whether a segment is proved to keep this in the place of one constraint.
    fn keeps(&mut self, index: usize, held: Held, ends: [&[f64]; 2]) -> bool {
        let allowed = std::mem::replace(&mut self.allowed[index], held);
        let keeps = self
            .violation(ends.into(), Search::Any)
            .is_none();
        self.allowed[index] = allowed;
        keeps
    }
}
