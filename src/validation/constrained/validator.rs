//! What a validator says of constraints.

use std::ops::Range;

use super::{ROUNDING, Search, Violation};
use crate::constraint::{Constraint, Held};
use crate::path::Path;
use crate::validation::demand::MARGIN;
use crate::validation::path_proof::{close_floor, ends, lowered_floor};
use crate::validation::requirement::{Measure, NamedRequirement, Requirement};
use crate::validation::validator::Validator;
use crate::validation::way::Way;
use crate::validation::{Hit, SegmentRefusal};

/// Part of its tolerance by which a waypoint that stays may be outside of a constraint.
const ROUNDED: f64 = 0.01;

impl Violation {
    pub(in crate::validation) fn requirement(&self) -> Requirement {
        Requirement::Constraint(self.constraint)
    }

    /// The same of one of several segments.
    pub(in crate::validation) fn refusal(&self, segment: usize) -> SegmentRefusal {
        SegmentRefusal {
            segment,
            t: self.t,
            requirement: self.requirement(),
            reason: self.reason,
        }
    }
}

impl<'a> Validator<'a> {
    /// The same for a request with constraints.
    #[must_use]
    pub fn with_constraints(mut self, constraints: &'a [Constraint]) -> Self {
        self.constrained = self.constrained.of(constraints);
        self
    }

    /// The constraints of the request.
    pub fn constraints(&self) -> &'a [Constraint] {
        self.constrained.constraints()
    }

    /// What is proved of each constraint: its tolerance may be raised.
    pub fn allowed(&self) -> &[Held] {
        self.constrained.allowed()
    }

    /// What people call a requirement.
    pub fn named(&self, requirement: Requirement) -> NamedRequirement {
        requirement.named(self.model(), self.constraints())
    }

    /// What is left of the tolerance of each constraint wherever something is proved; `None` where there are
    /// none.
    pub(in crate::validation) fn left_everywhere(&self) -> Option<Vec<f64>> {
        let has_any = !self.constraints().is_empty();
        has_any.then(|| self.constrained.least_claims())
    }

    /// The first of these waypoints that is outside of a constraint, and the worst that it violates;
    /// where `is_strict` be it by as little as can be.
    pub fn outside_at(
        &mut self,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        is_strict: bool,
    ) -> Option<(usize, Requirement, Measure)> {
        for waypoint in waypoints {
            let violated = self.violated_at(path.waypoint(waypoint), is_strict);
            if let Some((requirement, measure)) = violated {
                return Some((waypoint, requirement, measure));
            }
        }
        None
    }

    fn violated_at(
        &mut self,
        configuration: &[f64],
        is_strict: bool,
    ) -> Option<(Requirement, Measure)> {
        let part = if is_strict { 0.0 } else { ROUNDED };
        (0..self.constraints().len()).find_map(|index| {
            let most = part * self.constraints()[index].held.tolerance();
            let measure = self.constrained.measure(index, configuration);
            let most = if most.is_finite() { most } else { 0.0 }.max(ROUNDING);
            (measure.amount < -most).then_some((Requirement::Constraint(index), measure))
        })
    }

    /// Where a segment violates a constraint, or may.
    pub(in crate::validation) fn violation(
        &mut self,
        way: Way,
        search: Search,
    ) -> Option<Violation> {
        self.constrained.violation(way, search)
    }

    /// The same, measured.
    pub(in crate::validation) fn violation_hit(
        &mut self,
        ends: [&[f64]; 2],
        search: Search,
    ) -> Option<Hit> {
        let violation = self.violation(ends.into(), search)?;
        let measure = self.measure(violation.requirement(), ends, violation.t);
        Some(Hit {
            reason: violation.reason,
            t: violation.t,
            requirement: violation.requirement(),
            measure,
            proved_until: match search {
                Search::Any => 0.0,
                Search::First => violation.proved_until,
            },
        })
    }

    /// The first of several segments, each with its number, that violates a constraint and is not
    /// known; `None` where stopped, which is asked at each.
    pub(in crate::validation) fn refused_by_constraints<'q>(
        &mut self,
        segments: impl Iterator<Item = [&'q [f64]; 2]>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<SegmentRefusal>> {
        if self.constrained.is_empty() {
            return Some(None);
        }
        for (number, ends) in segments.enumerate() {
            if self.known(ends[0], ends[1]).is_some() {
                continue;
            }
            if !self.constrained.keeps_all(ends)
                && let Some(violation) = self.violation(ends.into(), Search::Any)
            {
                return Some(Some(violation.refusal(number)));
            }
            if stop() {
                return None;
            }
        }
        Some(None)
    }

    /// Where constraints are violated on the segments between rows laid end to end: of each segment the
    /// first that is seen.
    pub fn violations(&mut self, rows: &[f64]) -> Vec<SegmentRefusal> {
        let segments = self.segments_of(rows).enumerate();
        segments
            .filter_map(|(number, ends)| {
                if self.constrained.keeps_all(ends) {
                    return None;
                }
                let violation = self.violation(ends.into(), Search::Any)?;
                Some(violation.refusal(number))
            })
            .collect()
    }

    /// The segments of a range up to the first that violates a constraint; `None` where stopped.
    pub(in crate::validation) fn up_to_violation(
        &mut self,
        path: &Path,
        range: Range<usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Range<usize>> {
        let segments = range.clone().map(|number| ends(path, number));
        let refused = self.refused_by_constraints(segments, stop)?;
        let count = refused.map_or(range.len(), |refusal| refusal.segment);
        Some(range.start..range.start + count)
    }

    /// The floor at which a requirement that leaves this much may be proved next; `None` below the
    /// last.
    pub(in crate::validation) fn next_floor(
        &self,
        requirement: Requirement,
        amount: f64,
    ) -> Option<f64> {
        let present = self.floors().of(requirement);
        match requirement {
            Requirement::Clearance(_) if self.margin < MARGIN => close_floor(present, amount),
            Requirement::Clearance(_) => lowered_floor(present, amount),
            Requirement::Constraint(index) => self
                .constrained
                .next_raise(index, -present, amount)
                .map(|raise| -raise),
        }
    }
}
