//! How much of its tolerance each constraint provably leaves on a segment.

use super::Constrained;
use super::least::Least;
use super::search::Search;
use crate::constraint::Held;

/// What is claimed at first is below what is seen by this part of it, ...
const BELOW: f64 = 0.05;
/// ... and by no less than this part of the tolerance.
const LEAST_BELOW: f64 = 1e-3;
/// Claims that are tried of a constraint, each twice as far below what is seen as the one before.
const CLAIMS: u32 = 6;

/// What is claimed to be left of a constraint.
struct Claim {
    left: f64,
    /// By how much less the next claim is.
    step: f64,
    /// What is proved already: the tolerance as it is raised.
    proved: f64,
    tries: u32,
}

impl Claim {
    fn new(held: &Held, seen: f64, proved: f64) -> Self {
        let tolerance = held.tolerance().min(1.0);
        let step = (BELOW * seen.abs()).max(LEAST_BELOW * tolerance);
        let mut claim = Self {
            left: seen,
            step,
            proved,
            tries: 0,
        };
        claim.lower(held);
        claim
    }

    /// Claims less; what is proved already, where that was tried often enough.
    fn lower(&mut self, held: &Held) {
        self.left -= self.step;
        self.step *= 2.0;
        self.tries += 1;
        let is_convex = |left: f64| held.widened(-left).is_convex();
        while self.left > self.proved && !is_convex(self.left) {
            self.left -= self.step;
        }
        if self.tries > CLAIMS {
            self.left = self.proved;
        }
        self.left = self.left.max(self.proved);
    }
}

impl Constrained<'_> {
    /// What is left of each tolerance, as it is asked for, everywhere on a proved segment on which this
    /// is the least that was seen: negative where it is raised and that is needed.
    pub(super) fn claims(&mut self, ends: [&[f64]; 2], seen: &[Least]) -> Vec<f64> {
        let mut claims: Vec<Claim> = (0..seen.len())
            .map(|index| self.first_claim(index, seen[index].left))
            .collect();
        let allowed = std::mem::take(&mut self.allowed);
        let is_proved = self.prove_claims(ends, &mut claims);
        self.allowed = allowed;
        claims
            .into_iter()
            .map(|claim| if is_proved { claim.left } else { claim.proved })
            .collect()
    }

    /// What is proved of every constraint wherever a segment is.
    pub(super) fn least_claims(&self) -> Vec<f64> {
        (0..self.raises.len())
            .map(|index| self.proved(index))
            .collect()
    }

    /// What is proved of a constraint wherever a segment is: nothing is left, which is no −0, or less.
    fn proved(&self, index: usize) -> f64 {
        0.0 - self.raises[index]
    }

    fn first_claim(&self, index: usize, seen: f64) -> Claim {
        Claim::new(&self.constraints[index].held, seen, self.proved(index))
    }

    /// Lowers claims until all are proved; whether that came about.
    fn prove_claims(&mut self, ends: [&[f64]; 2], claims: &mut [Claim]) -> bool {
        for _ in 0..=CLAIMS as usize * claims.len() {
            self.narrow(claims);
            match self.violation(ends.into(), Search::Any) {
                None => return true,
                Some(violation) => {
                    let index = violation.constraint;
                    claims[index].lower(&self.constraints[index].held);
                }
            }
        }
        false
    }

    /// Allows no more than what is claimed.
    fn narrow(&mut self, claims: &[Claim]) {
        let constraints = self.constraints.iter().zip(claims);
        self.allowed = constraints
            .map(|(constraint, claim)| constraint.held.widened(-claim.left))
            .collect();
    }
}
