//! Stretches of a path on which a pair is near, and the least distance on each.

use super::super::interval::{IntervalVerdict, Looks, PairInterval};
use super::super::undecided::Interval;
use super::super::validator::Validator;
use super::Near;
use super::candidates::Candidate;

/// Half widths below this are not halved any more: a rounding wide in any room.
const FINEST_HALF: f64 = 1e-6;
/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sought {
    pub(super) pair: usize,
    /// Distances below this count (m).
    pub(super) within: f64,
    /// How much above the least distance a found one may be (m).
    pub(super) resolution: f64,
    /// The validator's count of work at which to give up.
    pub(super) most_work: u64,
}

/// Part of the resolution to which the place of the least distance is followed.
const SETTLED: f64 = 0.02;

/// An interval, and about the distance of the pair in its middle (m).
#[derive(Clone, Copy, Debug)]
struct Cell {
    interval: Interval,
    distance: f64,
}

/// What is known of one pair, along the path.
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

impl Validator<'_> {
    /// The nearest place of each stretch of the pair's candidates, which are in order. `None` where
    /// stopped or too dear.
    pub(super) fn stretches(
        &mut self,
        sought: &Sought,
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
            let is_settled = near.is_some() || self.is_hardly_nearer(sought, &interval, stop)?;
            if is_settled || interval.half <= FINEST_HALF {
                self.append(sought, &mut along, &interval, near, stop)?;
            } else {
                open.extend(interval.halves().into_iter().rev());
            }
        }
        self.close(sought, &mut along, stop)?;
        Some(self.merged(&along))
    }

    /// About the distance in the middle of an interval, where it is less than is sought.
    fn distance_within(&mut self, sought: &Sought, interval: &Interval) -> Option<f64> {
        let distance = self.nearly_apart(sought.pair, interval);
        (distance < sought.within).then_some(distance)
    }

    /// What is hardly nearer anywhere than what is sought is not near.
    fn is_hardly_nearer(
        &mut self,
        sought: &Sought,
        interval: &Interval,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        self.keeps(sought, interval, sought.within - sought.resolution, stop)
    }

    /// Goes on along the path by an interval that is looked at enough; `near` is about the distance
    /// in its middle, or `None` where all of it is too far.
    fn append(
        &mut self,
        sought: &Sought,
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
            self.close(sought, along, stop)?;
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
        along: &mut Along,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<()> {
        let least = self.least(sought, &along.stretch, stop)?;
        let near = least.filter(|near| near.contact.distance < sought.within);
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
        stretch: &[Cell],
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Near>> {
        let nearest = |a: &&Cell, b: &&Cell| a.distance.total_cmp(&b.distance);
        let Some(start) = stretch.iter().min_by(nearest) else {
            return Some(None);
        };
        let reach = reach(stretch);
        let mut best = self.follow(sought.pair, &start.interval, reach, sought.settled());
        let mut open: Vec<Interval> = stretch
            .iter()
            .map(|cell| cell.interval)
            .collect();
        while let Some(interval) = open.pop() {
            if self.is_over(sought, stop) {
                return None;
            }
            let enough = best.contact.distance - sought.resolution;
            if interval.half <= FINEST_HALF || self.keeps(sought, &interval, enough, stop)? {
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
        if self.nearly_apart(sought.pair, interval) < best.contact.distance {
            let near = self.follow(sought.pair, interval, reach, sought.settled());
            if near.contact.distance < best.contact.distance {
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
                Some(last) if near.contact.distance < last.contact.distance => *last = *near,
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
            || ends_at && (begins_at || self.rate(first.pair, second.segment, 0.0) < 0.0)
            || begins_at && self.rate(first.pair, first.segment, 1.0) > 0.0
    }

    /// The rate at which a pair's distance grows at a ratio of a segment (m per unit t).
    fn rate(&mut self, pair: usize, segment: usize, t: f64) -> f64 {
        let interval = Interval {
            segment,
            ..Interval::default()
        };
        self.near(pair, &interval, t).1
    }

    /// Whether the pair is proved to keep this distance (m) on the whole interval. `None` where
    /// stopped.
    fn keeps(
        &mut self,
        sought: &Sought,
        interval: &Interval,
        distance: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<bool> {
        self.place(interval);
        let bound = PairInterval {
            too_close: distance,
            ..self.bound(sought.pair, interval.half, distance)
        };
        let mut looks = Looks::new(stop);
        let verdict = self.decide_along(sought.pair, &bound, &mut looks);
        self.exact += looks.count;
        match verdict {
            IntervalVerdict::Stopped => None,
            verdict => Some(matches!(verdict, IntervalVerdict::Proved(_))),
        }
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
