//! Who is computed first.
//!
//! Between classes the higher one. Within a class clients share the workers: each job has a *lead*,
//! what its client and the job itself have had of them of late, and jobs that lead by
//! more than [`SHARE_NS`] wait for the others. Among those that do not, the earliest deadline goes
//! first, else who came first. So a client with one short path does not wait for another's long
//! ones, and a client's own short path not for its long one.

use std::cmp::Ordering;

/// By how much (ns of computing) one job may lead another before it has to let it go first.
pub(super) const SHARE_NS: u64 = 10_000_000;
/// How long (ns) a job goes on beside one with an earlier deadline: two of one client would else
/// take turns all the time.
const TURN_NS: u64 = 4_000_000;

/// What the order looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Standing {
    /// Higher goes first.
    pub class: u32,
    /// What the client and the job have had.
    pub lead_ns: u64,
    /// On the monotonic clock; none = the end of time.
    pub deadline_ns: u64,
    /// In order of arrival.
    pub number: u64,
}

impl Standing {
    /// Whether its share is used up beside `other`.
    fn has_had_more_than(&self, other: &Self) -> bool {
        self.lead_ns > other.lead_ns.saturating_add(SHARE_NS)
    }

    /// Whether `other` has an earlier deadline, and its share is not used up.
    fn is_later_than(&self, other: &Self) -> bool {
        !other.has_had_more_than(self) && other.deadline_ns < self.deadline_ns
    }

    /// Whether it would be taken after `other`, however that came.
    pub(super) fn goes_after(&self, other: &Self) -> bool {
        self.yields_to(other, u64::MAX)
    }

    /// Whether a job that has been computed for `turn_ns` makes room for `other`. Never both ways.
    pub(super) fn yields_to(&self, other: &Self, turn_ns: u64) -> bool {
        match other.class.cmp(&self.class) {
            Ordering::Greater => true,
            Ordering::Less => false,
            Ordering::Equal if self.has_had_more_than(other) => true,
            Ordering::Equal => turn_ns >= TURN_NS && self.is_later_than(other),
        }
    }
}

/// Index of the job to compute next.
pub(super) fn next(standings: impl Iterator<Item = Standing> + Clone) -> Option<usize> {
    let class = standings
        .clone()
        .map(|standing| standing.class)
        .max()?;
    let in_class = move || {
        standings
            .clone()
            .enumerate()
            .filter(move |(_, standing)| standing.class == class)
    };
    let least = in_class()
        .min_by_key(|(_, standing)| standing.lead_ns)?
        .1;
    let eligible = in_class().filter(|(_, standing)| !standing.has_had_more_than(&least));
    eligible
        .min_by_key(|(_, standing)| (standing.deadline_ns, standing.number))
        .map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: u64 = u64::MAX;

    fn standing(class: u32, lead_ms: u64, deadline_ns: u64, number: u64) -> Standing {
        Standing {
            class,
            lead_ns: lead_ms * 1_000_000,
            deadline_ns,
            number,
        }
    }

    #[test]
    fn class_then_share_then_deadline_then_arrival() {
        let next = |standings: &[Standing]| next(standings.iter().copied());
        assert_eq!(next(&[]), None);
        assert_eq!(
            next(&[standing(0, 0, NONE, 1), standing(1, 99, NONE, 2)]),
            Some(1),
            "class before share"
        );
        assert_eq!(
            next(&[standing(0, 50, 5, 1), standing(0, 0, 9, 2)]),
            Some(1),
            "share before deadline"
        );
        assert_eq!(
            next(&[standing(0, 9, 5, 1), standing(0, 0, 9, 2)]),
            Some(0),
            "deadline within the share"
        );
        assert_eq!(
            next(&[standing(0, 0, NONE, 2), standing(0, 9, NONE, 1)]),
            Some(1),
            "then order of arrival"
        );
        assert_eq!(
            next(&[standing(0, 0, 7, 2), standing(0, 0, 7, 1)]),
            Some(1),
            "then order of arrival"
        );
    }

    #[test]
    fn what_yields_is_not_yielded_to() {
        let all: Vec<Standing> = [0, 1]
            .into_iter()
            .flat_map(|class| [0, 5, 30].map(move |lead| (class, lead)))
            .flat_map(|(class, lead)| {
                [3, NONE].map(move |deadline| standing(class, lead, deadline, lead))
            })
            .collect();
        for a in &all {
            for b in &all {
                assert!(
                    !(a.goes_after(b) && b.goes_after(a)),
                    "{a:?} and {b:?} would take turns for ever"
                );
                assert!(a.goes_after(b) || !a.yields_to(b, 0));
                if a.goes_after(b) {
                    assert_eq!(
                        next([*a, *b].into_iter()),
                        Some(1),
                        "{a:?} made room for {b:?}, and would go on itself"
                    );
                }
            }
        }
    }
}
