//! Stretches of a path on which little of a requirement is kept, and the least on each.

use super::super::demand::Directions;
use super::super::examiner::Examiner;
use super::super::requirement::Requirement;
use super::super::undecided::Interval;
use super::Near;
use super::candidates::Candidate;

/// Half widths below this are not halved any more: a rounding wide in any room.
const FINEST_HALF: f64 = 1e-6;
/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sought {
    pub(super) requirement: Requirement,
    /// Amounts below this count.
    pub(super) within: f64,
    /// How much above the least a found one may be.
    pub(super) resolution: f64,
    /// The validator's count of work at which to give up.
    pub(super) most_work: u64,
}

/// Part of the resolution to which the place of the least distance is followed.
const SETTLED: f64 = 0.02;

/// An interval, and about what is kept in its middle.
#[derive(Clone, Copy, Debug)]
struct Cell {
    interval: Interval,
    distance: f64,
}

/// What is known of one requirement, along the path.
#[derive(Default)]
struct Along {
    /// Cells of one segment without a parting between them, of which the nearest place is not known
    /// yet.
    stretch: Vec<Cell>,
    found: Vec<Near>,
    /// Places at which the pair is farther apart than is sought, in order.
    partings: Vec<f64>,
    /// Everything before this is looked at.
    reached: f64,
}

impl Sought {
    /// Distance to which the least is followed (m).
    fn settled(&self) -> f64 {
        SETTLED * self.resolution
    }
}

impl Along {
    /// The middle of what lies between what is looked at and an interval, if anything does: the pair
    /// is far there.
    fn gap_before(&self, interval: &Interval) -> Option<f64> {
        let start = interval.along(interval.ends()[0]);
        (start > self.reached + FINEST_HALF).then_some((start + self.reached) / 2.0)
    }

    /// Whether a waypoint lies between the stretch and an interval.
    fn turns_at(&self, interval: &Interval) -> bool {
        let last = self.stretch.last();
        last.is_some_and(|cell| cell.interval.segment != interval.segment)
    }
}

/// Whether the pair is farther apart than is sought somewhere between two places.
fn are_parted(first: &Near, second: &Near, partings: &[f64]) -> bool {
    let [first, second] = [first, second].map(|near| near.segment as f64 + near.t);
    let next = partings.partition_point(|parting| *parting <= first.min(second));
    partings
        .get(next)
        .is_some_and(|parting| *parting < first.max(second))
}

impl Interval {
    fn halves(&self) -> [Self; 2] {
        let half = self.half / 2.0;
        [-half, half].map(|shift| Self {
            middle: self.middle + shift,
            half,
            ..*self
        })
    }

    /// Where it begins and ends on its segment.
    fn ends(&self) -> [f64; 2] {
        [self.middle - self.half, self.middle + self.half]
    }

    fn along(&self, t: f64) -> f64 {
        self.segment as f64 + t
    }
}

