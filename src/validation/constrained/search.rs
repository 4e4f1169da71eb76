//! Whether a segment keeps every constraint, and where not.

use super::{Constrained, Course, Way, bound, kept};
use crate::constraint::Held;
use crate::validation::HitReason;
use crate::validation::motion::MotionBounds;

/// Width to which the first violation is narrowed down: as fine as contacts are.
const FINEST: f64 = 1.0 / 2048.0;
/// No interval is halved that is narrower than this: what keeps nothing is not proved by any.
const THINNEST: f64 = 1e-7;
/// Intervals of one segment after which it counts as not provable.
const MOST_LOOKS: u32 = 20_000;

/// What is looked for on a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::validation) enum Search {
    /// Any violation: the widest interval that shows one.
    Any,
    /// The first along the segment.
    First,
}

/// Where a constraint is not kept, or not provably.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::validation) struct Violation {
    pub(in crate::validation) constraint: usize,
    pub(in crate::validation) t: f64,
    /// Everything on the segment before this is proved, where the first was looked for.
    pub(in crate::validation) proved_until: f64,
    pub(in crate::validation) reason: HitReason,
}

/// `[middle − half, middle + half]`, and which of the listed constraints are open there.
#[derive(Clone, Copy, Debug)]
struct Interval {
    middle: f64,
    half: f64,
    open: (usize, usize),
}

impl Interval {
    /// The first half, and the second; they look at these.
    fn halves(&self, open: (usize, usize)) -> [Self; 2] {
        let half = 0.5 * self.half;
        [self.middle - half, self.middle + half].map(|middle| Self { middle, half, open })
    }

    fn violation(&self, constraint: usize, reason: HitReason) -> Violation {
        Violation {
            constraint,
            t: self.middle,
            proved_until: self.middle - self.half,
            reason,
        }
    }
}

/// Intervals that wait, what is open on each, and what was found.
struct Waiting {
    /// What is farthest left is last.
    stack: Vec<Interval>,
    /// Lists of constraints, each a range of this.
    lists: Vec<usize>,
    looks: u32,
    found: Option<Violation>,
}

impl Waiting {
    fn all(constraints: usize) -> Self {
        Self {
            stack: vec![Interval {
                middle: 0.5,
                half: 0.5,
                open: (0, constraints),
            }],
            lists: (0..constraints).collect(),
            looks: 0,
            found: None,
        }
    }

    /// What lies before a violation is looked at, if the first is looked for; nothing else counts.
    fn meet(&mut self, interval: &Interval, violation: Violation, search: Search) {
        self.stack.clear();
        // Just before a violation nothing is left to prove anything with: that is no other refusal.
        if let Some(found) = &mut self.found
            && violation.reason == HitReason::Uncertified
        {
            found.proved_until = violation.proved_until;
            return;
        }
        self.found = Some(violation);
        if search == Search::First && interval.half > FINEST {
            let [left, _] = interval.halves(interval.open);
            self.stack.push(left);
        }
    }
}

impl Constrained<'_> {
    /// Where a segment does not keep every constraint; `None` where it is proved to.
    pub(in crate::validation) fn violation(
        &mut self,
        way: Way,
        search: Search,
    ) -> Option<Violation> {
        if self.is_empty() {
            return None;
        }
        if let Way::Straight(ends) = way {
            self.set_out(ends);
        }
        let mut waiting = Waiting::all(self.allowed.len());
        while let Some(interval) = waiting.stack.pop() {
            self.stand(way, &interval);
            waiting.looks += 1;
            self.look(&interval, search, &mut waiting);
        }
        self.looks += u64::from(waiting.looks);
        waiting.found
    }

    /// Sets out on a straight segment, and bounds what is watched on it.
    pub(super) fn set_out(&mut self, ends: [&[f64]; 2]) {
        self.standing.set_out(ends);
        let course = Course::Straight {
            from: ends[0],
            velocity: &self.standing.velocity,
        };
        bound_all(&mut self.bounds, &self.allowed, &course, self.standing.held);
    }

    /// Stands in the middle of an interval; on a curve, bounds what is watched on it.
    fn stand(&mut self, way: Way, interval: &Interval) {
        match way {
            Way::Straight([from, _]) => self.standing.stand(from, interval.middle),
            Way::Curved(columns) => {
                self.standing
                    .follow(columns, interval.middle, interval.half);
                let course = Course::Curved(&self.standing.expansion);
                bound_all(&mut self.bounds, &self.allowed, &course, self.standing.held);
            }
        }
    }

    /// Looks at an interval in the middle of which the robot stands.
    fn look(&self, interval: &Interval, search: Search, waiting: &mut Waiting) {
        let begin = waiting.lists.len();
        for entry in interval.open.0..interval.open.1 {
            let index = waiting.lists[entry];
            match self.verdict(index, interval, waiting.looks) {
                None => {}
                Some(Some(reason)) => {
                    return waiting.meet(interval, interval.violation(index, reason), search);
                }
                Some(None) => waiting.lists.push(index),
            }
        }
        let open = (begin, waiting.lists.len());
        if open.0 < open.1 {
            let [left, right] = interval.halves(open);
            waiting.stack.extend([right, left]);
        }
    }

    /// `None` where a constraint is kept on an interval, a reason where that is refused, else it is
    /// open.
    fn verdict(&self, index: usize, interval: &Interval, looks: u32) -> Option<Option<HitReason>> {
        let held = &self.allowed[index];
        let stand = self.standing.seen();
        if kept(held, &stand, &self.bounds[index], interval.half) >= 0.0 {
            return None;
        }
        let is_outside = held.depth(held.watched.at(&stand)) < 0.0;
        let is_spent = interval.half < THINNEST || looks > MOST_LOOKS;
        Some(match is_outside {
            true => Some(HitReason::Outside),
            false => is_spent.then_some(HitReason::Uncertified),
        })
    }
}

fn bound_all(all: &mut Vec<MotionBounds>, allowed: &[Held], course: &Course, joints: &[f64]) {
    all.resize_with(allowed.len(), MotionBounds::default);
    for (bounds, held) in all.iter_mut().zip(allowed) {
        bound(bounds, &held.watched, course, joints);
    }
}