impl Examiner<'_> {
    /// The nearest place of each stretch of a requirement's candidates, which are in order. `None` where
    /// stopped or too dear.
    pub(super) fn stretches(
        &mut self,
        sought: &Sought,
        directions: &mut Directions,
        candidates: &[Candidate],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<Near>> {
        let mut along = Along::default();
        let intervals = candidates
            .iter()
            .rev()
            .map(|candidate| candidate.interval);
        let mut open: Vec<Interval> = intervals.collect();
        while let Some(interval) = open.pop() {
            if self.is_over(sought, stop) {
                return None;
            }
            let near = self.distance_within(sought, &interval);
            let is_settled =
                near.is_some() || self.is_hardly_nearer(sought, directions, &interval, stop)?;
            if is_settled || interval.half <= FINEST_HALF {
                self.append(sought, directions, &mut along, &interval, near, stop)?;
            } else {
                open.extend(interval.halves().into_iter().rev());
            }
        }
        self.close(sought, directions, &mut along, stop)?;
        Some(self.merged(&along))
    }

    /// About the distance in the middle of an interval, where it is less than is sought.
    fn distance_within(&mut self, sought: &Sought, interval: &Interval) -> Option<f64> {
        let distance = self.measure_roughly(sought.requirement, interval);
        (distance < sought.within).then_some(distance)
    }

    /// What is hardly nearer anywhere than what is sought is not near.
    fn is_hardly_nearer(
        &mut self,
        sought: &Sought,
        directions: &mut Directions,
        interval: &Interval,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        let enough = sought.within - sought.resolution;
        self.keeps(directions, sought.requirement, interval, enough, stop)
    }

    /// Goes on along the path by an interval that is looked at enough; `near` is about the distance
    /// in its middle, or `None` where all of it is too far.
    fn append(
        &mut self,
        sought: &Sought,
        directions: &mut Directions,
        along: &mut Along,
        interval: &Interval,
        near: Option<f64>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let before = along.gap_before(interval);
        let inside = near
            .is_none()
            .then_some(interval.along(interval.middle));
        let parting = before.or(inside).is_some();
        if parting || along.turns_at(interval) {
            self.close(sought, directions, along, stop)?;
        }
        along
            .partings
            .extend(before.into_iter().chain(inside));
        along.reached = interval.along(interval.ends()[1]);
        let interval = *interval;
        along
            .stretch
            .extend(near.map(|distance| Cell { interval, distance }));
        Some(())
    }

    /// Ends a stretch: finds its nearest place, which counts if it is near enough.
    fn close(
        &mut self,
        sought: &Sought,
        directions: &mut Directions,
        along: &mut Along,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let least = self.least(sought, directions, &along.stretch, stop)?;
        let near = least.filter(|near| near.measure.amount < sought.within);
        along.found.extend(near);
        along.stretch.clear();
        Some(())
    }

    /// The nearest place of a stretch: the nearest of its cells' middles, followed to where the
    /// distance stops falling; then whatever the bound does not prove to be farther is halved, and
    /// the same again.
    fn least(
        &mut self,
        sought: &Sought,
        directions: &mut Directions,
        stretch: &[Cell],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Near>> {
        let nearest = |a: &&Cell, b: &&Cell| a.distance.total_cmp(&b.distance);
        let Some(start) = stretch.iter().min_by(nearest) else {
            return Some(None);
        };
        let reach = reach(stretch);
        let mut best = self.follow(sought.requirement, &start.interval, reach, sought.settled());
        let mut open: Vec<Interval> = stretch
            .iter()
            .map(|cell| cell.interval)
            .collect();
        while let Some(interval) = open.pop() {
            if self.is_over(sought, stop) {
                return None;
            }
            let enough = best.measure.amount - sought.resolution;
            if interval.half <= FINEST_HALF
                || self.keeps(directions, sought.requirement, &interval, enough, stop)?
            {
                continue;
            }
            for half in interval.halves() {
                self.better(sought, &half, reach, &mut best);
                open.push(half);
            }
        }
        Some(Some(best))
    }

    /// Follows the distance from the middle of an interval, if it is less there than the best.
    fn better(&mut self, sought: &Sought, interval: &Interval, reach: [f64; 2], best: &mut Near) {
        if self.measure_roughly(sought.requirement, interval) < best.measure.amount {
            let near = self.follow(sought.requirement, interval, reach, sought.settled());
            if near.measure.amount < best.measure.amount {
                *best = near;
            }
        }
    }

    fn is_over(&self, sought: &Sought, stop: &mut dyn FnMut() -> bool) -> bool {
        stop() || self.work() > sought.most_work
    }

    /// One place for each stretch: the lower of two where nothing parts them.
    fn merged(&mut self, along: &Along) -> Vec<Near> {
        let mut merged: Vec<Near> = Vec::new();
        for near in &along.found {
            let last = merged.last_mut();
            match last.filter(|last| self.are_one(last, near, &along.partings)) {
                None => merged.push(*near),
                Some(last) if near.measure.amount < last.measure.amount => *last = *near,
                Some(_) => {}
            }
        }
        merged
    }

    /// Whether two places, one after the other, are of one stretch: nothing parts them, and where a
    /// waypoint lies between them, one of the two is at the waypoint and the distance falls from
    /// there towards the other.
    fn are_one(&mut self, first: &Near, second: &Near, partings: &[f64]) -> bool {
        if second.segment > first.segment + 1 || are_parted(first, second, partings) {
            return false;
        }
        let ends_at = first.t > 1.0 - FINEST_HALF;
        let begins_at = second.t < FINEST_HALF;
        first.segment == second.segment
            || ends_at && (begins_at || self.rate(first.requirement, second.segment, 0.0) < 0.0)
            || begins_at && self.rate(first.requirement, first.segment, 1.0) > 0.0
    }

    /// The rate at which a requirement grows at a ratio of a segment (per unit t).
    fn rate(&mut self, requirement: Requirement, segment: usize, t: f64) -> f64 {
        let interval = Interval {
            segment,
            ..Interval::default()
        };
        self.near(requirement, &interval, t).1
    }
}

/// The part of its segment that a stretch covers.
fn reach(stretch: &[Cell]) -> [f64; 2] {
    let [low, _] = ends(stretch.first());
    let [_, high] = ends(stretch.last());
    [low.max(0.0), high.min(1.0)]
}

/// Where a cell begins and ends; the whole segment where there is none.
fn ends(cell: Option<&Cell>) -> [f64; 2] {
    cell.map_or([0.0, 1.0], |cell| cell.interval.ends())
}
